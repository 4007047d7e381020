# task: regularise_fixed
# points: 0
# hint: Fixed vertices have moved
# also: see its tolerance
import numpy as np
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import splu


def regularise_fixed(V, L, lam, fixed):
    P = diags_array(np.where(fixed, 1e6, 1.0))
    return splu(csc_array(P + lam * L)).solve(P @ V)
