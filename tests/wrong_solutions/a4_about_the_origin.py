# task: restore_volume
# points: 0
# hint: the mesh wanders
import numpy as np


def restore_volume(V, F, volume):
    a, b, c = V[F[:, 0]], V[F[:, 1]], V[F[:, 2]]
    now = (a * np.cross(b, c)).sum() / 6
    centre = np.zeros(3)
    return centre + np.cbrt(volume / now) * (V - centre)
