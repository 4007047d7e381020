# task: distance_weights
# points: 1
# hint: These are the reciprocals:
import numpy as np
from scipy.sparse import coo_array


def distance_weights(V, F):
    W = combinatorial_weights(F, len(V)).tocoo()
    lengths = np.linalg.norm(V[W.row] - V[W.col], axis=1)
    return coo_array((1 / lengths, (W.row, W.col)), shape=W.shape).tocsr()
