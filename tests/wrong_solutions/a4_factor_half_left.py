# task: regularise
# points: 1
# hint: A factor 1/2 is left over
from scipy.sparse import csc_array, eye_array
from scipy.sparse.linalg import splu


def regularise(V, L, lam):
    return splu(csc_array(2 * eye_array(len(V)) + lam * L)).solve(2 * V)
