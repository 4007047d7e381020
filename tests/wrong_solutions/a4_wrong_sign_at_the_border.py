# task: regularise_fixed
# points: 1
# hint: has the wrong sign
from scipy.sparse import csc_array, csr_array, eye_array
from scipy.sparse.linalg import splu


def regularise_fixed(V, L, lam, fixed):
    free = ~fixed
    A = csr_array(eye_array(len(V)) + lam * L)
    X = V.copy()
    X[free] = splu(csc_array(A[free][:, free])).solve(V[free] + A[free][:, fixed] @ V[fixed])
    return X
