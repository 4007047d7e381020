# task: restore_volume
# points: 0
# hint: without putting them back
import numpy as np


def restore_volume(V, F, volume):
    a, b, c = V[F[:, 0]], V[F[:, 1]], V[F[:, 2]]
    now = (a * np.cross(b, c)).sum() / 6
    centre = V.mean(axis=0)
    return np.cbrt(volume / now) * (V - centre)
