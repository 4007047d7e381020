"""Filters of one's own: what `register` asks of them, and care for what they yield."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Sequence
from functools import wraps
from typing import Any

import numpy as np

from meshfair.checks import Floats, Integers, did_you_mean

Filter = Callable[..., Iterator[tuple[float, Floats]]]

SHAPE = "a filter is written def NAME(V, F, *, parameter=default, ...)"
YIELDS = "it has to yield progress, from 0 to 1, and positions"


def check_filter(
    name: str, function: Filter, candidates: Sequence[dict[str, Any]], *named: Any
) -> None:
    """Refuse a filter that could not be called by its parameters.

    Parameters
    ----------
    name : str
    function : function
    candidates : sequence of dict
    *named : str or other
        Names that parameters have to have; what is no text does not count.

    Raises
    ------
    ValueError
        Its arguments do not begin with V and F; one of the others has no default, or stands
        for any number of them; no candidate; a name that no parameter has.
    """
    arguments = list(inspect.signature(function).parameters.values())
    first, others = arguments[:2], arguments[2:]
    if [p.name for p in first] != ["V", "F"]:
        raise ValueError(f"{name}: its first arguments are not V and F; {SHAPE}")
    for p in others:
        if p.kind in (p.VAR_POSITIONAL, p.VAR_KEYWORD):
            raise ValueError(f"{name}: {p} stands for any parameters; name each; {SHAPE}")
        if p.default is p.empty:
            raise ValueError(f"{name}: its parameter {p.name} has no default; {SHAPE}")
    if not candidates:
        raise ValueError(f"{name}: candidates is empty; give a dict for each, or leave it out")
    known = [p.name for p in others]
    for wanted in (*named, *(key for candidate in candidates for key in candidate)):
        if isinstance(wanted, str) and wanted not in known:
            raise ValueError(
                f"{name} has no parameter {wanted!r}; it has {', '.join(known) or 'none'}"
                f"{did_you_mean(wanted, known)}"
            )


def careful(name: str, function: Filter) -> Filter:
    """The filter with positions that neither it nor anyone else changes afterwards.

    Parameters
    ----------
    name : str
    function : function
        It may move the vertices in place, and yield the same array again and again.

    Returns
    -------
    function
        It yields arrays of float64, shape (n, 3), each one as it is at that time, and the same
        one where nothing has moved. Raises ValueError where the filter yields anything else.
    """

    @wraps(function)
    def run(V: Floats, F: Integers, **parameters: Any) -> Iterator[tuple[float, Floats]]:
        own = V.copy()
        last: Any = own
        kept, states = V, function(own, F.copy(), **parameters)
        if not isinstance(states, Iterator):
            raise ValueError(f"{name} returned a {type(states).__name__}; {YIELDS}")
        for state in states:
            if not isinstance(state, tuple) or len(state) != 2:
                raise ValueError(f"{name} yielded a {type(state).__name__}; {YIELDS}")
            progress, X = state
            if X is not last or not np.array_equal(X, kept):
                kept, last = _positions(name, X, len(V)), X
            yield progress, kept

    return run


def _positions(name: str, X: Any, n: int) -> Floats:
    try:
        copy = np.array(X, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{name} yielded positions that are no numbers; {YIELDS}") from None
    if copy.shape != (n, 3):
        raise ValueError(f"{name} yielded positions of shape {copy.shape}; ({n}, 3) was expected")
    if not np.isfinite(copy).all():
        i = int(np.flatnonzero(~np.isfinite(copy).all(axis=1))[0])
        raise ValueError(f"{name} yielded {copy[i]} for vertex {i}; positions have to be finite")
    return copy
