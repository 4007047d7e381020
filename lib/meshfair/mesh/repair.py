"""Repair what `inspect` finds: only what is asked for, and each step is reported."""

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import (
    Booleans,
    Floats,
    Integers,
    MeshError,
    check_choice,
    check_mesh,
    check_number,
)
from meshfair.mesh.duplicates import duplicate_faces, first_equal
from meshfair.mesh.elements import Edges
from meshfair.mesh.geometry import degenerate_faces, mean_edge_length
from meshfair.mesh.objects import takes_meshes
from meshfair.mesh.topology import (
    HalfEdgePairs,
    Orientation,
    connected_components,
    fans,
    half_edge_pairs,
    interior_manifold_pairs,
    orientation,
    referenced,
    topologically_degenerate,
)

ORIENT = (None, "consistent", "outward")
# Welding that would merge a vertex with this many others on average is no
# welding any more, and the list of pairs would fill the memory.
MOST_NEAR = 30


class Step(NamedTuple):
    """One thing that `repair` was asked to do, and what it did."""

    name: str
    """The parameter that asked for it."""
    changed: int
    """How many vertices or faces it changed; 0 where there was nothing to do."""
    message: str
    """The same in words."""


class Repaired(NamedTuple):
    """What `repair` returns."""

    V: Floats
    """Positions, float64 of shape (n', 3): always ``V_old[vertex_map]``."""
    F: Integers
    """Faces, int64 of shape (m', 3)."""
    vertex_map: Integers
    """The old index of each vertex; int64 of shape (n',). A vertex that was
    split comes more than once; one that was welded into another or dropped is
    missing."""
    report: tuple[Step, ...]
    """One step for each thing asked for, in the order in which they were done."""


@takes_meshes
def repair(
    V: ArrayLike,
    F: ArrayLike,
    *,
    weld: float | None = None,
    degenerate: bool = False,
    duplicates: bool = False,
    split: bool = False,
    orient: Literal["consistent", "outward"] | None = None,
    unreferenced: bool = False,
) -> Repaired:
    """Repair a mesh, step by step, doing only what is asked for.

    The steps are done in the order of the parameters. Values of the old
    vertices carry over through ``vertex_map``: the positions of a ground truth
    to compare with become ``V_true[vertex_map]``.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    weld : float, optional
        Merge vertices that are no further apart than this fraction of the mean
        edge length, 0 to 1; with 0, those in just the same place. Chains of
        such vertices become one, that with the lowest index, which keeps its
        place.
    degenerate : bool
        Drop the faces without area, see `degenerate_faces`. Where their
        corners are three different places, that opens a slit in the surface.
    duplicates : bool
        Drop the faces that have the three vertices of an earlier face,
        whatever the orientation of either.
    split : bool
        Cut the surface apart along edges with more than two faces, and at
        vertices where it only touches itself, by giving each part a vertex of
        its own [GTLH01]_. All edges and vertices are manifold after it. The
        first part keeps the old vertices; copies are appended at the end.
    orient : {"consistent", "outward"}, optional
        Flip faces so that neighbours have one orientation. The majority of the
        connected faces keeps its own; with "outward", closed surfaces are
        oriented so that they enclose a positive volume (cavities too).
        Non-orientable surfaces stay as they are.
    unreferenced : bool
        Drop the vertices that no face uses (any more).

    Returns
    -------
    Repaired
        V, F, vertex_map, report.

    Raises
    ------
    MeshError
        No mesh, a welding distance that would merge a large part of the
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
    ...     print(step.message)
    """
    V, F = check_mesh(V, F)
    check_choice(orient, "orient", ORIENT)
    if weld is not None:
        weld = check_number(weld, "weld", 0, 1)
    F, vertex_map = F.copy(), np.arange(len(V))
    report: list[Step] = []
    if weld is not None:
        F, vertex_map, step = _weld(V, F, weld)
        report.append(step)
    if degenerate:
        F, step = _drop_faces(F, degenerate_faces(V[vertex_map], F), "degenerate", "without area")
        report.append(step)
    if duplicates:
        F, step = _drop_faces(F, duplicate_faces(F), "duplicates", "that were duplicates")
        report.append(step)
    if split:
        F, vertex_map, step = _split(F, vertex_map)
        report.append(step)
    if orient is not None:  # what was cut off may be closed now
        F, step = _orient(V[vertex_map], F, orient)
        report.append(step)
    if unreferenced:
        F, vertex_map, step = _drop_unreferenced(F, vertex_map)
        report.append(step)
    return Repaired(V[vertex_map], F, vertex_map, tuple(report))


def _weld(V: Floats, F: Integers, tolerance: float) -> tuple[Integers, Integers, Step]:
    """Faces on the welded vertices, the old index of those that stay, and the step."""
    leader = first_equal(V)
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


def _near(V: Floats, rows: Integers, reach: float) -> Integers:
    """The lowest index that a chain of near vertices leads to, among some rows of V.

    Returns an array of shape (n,), of use at ``rows`` only.
    """
    from scipy.spatial import KDTree  # slow to load, and seldom needed

    tree = KDTree(V[rows])
    if tree.count_neighbors(tree, reach) > (1 + MOST_NEAR) * len(rows):
        raise MeshError(
            f"welding within {reach:.3g} units would merge each vertex with more than {MOST_NEAR} "
            "others on average; give a smaller weld"
        )
    i, j = tree.query_pairs(reach, output_type="ndarray").T
    _, group = connected_components(i, j, len(rows))
    lowest = np.arange(len(V))
    lowest[rows] = rows[np.unique(group, return_index=True)[1][group]]
    return lowest


def _drop_faces(F: Integers, drop: Booleans, name: str, which: str) -> tuple[Integers, Step]:
    """The faces that stay, and the step."""
    count = int(drop.sum())
    if count == len(F):
        raise MeshError(f"every face is {which}, so {name} would leave no mesh")
    return F[~drop], Step(name, count, f"dropped {count:,} faces {which}")


def _orient(V: Floats, F: Integers, how: str) -> tuple[Integers, Step]:
    """Faces flipped where needed, and the step."""
    proper = np.flatnonzero(~topologically_degenerate(F))
    T = F[proper]
    edges = Edges.of_all(T, len(V))
    pairs = interior_manifold_pairs(half_edge_pairs(T, edges), edges)
    oriented = orientation(T, pairs)
    flip = oriented.flip
    if how == "outward":
        flip = flip ^ _inside_out(V, T, oriented, pairs)
    F[proper[flip]] = F[proper[flip]][:, [0, 2, 1]]
    message = f"flipped {flip.sum():,} faces"
    if left := int(oriented.nonorientable.sum()):
        message += f"; left {left:,} on non-orientable surfaces, which have one side only"
    return F, Step("orient", int(flip.sum()), message)


def _inside_out(V: Floats, F: Integers, oriented: Orientation, pairs: HalfEdgePairs) -> Booleans:
    """Faces on closed patches that enclose a negative volume once neighbours agree."""
    patch, flip, nonorientable = oriented
    X = V - V.mean(axis=0)
    a, b, c = X[F[:, 0]], X[F[:, 1]], X[F[:, 2]]
    volume = np.einsum("ij,ij->i", a, np.cross(b, c))
    volume = np.bincount(patch, np.where(flip, -volume, volume))
    # A patch is closed where each of its faces is paired across all three edges.
    paired = np.bincount(np.concatenate([pairs.first, pairs.second]) % len(F), minlength=len(F))
    is_open = np.bincount(patch, (paired < 3) | nonorientable) > 0
    return ((volume < 0) & ~is_open)[patch]


def _split(F: Integers, vertex_map: Integers) -> tuple[Integers, Integers, Step]:
    """Faces with a vertex of its own for each fan, the vertices' old indices, and the step."""
    proper = ~topologically_degenerate(F)
    T = F[proper]
    edges = Edges.of_all(T, len(vertex_map))
    fan = fans(T, interior_manifold_pairs(half_edge_pairs(T, edges), edges)).T
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
    message = (
        f"cut the surface apart along {(edges.faces_of_edge > 2).sum():,} non-manifold edges and "
        f"at {len(np.unique(vertex_of_fan[copies])):,} vertices, which took {len(copies):,} copies"
    )
    return F, vertex_map, Step("split", len(copies), message)


def _drop_unreferenced(F: Integers, vertex_map: Integers) -> tuple[Integers, Integers, Step]:
    """Faces and old indices after unused vertices are dropped, and the step."""
    used = referenced(F, len(vertex_map))
    number = np.cumsum(used) - 1
    count = int((~used).sum())
    message = f"dropped {count:,} vertices without faces"
    return number[F], vertex_map[used], Step("unreferenced", count, message)
