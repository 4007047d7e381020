# task: cotangent_weights
# points: 1
# hint: forgets the first
import numpy as np
from scipy.sparse import lil_array


def cotangent_weights(V, F):
    W = lil_array((len(V), len(V)))
    for face in F:
        for corner in range(3):
            k, i, j = face[corner], face[(corner + 1) % 3], face[(corner + 2) % 3]
            u, v = V[i] - V[k], V[j] - V[k]
            W[i, j] = W[j, i] = u @ v / np.linalg.norm(np.cross(u, v)) / 2
    return W.tocsr()
