"""Iterated averaging, the heat equation by forward Euler, and when to stop."""

import warnings
from numbers import Integral
from typing import NamedTuple

import numpy as np

from meshfair.checks import MeshError, StabilityWarning, check_number, check_vertices
from meshfair.noise import snr
from meshfair.operators import stable_step


class BestStopping(NamedTuple):
    """Where a flow comes closest to the clean mesh."""

    time: float
    """Flow time with the highest SNR; 0 where the flow never helps."""
    snr: float
    """SNR at that time, in decibels."""
    gain: float
    """Gain over the noisy mesh's SNR, in percent of it (the seed's Table 1)."""


def _check_operator(A, V):
    if np.shape(A) != (len(V), len(V)):
        raise MeshError(
            f"the operator has shape {np.shape(A)}, but V has {len(V)} vertices; "
            "build it from the same mesh"
        )
    return A


def average(V, A, steps):
    """Iterated averaging, V~ = W~^s V (the seed, section 2.1).

    Parameters
    ----------
    V : array_like, shape (n, 3)
    A : sparse array, shape (n, n)
        Averaging operator, see `meshfair.operators.averaging`.
    steps : int
        Number s of iterations, at least 0.

    Returns
    -------
    ndarray of float64, shape (n, 3)

    Raises
    ------
    MeshError, ValueError
        Arrays that do not fit together, or ``steps`` no whole number >= 0.
    """
    V = check_vertices(V)
    _check_operator(A, V)
    if not isinstance(steps, Integral) or steps < 0:
        raise ValueError(f"steps is {steps!r}; give a whole number of at least 0")
    for _ in range(steps):
        V = A @ V
    return V.copy() if steps == 0 else V


def heat(V, A, tau, time, *, rebuild=False):
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
        needs a function for ``A``. The seed does not say which it did;
        its figures agree with operators built once.

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
    build = A if callable(A) else lambda V: A
    first = _check_operator(build(V), V)
    _warn_if_unstable(first, tau)
    steps = int(time / abs(tau) * (1 + 1e-12))  # 0.6 / 0.2 is 2.9999999999999996
    return _heat(V, first, build, tau, steps, rebuild)


def _heat(V, A, build, tau, steps, rebuild):
    yield 0.0, V.copy()
    for step in range(1, steps + 1):
        if rebuild and step > 1:
            A = build(V)
        V = (1 - tau) * V + tau * (A @ V)
        yield round(step * tau, 12), V  # 0.6, not 0.6000000000000001


def _warn_if_unstable(A, tau):
    if 0 < tau <= 1 and (not A.nnz or A.data.min() >= 0):
        return  # every new vertex is a mean of old ones: nothing can grow
    bound = stable_step(A)
    if 0 < tau <= 1 and tau <= bound * (1 + 1e-3):  # the accuracy of the bound
        return
    advice = f"the bound on this mesh is tau = {bound:.3g}" if bound else "no step is stable"
    reason = "with negative weights" if 0 < tau <= 1 else "outside (0, 1]"
    warnings.warn(
        f"tau = {tau:g} {reason}: the flow may grow instead of smoothing; {advice}, "
        "2 over the spectral radius of I - A",
        StabilityWarning,
        stacklevel=3,
    )


def best_stopping(V_noisy, V_clean, A, tau, time, *, rebuild=False):
    """The stopping time at which the heat flow's SNR is highest (the seed, Table 1).

    Parameters
    ----------
    V_noisy : array_like, shape (n, 3)
        Where the flow starts.
    V_clean : array_like, shape (n, 3)
        What it is compared with.
    A, tau, time, rebuild
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
    curve = snr_curve(V_noisy, V_clean, A, tau, time, rebuild=rebuild)
    start = curve[0, 1]
    best_time, best = curve[curve[:, 1].argmax()]
    gain = 100 * (best - start) / abs(start) if best > start else 0.0
    return BestStopping(float(best_time), float(best), float(gain))


def snr_curve(V_noisy, V_clean, A, tau, time, *, rebuild=False):
    """SNR along the heat flow (the seed, Figures 3 and 6).

    Parameters and errors are those of `best_stopping`.

    Returns
    -------
    ndarray of float64, shape (steps + 1, 2)
        Rows of flow time and SNR in decibels, from time 0.
    """
    flow = heat(V_noisy, A, tau, time, rebuild=rebuild)
    return np.array([(t, snr(V_clean, V)) for t, V in flow])
