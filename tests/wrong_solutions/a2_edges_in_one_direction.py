# task: combinatorial_weights
# points: 0
# hint: Only one half of W is filled: set w_ij and w_ji for
import numpy as np
from scipy.sparse import coo_array


def combinatorial_weights(F, n):
    E = edges(F)
    return coo_array((np.ones(len(E)), (E[:, 0], E[:, 1])), shape=(n, n)).tocsr()
