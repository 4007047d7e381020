# task: implicit_step
# points: 0
# hint: The sign of L is wrong
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu


def implicit_step(V, M, L, t):
    return splu(csc_array(M - t * L)).solve(M @ V)
