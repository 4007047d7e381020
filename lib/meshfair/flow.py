"""Iterated averaging, the heat equation by forward Euler, and when to stop."""

from collections.abc import Callable, Iterator
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array, sparray

from meshfair import _fast
from meshfair.checks import (
    LARGEST_COORDINATE,
    Booleans,
    Floats,
    MeshError,
    check_count,
    check_fixed,
    check_number,
    check_operator,
    check_same_vertices,
    check_square,
    check_vertices,
)
from meshfair.metrics import snr, snr_of_distances
from meshfair.stability import warn_if_unstable

Builder = Callable[[Floats], sparray]
Operator: TypeAlias = sparray | Builder
Fixed: TypeAlias = ArrayLike | None

# Steps of a flow: on the smallest mesh, these would take hours.
MOST_STEPS = 1e9


class BestStopping(NamedTuple):
    """Where a flow comes closest to the ground truth."""

    time: float
    """Flow time with the highest SNR; 0 where the flow never helps."""
    snr: float
    """SNR at that time, in decibels."""
    gain: float
    """Gain over the noisy mesh's SNR, in percent of it (the original report's Table 1)."""


def average(V: ArrayLike, A: sparray, iterations: int, *, fixed: ArrayLike | None = None) -> Floats:
    """Iterated averaging, V~ = W~^s V (the original report, section 2.1).

    Parameters
    ----------
    V : array_like, shape (n, 3)
    A : sparse array, shape (n, n)
        Averaging operator W~, see `meshfair.operators.averaging`.
    iterations : int
        Their number s, at least 0.
    fixed : array_like, optional
        Vertices that keep their place, as a boolean mask (n,) or as indices.

    Returns
    -------
    ndarray of float64, shape (n, 3)

    Raises
    ------
    MeshError, ValueError
        Arrays that do not fit together, or ``iterations`` no whole number >= 0.
    """
    V = check_vertices(V, values=False)
    A = check_operator(A, len(V), entries=False)
    fixed = check_fixed(fixed, len(V))
    iterations = check_count(iterations, "iterations")
    if _fast.wanted(len(V)):  # which checks what V and A hold on its way
        return _fast.flow.average(V, A, iterations, fixed)
    V, A = check_vertices(V), check_square(A)
    X = V.copy()
    for _ in range(iterations):
        X = A @ X
        X[fixed] = V[fixed]
    return X


def heat(
    V: ArrayLike, A: Operator, tau: float, time: float, *, fixed: Fixed = None
) -> Iterator[tuple[float, Floats]]:
    """The heat equation by forward Euler, as an iterator (the original report, section 2.2).

    V+ = (1 - tau) V + tau W~ V. With tau = 1 this is `average`.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        Positions at time 0.
    A : sparse array, shape (n, n), or callable
        Averaging operator W~, or a function such as ``lambda V:
        averaging(weights.cotangent(V, edges))`` that builds it anew from the
        moved vertices before every step. The original report does not say
        which it did; its figures agree with operators built once.
    tau : float
        Time step; in (0, 1] the flow is stable with nonnegative weights.
        Below 0 the flow runs backwards, which amplifies noise.
    time : float
        How long to flow, at least 0. Whole steps only: the last state is at
        the largest multiple of tau up to ``time``.
    fixed : array_like, optional
        Vertices that keep their place, as a boolean mask (n,) or as indices.

    Returns
    -------
    iterator of (float, ndarray of float64, shape (n, 3))
        Times 0, tau, 2 tau, ... and the positions then: a new array at each
        step; the iterator holds only two.

    Raises
    ------
    MeshError, ValueError
        At the call: arrays that do not fit together, tau zero or not finite,
        a negative time. On the way: a flow that grows beyond all bounds.

    Warns
    -----
    StabilityWarning
        tau is outside (0, 1], or past the stable step that negative
        weights leave; the message names the bound.
    """
    V, build, A, tau, steps, fixed = _checked(V, A, tau, time, fixed)
    warn_if_unstable(A, tau)
    return _states(V, build, A, tau, steps, fixed)


def _states(
    V: Floats, build: Builder | None, A: csr_array, tau: float, steps: int, fixed: Booleans
) -> Iterator[tuple[float, Floats]]:
    yield 0.0, V.copy()
    for step in range(1, steps + 1):
        if build and step > 1:
            A = check_operator(build(V), len(V))
        if _fast.wanted(len(V)):
            V = _fast.flow.step(V, A, tau, fixed)
        else:
            V_next = (1 - tau) * V + tau * (A @ V)
            V_next[fixed] = V[fixed]
            V = V_next
        _stop_if_outgrown(np.abs(V).max(), step, tau)
        yield round(step * tau, 12), V  # 0.6, not 0.6000000000000001


def snr_curve(
    V: ArrayLike, V_true: ArrayLike, A: Operator, tau: float, time: float, *, fixed: Fixed = None
) -> Floats:
    """SNR along the heat flow (the original report, Figures 3 and 6).

    Parameters
    ----------
    V : array_like, shape (n, 3)
        Noisy positions, where the flow starts.
    V_true : array_like, shape (n, 3)
        The ground truth that it is compared with.
    A, tau, time, fixed
        As in `heat`.

    Returns
    -------
    ndarray of float64, shape (steps + 1, 2)
        Rows of flow time and SNR in decibels, from time 0.

    Raises
    ------
    MeshError, ValueError
        As `heat` and `meshfair.metrics.snr`.
    """
    V_true, V = check_same_vertices(V_true, V, ("V_true", "V"))
    V, build, A, tau, steps, fixed = _checked(V, A, tau, time, fixed)
    warn_if_unstable(A, tau)
    if build or not _fast.wanted(len(V)):
        return np.array([(t, snr(V_true, X)) for t, X in _states(V, build, A, tau, steps, fixed)])
    distances = np.empty(steps + 1)
    for step, distance in enumerate(_fast.flow.distances(V, V_true, A, tau, steps, fixed)):
        _stop_if_outgrown(distance, step, tau)
        distances[step] = distance
    times = np.round(np.arange(steps + 1) * tau, 12)
    return np.column_stack([times, snr_of_distances(V_true, distances)])


def best_stopping(
    V: ArrayLike, V_true: ArrayLike, A: Operator, tau: float, time: float, *, fixed: Fixed = None
) -> BestStopping:
    """The stopping time at which the heat flow's SNR is highest (the original report, Table 1).

    Parameters
    ----------
    V, V_true, A, tau, time, fixed
        As in `snr_curve`.

    Returns
    -------
    BestStopping
        time, snr in decibels, gain in percent of the noisy mesh's SNR.

    Raises
    ------
    MeshError, ValueError
        As `snr_curve`.
    """
    curve = snr_curve(V, V_true, A, tau, time, fixed=fixed)
    start = curve[0, 1]
    best_time, best = curve[curve[:, 1].argmax()]
    gain = 100 * (best - start) / abs(start) if best > start else 0.0
    return BestStopping(float(best_time), float(best), float(gain))


def _checked(
    V: ArrayLike, A: Operator, tau: float, time: float, fixed: Fixed
) -> tuple[Floats, Builder | None, csr_array, float, int, Booleans]:
    """Positions, builder of operators if there is one, operator, tau, number of steps, fixed."""
    V = check_vertices(V)
    tau = check_number(tau, "tau", -np.inf)
    time = check_number(time, "time", 0)
    if tau == 0:
        raise ValueError("tau is 0; give a time step in (0, 1]")
    build = A if callable(A) else None
    A = check_operator(build(V) if build else A, len(V))
    steps = time / abs(tau) * (1 + 1e-12)  # 0.6 / 0.2 is 2.9999999999999996
    if steps > MOST_STEPS:
        raise ValueError(
            f"time is {time:g}, which is {steps:.1g} steps of tau = {tau:g}, more than anyone "
            f"waits for; give up to {MOST_STEPS * abs(tau):g}"
        )
    return V, build, A, tau, int(steps), check_fixed(fixed, len(V))


def _stop_if_outgrown(size: float, step: int, tau: float) -> None:
    if not size <= LARGEST_COORDINATE:  # so that NaN is caught
        raise MeshError(
            f"the flow has outgrown all numbers at time {round(step * tau, 12):g}; take a smaller "
            f"step than tau = {tau:g}, or stop earlier"
        )
