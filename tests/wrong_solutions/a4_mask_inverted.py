# task: regularise_fixed
# points: 0
# hint: The free vertices stayed
from scipy.sparse import csc_array, csr_array, eye_array
from scipy.sparse.linalg import splu


def regularise_fixed(V, L, lam, fixed):
    free, fixed = fixed, ~fixed
    A = csr_array(eye_array(len(V)) + lam * L)
    X = V.copy()
    X[free] = splu(csc_array(A[free][:, free])).solve(V[free] - A[free][:, fixed] @ V[fixed])
    return X
