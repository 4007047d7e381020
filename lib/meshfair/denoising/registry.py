"""The filters by name, with what there is to know of each: `register`, `methods`, `defaults`."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np

from meshfair import filters
from meshfair.checks import Floats, Integers, check_text, did_you_mean
from meshfair.denoising.own import careful, check_filter
from meshfair.filters.feature_convinced import fill_in

Parameters = dict[str, Any]
States = Iterator[tuple[float, Floats]]

STRENGTH = "strength"
"""A parameter of all methods, beside those of the filter: see `meshfair.denoising.denoise`."""
STRENGTHS = tuple(k / 8 for k in range(1, 8))
"""Strengths below 1 among which to choose."""


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
    nearer_margin: float = 0.3
    """What other parameters that change the mesh less than its defaults have to promise more,
    in log ratio: see `meshfair.denoising.rules`."""
    further: Mapping[str, Sequence[int]] = field(default_factory=dict)
    """A number of iterations and values above its default, with which the method goes on from
    what its defaults lead to: chosen once these are, by `meshfair.denoising.forecast.change`.
    Where all of the way is in doubt, a part of it is chosen (`best_part`)."""

    @property
    def refinements(self) -> list[Parameters]:
        """What may be chosen in place of a default once the defaults are chosen."""
        longer = [{name: count} for name, counts in self.further.items() for count in counts]
        return longer + [{STRENGTH: part} for part in STRENGTHS] if self.further else []

    def states(self, V: Floats, F: Integers, parameters: Parameters) -> States:
        """Yield what the filter yields, with the vertices a part of the way there.

        Parameters
        ----------
        V : ndarray of float64, shape (n, 3)
        F : ndarray of int64, shape (m, 3)
        parameters : dict
            The filter's, and the part as `STRENGTH`; without it, all of the way.

        Yields
        ------
        progress, V
        """
        parameters = dict(parameters)
        strength = parameters.pop(STRENGTH, 1.0)
        last = part = V
        for progress, X in self.function(V, F, **parameters):
            if X is not last:
                last, part = X, X if strength == 1 else V + strength * (X - V)
            yield progress, part

    def filled_in(self, V: Floats, F: Integers, parameters: Parameters) -> Parameters:
        """The parameters with those that are None chosen from the mesh."""
        return self.fill_in(V, F, parameters) if self.fill_in else parameters

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


# A filter of normals that filters less is seldom worse.
_SURE = 0.06

# Candidates are spread so widely that the best lies among them, on smooth and on sharp meshes.
_STEPS = (0.0, 0.0625, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0)

_METHODS: dict[str, Method] = {
    "averaging": Method(filters.averaging, [{"iterations": 30}], "iterations", normals=False),
    "heat": Method(filters.heat, [{"time": 20.0}], _heat_until, normals=False),
    "implicit": Method(filters.implicit, _grid(step=_STEPS), normals=False),
    "regularised": Method(filters.regularised, _grid(order=(1, 2), lam=_STEPS), normals=False),
    "taubin": Method(filters.taubin, [{"iterations": 60}], "iterations", normals=False),
    "bilateral": Method(filters.bilateral, [{"iterations": 20}], "iterations"),
    "sun": Method(
        filters.sun,
        _grid(normal_iterations=(5, 20), threshold=(0.3, 0.6)),
        "vertex_iterations",
        nearer_margin=_SURE,
    ),
    "bilateral-normal": Method(
        filters.bilateral_normal,
        _grid(normal_iterations=(2, 5, 20), sigma_normal=(0.35, 0.5)),
        "vertex_iterations",
        nearer_margin=_SURE,
    ),
    "guided-normal": Method(
        filters.guided_normal, _grid(sigma_normal=(0.35, 0.5)), "iterations", nearer_margin=_SURE
    ),
    "l0": Method(filters.l0, _grid(lam=(0.05, 0.2)), normals=False),
    "feature-convinced": Method(
        filters.feature_convinced,
        _grid(vertex_iterations=(1, 2), sigma_normal=(0.25, 0.35, 0.5)),
        "iterations",
        fill_in,
        "noise",
        nearer_margin=_SURE,
    ),
    "learned": Method(
        filters.learned, _grid(stages=(1, 2)), further={"vertex_iterations": (40, 160)}
    ),
}
BUILT_IN = tuple(_METHODS)
"""The methods that come with the package, among which "auto" chooses."""
DEFAULT = "auto"
"""The method of `denoise` where none is named."""


def register(
    name: str,
    *,
    candidates: Iterable[Parameters] = ({},),
    count: str | Callable[[Parameters, int], Parameters] | None = None,
    fill_in: Callable[[Floats, Integers, Parameters], Parameters] | None = None,
    noise: str | None = None,
    normals: bool = True,
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
        A name in use is taken over, but not "auto", nor one that comes with the package: among
        these "auto" chooses, by what it has learned of them.
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
    normals : bool
        Whether it uses normals, so that faces that are turned against each other have to be
        turned first.

    Returns
    -------
    function
        A decorator that leaves the filter as it is. The filter takes V, F and keyword
        parameters that all have defaults, and yields progress (0 to 1) and positions, which
        it may move in place. It has ``fixed``, a mask, if it is to be called with that.

    Raises
    ------
    ValueError
        The name is "auto" or one that comes with the package; the filter has a parameter
        ``strength``, which is that of all methods, one without a default, or not one that
        ``candidates``, ``count`` or ``noise`` name.
    """
    if check_text(name, "name") == DEFAULT:
        raise ValueError(f"name is {name!r}, which chooses among all methods; give another one")
    if name in BUILT_IN:
        raise ValueError(
            f"name is {name!r}, which comes with the package, and {DEFAULT!r} chooses by what it "
            "has learned of that; give another one"
        )

    candidates = list(candidates)

    def add(function: Callable[..., States]) -> Callable[..., States]:
        if STRENGTH in inspect.signature(function).parameters:
            raise ValueError(
                f"{name} has a parameter {STRENGTH!r}, which is the part of the way that denoise "
                "takes with any method; call the filter's own by another name"
            )
        check_filter(name, function, candidates, count, noise)
        _METHODS[name] = Method(careful(name, function), candidates, count, fill_in, noise, normals)
        return function

    return add


def methods() -> list[str]:
    """The names of all methods, in the order in which they were registered.

    "auto", which chooses one of those that come with the package, is not among them.

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
    signature = inspect.signature(find_method(method).function)
    return {name: p.default for name, p in signature.parameters.items() if name not in ("V", "F")}


def find_method(method: str) -> Method:
    """The method of a name, or an error that names those there are."""
    if not isinstance(method, str) or method not in _METHODS:
        raise unknown(method, _METHODS)
    return _METHODS[method]


def unknown(method: Any, known: Iterable[str]) -> ValueError:
    """The error of a method that is none of the known ones."""
    known = list(known)
    return ValueError(
        f"no method is called {method!r}; there are {', '.join(known)}{did_you_mean(method, known)}"
    )


def same(first: Parameters, second: Parameters) -> bool:
    """Whether parameters agree; ``fixed`` may be an array."""
    return first.keys() == second.keys() and all(
        np.array_equal(first[name], second[name]) for name in first
    )


def distinct(trials: Iterable[Parameters]) -> list[Parameters]:
    """The parameters, those that come again left out."""
    found: list[Parameters] = []
    for parameters in trials:
        if not any(same(parameters, other) for other in found):
            found.append(parameters)
    return found


def with_noise(method: str, chosen: Parameters, sigma: float | None) -> Parameters:
    """The chosen parameters, with the known noise where the method uses it."""
    noise = find_method(method).noise
    return chosen if noise is None or sigma is None else {noise: sigma} | chosen
