"""Copies of one vertex along a seam, joined for the time of some work.

A soup of triangles, a texture's seams, an export by faces: one place of the surface, and a
vertex for each face or patch that meets there. Whatever moves vertices by their
neighbours tears such a surface apart; so the copies are joined before the work,
and all of them get what it made of the one.
"""

from collections.abc import Callable
from functools import wraps
from typing import Concatenate, NamedTuple, ParamSpec

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import (
    Booleans,
    Floats,
    Integers,
    check_fixed,
    check_mesh,
    warn,
)
from meshfair.mesh.duplicates import first_equal
from meshfair.mesh.elements import Edges
from meshfair.mesh.topology import connected_components

P = ParamSpec("P")


class Joined(NamedTuple):
    """A mesh whose seams are closed, and the way back."""

    V: Floats
    """Positions, each once; float64, shape (n', 3)."""
    F: Integers
    """The same faces on them; int64, shape (m, 3)."""
    copies: Integers
    """The joined vertex of each vertex, so that ``V[copies]`` are the old positions; shape (n,)."""

    def fixed(self, fixed: ArrayLike | None) -> Booleans:
        """Which joined vertices are fixed: those of which any copy is.

        Parameters
        ----------
        fixed : array_like or None
            As in `meshfair.checks.check_fixed`, for the old vertices.

        Returns
        -------
        ndarray of bool, shape (n',)

        Raises
        ------
        MeshError
            Neither a mask nor indices of the old vertices.
        """
        mask = np.zeros(len(self.V), dtype=bool)
        mask[self.copies[check_fixed(fixed, len(self.copies))]] = True
        return mask


def join(V: ArrayLike, F: ArrayLike) -> Joined:
    """Join the copies of vertices along seams.

    A seam is where boundary edges lie in just the same place: the ends of such edges are
    copies of one vertex. Surfaces that only touch, in vertices or edges
    that are no boundary, stay apart. `repair` merges whatever lies in one place.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    Joined
        V, F, copies; V and F themselves where there is no seam.

    Raises
    ------
    MeshError
        No mesh.
    """
    V, F = check_mesh(V, F)
    place = first_equal(V)
    copies = np.arange(len(V))
    if np.array_equal(place, copies):
        return Joined(V, F, copies)
    edges = Edges.of_all(F, len(V))
    i, j = edges.ends[edges.faces_of_edge == 1].T
    # From the lower place to the higher, so that ends in one place are paired.
    swap = place[i] > place[j]
    i, j = np.where(swap, j, i), np.where(swap, i, j)
    keys = place[i] * len(V) + place[j]
    order = np.argsort(keys, kind="stable")
    order = order[place[i[order]] != place[j[order]]]
    same = np.flatnonzero(keys[order][1:] == keys[order][:-1])
    one, other = order[same], order[same + 1]
    _, group = connected_components(
        np.concatenate([i[one], j[one]]), np.concatenate([i[other], j[other]]), len(V)
    )
    first, copies = np.unique(group, return_index=True, return_inverse=True)[1:]
    if len(first) == len(V):
        return Joined(V, F, np.arange(len(V)))
    rank = np.argsort(np.argsort(first))  # joined vertices stay in their order
    copies = rank[copies]
    return Joined(V[np.sort(first)], copies[F], copies)


def warn_of_copies(joined: Joined) -> None:
    """Say in one line that copies were joined, if there are any.

    Parameters
    ----------
    joined : Joined

    Warns
    -----
    MeshWarning
    """
    if len(joined.V) < len(joined.copies):
        n, count = len(joined.copies), len(joined.copies) - len(joined.V)
        warn(
            f"{count:,} of {n:,} vertices are copies of others, along seams or in a soup of "
            "triangles; copies are moved as one, and stay together"
        )


def on_joined(
    function: Callable[Concatenate[ArrayLike, ArrayLike, P], Floats],
) -> Callable[Concatenate[ArrayLike, ArrayLike, P], Floats]:
    """Decorate a function from a mesh to new positions: all copies of a vertex get the same one.

    Parameters
    ----------
    function : function
        Called as ``function(V, F, ...)``, returns positions of the shape of V.

    Returns
    -------
    function
    """

    @wraps(function)
    def joined_first(V: ArrayLike, F: ArrayLike, *args: P.args, **kwargs: P.kwargs) -> Floats:
        joined = join(V, F)
        warn_of_copies(joined)
        return function(joined.V, joined.F, *args, **kwargs)[joined.copies]

    return joined_first
