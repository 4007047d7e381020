"""Conjugate gradients with a multigrid cycle as preconditioner, three columns at a time."""

import numpy as np

from meshfair._fast import ordering
from meshfair._fast.flow import row_product
from meshfair._fast.kernels import compiled, on_all_cores, unsigned
from meshfair._fast.multigrid import Multigrid

# Multigrid needs 10 to 50 iterations on meshes; so many more mean that something is wrong.
ITERATIONS = 500


def solve(A, B, X, tolerance):
    """Solve A X = B from a guess X; return X and the number of steps."""
    order, A = ordering.nearby(A)
    B, X = ordering.take(B, order), ordering.take(X, order)
    multigrid = Multigrid(A)
    steps = 0
    for k in range(0, B.shape[1], 3):  # three columns at a time
        columns = slice(k, min(k + 3, B.shape[1]))
        count = columns.stop - k
        B3, X3 = np.zeros((2, len(B), 3))
        B3[:, :count], X3[:, :count] = B[:, columns], X[:, columns]
        # Half of it: rounding lets the true residual drift from the iteration's.
        steps += _conjugate_gradients(A, multigrid, B3, X3, tolerance / 2)
        X[:, columns] = X3[:, :count]
    return ordering.put_back(X, order, np.empty_like(X)), steps


def _conjugate_gradients(A, multigrid, B, X, tolerance):
    """Improve three columns X in place; return the number of steps.

    Preconditioned conjugate gradients, each column with step lengths of its own.
    """
    size = _lengths(B)
    X[:, size == 0] = 0
    P, AP = np.zeros((2, *X.shape))
    A_rows = (*unsigned(A.indptr, A.indices), A.data)
    on_all_cores(_multiply, len(X), *A_rows, X, AP)
    R = B - AP
    largest = np.abs(R).max()
    if np.all(_lengths(R) <= tolerance * size):
        return 0
    R_single = (R / largest).astype(np.float32)  # so that it stays in range
    zr = np.ones(3)
    for step in range(1, ITERATIONS + 1):
        zr_before = zr
        Z, zr = multigrid.cycle(R_single)
        zr *= largest
        on_all_cores(_turn, len(P), Z, _ratio(zr, zr_before), P)
        pap = _sums(on_all_cores(_multiply, len(P), *A_rows, P, AP))
        if not np.all(pap >= 0):  # A is not positive definite, or all is NaN
            return step
        rr = _sums(
            on_all_cores(_advance, len(P), _ratio(zr, pap), P, AP, 1 / largest, X, R, R_single)
        )
        if np.all(np.sqrt(rr) <= tolerance * size):
            return step
    return ITERATIONS


def _lengths(X):
    """Euclidean lengths of the columns, without the copies that np.linalg.norm makes."""
    return np.sqrt(np.einsum("ij,ij->j", X, X))


def _sums(of_blocks):
    return np.sum(of_blocks, axis=0)


def _ratio(a, b):
    """a / b, and 0 for columns that have nothing left to do."""
    return np.divide(a, b, out=np.zeros_like(a), where=b > 0)


@compiled
def _turn(first, last, Z, beta, P):
    """The next direction, conjugate to those before: p = z + beta p."""
    for i in range(first, last):
        for c in range(3):
            P[i, c] = Z[i, c] + beta[c] * P[i, c]


@compiled(fused=True)
def _multiply(first, last, indptr, indices, A, P, AP):
    """A p, and the sums p . A p."""
    p, pap_x, pap_y, pap_z = indptr[first], 0.0, 0.0, 0.0
    for i in range(first, last):
        x, y, z, p = row_product(p, indptr[i + 1], indices, A, P)
        AP[i, 0], AP[i, 1], AP[i, 2] = x, y, z
        pap_x += x * P[i, 0]
        pap_y += y * P[i, 1]
        pap_z += z * P[i, 2]
    return pap_x, pap_y, pap_z


@compiled
def _advance(first, last, alpha, P, AP, scale, X, R, R_single):
    """x + alpha p and r - alpha A p, and the sums r . r."""
    rr_x = rr_y = rr_z = 0.0
    for i in range(first, last):
        for c in range(3):
            X[i, c] += alpha[c] * P[i, c]
            R[i, c] -= alpha[c] * AP[i, c]
            R_single[i, c] = scale * R[i, c]
        rr_x += R[i, 0] * R[i, 0]
        rr_y += R[i, 1] * R[i, 1]
        rr_z += R[i, 2] * R[i, 2]
    return rr_x, rr_y, rr_z
