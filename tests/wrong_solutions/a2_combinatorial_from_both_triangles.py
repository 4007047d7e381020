# task: combinatorial_weights
# points: 1
# hint: All weights are 2
import numpy as np
from scipy.sparse import coo_array


def combinatorial_weights(F, n):
    r = np.concatenate([F[:, 0], F[:, 1], F[:, 2]])
    c = np.concatenate([F[:, 1], F[:, 2], F[:, 0]])
    W = coo_array((np.ones(len(r)), (r, c)), shape=(n, n)).tocsr()
    return W + W.T
