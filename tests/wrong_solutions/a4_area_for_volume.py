# task: restore_volume
# points: 0
# hint: area of the surface; the present volume
import numpy as np


def restore_volume(V, F, volume):
    a, b, c = V[F[:, 0]], V[F[:, 1]], V[F[:, 2]]
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    centre = V.mean(axis=0)
    return centre + np.cbrt(volume / area) * (V - centre)
