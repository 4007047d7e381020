# task: cotangent_weights
# points: 6
# hint: cotangents of obtuse angles are negative
import numpy as np
from scipy.sparse import coo_array, csr_array


def cotangent_weights(V, F):
    W = csr_array((len(V), len(V)))
    for corner in range(3):
        k, i, j = (F[:, (corner + step) % 3] for step in range(3))
        u, v = V[i] - V[k], V[j] - V[k]
        sine = (
            np.linalg.norm(np.cross(u, v), axis=1)
            / np.linalg.norm(u, axis=1)
            / np.linalg.norm(v, axis=1)
        )
        cotangent = np.sqrt(1 - sine**2) / sine
        W = W + coo_array((cotangent / 2, (i, j)), shape=W.shape)
    return csr_array(W + W.T)
