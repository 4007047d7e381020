"""Products with I - A in single precision, and bounds on its eigenvalues."""

import numpy as np

from meshfair._fast.kernels import compiled, on_all_cores, unsigned


def product(N):
    """A function that multiplies a vector by a sparse matrix."""
    rows = (*unsigned(N.indptr, N.indices), N.data)

    def multiply(x):
        x = np.ascontiguousarray(x).reshape(-1)
        y = np.empty_like(x)
        on_all_cores(_multiply, len(x), *rows, x, y)
        return y

    return multiply


def absolute_product(A):
    """A function from x > 0 to |I - A| x."""
    rows = (*unsigned(A.indptr, A.indices), A.data)

    def multiply(x):
        y = np.empty_like(x)
        on_all_cores(_absolute, len(x), *rows, x, y)
        return y

    return multiply


@compiled
def _multiply(first, last, indptr, indices, N, x, y):
    for i in range(first, last):
        total = x[i] * 0  # in the precision of x
        for p in range(indptr[i], indptr[i + 1]):
            total += N[p] * x[indices[p]]
        y[i] = total


@compiled
def _absolute(first, last, indptr, indices, A, x, y):
    for i in range(first, last):
        diagonal, others = 1.0, 0.0
        for p in range(indptr[i], indptr[i + 1]):
            j = indices[p]
            if i == j:
                diagonal -= A[p]
            else:
                others += abs(A[p]) * x[j]
        y[i] = abs(diagonal) * x[i] + others
