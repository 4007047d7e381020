"""What all filters check about their arguments."""

from numbers import Integral

import numpy as np

from meshfair.operators import pinned


def check_count(value, name, low=0):
    """Return a whole number of at least ``low``, or say why not.

    Raises
    ------
    ValueError
        Not a whole number, or below ``low``.
    """
    if not isinstance(value, Integral) or isinstance(value, bool) or value < low:
        raise ValueError(f"{name} is {value!r}; give a whole number of at least {low}")
    return int(value)


def check_choice(value, name, choices):
    """Return one of the choices, or list them.

    Raises
    ------
    ValueError
        None of the choices.
    """
    if value not in choices:
        raise ValueError(f"{name} is {value!r}; give one of {', '.join(choices)}")
    return value


def held_vertices(fixed, n, boundary=()):
    """Which vertices a filter leaves where they are.

    Parameters
    ----------
    fixed : array_like or None
        A boolean mask (n,), or indices.
    n : int
        Number of vertices.
    boundary : array_like of integers
        Indices of further vertices to hold.

    Returns
    -------
    ndarray of bool, shape (n,)

    Raises
    ------
    MeshError
        A mask of another length, or an index outside 0 .. n - 1.
    """
    held = np.zeros(n, dtype=bool) if fixed is None else pinned(fixed, n).copy()
    held[np.asarray(boundary, dtype=np.int64)] = True
    return held
