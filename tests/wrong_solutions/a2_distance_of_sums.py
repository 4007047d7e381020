# task: distance_weights
# points: 1
# hint: You add up |dx| + |dy| + |dz|
import numpy as np
from scipy.sparse import coo_array


def distance_weights(V, F):
    W = combinatorial_weights(F, len(V)).tocoo()
    lengths = np.abs(V[W.row] - V[W.col]).sum(axis=1)
    return coo_array((lengths, (W.row, W.col)), shape=W.shape).tocsr()
