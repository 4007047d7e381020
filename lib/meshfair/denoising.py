"""One front for all filters: `denoise` by name, with chosen, default or automatic parameters."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import wraps
from itertools import product
from time import perf_counter
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike

from meshfair import filters
from meshfair.checks import (
    Floats,
    Integers,
    check_choice,
    check_mesh,
    check_number,
    check_same_vertices,
    did_you_mean,
    needed_for,
    warn,
)
from meshfair.filters.feature_convinced import fill_in, noise_by_lengths
from meshfair.filters.preparation import Prepared
from meshfair.mesh.objects import arrays, is_object, moved, takes_meshes
from meshfair.metrics import normal_angle, snr
from meshfair.solve import SolveError
from meshfair.sure import SURE, noise_by_differences

if TYPE_CHECKING:
    import pandas as pd

Parameters = dict[str, Any]
States = Iterator[tuple[float, Floats]]


class Denoised(NamedTuple):
    """A denoised mesh, and how it came about."""

    V: Floats
    """Positions, shape (n, 3)."""
    method: str
    """The method's name."""
    parameters: Parameters
    """All parameters that were used; with them `denoise` gives the same V again."""
    history: pd.DataFrame | None
    """Against the ground truth, a pandas table of iteration, normal_angle (degrees) and snr
    (decibels), from the noisy mesh at iteration 0 on; None without a ground truth."""
    sure: float | None
    """With automatic parameters, the estimated risk (`meshfair.sure.SURE`), in squared units
    of V; None if there is none. It compares methods on a mesh too: the smaller the better."""
    seconds: float
    """Time taken."""
    finished: bool
    """False where the callback has cancelled it: V is what was reached until then."""
    mesh: Any = None
    """Where a mesh object of another library was given (see `meshfair.mesh.arrays`): a copy
    of it with the positions V."""


@dataclass(frozen=True)
class Method:
    """A filter, and what automatic parameters need to know of it."""

    function: Callable[..., States]
    """Called as ``function(V, F, **parameters)``, yields progress and positions."""
    candidates: list[Parameters]
    """Parameters, as dicts, among which to choose."""
    count: str | Callable[[Parameters, int], Parameters] | None = None
    """The parameter that says how often it yields new positions, so that it can end
    earlier; or a function from its parameters and k to those with which it ends at the k-th
    new positions; None where only the last ones are a result."""
    fill_in: Callable[[Floats, Integers, Parameters], Parameters] | None = None
    """``fill_in(V, F, parameters)``: the parameters with those that are None chosen from
    the mesh; None where there are none of that kind."""
    noise: str | None = None
    """The parameter that takes the noise's size, if there is one."""
    normals: bool = True
    """Whether it uses normals, so that faces have to be turned consistently."""

    def stopped(self, parameters: Parameters, k: int) -> Parameters:
        """The parameters with which it ends where it now yields its k-th new positions.

        Parameters
        ----------
        parameters : dict
        k : int

        Returns
        -------
        dict
        """
        if callable(self.count):
            return self.count(parameters, k)
        return parameters | {self.count: k} if self.count else parameters


def _heat_until(parameters: Parameters, k: int) -> Parameters:
    return parameters | {"time": min(parameters["time"], k * parameters["tau"])}


def _grid(**values: Sequence[Any]) -> list[Parameters]:
    """Candidates with all combinations of several parameters' values."""
    return [dict(zip(values, chosen, strict=True)) for chosen in product(*values.values())]


# Candidates are spread so widely that the best lies among them, on smooth and on sharp meshes.
_STRENGTHS = (0.0, 0.0625, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0)

_METHODS: dict[str, Method] = {
    "averaging": Method(filters.averaging, [{"iterations": 30}], "iterations", normals=False),
    "heat": Method(filters.heat, [{"time": 20.0}], _heat_until, normals=False),
    "implicit": Method(filters.implicit, _grid(step=_STRENGTHS), normals=False),
    "regularised": Method(filters.regularised, _grid(order=(1, 2), lam=_STRENGTHS), normals=False),
    "taubin": Method(filters.taubin, [{"iterations": 60}], "iterations", normals=False),
    "bilateral": Method(filters.bilateral, [{"iterations": 20}], "iterations"),
    "sun": Method(
        filters.sun,
        _grid(normal_iterations=(5, 20), threshold=(0.3, 0.6)),
        "vertex_iterations",
    ),
    "bilateral-normal": Method(
        filters.bilateral_normal,
        _grid(normal_iterations=(2, 5, 20), sigma_normal=(0.35, 0.5)),
        "vertex_iterations",
    ),
    "guided-normal": Method(filters.guided_normal, _grid(sigma_normal=(0.35, 0.5)), "iterations"),
    "l0": Method(filters.l0, _grid(lam=(0.05, 0.2)), normals=False),
    "feature-convinced": Method(
        filters.feature_convinced,
        _grid(vertex_iterations=(1, 2), sigma_normal=(0.25, 0.35, 0.5)),
        "iterations",
        fill_in,
        "noise",
    ),
    "learned": Method(filters.learned, _grid(stages=(1, 2))),
}
DEFAULT = "feature-convinced"
"""The method of `denoise` where none is named."""


def register(
    name: str,
    *,
    candidates: Iterable[Parameters] = ({},),
    count: str | Callable[[Parameters, int], Parameters] | None = None,
    fill_in: Callable[[Floats, Integers, Parameters], Parameters] | None = None,
    noise: str | None = None,
) -> Callable[[Callable[..., States]], Callable[..., States]]:
    """Make a filter known to `denoise` by a name; a decorator.

    For example::

        @denoising.register("halfway", candidates=[{"iterations": 10}], count="iterations")
        def halfway(V, F, *, iterations=3):
            A = averaging(weights.combinatorial(F, len(V)))
            for k in range(iterations):
                V = (V + A @ V) / 2
                yield (k + 1) / iterations, V

    Parameters
    ----------
    name : str
        A name in use is taken over.
    candidates : sequence of dict
        Parameters among which ``parameters="auto"`` chooses.
    count : str or function, optional
        The parameter that says how often the filter yields new positions; or a
        function from its parameters (a dict) and a number k to those with which it ends
        where it now yields new positions for the k-th time. With it, "auto" also
        chooses when to stop.
    fill_in : function, optional
        From V, F and parameters (a dict) to the parameters with those that are None
        chosen from the mesh, so that a result can name what was used.
    noise : str, optional
        The parameter that takes the size of the noise, which ``sigma`` of `denoise` is.

    Returns
    -------
    function
        A decorator that leaves the filter as it is. The filter takes V, F and keyword
        parameters that all have defaults, and yields progress (0 to 1) and positions.
    """

    def add(function: Callable[..., States]) -> Callable[..., States]:
        _METHODS[name] = Method(function, list(candidates), count, fill_in, noise)
        return function

    return add


def methods() -> list[str]:
    """The names of all methods, in the order in which they were registered.

    Returns
    -------
    list of str
    """
    return list(_METHODS)


def defaults(method: str) -> Parameters:
    """The parameters of a method and their default values.

    Parameters
    ----------
    method : str

    Returns
    -------
    dict

    Raises
    ------
    ValueError
        No method has this name.
    """
    signature = inspect.signature(_find(method).function)
    return {name: p.default for name, p in signature.parameters.items() if name not in ("V", "F")}


Function = TypeVar("Function", bound=Callable[..., Denoised])


def _gives_mesh(function: Function) -> Function:
    """Decorate a function of V and F that also takes a mesh object, and gives back its kind."""

    @wraps(function)
    def unpacked(V: Any, *args: Any, **kwargs: Any) -> Denoised:
        if is_object(kwargs.get("ground_truth")):
            kwargs["ground_truth"], _ = arrays(kwargs["ground_truth"])
        if not is_object(V):
            return function(V, *args, **kwargs)
        result = takes_meshes(function)(V, *args, **kwargs)
        return result._replace(mesh=moved(V, result.V))

    return cast(Function, unpacked)


@_gives_mesh
def denoise(
    V: ArrayLike,
    F: ArrayLike,
    method: str = DEFAULT,
    *,
    parameters: str = "default",
    sigma: float | None = None,
    rng: np.random.Generator | None = None,
    ground_truth: ArrayLike | None = None,
    callback: Callable[[float], Any] | None = None,
    **chosen: Any,
) -> Denoised:
    """Denoise a mesh.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        Noisy positions.
    F : array_like of integers, shape (m, 3)
        A mesh object of another library may stand for V and F, see `meshfair.mesh.arrays`.
    method : str
        One of `methods`.
    parameters : {"default", "auto"}
        Where parameters come from that are not given by name. "auto" runs the
        method with each of its candidates, twice, and takes the parameters, and
        the iteration to stop at, whose estimated risk is smallest (Stein's unbiased
        estimate, see `meshfair.sure.SURE`); that may be the noisy mesh. A number of
        iterations that is given is then the most that are made.
    sigma : float, optional
        The noise's standard deviation, as a fraction of the mean edge length, if it is
        known. "auto" needs it, and estimates it by differences (see `estimate_noise`)
        where it is not given; of the methods, feature-convinced uses it (its ``noise``).
    rng : numpy.random.Generator, optional
        For "auto": draws the estimate's probe; if none is given, the same one each time.
    ground_truth : array_like, shape (n, 3), optional
        The noise-free positions, for the history. Nothing else looks at them.
    callback : function, optional
        Called with the progress, a number up to 1, after each iteration.
        When it returns False (not None), the work ends there.
    **chosen
        The method's parameters by name; ``fixed`` (vertices that keep their place,
        as a boolean mask (n,) or as indices) is one that they all have.

    Returns
    -------
    Denoised
        V, method, parameters, history, sure, seconds, finished, mesh.

    Raises
    ------
    MeshError, ValueError, TypeError
        No mesh; no such method or parameter (the message lists those there
        are); a parameter outside its range; ``sigma`` for a method that does not
        use it; a callback that is no function.

    Warns
    -----
    MeshWarning
        Copies of vertices along seams, which are joined for the work; faces turned against
        their neighbours', where that matters; candidates of "auto" that cannot be solved.
    """
    V, F = check_mesh(V, F)
    if ground_truth is not None:
        V, ground_truth = check_same_vertices(V, ground_truth, ("V", "ground_truth"))
        _table(())  # needs pandas: to be said before the work, not after it
    auto = check_choice(parameters, "parameters", ("default", "auto")) == "auto"
    if sigma is not None:
        chosen = _with_noise(method, chosen, check_number(sigma, "sigma", 0), auto)
    run = _Run(V, F, method, chosen, ground_truth, callback, normals=auto)
    if not auto:
        return run.ended(run.states(run.V, run.filled_in(run.known | run.chosen), run.report))
    # A generator of its own for each call: the same call gives the same mesh.
    sure = SURE(run.V, run.F, np.random.default_rng(0) if rng is None else rng, sigma)
    return run.ended(run.better_states((run.V, sure.V_perturbed), sure))


def _with_noise(method: str, chosen: Parameters, sigma: float, auto: bool) -> Parameters:
    """The chosen parameters, with the known noise where the method uses it."""
    noise = _find(method).noise
    if noise:
        return {noise: sigma} | chosen
    if auto:
        return chosen
    raise ValueError(
        f"sigma is given, but {method} with default parameters does not use it; leave it out, "
        'or let parameters="auto" choose'
    )


@_gives_mesh
def tune(
    V: ArrayLike,
    F: ArrayLike,
    method: str,
    ground_truth: ArrayLike,
    *,
    callback: Callable[[float], Any] | None = None,
    **chosen: Any,
) -> Denoised:
    """Denoise with the parameters that come closest to the ground truth, which has to be known.

    Among the candidates of "auto", and the iterations to stop at, this takes
    those with the smallest mean normal angle: what a method can do at best,
    and a way to find parameters for meshes like this one.

    Parameters
    ----------
    V, F, method, callback, **chosen
        As in `denoise`.
    ground_truth : array_like, shape (n, 3)
        The positions that decide.

    Returns
    -------
    Denoised

    Raises
    ------
    MeshError, ValueError
        As `denoise`.
    """
    V, F = check_mesh(V, F)
    V, ground_truth = check_same_vertices(V, ground_truth, ("V", "ground_truth"))
    run = _Run(V, F, method, chosen, ground_truth, callback)

    def score(X: Floats) -> float:
        return normal_angle(run.ready.restored(X), ground_truth, F)

    return run.ended(run.better_states((run.V,), score))._replace(sure=None)


@takes_meshes
def estimate_noise(V: ArrayLike, F: ArrayLike, by: str = "lengths") -> float:
    """The size of the noise on a mesh, estimated without the ground truth.

    By "lengths" of the edges, which noise makes longer, see
    `meshfair.filters.feature_convinced`'s `noise_by_lengths`; by third "differences",
    see `meshfair.sure.noise_by_differences`: closer on coarse meshes, and with strong noise.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    by : {"lengths", "differences"}

    Returns
    -------
    float
        As a fraction of the mean edge length, as in `along_normals`; but of the
        noisy mesh's, since the true one's is unknown. From about 0.4 on
        too small: normals are lost. On clean meshes with much detail
        too large, since detail looks like noise.

    Raises
    ------
    MeshError, ValueError
        No mesh; another word for ``by``.
    """
    V, F = check_mesh(V, F)
    return _ESTIMATES[check_choice(by, "by", _ESTIMATES)](V, F)


_ESTIMATES: dict[str, Callable[[ArrayLike, ArrayLike], float]] = {
    "lengths": noise_by_lengths,
    "differences": noise_by_differences,
}


class _CancelledError(Exception):
    """The callback wants no more."""


class _State(NamedTuple):
    """Positions on the way, and how they came about."""

    V: Floats
    parameters: Parameters
    history: tuple[tuple[float, float], ...]
    score: float | None = None


class _Run:
    """A method on one mesh, with given or with several parameters."""

    def __init__(
        self,
        V: Floats,
        F: Integers,
        method: str,
        chosen: Parameters,
        ground_truth: Floats | None,
        callback: Callable[[float], Any] | None,
        *,
        normals: bool = False,
    ) -> None:
        self.start = perf_counter()
        self.name, self.method = method, _find(method)
        self.known = defaults(method)
        for name in chosen:
            if name not in self.known:
                raise ValueError(
                    f"{method} has no parameter {name!r}; it has {', '.join(self.known)}"
                    f"{did_you_mean(name, self.known)}"
                )
        if callback is not None and not callable(callback):
            raise TypeError(f"callback is {callback!r}; give a function of one number, 0 to 1")
        self.callback = callback
        # What is measured is the mesh that was given; what is worked on is this one.
        self.given_F, self.ground_truth, self.given = F, ground_truth, chosen
        self.ready = Prepared(V, F, normals=normals or self.method.normals)
        self.V, self.F = self.ready.V, self.ready.F
        self.chosen = chosen
        if chosen.get("fixed") is not None:
            self.chosen = chosen | {"fixed": self.ready.fixed(chosen["fixed"])}

    def filled_in(self, parameters: Parameters) -> Parameters:
        """The parameters with those that are None chosen from the mesh."""
        fill_in = self.method.fill_in
        return fill_in(self.V, self.F, parameters) if fill_in else parameters

    def report(self, progress: float) -> None:
        """Tell the callback; it may cancel."""
        if self.callback is not None and self.callback(progress) is False:
            raise _CancelledError

    def states(
        self, V: Floats, parameters: Parameters, report: Callable[[float], None] | None
    ) -> Iterator[_State]:
        """Yield the state before the filter, and one for each new positions that it yields.

        Without a function ``report`` they are not compared with the ground truth.
        """
        history = self._measured(V) if report else ()
        yield _State(V.copy(), parameters, history)
        last = V
        for progress, X in self.method.function(V, self.F, **parameters):
            if X is not last:
                history += self._measured(X) if report else ()
                yield _State(X, parameters, history)
                last = X
            if report:
                report(progress)

    def better_states(
        self, meshes: tuple[Floats, ...], score: Callable[..., float]
    ) -> Iterator[_State]:
        """Yield states of all trials, each with a smaller score than those before.

        The filter runs on all ``meshes``, the first of them the noisy one; ``score`` is
        a function of what it makes of each.
        """
        trials: list[Parameters] = []
        for candidate in self.method.candidates:
            parameters = self.filled_in(self.known | candidate | self.chosen)
            if not any(_same(parameters, trial) for trial in trials):
                trials.append(parameters)
        least = np.inf
        failed: list[tuple[Parameters, Exception]] = []
        yield _State(self.V.copy(), trials[0], self._measured(self.V), least)
        for number, parameters in enumerate(trials):

            def report(progress: float, number: int = number) -> None:
                self.report((number + progress) / len(trials))

            reports = [report, *[None] * (len(meshes) - 1)]
            runs = [self._results(V, parameters, r) for V, r in zip(meshes, reports, strict=True)]
            try:
                for states in zip(*runs, strict=True):
                    found = score(*(state.V for state in states))
                    if found < least:
                        least = found
                        yield states[0]._replace(score=found)
            except SolveError as error:
                failed.append((trials[number], error))
        if len(failed) == len(trials):
            raise failed[0][1]
        if failed:
            _warn_of_failed(failed, len(trials))

    def _results(
        self, V: Floats, parameters: Parameters, report: Callable[[float], None] | None
    ) -> Iterator[_State]:
        """Those of a trial's states that some parameters end with, with these parameters."""
        for k, state in enumerate(self.states(V, parameters, report)):
            if self.method.count:
                yield state._replace(parameters=self.method.stopped(parameters, k))
        if not self.method.count:
            yield state

    def ended(self, states: Iterator[_State]) -> Denoised:
        """The last of these states as a result; its score is the risk."""
        finished = True
        try:
            for state in states:
                last = state
        except _CancelledError:
            finished = False
        history = None if self.ground_truth is None else _table(last.history)
        sure = None if last.score == np.inf else last.score  # cancelled before any was estimated
        seconds = perf_counter() - self.start
        V, parameters = self.ready.restored(last.V), last.parameters
        if "fixed" in self.given:
            parameters = parameters | {"fixed": self.given["fixed"]}
        return Denoised(V, self.name, parameters, history, sure, seconds, finished)

    def _measured(self, V: Floats) -> tuple[tuple[float, float], ...]:
        """A row of the history, if there is a ground truth."""
        if self.ground_truth is None:
            return ()
        V = self.ready.restored(V)
        return ((normal_angle(V, self.ground_truth, self.given_F), snr(self.ground_truth, V)),)


def _find(method: str) -> Method:
    if method not in _METHODS:
        raise ValueError(
            f"no method is called {method!r}; there are {', '.join(_METHODS)}"
            f"{did_you_mean(method, _METHODS)}"
        )
    return _METHODS[method]


def _warn_of_failed(failed: list[tuple[Parameters, Exception]], count: int) -> None:
    """Say which candidates were left out, and why the first one was."""
    parameters, error = failed[0]
    first = ", ".join(f"{k}={v}" for k, v in parameters.items() if k != "fixed")
    warn(
        f"{len(failed)} of {count} candidates were left out, since they cannot be solved (the "
        f"first: {first}: {error})"
    )


def _same(first: Parameters, second: Parameters) -> bool:
    """Whether parameters agree; ``fixed`` may be an array."""
    return all(np.array_equal(first[name], second[name]) for name in first)


def _table(history: tuple[tuple[float, float], ...]) -> pd.DataFrame:
    with needed_for("a comparison with the ground truth"):
        import pandas as pd  # a third of a second to load, for this table alone

    table = pd.DataFrame(history, columns=["normal_angle", "snr"])
    table.insert(0, "iteration", range(len(table)))
    return table
