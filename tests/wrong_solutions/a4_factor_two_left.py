# task: regularise
# points: 1
# hint: A factor 2 is left over
from scipy.sparse import csc_array, eye_array
from scipy.sparse.linalg import splu


def regularise(V, L, lam):
    return splu(csc_array(eye_array(len(V)) + 2 * lam * L)).solve(V)
