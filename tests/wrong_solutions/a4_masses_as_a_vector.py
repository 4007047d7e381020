# task: mass_matrix
# points: 0
# hint: diags_array
import numpy as np


def mass_matrix(V, F):
    a, b, c = V[F[:, 0]], V[F[:, 1]], V[F[:, 2]]
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    return np.bincount(F.ravel(), weights=np.repeat(areas / 3, 3), minlength=len(V))
