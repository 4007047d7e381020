# task: implicit_step
# points: 0
# hint: t is not used
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu


def implicit_step(V, M, L, t):
    return splu(csc_array(M + L)).solve(M @ V)
