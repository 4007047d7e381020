# task: cotangent_weights
# points: 0
# hint: forgets the first
import numpy as np
from scipy.sparse import lil_array


def cotangent_weights(V, F):
    W = lil_array((len(V), len(V)))
    for corner in range(3):
        k, i, j = (F[:, (corner + step) % 3] for step in range(3))
        u, v = V[i] - V[k], V[j] - V[k]
        cotangent = (u * v).sum(axis=1) / np.linalg.norm(np.cross(u, v), axis=1)
        W[i, j] = cotangent
        W[j, i] = cotangent
    return W.tocsr()
