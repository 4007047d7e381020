# task: regularise_fixed
# points: 1
# hint: put the fixed vertices back
from scipy.sparse import csc_array, eye_array
from scipy.sparse.linalg import splu


def regularise_fixed(V, L, lam, fixed):
    X = splu(csc_array(eye_array(len(V)) + lam * L)).solve(V)
    X[fixed] = V[fixed]
    return X
