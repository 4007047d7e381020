# task: distance_weights
# points: 1
# hint: exponential that falls
import numpy as np
from scipy.sparse import coo_array


def distance_weights(V, F):
    W = combinatorial_weights(F, len(V)).tocoo()
    lengths = np.linalg.norm(V[W.row] - V[W.col], axis=1)
    return coo_array((np.exp(-(lengths**2)), (W.row, W.col)), shape=W.shape).tocsr()
