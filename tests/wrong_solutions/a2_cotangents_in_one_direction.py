# task: cotangent_weights
# points: 0
# hint: Each direction has the cotangent
import numpy as np
from scipy.sparse import coo_array, csr_array


def cotangent_weights(V, F):
    W = csr_array((len(V), len(V)))
    for corner in range(3):
        k, i, j = (F[:, (corner + step) % 3] for step in range(3))
        u, v = V[i] - V[k], V[j] - V[k]
        cotangent = (u * v).sum(axis=1) / np.linalg.norm(np.cross(u, v), axis=1)
        W = W + coo_array((cotangent / 2, (i, j)), shape=W.shape)
    return csr_array(W)
