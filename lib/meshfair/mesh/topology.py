"""How faces are connected: components, fans around vertices, orientation."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array

from meshfair.checks import Booleans, Integers, check_faces
from meshfair.mesh.elements import Edges, half_edges


def topologically_degenerate(F: Integers) -> Booleans:
    """Which faces name a vertex twice, and so are no triangles at all.

    Parameters
    ----------
    F : ndarray of int64, shape (m, 3)

    Returns
    -------
    ndarray of bool, shape (m,)
    """
    a, b, c = F.T
    return (a == b) | (b == c) | (c == a)


def is_closed(F: ArrayLike) -> bool:
    """Whether every edge has exactly two faces: closed, edges manifold.

    The original report's assumption on its meshes (section 1): no boundary, and
    two faces at each edge.

    Parameters
    ----------
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    bool

    Raises
    ------
    MeshError
        Not of shape (m, 3), not integers, no faces, or a negative index.
    """
    return bool(np.all(Edges(F).faces_of_edge == 2))


def connected_components(i: Integers, j: Integers, count: int) -> tuple[int, NDArray[np.int32]]:
    """Number the connected components of a graph that is given by its links.

    Parameters
    ----------
    i, j : ndarray of integers, shape (k,)
        Link l connects the nodes i[l] and j[l].
    count : int
        Number of nodes.

    Returns
    -------
    components : int
        Number of components; a node without links is one.
    labels : ndarray of int32, shape (count,)
        Component of each node, 0 .. components - 1.
    """
    from scipy.sparse import csgraph  # slow to load, and seldom needed

    links = coo_array((np.ones(len(i), dtype=np.int8), (i, j)), shape=(count, count))
    components, labels = csgraph.connected_components(links, directed=False)
    return components, labels


def components(F: ArrayLike, n: int) -> tuple[int, Integers]:
    """Connected components of the mesh's graph.

    Parameters
    ----------
    F : array_like of integers, shape (m, 3)
    n : int
        Number of vertices.

    Returns
    -------
    count : int
        Number of components that have a face; an unreferenced vertex is none.
    labels : ndarray of int64, shape (n,)
        Component of each vertex, 0 .. count-1, and -1 where no face uses it.

    Raises
    ------
    MeshError
        See `meshfair.checks.check_faces`.
    """
    return number_components(check_faces(F, n), n)


def number_components(F: Integers, n: int) -> tuple[int, Integers]:
    """`components` of checked faces, or of none."""
    # Two of a triangle's edges connect its three vertices.
    parts, raw = connected_components(F[:, :2].ravel(), F[:, 1:].ravel(), n)
    used = referenced(F, n)
    has_faces = np.bincount(raw[used], minlength=parts) > 0
    number = np.cumsum(has_faces) - 1
    return int(has_faces.sum()), np.where(used, number[raw], -1)


def referenced(F: Integers, n: int) -> Booleans:
    """Which vertices have a face; bool, shape (n,)."""
    used = np.zeros(n, dtype=bool)
    used[F] = True
    return used


class HalfEdgePairs(NamedTuple):
    """Pairs of half-edges that lie on one edge: where faces meet."""

    first: Integers
    """Rows of `half_edges`, shape (k,)."""
    second: Integers
    """The other half-edge of each pair, shape (k,)."""
    opposed: Booleans
    """Whether the two run in opposite directions, as in faces of one orientation."""
    edge: Integers
    """The edge they lie on, shape (k,)."""


def orientations_agree(F: Integers, n: int) -> bool:
    """Whether no two half-edges run the same way, as where neighbours have one orientation.

    Parameters
    ----------
    F : ndarray of int64, shape (m, 3)
    n : int
        Number of vertices.

    Returns
    -------
    bool
        False also where an edge has more than two faces, and at duplicate faces.
    """
    tail, tip = half_edges(F).T
    keys = np.sort(tail * n + tip)
    return not np.any(keys[1:] == keys[:-1])


def half_edge_pairs(F: Integers, edges: Edges) -> HalfEdgePairs:
    """The faces that meet at each edge, as pairs of half-edges.

    Parameters
    ----------
    F : ndarray of int64, shape (m, 3)
    edges : Edges
        Of the same faces.

    Returns
    -------
    HalfEdgePairs
        An edge of more than two faces gives a chain of pairs, from each of
        its faces to the next; one on the boundary gives none.
    """
    edge = edges.of_half_edge
    meet = np.flatnonzero(edge[1:] == edge[:-1])
    first, second = edges.half_edges[meet], edges.half_edges[meet + 1]
    tail = F[:, [1, 2, 0]].T.ravel()
    return HalfEdgePairs(first, second, tail[first] != tail[second], edge[meet])


def interior_manifold_pairs(pairs: HalfEdgePairs, edges: Edges) -> HalfEdgePairs:
    """Those pairs that lie on interior manifold edges, which have just two faces."""
    two = edges.faces_of_edge[pairs.edge] == 2
    return pairs if two.all() else HalfEdgePairs(*(column[two] for column in pairs))


def fans(F: Integers, pairs: HalfEdgePairs) -> NDArray[np.int32]:
    """Group the corners of faces into fans: runs of faces around a vertex.

    Two corners at one vertex are in one fan when a walk from face to face
    across the given pairs of half-edges, always around this vertex, leads
    from one to the other. On a manifold every vertex has one fan.

    Parameters
    ----------
    F : ndarray of int64, shape (m, 3)
    pairs : HalfEdgePairs

    Returns
    -------
    ndarray of int32, shape (3, m)
        Number of the fan, from 0, of each face's first, second and third corner.
    """
    corners = 3 * len(F)
    # Half-edge h, opposite corner h, runs from the next corner to the one after.
    tail_1, tip_1 = _around(pairs.first, len(F))
    tail_2, tip_2 = _around(pairs.second, len(F))
    i = np.concatenate([tail_1, tip_1])
    j = np.concatenate(
        [np.where(pairs.opposed, tip_2, tail_2), np.where(pairs.opposed, tail_2, tip_2)]
    )
    return connected_components(i, j, corners)[1].reshape(3, -1)


def _around(h: Integers, m: int) -> tuple[Integers, Integers]:
    """Corners (numbered as half-edges are: corner k of face f is k m + f) at h's two ends."""
    return (h + m) % (3 * m), (h + 2 * m) % (3 * m)


def boundary_loops(edges: Edges, corner_fans: NDArray[np.int32]) -> int:
    """Number the loops of the boundary.

    Where the surface touches itself at a vertex, the loops through it are
    distinguished by the fans that they go around.

    Parameters
    ----------
    edges : Edges
    corner_fans : ndarray of integers, shape (3, m)
        As `fans` gives them, for all pairs of half-edges.

    Returns
    -------
    int
        Number of loops.
    """
    on_boundary = edges.half_edges[edges.start[:-1][edges.faces_of_edge == 1]]
    ends = corner_fans.ravel()[np.stack(_around(on_boundary, corner_fans.shape[1]))]
    at, links = np.unique(ends, return_inverse=True)
    tail, tip = links.reshape(2, -1)
    return connected_components(tail, tip, len(at))[0]


class Orientation(NamedTuple):
    """How the orientations of faces agree, and which faces to flip."""

    patch: NDArray[np.int32]
    """Number of each face's patch: faces that are connected across edges; shape (m,)."""
    flip: Booleans
    """The faces to flip for all of a patch to agree: the fewer of its two sides,
    and on equal numbers the side without its first face; bool, shape (m,)."""
    nonorientable: Booleans
    """Faces of a patch that cannot agree, as on a Moebius strip; bool, shape (m,)."""


def orientation(F: Integers, pairs: HalfEdgePairs) -> Orientation:
    """Find the faces to flip so that neighbours have one orientation.

    Parameters
    ----------
    F : ndarray of int64, shape (m, 3)
    pairs : HalfEdgePairs
        The `interior_manifold_pairs`: where more than two faces meet, no two of
        them are neighbours more than the others.

    Returns
    -------
    Orientation
    """
    m = len(F)
    f, g = pairs.first % m, pairs.second % m
    count, patch = connected_components(f, g, m)
    # Each face twice: as it is (f) and flipped (f + m). Neighbours that agree are
    # linked like to like, others like to flipped; so the two sides of a patch fall
    # apart into two components, unless it is non-orientable.
    swap = np.where(pairs.opposed, 0, m)
    i, j = np.concatenate([f, f + m]), np.concatenate([g + swap, g + m - swap])
    _, side = connected_components(i, j, 2 * m)
    nonorientable = side[:m] == side[m:]
    leader = np.unique(patch, return_index=True)[1]
    against = side[:m] != side[leader[patch]]
    most = 2 * np.bincount(patch, against, count) > np.bincount(patch, minlength=count)
    return Orientation(patch, (against ^ most[patch]) & ~nonorientable, nonorientable)
