# task: regularise
# points: 1
# hint: (I + lam L L)
from scipy.sparse import csc_array, eye_array
from scipy.sparse.linalg import splu


def regularise(V, L, lam):
    return splu(csc_array(eye_array(len(V)) + lam * L @ L)).solve(V)
