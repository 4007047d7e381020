# task: implicit_step
# points: 0
# hint: does not allow the use of
import numpy as np


def implicit_step(V, M, L, t):
    return np.linalg.inv((M + t * L).todense()) @ (M @ V)
