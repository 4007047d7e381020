# task: combinatorial_weights
# points: 3
# hint: not symmetric at the boundary
import numpy as np
from scipy.sparse import coo_array


def combinatorial_weights(F, n):
    E = np.concatenate([F[:, [0, 1]], F[:, [1, 2]], F[:, [2, 0]]])
    return coo_array((np.ones(len(E)), E.T), shape=(n, n)).tocsr()
