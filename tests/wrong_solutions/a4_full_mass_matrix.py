# task: mass_matrix
# points: 0
# hint: nothing stands beside the diagonal
import numpy as np
from scipy.sparse import coo_array


def mass_matrix(V, F):
    a, b, c = V[F[:, 0]], V[F[:, 1]], V[F[:, 2]]
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    M = 0
    for i in range(3):
        for j in range(3):
            w = areas / (6 if i == j else 12)
            M = M + coo_array((w, (F[:, i], F[:, j])), shape=(len(V), len(V)))
    return M.tocsr()
