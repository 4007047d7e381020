# task: distance_weights
# points: 1
# hint: You subtract norms
import numpy as np
from scipy.sparse import coo_array


def distance_weights(V, F):
    W = combinatorial_weights(F, len(V)).tocoo()
    norms = np.linalg.norm(V, axis=1)
    return coo_array((np.abs(norms[W.row] - norms[W.col]), (W.row, W.col)), shape=W.shape).tocsr()
