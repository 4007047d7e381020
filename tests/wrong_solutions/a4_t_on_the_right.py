# task: implicit_step
# points: 0
# hint: t stands at the right-hand side
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu


def implicit_step(V, M, L, t):
    return splu(csc_array(M + L)).solve(t * (M @ V))
