# task: distance_weights
# points: 1
# hint: reciprocals of the squares
import numpy as np
from scipy.sparse import coo_array


def distance_weights(V, F):
    W = combinatorial_weights(F, len(V)).tocoo()
    lengths = np.linalg.norm(V[W.row] - V[W.col], axis=1)
    return coo_array((lengths**-2.0, (W.row, W.col)), shape=W.shape).tocsr()
