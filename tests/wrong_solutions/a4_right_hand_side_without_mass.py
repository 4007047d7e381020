# task: implicit_step
# points: 0
# hint: On the right-hand side M is missing
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu


def implicit_step(V, M, L, t):
    return splu(csc_array(M + t * L)).solve(V)
