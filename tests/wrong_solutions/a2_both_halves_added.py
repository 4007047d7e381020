# task: combinatorial_weights
# points: 1
# hint: All weights are 2
import numpy as np
from scipy.sparse import coo_array


def combinatorial_weights(F, n):
    E = np.concatenate([F[:, [0, 1]], F[:, [1, 2]], F[:, [2, 0]]])
    i, j = np.concatenate([E, E[:, ::-1]]).T
    return coo_array((np.ones(len(i)), (i, j)), shape=(n, n)).tocsr()
