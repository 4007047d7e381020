# task: regularise
# points: 0
# hint: what has moved, X - V
from scipy.sparse import csc_array, eye_array
from scipy.sparse.linalg import splu


def regularise(V, L, lam):
    return splu(csc_array(eye_array(len(V)) + lam * L)).solve(V) - V
