"""Sparse symmetric positive definite systems, such as the implicit step of a flow."""

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import splu

from meshfair import ordering
from meshfair.checks import MeshError, check_number, check_vertices
from meshfair.kernels import compiled, on_all_cores, unsigned
from meshfair.multigrid import Multigrid
from meshfair.operators import pinned

METHODS = ("auto", "direct", "iterative")
# On surface meshes a factorisation is quicker up to here, and where A is hardly
# more than a Laplacian (long steps), up to there.
DIRECT = 5_000
DIRECT_WHEN_STIFF = 25_000
# (M + t L has row sums M: so small a part of the diagonal is left at t = 30 squared edges.)
STIFF = 0.01
# Multigrid needs 10 to 50 iterations on meshes; so many more mean that something is wrong.
ITERATIONS = 500


class SolveError(ArithmeticError):
    """A system that could not be solved; the message says how far it came, and why."""


def spd(A, B, *, guess=None, fixed=None, method="auto", tolerance=1e-8):
    """Solve A X = B for a sparse symmetric positive definite A.

    Parameters
    ----------
    A : sparse array, shape (n, n)
        Symmetric and positive definite; symmetry is not checked.
    B : array_like, shape (n, k) or (n,)
        Right-hand sides, one a column.
    guess : array_like, shape of ``B``, optional
        Where the iteration starts; zero without it.
    fixed : array_like, optional
        Unknowns that are held, as a boolean mask (n,) or as indices: their
        rows of X are those of ``guess``, and their equations are left out.
    method : {"auto", "direct", "iterative"}
        SuperLU's factorisation, or conjugate gradients with a multigrid cycle
        as preconditioner; ``auto`` takes what is quicker for the size and the step.
    tolerance : float
        Each column ends with |A x - b| <= tolerance |b|; at least 1e-13.

    Returns
    -------
    X : ndarray of float64, shape of ``B``

    Raises
    ------
    MeshError, ValueError
        Arrays that do not fit together or are not finite; ``fixed`` without
        ``guess``; an unknown method.
    SolveError
        The residual stays above the tolerance, or A is singular.
    """
    A, B = csr_array(A, dtype=np.float64), np.asarray(B, dtype=np.float64)
    n = A.shape[0]
    if A.shape != (n, n) or B.ndim not in (1, 2) or len(B) != n:
        raise MeshError(f"A has shape {A.shape} and B {B.shape}; give (n, n) and (n, k)")
    X = np.zeros_like(B) if guess is None else np.array(guess, dtype=np.float64)
    if X.shape != B.shape:
        raise MeshError(f"guess has shape {X.shape}; give that of B, {B.shape}")
    for Y, name in ((A.data, "A"), (B, "B"), (X, "guess")):
        if not np.isfinite(Y).all():
            raise MeshError(f"{name} holds NaN or infinite numbers; build it from a checked mesh")
    if method not in METHODS:
        raise ValueError(f"method is {method!r}; give one of {', '.join(METHODS)}")
    tolerance = check_number(tolerance, "tolerance", 1e-13, 1)
    if fixed is None:
        return _solve(A, B.reshape(n, -1), X.reshape(n, -1), method, tolerance).reshape(B.shape)
    if guess is None:
        raise ValueError("fixed needs guess, whose rows are the values that are held")
    free = ~pinned(fixed, n)
    if free.any():
        A = A[free]
        X[free] = spd(
            A[:, free],
            B[free] - A[:, ~free] @ X[~free],
            guess=X[free],
            method=method,
            tolerance=tolerance,
        )
    return X


def implicit_step(V, L, M, t, *, fixed=None, method="auto", tolerance=1e-8):
    """One backward Euler step of the diffusion dV/dt = -M^-1 L V [MD99].

    Solves (M + t L) V+ = M V for the three coordinates at once. It is stable
    for every t.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    L : sparse array, shape (n, n)
        Laplacian, see `meshfair.operators.laplacian`.
    M : sparse array, shape (n, n)
        Diagonal mass matrix, see `meshfair.operators.mass`.
    t : float
        Time step, at least 0, in squared units of length.
    fixed : array_like, optional
        Vertices that keep their place, as a boolean mask (n,) or as indices.
        Those without mass keep it in any case.
    method, tolerance
        As in `spd`; the tolerance is relative to the mesh around its centre.

    Returns
    -------
    ndarray of float64, shape (n, 3)

    Raises
    ------
    MeshError, ValueError, SolveError
        As `spd`, or a negative ``t``.
    """
    V = check_vertices(V)
    t = check_number(t, "t", 0)
    n = len(V)
    for A, name in ((L, "L"), (M, "M")):
        if np.shape(A) != (n, n):
            raise MeshError(f"{name} has shape {np.shape(A)}, but V has {n} vertices")
    m = csr_array(M).diagonal()
    held = (m == 0) if fixed is None else (m == 0) | pinned(fixed, n)
    centre = V.mean(axis=0)
    X = V - centre
    try:
        X = spd(
            M + t * L,
            m[:, None] * X,
            guess=X,
            fixed=held if held.any() else None,
            method=method,
            tolerance=tolerance,
        )
    except SolveError as error:
        raise SolveError(f"implicit step of t = {t:g}: {error}") from None
    X += centre
    X[held] = V[held]  # to the last digit
    return X


def _solve(A, B, X, method, tolerance):
    """Solve by the method, and check the residual."""
    if method == "auto":
        stiff = A.sum() < STIFF * A.trace()
        direct = len(B) <= (DIRECT_WHEN_STIFF if stiff else DIRECT)
        method = "direct" if direct else "iterative"
    try:
        X, how = _direct(A, B) if method == "direct" else _iterative(A, B, X, tolerance)
    except RuntimeError as error:  # SuperLU's word for a pivot of zero
        raise SolveError(f"A is singular ({error}); is every part of the mesh held?") from None
    size = _lengths(B)
    residual = _lengths(A @ X - B)
    if not np.all(residual <= tolerance * size):  # so that NaN is caught
        worst = np.max(np.divide(residual, size, out=residual.copy(), where=size > 0))
        raise SolveError(
            f"{how} left a residual of {worst:.3g} |b|, more than the tolerance {tolerance:g}; "
            "A is not positive definite, or so close to singular that rounding decides"
        )
    return X


def _direct(A, B):
    factors = splu(
        A.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0, options={"SymmetricMode": True}
    )
    return factors.solve(B), "the factorisation"


def _iterative(A, B, X, tolerance):
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
    X = ordering.put_back(X, order)
    return X, f"the iteration stopped after {steps} steps and"


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
    pap_x = pap_y = pap_z = 0.0
    for i in range(first, last):
        x = y = z = 0.0
        for p in range(indptr[i], indptr[i + 1]):
            a, j = A[p], indices[p]
            x += a * P[j, 0]
            y += a * P[j, 1]
            z += a * P[j, 2]
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
