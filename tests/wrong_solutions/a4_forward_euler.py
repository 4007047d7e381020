# task: implicit_step
# points: 0
# hint: This is forward Euler
from scipy.sparse import diags_array


def implicit_step(V, M, L, t):
    return V - t * diags_array(1 / M.diagonal()) @ (L @ V)
