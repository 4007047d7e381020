# task: implicit_step
# points: 3.5
# hint: see its tolerance
import numpy as np
from scipy.sparse.linalg import cg


def implicit_step(V, M, L, t):
    return np.column_stack([cg(M + t * L, b)[0] for b in (M @ V).T])
