# task: restore_volume
# points: 0
# hint: This is the square root
import numpy as np


def restore_volume(V, F, volume):
    a, b, c = V[F[:, 0]], V[F[:, 1]], V[F[:, 2]]
    now = (a * np.cross(b, c)).sum() / 6
    c = V.mean(axis=0)
    return c + (volume / now) ** (1 / 2) * (V - c)
