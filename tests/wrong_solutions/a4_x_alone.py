# task: implicit_step
# points: 0
# hint: do the same with all coordinates
import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu


def implicit_step(V, M, L, t):
    return np.column_stack([splu(csc_array(M + t * L)).solve(M @ V[:, 0]), V[:, 1], V[:, 2]])
