# task: cotangent_weights
# points: 6
# hint: cut negative cotangents off
import numpy as np
from scipy.sparse import coo_array, csr_array


def cotangent_weights(V, F):
    W = csr_array((len(V), len(V)))
    for corner in range(3):
        k, i, j = (F[:, (corner + step) % 3] for step in range(3))
        u, v = V[i] - V[k], V[j] - V[k]
        cotangent = np.maximum((u * v).sum(axis=1) / np.linalg.norm(np.cross(u, v), axis=1), 0)
        W = W + coo_array((cotangent / 2, (i, j)), shape=W.shape)
    return csr_array(W + W.T)
