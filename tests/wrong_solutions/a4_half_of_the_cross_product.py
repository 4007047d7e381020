# task: mass_matrix
# points: 0
# hint: the half is missing
import numpy as np
from scipy.sparse import csr_array, diags_array


def mass_matrix(V, F):
    a, b, c = V[F[:, 0]], V[F[:, 1]], V[F[:, 2]]
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    m = np.zeros(len(V))
    for corner in range(3):
        np.add.at(m, F[:, corner], areas / 3)
    return csr_array(diags_array(m))
