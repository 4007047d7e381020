# task: implicit_step
# points: 0
# hint: Crank and Nicolson
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu


def implicit_step(V, M, L, t):
    return splu(csc_array(M + t / 2 * L)).solve(M @ V - t / 2 * (L @ V))
