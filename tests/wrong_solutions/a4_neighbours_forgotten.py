# task: regularise_fixed
# points: 1
# hint: is missing on the right-hand side
from scipy.sparse import csc_array, csr_array, eye_array
from scipy.sparse.linalg import splu


def regularise_fixed(V, L, lam, fixed):
    free = ~fixed
    A = csr_array(eye_array(len(V)) + lam * L)
    X = V.copy()
    X[free] = splu(csc_array(A[free][:, free])).solve(V[free])
    return X
