"""What is done to a mesh before a filter works on it, and undone on its results.

Copies of vertices along seams are joined, and for filters that use normals, faces that are
turned against each other are turned to agree. A filter is written for a mesh that needs
neither, and `prepared` makes it take any.
"""

from collections.abc import Callable, Iterator
from functools import wraps
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import (
    Booleans,
    Floats,
    Integers,
    check_mesh,
    warn,
)
from meshfair.mesh import join, repair
from meshfair.mesh.elements import Edges
from meshfair.mesh.joining import warn_of_copies
from meshfair.mesh.objects import takes_meshes
from meshfair.mesh.topology import half_edge_pairs, interior_manifold_pairs, orientations_agree

Filter = Callable[..., Iterator[tuple[float, Floats]]]


class Prepared:
    """A mesh as filters work on it, and the way back.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    normals : bool
        Whether faces shall be turned consistently.

    Attributes
    ----------
    V : ndarray of float64, shape (n', 3)
    F : ndarray of int64, shape (m, 3)

    Raises
    ------
    MeshError
        No mesh.

    Warns
    -----
    MeshWarning
        What was joined, and what was turned.
    """

    def __init__(self, V: ArrayLike, F: ArrayLike, *, normals: bool) -> None:
        self._V, F = check_mesh(V, F)
        self._joined = join(self._V, F)
        warn_of_copies(self._joined)
        self._last: tuple[Floats, Floats] | None = None
        self.V, self.F = self._joined.V, self._joined.F
        if normals and not orientations_agree(self.F, len(self.V)):
            self.F = _turned(self.V, self.F)

    def fixed(self, fixed: ArrayLike | None) -> Booleans:
        """Which of its vertices are fixed, see `meshfair.mesh.Joined.fixed`; shape (n',)."""
        return self._joined.fixed(fixed)

    def restored(self, X: Floats) -> Floats:
        """The positions of the given mesh's vertices that belong to positions of this one's.

        Parameters
        ----------
        X : ndarray of float64, shape (n', 3)

        Returns
        -------
        ndarray of float64, shape (n, 3)
            The same array where X is the one of the last call, and V itself for its own.
        """
        if X is self.V:
            return self._V
        if self._last is None or X is not self._last[0]:
            copies = self._joined.copies
            self._last = X, X if len(X) == len(copies) else X[copies]
        return self._last[1]


def prepared(function: Filter, *, normals: bool = False) -> Filter:
    """A filter that takes any mesh, from one written for prepared ones: see `Prepared`.

    Parameters
    ----------
    function : function
        Called as ``function(V, F, *, fixed, ...)``; an iterator over progress and positions.
    normals : bool
        Whether it uses normals.

    Returns
    -------
    function
        Called in the same way.
    """

    @takes_meshes
    @wraps(function)
    def run(V: ArrayLike, F: ArrayLike, **parameters: Any) -> Iterator[tuple[float, Floats]]:
        ready = Prepared(V, F, normals=normals)
        if parameters.get("fixed") is not None:
            parameters["fixed"] = ready.fixed(parameters["fixed"])
        for progress, X in function(ready.V, ready.F, **parameters):
            yield progress, ready.restored(X)

    return run


def _turned(V: Floats, F: Integers) -> Integers:
    """The faces turned consistently, as far as that goes; what was done is told."""
    F_turned = repair(V, F, orient="consistent").F
    count = int(np.any(F_turned != F, axis=1).sum())
    edges = Edges.of_all(F_turned, len(V))
    pairs = interior_manifold_pairs(half_edge_pairs(F_turned, edges), edges)
    against, shared = int((~pairs.opposed).sum()), int((edges.faces_of_edge > 2).sum())
    told = []
    if count:
        told.append(f"{count:,} of {len(F):,} faces were turned to agree with their neighbours")
    if against:
        told.append(f"normals turn over at {against:,} edges, as on a surface of one side")
    if shared:
        told.append(f"normals mix where more than two faces meet, at {shared:,} edges")
    if told:
        warn(f"{'; '.join(told)} (see mesh.inspect)")
    return F_turned
