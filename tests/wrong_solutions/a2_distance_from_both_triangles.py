# task: distance_weights
# points: 1
# hint: All weights are twice the distance
import numpy as np
from scipy.sparse import coo_array


def distance_weights(V, F):
    W = 0
    for k in range(3):
        i, j = F[:, k], F[:, k - 1]
        d = np.linalg.norm(V[i] - V[j], axis=1)
        W = (
            W
            + coo_array((d, (i, j)), shape=(len(V), len(V)))
            + coo_array((d, (j, i)), shape=(len(V), len(V)))
        )
    return W.tocsr()
