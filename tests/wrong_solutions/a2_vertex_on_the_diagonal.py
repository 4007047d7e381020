# task: combinatorial_weights
# points: 0
# hint: Each vertex is its own neighbour here
import numpy as np
from scipy.sparse import coo_array, eye_array


def combinatorial_weights(F, n):
    E = edges(F)
    rows, columns = np.concatenate([E, E[:, ::-1]]).T
    return (coo_array((np.ones(len(rows)), (rows, columns)), shape=(n, n)) + eye_array(n)).tocsr()
