"""Diffusion: averaging, heat flow, implicit steps, quadratic regularisation, Taubin's filter.

All work with each of the original report's three edge weights. Steps and strengths do not
depend on the mesh's scale: they are multiples of its mean edge length.

References
----------
.. [MD99] M. Desbrun, M. Meyer, P. Schroeder, A. Barr, "Implicit fairing of irregular
   meshes using diffusion and curvature flow", SIGGRAPH 1999.
.. [Taubin95] G. Taubin, "A signal processing approach to fair surface design",
   SIGGRAPH 1995.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array, diags_array

from meshfair import flow, solve
from meshfair.checks import (
    LARGEST_COORDINATE,
    Floats,
    Integers,
    MeshError,
    check_choice,
    check_count,
    check_fixed,
    check_mesh,
    check_number,
)
from meshfair.mesh import Edges, Triangles, is_closed, mean_edge_length, volume
from meshfair.operators import averaging as averaging_operator
from meshfair.operators import laplacian, mass
from meshfair.weights import BY_NAME

# Height over longest edge below which a face's shape can make a system hard to solve: there the
# cotangents are above a hundred.
FLAT = 0.01


def averaging(
    V: ArrayLike,
    F: ArrayLike,
    *,
    weights: str = "combinatorial",
    iterations: int = 2,
    fixed: ArrayLike | None = None,
) -> Iterator[tuple[float, Floats]]:
    """Iterated averaging V~ = W~^s V, as an iterator: each vertex moves to its neighbours' mean.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    weights : {"combinatorial", "distance", "cotangent"}
        Built once, from the noisy mesh.
    iterations : int
        How many, the s of the formula.
    fixed : array_like, optional
        Vertices that keep their place, as a boolean mask (n,) or as indices.

    Yields
    ------
    progress : float
        The part of the work that is done; 1 at the end.
    V : ndarray of float64, shape (n, 3)

    Raises
    ------
    MeshError, ValueError
        No mesh, or a parameter outside its range.

    Warns
    -----
    StabilityWarning
        Cotangent weights so negative that the iteration may grow.
    """
    iterations = check_count(iterations, "iterations")
    yield from heat(V, F, weights=weights, tau=1.0, time=iterations, fixed=fixed)


def heat(
    V: ArrayLike,
    F: ArrayLike,
    *,
    weights: str = "combinatorial",
    tau: float = 0.2,
    time: float = 2.0,
    fixed: ArrayLike | None = None,
) -> Iterator[tuple[float, Floats]]:
    """The heat flow by forward Euler, V+ = (1 - tau) V + tau W~ V, as an iterator.

    Parameters
    ----------
    V, F, weights, fixed
        As in `averaging`.
    tau : float
        Time step, above 0, best at most 1.
    time : float
        How long to flow.

    Yields
    ------
    progress, V
        As `averaging`.

    Raises
    ------
    MeshError, ValueError
        As `averaging`.

    Warns
    -----
    StabilityWarning
        See `meshfair.flow.heat`.
    """
    V, F = check_mesh(V, F)
    tau = check_number(tau, "tau", 0, open_low=True)
    A = averaging_operator(_edge_weights(V, F, weights))
    states = flow.heat(V, A, tau, time, fixed=fixed)
    next(states)  # at time 0
    for t, X in states:
        yield min(1.0, t / time), X


def taubin(
    V: ArrayLike,
    F: ArrayLike,
    *,
    weights: str = "combinatorial",
    lam: float = 0.5,
    mu: float = -0.53,
    iterations: int = 10,
    fixed: ArrayLike | None = None,
) -> Iterator[tuple[float, Floats]]:
    """Taubin's filter [Taubin95]_, as an iterator: smoothing without shrinking.

    Each iteration is a step of heat flow and a slightly larger one backwards,
    V <- V + lambda (W~ - I) V, then V <- V + mu (W~ - I) V: a low-pass filter
    that leaves slow variations as they are.

    Parameters
    ----------
    V, F, weights, fixed
        As in `averaging`.
    lam, mu : float
        lambda > 0 and mu < -lambda.
    iterations : int

    Yields
    ------
    progress, V
        As `averaging`.

    Raises
    ------
    MeshError, ValueError
        As `averaging`; also: positions that outgrow all numbers, with a large mu.
    """
    V, F = check_mesh(V, F)
    lam = check_number(lam, "lam", 0, 1, open_low=True)
    mu = check_number(mu, "mu", -np.inf, -lam)
    iterations = check_count(iterations, "iterations")
    free = ~check_fixed(fixed, len(V))[:, None]
    A = averaging_operator(_edge_weights(V, F, weights))
    X: Floats = V
    for step in range(1, iterations + 1):
        with np.errstate(over="ignore", invalid="ignore"):
            for factor in (lam, mu):
                X = X + factor * free * (A @ X - X)
        if not np.abs(X).max() <= LARGEST_COORDINATE:  # so that NaN is caught
            raise MeshError(
                f"the filter has outgrown all numbers in iteration {step}; take mu = {mu:g} "
                f"closer to -lam = {-lam:g}, or fewer iterations"
            )
        yield step / iterations, X


def implicit(
    V: ArrayLike,
    F: ArrayLike,
    *,
    weights: str = "cotangent",
    step: float = 0.25,
    iterations: int = 1,
    keep_volume: bool = False,
    fixed: ArrayLike | None = None,
) -> Iterator[tuple[float, Floats]]:
    """Implicit fairing [MD99]_, as an iterator: backward Euler steps of the diffusion.

    (M + t L) V+ = M V with the mass matrix M and the Laplacian L = D - W,
    both built anew from the positions before each step. Stable for every t.

    Parameters
    ----------
    V, F, weights, fixed
        As in `averaging`. With cotangent weights this is mean curvature flow.
    step : float
        t, in squared mean edge lengths of the input.
    iterations : int
    keep_volume : bool
        After each step, scale the mesh about its centroid back to the
        volume it had at the start.

    Yields
    ------
    progress, V
        As `averaging`.

    Raises
    ------
    MeshError, ValueError
        As `averaging`; also: ``keep_volume`` on an open mesh or together with ``fixed``.
    SolveError
        The linear system could not be solved.
    """
    V, F = check_mesh(V, F)
    step = check_number(step, "step", 0)
    iterations = check_count(iterations, "iterations")
    rescale = volume_keeper(V, F, keep_volume, fixed)
    edges, length = Edges(F, len(V)), mean_edge_length(V, F)
    for k in range(1, iterations + 1):
        L = _laplacian(V, edges, weights, length)
        with _cause_named(V, F, f"step={step:g}"):
            V = rescale(solve.implicit_step(V, L, mass(V, F), step * length**2, fixed=fixed))
        yield k / iterations, V


def regularised(
    V: ArrayLike,
    F: ArrayLike,
    *,
    weights: str = "cotangent",
    order: int = 1,
    lam: float = 0.25,
    keep_volume: bool = False,
    fixed: ArrayLike | None = None,
) -> Iterator[tuple[float, Floats]]:
    """Quadratic regularisation, as the original report proposes it, as an iterator: one solution.

    The minimiser of |V' - V|_M^2 + lambda E(V'), with a penalty on the gradient
    or, of second order, on the Laplacian:

        E(V') = <V', L V'>              (M + lambda L) V' = M V,
        E(V') = |M^-1 L V'|_M^2         (M + lambda L M^-1 L) V' = M V.

    The first is one implicit step of size lambda; the second leaves low
    frequencies alone and damps high ones more.

    Parameters
    ----------
    V, F, weights, fixed
        As in `implicit`; it yields once.
    order : {1, 2}
    lam : float
        lambda, in mean edge lengths to the power 2 (order 1) or 4 (order 2).
    keep_volume : bool
        As in `implicit`.

    Yields
    ------
    progress, V
        As `averaging`.

    Raises
    ------
    MeshError, ValueError
        As `averaging`.
    """
    V, F = check_mesh(V, F)
    check_choice(order, "order", (1, 2))
    lam = check_number(lam, "lam", 0)
    rescale = volume_keeper(V, F, keep_volume, fixed)
    length = mean_edge_length(V, F)
    L = _laplacian(V, F, weights, length)
    M = mass(V, F)
    if order == 2:
        m = M.diagonal()
        inverse = np.divide(1.0, m, out=np.zeros_like(m), where=m > 0)
        L = L @ diags_array(inverse) @ L
    with _cause_named(V, F, f"lam={lam:g}"):
        V = rescale(solve.implicit_step(V, L, M, lam * length ** (2 * order), fixed=fixed))
    yield 1.0, V


@contextmanager
def _cause_named(V: Floats, F: Integers, size: str) -> Iterator[None]:
    """Where a system cannot be solved, name the triangle that is most likely why, or the step."""
    try:
        yield
    except solve.SolveError as error:
        T = Triangles(V, F)
        flattest = int(np.argmin(np.where(T.degenerate, np.inf, T.flatness)))
        if T.flatness[flattest] > FLAT:
            raise solve.SolveError(f"{error}. No face is flat: {size} is too large") from None
        raise solve.SolveError(
            f"{error}. The flattest face is {flattest}, with vertices {F[flattest].tolist()}: its "
            f"height is {T.flatness[flattest]:.2g} of its longest edge; move or drop what is so "
            'flat, or take weights="combinatorial"'
        ) from None


def _edge_weights(V: Floats, F: Integers | Edges, kind: str) -> csr_array:
    """One of the original report's three edge weights."""
    return BY_NAME[check_choice(kind, "weights", BY_NAME)](V, F)


def _laplacian(V: Floats, F: Integers | Edges, kind: str, length: float) -> csr_array:
    """L = D - W of the mesh measured in this length, so that its scale does not matter."""
    return laplacian(_edge_weights(V / (length or 1.0), F, kind))


def volume_keeper(
    V: Floats, F: Integers, keep_volume: bool, fixed: ArrayLike | None
) -> Callable[[Floats], Floats]:
    """A function that scales positions about their centroid to the volume that V has.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    keep_volume : bool
        Without it, the function leaves positions as they are.
    fixed : array_like or None
        Constrained vertices.

    Returns
    -------
    function of an array of shape (n, 3)

    Raises
    ------
    MeshError, ValueError
        The mesh is open or encloses nothing; vertices are fixed, which scaling
        would move.
    """
    if not keep_volume:
        return lambda X: X
    if fixed is not None:
        raise ValueError("keep_volume scales the whole mesh, so no vertex can stay fixed")
    target = volume(V, F)
    if not is_closed(F) or target == 0:
        raise MeshError("keep_volume needs a closed mesh with a volume; this one has none")

    def rescale(X: Floats) -> Floats:
        reached = volume(X, F)
        if reached * target <= 0:
            raise MeshError("the step turned the mesh inside out; take a smaller one")
        centroid = X.mean(axis=0)
        return centroid + (target / reached) ** (1 / 3) * (X - centroid)

    return rescale
