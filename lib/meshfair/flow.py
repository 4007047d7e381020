"""Iterated averaging, the heat equation by forward Euler, and when to stop."""

import warnings
from numbers import Integral
from typing import NamedTuple

import numpy as np

from meshfair import ordering
from meshfair.checks import (
    MeshError,
    StabilityWarning,
    check_number,
    check_same_vertices,
    check_vertices,
)
from meshfair.kernels import compiled, on_all_cores, unsigned
from meshfair.operators import check_operator, pinned, stable_step, surely_stable

# From so many steps on, on a mesh whose positions outgrow the caches, ordering
# the vertices for locality first is repaid.
STEPS_WORTH_ORDERING = 8
VERTICES_WORTH_ORDERING = 100_000


class BestStopping(NamedTuple):
    """Where a flow comes closest to the clean mesh."""

    time: float
    """Flow time with the highest SNR; 0 where the flow never helps."""
    snr: float
    """SNR at that time, in decibels."""
    gain: float
    """Gain over the noisy mesh's SNR, in percent of it (the seed's Table 1)."""


def average(V, A, steps, *, fixed=None):
    """Iterated averaging, V~ = W~^s V (the seed, section 2.1).

    Parameters
    ----------
    V : array_like, shape (n, 3)
    A : sparse array, shape (n, n)
        Averaging operator, see `meshfair.operators.averaging`.
    steps : int
        Number s of iterations, at least 0.
    fixed : array_like, optional
        Vertices that keep their place, as a boolean mask (n,) or as indices.

    Returns
    -------
    ndarray of float64, shape (n, 3)

    Raises
    ------
    MeshError, ValueError
        Arrays that do not fit together, or ``steps`` no whole number >= 0.
    """
    V = check_vertices(V)
    A = check_operator(A, len(V))
    held = _held(fixed, len(V))
    if not isinstance(steps, Integral) or steps < 0:
        raise ValueError(f"steps is {steps!r}; give a whole number of at least 0")
    order, A = _order_for(A, steps)
    X, held = _in_order(order, V if steps else V.copy(), held)
    Y = np.empty_like(V)
    for _ in range(steps):
        _step(A, X, held, 1.0, Y)
        X, Y = Y, np.empty_like(V) if X is V else X  # V itself is not ours to write to
    return X if order is None else ordering.put_back(X, order, Y)


def heat(V, A, tau, time, *, rebuild=False, fixed=None):
    """The heat equation by forward Euler, as an iterator (the seed, section 2.2).

    V+ = (1 - tau) V + tau W~ V. With tau = 1 this is `average`.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        Positions at time 0.
    A : sparse array, shape (n, n), or callable
        Averaging operator, or a function that builds one from positions, such
        as ``lambda V: averaging(weights.cotangent(V, F))``.
    tau : float
        Time step; in (0, 1] the flow is stable with nonnegative weights.
        Below 0 the flow runs backwards, which amplifies noise.
    time : float
        How long to flow, at least 0. Whole steps only: the last state is at
        the largest multiple of tau up to ``time``.
    rebuild : bool
        Build the operator anew from the moved vertices before every step;
        needs a function for ``A``. Let it take a `meshfair.weights.Pattern`
        for F, so that only values are computed anew. The seed does not say
        which it did; its figures agree with operators built once.
    fixed : array_like, optional
        Vertices that keep their place, as a boolean mask (n,) or as indices.

    Yields
    ------
    time : float
        0, tau, 2 tau, ...
    V : ndarray of float64, shape (n, 3)
        A new array at each step; the iterator holds only two.

    Raises
    ------
    MeshError, ValueError
        At the call: arrays that do not fit together, tau zero or not finite,
        a negative time, ``rebuild`` without a function.

    Warns
    -----
    StabilityWarning
        tau is outside (0, 1], or past the stable step that negative
        weights leave; the message names the bound.
    """
    V, A, tau, steps, build, held = _checked(V, A, tau, time, rebuild, fixed)
    _warn_if_unstable(A, tau, stacklevel=3)
    return _heat(V, A, tau, steps, build, held)


def _heat(V, A, tau, steps, build, held):
    yield 0.0, V.copy()
    for step in range(1, steps + 1):
        if build and step > 1:
            A = check_operator(build(V), len(V))
        V_next = np.empty_like(V)
        _step(A, V, held, tau, V_next)
        V = V_next
        yield _time(step, tau), V


def best_stopping(V_noisy, V_clean, A, tau, time, *, rebuild=False, fixed=None):
    """The stopping time at which the heat flow's SNR is highest (the seed, Table 1).

    Parameters
    ----------
    V_noisy : array_like, shape (n, 3)
        Where the flow starts.
    V_clean : array_like, shape (n, 3)
        What it is compared with.
    A, tau, time, rebuild, fixed
        As in `heat`.

    Returns
    -------
    BestStopping
        time, snr in decibels, gain in percent of the noisy mesh's SNR.

    Raises
    ------
    MeshError, ValueError
        As `heat` and `meshfair.noise.snr`.
    """
    curve = _snr_curve(V_noisy, V_clean, A, tau, time, rebuild, fixed)
    start = curve[0, 1]
    best_time, best = curve[curve[:, 1].argmax()]
    gain = 100 * (best - start) / abs(start) if best > start else 0.0
    return BestStopping(float(best_time), float(best), float(gain))


def snr_curve(V_noisy, V_clean, A, tau, time, *, rebuild=False, fixed=None):
    """SNR along the heat flow (the seed, Figures 3 and 6).

    Parameters and errors are those of `best_stopping`.

    Returns
    -------
    ndarray of float64, shape (steps + 1, 2)
        Rows of flow time and SNR in decibels, from time 0.
    """
    return _snr_curve(V_noisy, V_clean, A, tau, time, rebuild, fixed)


def _snr_curve(V_noisy, V_clean, A, tau, time, rebuild, fixed):
    V, A, tau, steps, build, held = _checked(V_noisy, A, tau, time, rebuild, fixed)
    _warn_if_unstable(A, tau, stacklevel=4)
    V_clean, V = check_same_vertices(V_clean, V, ("V_clean", "V_noisy"))
    signal = np.linalg.norm(V_clean, axis=1).sum()
    if signal == 0:
        raise MeshError("V_clean has all its vertices at the origin, so it has no SNR; move it")

    order, A = (None, A) if build else _order_for(A, steps)
    X, V_clean, held = _in_order(order, V.copy(), V_clean, held)
    Y = np.empty_like(X)
    curve = np.empty((steps + 1, 2))
    for step in range(steps + 1):
        if build and step > 1:
            A = check_operator(build(X), len(X))
        # Step 0 holds all vertices: it only measures, and rounds as the others do.
        noise = _step(A, X, held if step else np.ones_like(held), tau, Y, V_clean)
        if not np.isfinite(noise):
            raise MeshError(
                f"the flow has outgrown all numbers at time {_time(step, tau):g}; take a smaller "
                f"step than tau = {tau:g}, or stop earlier"
            )
        curve[step] = _time(step, tau), -20 * np.log10(noise / signal) if noise else np.inf
        X, Y = Y, X
    return curve


def _step(A, V, held, tau, V_next, V_clean=None):
    """Write one step of the flow to V_next; return sum_i |v_i - v_clean_i| if V_clean is given."""
    A_rows = (*unsigned(A.indptr, A.indices), A.data)
    if tau == 1 and V_clean is None and not held.any():
        on_all_cores(_average, len(V), *A_rows, V, V_next)
        return None
    V_clean = np.empty((0, 3)) if V_clean is None else V_clean
    return sum(on_all_cores(_flow, len(V), *A_rows, V, held, tau, V_next, V_clean))


@compiled(fused=True)
def _average(first, last, indptr, indices, A, V, V_next):
    """v+_i = sum_j a_ij v_j: `_flow` for tau = 1 and nothing held, with less to do per row."""
    p, one = indptr[first], indptr.dtype.type(1)  # of one type: numba adds two as floats
    for i in range(first, last):
        x = y = z = 0.0
        while p < indptr[i + 1]:
            a, j = A[p], indices[p]
            x += a * V[j, 0]
            y += a * V[j, 1]
            z += a * V[j, 2]
            p += one
        V_next[i, 0], V_next[i, 1], V_next[i, 2] = x, y, z


@compiled(fused=True)
def _flow(first, last, indptr, indices, A, V, held, tau, V_next, V_clean):
    """v+_i = (1 - tau) v_i + tau sum_j a_ij v_j, but v+_i = v_i where held."""
    noise = 0.0
    p, one = indptr[first], indptr.dtype.type(1)
    for i in range(first, last):
        x = y = z = 0.0
        while p < indptr[i + 1]:
            a, j = A[p], indices[p]
            x += a * V[j, 0]
            y += a * V[j, 1]
            z += a * V[j, 2]
            p += one
        if held[i]:
            x, y, z = V[i, 0], V[i, 1], V[i, 2]
        else:
            x = (1 - tau) * V[i, 0] + tau * x
            y = (1 - tau) * V[i, 1] + tau * y
            z = (1 - tau) * V[i, 2] + tau * z
        V_next[i, 0], V_next[i, 1], V_next[i, 2] = x, y, z
        if len(V_clean):
            dx, dy, dz = x - V_clean[i, 0], y - V_clean[i, 1], z - V_clean[i, 2]
            noise += np.sqrt(dx * dx + dy * dy + dz * dz)
    return noise


def _time(step, tau):
    return round(step * tau, 12)  # 0.6, not 0.6000000000000001


def _held(fixed, n):
    return np.zeros(n, dtype=bool) if fixed is None else pinned(fixed, n)


def _order_for(A, steps):
    """An order of the vertices in which so many steps are quicker, or None; and A in it."""
    few = steps < STEPS_WORTH_ORDERING or A.shape[0] < VERTICES_WORTH_ORDERING
    return (None, A) if few or ordering.is_near(A) else ordering.nearby(A)


def _in_order(order, *of_vertices):
    """Arrays with a row for each vertex, in this order of the vertices."""
    if order is None:
        return of_vertices
    return tuple(ordering.take(X, order) for X in of_vertices)


def _checked(V, A, tau, time, rebuild, fixed):
    """Check what a heat flow is called with; A, or its first value, as csr_array."""
    V = check_vertices(V)
    tau = check_number(tau, "tau", -np.inf)
    time = check_number(time, "time", 0)
    if tau == 0:
        raise ValueError("tau is 0; give a time step in (0, 1]")
    if rebuild and not callable(A):
        raise ValueError(
            "rebuild=True needs a function that builds the operator from V, such as "
            "lambda V: averaging(weights.cotangent(V, F)); A is a matrix"
        )
    build = A if rebuild else None
    A = check_operator(A(V) if callable(A) else A, len(V))
    held = _held(fixed, len(V))
    steps = int(time / abs(tau) * (1 + 1e-12))  # 0.6 / 0.2 is 2.9999999999999996
    return V, A, tau, steps, build, held


def _warn_if_unstable(A, tau, stacklevel):
    if 0 < tau <= 1 and (not A.nnz or A.data.min() >= 0):
        return  # every new vertex is a mean of old ones: nothing can grow
    if 0 < tau <= 1 and surely_stable(A, tau):
        return
    bound = stable_step(A)
    if 0 < tau <= 1 and tau <= bound * (1 + 1e-3):  # the accuracy of the bound
        return
    advice = f"the bound on this mesh is tau = {bound:.3g}" if bound else "no step is stable"
    reason = "with negative weights" if 0 < tau <= 1 else "outside (0, 1]"
    warnings.warn(
        f"tau = {tau:g} {reason}: the flow may grow instead of smoothing; {advice}, "
        "2 over the spectral radius of I - A",
        StabilityWarning,
        stacklevel=stacklevel,
    )
