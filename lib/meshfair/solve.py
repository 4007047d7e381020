"""Sparse symmetric positive definite systems, such as the implicit step of a flow.

References
----------
.. [MD99] M. Desbrun, M. Meyer, P. Schroeder, A. Barr, "Implicit fairing of irregular
   meshes using diffusion and curvature flow", SIGGRAPH 1999.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array, diags_array, sparray
from scipy.sparse.linalg import cg, splu

from meshfair import _fast
from meshfair.checks import (
    Floats,
    MeshError,
    check_choice,
    check_fixed,
    check_number,
    check_vertices,
)

METHODS = ("auto", "direct", "iterative")
# On surface meshes a factorisation is quicker up to here, and where A is hardly
# more than a Laplacian (long steps), up to there.
DIRECT = 5_000
DIRECT_WHEN_STIFF = 25_000
# (M + t L has row sums M: so small a part of the diagonal is left at t = 30 squared edges.)
STIFF = 0.01


class SolveError(ArithmeticError):
    """A system that could not be solved; the message says how far it came, and why."""


def spd(
    A: sparray,
    B: ArrayLike,
    *,
    guess: ArrayLike | None = None,
    fixed: ArrayLike | None = None,
    method: str = "auto",
    tolerance: float = 1e-8,
) -> Floats:
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
        Constrained unknowns, as a boolean mask (n,) or as indices: their
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
    check_choice(method, "method", METHODS)
    tolerance = check_number(tolerance, "tolerance", 1e-13, 1)
    if fixed is None:
        return _solve(A, B.reshape(n, -1), X.reshape(n, -1), method, tolerance).reshape(B.shape)
    if guess is None:
        raise ValueError("fixed needs guess, whose rows are the values that they keep")
    free = ~check_fixed(fixed, n)
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


def implicit_step(
    V: ArrayLike,
    L: sparray,
    M: sparray,
    t: float,
    *,
    fixed: ArrayLike | None = None,
    method: str = "auto",
    tolerance: float = 1e-8,
) -> Floats:
    """One backward Euler step of the diffusion dV/dt = -M^-1 L V [MD99]_.

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
    constrained = (m == 0) | check_fixed(fixed, n)
    centre = V.mean(axis=0)
    X = V - centre
    try:
        X = spd(
            M + t * L,
            m[:, None] * X,
            guess=X,
            fixed=constrained if constrained.any() else None,
            method=method,
            tolerance=tolerance,
        )
    except SolveError as error:
        raise SolveError(f"implicit step of t = {t:g}: {error}") from None
    X += centre
    X[constrained] = V[constrained]  # to the last digit
    return X


def _solve(A: csr_array, B: Floats, X: Floats, method: str, tolerance: float) -> Floats:
    """Solve by the method, and check the residual."""
    if method == "auto":
        stiff = A.sum() < STIFF * A.trace()
        direct = len(B) <= (DIRECT_WHEN_STIFF if stiff else DIRECT)
        method = "direct" if direct else "iterative"
    try:
        X, how = _direct(A, B) if method == "direct" else _iterative(A, B, X, tolerance)
    except RuntimeError as error:  # SuperLU's word for a pivot of zero
        raise SolveError(f"A is singular ({error}); is every part of the mesh fixed?") from None
    size = _lengths(B)
    residual = _lengths(A @ X - B)
    if not np.all(residual <= tolerance * size):  # so that NaN is caught
        worst = np.max(np.divide(residual, size, out=residual.copy(), where=size > 0))
        raise SolveError(
            f"{how} left a residual of {worst:.3g} |b|, more than the tolerance {tolerance:g}; "
            "A is not positive definite, or so close to singular that rounding decides"
        )
    return X


def _direct(A: csr_array, B: Floats) -> tuple[Floats, str]:
    factors = splu(
        A.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0, options={"SymmetricMode": True}
    )
    return factors.solve(B), "the factorisation"


def _iterative(A: csr_array, B: Floats, X: Floats, tolerance: float) -> tuple[Floats, str]:
    """Conjugate gradients: with a multigrid cycle on large meshes, else with the diagonal."""
    diagonal = A.diagonal()
    if not diagonal.min() > 0:
        row = diagonal.argmin()
        raise SolveError(
            f"A is not positive definite: row {row} has {diagonal[row]:g} on the diagonal"
        )
    if _fast.wanted(len(B)):
        X, steps = _fast.cg.solve(A, B, X, tolerance)
        return X, f"the iteration stopped after {steps} steps and"
    inverse = diags_array(1 / diagonal)
    columns = [
        cg(A, b, x, rtol=tolerance / 2, maxiter=2 * len(B), M=inverse)[0]
        for b, x in zip(B.T, X.T, strict=True)
    ]
    return np.column_stack(columns), "the iteration"


def _lengths(X: Floats) -> Floats:
    """Euclidean lengths of the columns, without the copies that np.linalg.norm makes."""
    return np.sqrt(np.einsum("ij,ij->j", X, X))
