"""Mend what `inspect` finds: only what is asked for, and each step is told."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree

from meshfair.checks import MeshError, check_mesh, check_number
from meshfair.mesh.duplicates import repeated_faces, repeated_rows
from meshfair.mesh.edges import Edges
from meshfair.mesh.geometry import degenerate_faces, mean_edge_length
from meshfair.mesh.topology import (
    across_two_faces,
    collapsed_faces,
    fans,
    joined,
    neighbours,
    orientation,
    referenced,
)

ORIENT = ("consistent", "outward")
# Welding that would join a vertex with this many others on average is no
# welding any more, and the list of pairs would fill the memory.
MOST_PAIRS = 30


class Step(NamedTuple):
    """One thing that `repair` was asked to do, and what came of it."""

    name: str
    """The parameter that asked for it."""
    count: int
    """How many vertices or faces it changed; 0 where there was nothing to do."""
    told: str
    """The same in words."""


class Repaired(NamedTuple):
    """What `repair` returns."""

    V: np.ndarray
    """Positions, float64 of shape (n', 3): always ``V_old[vertex_map]``."""
    F: np.ndarray
    """Faces, int64 of shape (m', 3)."""
    vertex_map: np.ndarray
    """The old index of each vertex; int64 of shape (n',). A vertex that was
    split comes more than once; one that was welded into another or dropped is
    missing."""
    report: tuple[Step, ...]
    """One step for each thing asked for, in the order in which they were done."""


def repair(
    V,
    F,
    *,
    weld=None,
    degenerate=False,
    duplicates=False,
    orient=None,
    split=False,
    unreferenced=False,
):
    """Mend a mesh, step by step, doing only what is asked for.

    The steps are done in the order of the parameters. Values of the old
    vertices carry over through ``vertex_map``: a clean mesh's positions to compare
    with become ``V_true[vertex_map]``.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    weld : float, optional
        Join vertices that are no further apart than this fraction of the mean
        edge length, 0 to 1; with 0, those in just the same place. Chains of
        such vertices become one, that with the lowest index, which keeps its
        place.
    degenerate : bool
        Drop the faces without area, see `degenerate_faces`. Where their
        corners are three different places, that opens a slit in the surface.
    duplicates : bool
        Drop the faces that have the three vertices of an earlier face,
        whatever the orientation of either.
    orient : {"consistent", "outward"}, optional
        Turn faces over so that neighbours agree. The majority of the faces
        that hang together keeps its orientation; with "outward", closed
        surfaces are turned so that they enclose a positive volume (cavities
        too). One-sided surfaces stay as they are.
    split : bool
        Cut the surface apart along edges with more than two faces, and at
        vertices where it only touches itself, by giving each part a vertex of
        its own [GTLH01]_. All edges and vertices are manifold after it. The
        first part keeps the old vertices; copies are appended at the end.
    unreferenced : bool
        Drop the vertices that no face uses (any more).

    Returns
    -------
    Repaired
        V, F, vertex_map, report.

    Raises
    ------
    MeshError
        No mesh, a welding distance that would join a large part of the
        vertices, or no face left.
    ValueError
        ``weld`` outside [0, 1], or an unknown ``orient``.

    References
    ----------
    .. [GTLH01] A. Gueziec, G. Taubin, F. Lazarus, B. Horn, "Cutting and
       stitching: converting sets of polygons to manifold surfaces", IEEE
       Transactions on Visualization and Computer Graphics 7(2), 2001.

    Examples
    --------
    >>> V, F, vertex_map, report = mesh.repair(V, F, weld=0, duplicates=True, split=True)
    >>> for step in report:
    ...     print(step.told)
    """
    V, F = check_mesh(V, F)
    if orient is not None and orient not in ORIENT:
        raise ValueError(f"orient is {orient!r}; give one of {', '.join(ORIENT)}, or None")
    if weld is not None:
        weld = check_number(weld, "weld", 0, 1)
    F, vertex_map, report = F.copy(), np.arange(len(V)), []
    if weld is not None:
        F, vertex_map, step = _weld(V, F, weld)
        report.append(step)
    if degenerate:
        F, step = _drop_faces(F, degenerate_faces(V[vertex_map], F), "degenerate", "without area")
        report.append(step)
    if duplicates:
        F, step = _drop_faces(F, repeated_faces(F), "duplicates", "that repeated an earlier one")
        report.append(step)
    if orient is not None:
        F, step = _orient(V[vertex_map], F, orient)
        report.append(step)
    if split:
        F, vertex_map, step = _split(F, vertex_map)
        report.append(step)
    if unreferenced:
        F, vertex_map, step = _drop_unreferenced(F, vertex_map)
        report.append(step)
    return Repaired(V[vertex_map], F, vertex_map, tuple(report))


def _weld(V, F, tolerance):
    """Faces on the welded vertices, the old index of those that stay, and the step."""
    leader = repeated_rows(V)
    if tolerance > 0:
        leader = leader[_near(V, np.unique(leader), tolerance * mean_edge_length(V, F))[leader]]
    vertex_map, number = np.unique(leader, return_inverse=True)
    count = len(V) - len(vertex_map)
    reach = f"within {tolerance:g} mean edge lengths" if tolerance else "in the same place"
    return (
        number[F],
        vertex_map,
        Step("weld", count, f"welded {count:,} vertices into others {reach}"),
    )


def _near(V, rows, reach):
    """The lowest index that a chain of near vertices leads to, among some rows of V.

    Returns an array of shape (n,), of use at ``rows`` only.
    """
    tree = KDTree(V[rows])
    if tree.count_neighbors(tree, reach) > (1 + MOST_PAIRS) * len(rows):
        raise MeshError(
            f"welding within {reach:.3g} units would join each vertex with more than {MOST_PAIRS} "
            "others on average; give a smaller weld"
        )
    i, j = tree.query_pairs(reach, output_type="ndarray").T
    _, group = joined(i, j, len(rows))
    lowest = np.arange(len(V))
    lowest[rows] = rows[np.unique(group, return_index=True)[1][group]]
    return lowest


def _drop_faces(F, drop, name, which):
    count = int(drop.sum())
    if count == len(F):
        raise MeshError(f"all {count:,} faces are {which}, so {name} would leave no mesh")
    return F[~drop], Step(name, count, f"dropped {count:,} faces {which}")


def _orient(V, F, how):
    """Faces turned over where needed, and the step."""
    proper = np.flatnonzero(~collapsed_faces(F))
    T = F[proper]
    edges = Edges.of_all(T, len(V))
    pairs = across_two_faces(neighbours(T, edges), edges)
    patch, turn, one_sided = orientation(T, pairs)
    if how == "outward":
        turn ^= _inside_out(V, T, patch, turn, one_sided, pairs)
    F[proper[turn]] = F[proper[turn]][:, [0, 2, 1]]
    told = f"turned {turn.sum():,} faces over"
    if one_sided.any():
        told += f"; left {one_sided.sum():,} on one-sided surfaces, which have no orientation"
    return F, Step("orient", int(turn.sum()), told)


def _inside_out(V, F, patch, turn, one_sided, pairs):
    """Faces on closed patches that enclose a negative volume once ``turn`` is applied."""
    X = V - V.mean(axis=0)
    a, b, c = X[F[:, 0]], X[F[:, 1]], X[F[:, 2]]
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    volume = np.bincount(patch, np.where(turn, -volume, volume))
    # A patch is closed where each of its faces is paired across all three edges.
    paired = np.bincount(np.concatenate([pairs.first, pairs.second]) % len(F), minlength=len(F))
    is_open = np.bincount(patch, (paired < 3) | one_sided) > 0
    return ((volume < 0) & ~is_open)[patch]


def _split(F, vertex_map):
    """Faces with a vertex of its own for each fan, the vertices' old indices, and the step."""
    proper = ~collapsed_faces(F)
    T = F[proper]
    edges = Edges.of_all(T, len(vertex_map))
    fan = fans(T, across_two_faces(neighbours(T, edges), edges)).T
    # Each fan's vertex; the fan of a vertex's first corner keeps it, the others get copies.
    _, first, number = np.unique(fan, return_index=True, return_inverse=True)
    vertex_of_fan = T.ravel()[first]
    keeps = np.full(len(vertex_map), len(T) * 3)
    np.minimum.at(keeps, vertex_of_fan, first)
    copies = np.flatnonzero(first != keeps[vertex_of_fan])
    copies = copies[np.argsort(first[copies])]
    new = vertex_of_fan.copy()
    new[copies] = len(vertex_map) + np.arange(len(copies))
    F = F.copy()
    F[proper] = new[number].reshape(-1, 3)
    vertex_map = np.concatenate([vertex_map, vertex_map[vertex_of_fan[copies]]])
    told = (
        f"cut the surface apart along {(edges.faces_of_edge > 2).sum():,} non-manifold edges and "
        f"at {len(np.unique(vertex_of_fan[copies])):,} vertices, which took {len(copies):,} copies"
    )
    return F, vertex_map, Step("split", len(copies), told)


def _drop_unreferenced(F, vertex_map):
    """Faces and old indices after unused vertices are dropped, and the step."""
    used = referenced(F, len(vertex_map))
    number = np.cumsum(used) - 1
    count = int((~used).sum())
    told = f"dropped {count:,} vertices without faces"
    return number[F], vertex_map[used], Step("unreferenced", count, told)
