# task: regularise
# points: 0
# hint: This is a mixture
from scipy.sparse import csc_array, eye_array
from scipy.sparse.linalg import splu


def regularise(V, L, lam):
    return splu(csc_array((1 - lam) * eye_array(len(V)) + lam * L)).solve((1 - lam) * V)
