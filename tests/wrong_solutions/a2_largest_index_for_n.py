# task: combinatorial_weights
# points: 3
# hint: is an argument
import numpy as np
from scipy.sparse import coo_array


def combinatorial_weights(F, n):
    E, n = edges(F), F.max() + 1
    rows, columns = np.concatenate([E, E[:, ::-1]]).T
    return coo_array((np.ones(len(rows)), (rows, columns)), shape=(n, n)).tocsr()
