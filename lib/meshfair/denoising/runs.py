"""One method at work on one mesh, and what comes of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from time import perf_counter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from meshfair.checks import Floats, Integers, needed_for, warn
from meshfair.denoising.registry import Method, Parameters
from meshfair.filters.preparation import Prepared
from meshfair.metrics import normal_angle, snr
from meshfair.solve import SolveError

if TYPE_CHECKING:
    import pandas as pd


class Denoised(NamedTuple):
    """A denoised mesh, and how it came about."""

    V: Floats
    """Positions, shape (n, 3)."""
    method: str
    """The method's name."""
    parameters: Parameters
    """All parameters that were used, ``strength`` where it was given or chosen; with them
    `denoise` gives the same V again, also after a cancelled run if the method can stop early."""
    history: pd.DataFrame | None
    """Against the ground truth, a pandas table of iteration, normal_angle (degrees) and snr
    (decibels), from the noisy mesh at iteration 0 on; None without a ground truth."""
    ratio: float | None
    """Where something was chosen, the share of the normals' error that is expected to be left
    (see `meshfair.denoising.forecast`): 0.1 for a tenth, 1 for the noisy mesh; else None."""
    reason: str | None
    """What was chosen and why, in a line; None where nothing was."""
    seconds: float
    """Time taken."""
    finished: bool
    """False where the callback has cancelled it: V is what was reached until then."""
    mesh: Any = None
    """Where a mesh object of another library was given (see `meshfair.mesh.arrays`): a copy
    of it with the positions V."""


class Cancelled(Exception):  # noqa: N818  a wish, not an error
    """The callback wants no more."""


class State(NamedTuple):
    """Positions on the way, and how they came about."""

    V: Floats
    parameters: Parameters
    history: tuple[tuple[float, float], ...] = ()


class Run:
    """What denoises one mesh: by one method with given parameters, or with the best for it.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    ground_truth : ndarray of float64, shape (n, 3), optional
    callback : function, optional
        As in `denoise`.
    chosen : dict
        The parameters that were given.
    normals : bool
        Whether faces have to be turned consistently.

    Raises
    ------
    TypeError
        A callback that is no function.
    """

    def __init__(
        self,
        V: Floats,
        F: Integers,
        ground_truth: Floats | None,
        callback: Callable[[float], Any] | None,
        chosen: Parameters,
        *,
        normals: bool,
    ) -> None:
        self.start = perf_counter()
        if callback is not None and not callable(callback):
            raise TypeError(f"callback is {callback!r}; give a function of one number, 0 to 1")
        self.callback, self.ground_truth = callback, ground_truth
        if ground_truth is not None:
            history_table(())  # needs pandas: to be said before the work, not after it
        # What is measured is the mesh that was given; what is worked on is this one.
        self.given_F, self.given = F, chosen
        self.ready = Prepared(V, F, normals=normals)
        self.V, self.F, self.chosen = self.ready.V, self.ready.F, chosen
        if chosen.get("fixed") is not None:
            self.chosen = chosen | {"fixed": self.ready.fixed(chosen["fixed"])}

    @property
    def fixed(self) -> Parameters:
        """The parameter ``fixed``, if it was given."""
        return {"fixed": self.chosen["fixed"]} if "fixed" in self.chosen else {}

    def report(self, progress: float) -> None:
        """Tell the callback; it may cancel."""
        if self.callback is None:
            return
        wish = self.callback(progress)
        if isinstance(wish, (bool, np.bool_)) and not wish:
            raise Cancelled

    def states(
        self, method: Method, parameters: Parameters, report: Callable[[float], None]
    ) -> Iterator[State]:
        """Yield the state before the filter, and one for each new positions that it yields."""
        history, count = self._measured(self.V), 0
        state = State(self.V.copy(), parameters, history)
        yield state
        last = self.V
        for progress, X in method.states(self.V, self.F, parameters):
            if X is not last:
                history, count = history + self._measured(X), count + 1
                state = State(X, parameters, history)
                yield state
                last = X
            try:
                report(progress)
            except Cancelled:
                yield state._replace(parameters=method.stopped(parameters, count))
                raise

    def known(self, V: Floats, parameters: Parameters) -> Iterator[State]:
        """Yield the one state of a result that is known already."""
        yield State(V, parameters, self._measured(V))
        self.report(1.0)

    def better_states(self, method: Method, trials: list[Parameters]) -> Iterator[State]:
        """Yield states of all trials, each closer to the ground truth than those before.

        Only states that some parameters end with are among them, with these parameters.
        """
        least = np.inf
        failed: list[tuple[Parameters, SolveError]] = []
        for number, parameters in enumerate(trials):

            def report(progress: float, number: int = number) -> None:
                self.report((number + progress) / len(trials))

            try:
                states = list(enumerate(self.states(method, parameters, report)))
                for k, state in states if method.count else states[-1:]:
                    if (angle := state.history[-1][0]) < least:
                        least = angle
                        yield state._replace(parameters=method.stopped(parameters, k))
            except SolveError as error:
                failed.append((parameters, error))
        if len(failed) == len(trials):
            raise failed[0][1]
        warn_of_failed(failed, len(trials))

    def ended(
        self,
        name: str,
        states: Iterator[State],
        ratio: float | None = None,
        reason: str | None = None,
    ) -> Denoised:
        """The last of these states as a result of the method of this name."""
        finished, last = True, State(self.V.copy(), {}, self._measured(self.V))
        try:
            for state in states:
                last = state
        except Cancelled:
            finished = False
        history = None if self.ground_truth is None else history_table(last.history)
        seconds = perf_counter() - self.start
        V, parameters = self.ready.restored(last.V), last.parameters
        if "fixed" in self.given:
            parameters = parameters | {"fixed": self.given["fixed"]}
        return Denoised(V, name, parameters, history, ratio, reason, seconds, finished)

    def _measured(self, V: Floats) -> tuple[tuple[float, float], ...]:
        """A row of the history, if there is a ground truth."""
        if self.ground_truth is None:
            return ()
        V = self.ready.restored(V)
        return ((normal_angle(V, self.ground_truth, self.given_F), snr(self.ground_truth, V)),)


def warn_of_failed(failed: list[tuple[Parameters, SolveError]], count: int) -> None:
    """Say how many of the candidates were left out, if any, and why the first one was."""
    if not failed:
        return
    parameters, error = failed[0]
    first = ", ".join(f"{k}={v}" for k, v in parameters.items() if k != "fixed")
    warn(
        f"{len(failed)} of {count} candidates were left out, since they cannot be solved (the "
        f"first: {first}: {error})"
    )


def history_table(history: tuple[tuple[float, float], ...]) -> pd.DataFrame:
    """The table of `Denoised.history` from pairs of angle and SNR."""
    with needed_for("a comparison with the ground truth"):
        import pandas as pd  # a third of a second to load, for this table alone

    table = pd.DataFrame(history, columns=["normal_angle", "snr"])
    table.insert(0, "iteration", range(len(table)))
    return table
