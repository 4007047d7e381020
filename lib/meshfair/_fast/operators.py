"""The averaging operator and the mass matrix in one pass over their rows."""

import numpy as np
from scipy.sparse import csr_array, diags_array

from meshfair._fast.faces import corner_areas
from meshfair._fast.kernels import compiled, on_all_cores, unsigned


def averaging(W):
    """As `meshfair.operators.averaging`."""
    data = np.empty(len(W.data))
    isolated = np.empty(W.shape[0], dtype=bool)
    on_all_cores(_divide_by_degree, len(isolated), *unsigned(W.indptr), W.data, data, isolated)
    A = csr_array((data, W.indices.copy(), W.indptr.copy()), shape=W.shape)
    return csr_array(A + diags_array(isolated.astype(float))) if isolated.any() else A


def mass(V, F):
    """As `meshfair.operators.mass`, its diagonal."""
    m = np.zeros(len(V))
    corner_areas(V, F, m)
    return m


@compiled
def _divide_by_degree(first, last, indptr, W, A, isolated):
    """a_ij = w_ij / d_i; zeros in row i where d_i = 0."""
    for i in range(first, last):
        d = 0.0
        for p in range(indptr[i], indptr[i + 1]):
            d += W[p]
        isolated[i] = d == 0
        for p in range(indptr[i], indptr[i + 1]):
            A[p] = 0.0 if isolated[i] else W[p] / d
