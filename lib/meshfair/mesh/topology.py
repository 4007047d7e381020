"""How faces hang together: edges, components, fans around vertices, orientation."""

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array

from meshfair.checks import check_faces
from meshfair.mesh.edges import Edges


def collapsed_faces(F):
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


def is_closed(F):
    """Whether every edge has exactly two faces: closed, edges manifold.

    The seed's assumption on its meshes (section 1): no boundary, and two
    faces at each edge.

    Parameters
    ----------
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    bool
    """
    return bool(np.all(Edges(F).faces_of_edge == 2))


def joined(i, j, count):
    """Number the groups into which links join things together.

    Parameters
    ----------
    i, j : ndarray of integers, shape (k,)
        Link number l joins the things i[l] and j[l].
    count : int
        How many things there are.

    Returns
    -------
    groups : int
        Number of groups; a thing without links is one.
    labels : ndarray of int32, shape (count,)
        Group of each thing, 0 .. groups - 1.
    """
    from scipy.sparse.csgraph import connected_components  # slow to load, and seldom needed

    links = coo_array((np.ones(len(i), dtype=np.int8), (i, j)), shape=(count, count))
    return connected_components(links, directed=False)


def components(F, n):
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
    """
    return number_components(check_faces(F, n), n)


def number_components(F, n):
    """`components` of checked faces, or of none."""
    # Two of a triangle's edges join its three vertices.
    groups, raw = joined(F[:, :2].ravel(), F[:, 1:].ravel(), n)
    used = referenced(F, n)
    has_faces = np.bincount(raw[used], minlength=groups) > 0
    number = np.cumsum(has_faces) - 1
    return int(has_faces.sum()), np.where(used, number[raw], -1)


def referenced(F, n):
    """Which vertices have a face; bool, shape (n,)."""
    used = np.zeros(n, dtype=bool)
    used[F] = True
    return used


class Neighbours(NamedTuple):
    """Pairs of half-edges that lie on one edge: where faces meet."""

    first: np.ndarray
    """Rows of `half_edges`, shape (k,)."""
    second: np.ndarray
    """The other half-edge of each pair, shape (k,)."""
    opposed: np.ndarray
    """Whether the two run in opposite directions, as in faces of one orientation."""
    edge: np.ndarray
    """The edge they lie on, shape (k,)."""


def neighbours(F, edges):
    """The faces that meet at each edge, as pairs of half-edges.

    Parameters
    ----------
    F : ndarray of int64, shape (m, 3)
    edges : Edges
        Of the same faces.

    Returns
    -------
    Neighbours
        An edge of more than two faces gives a chain of pairs, from each of
        its faces to the next; one on the boundary gives none.
    """
    edge = edges.of_half_edge
    meet = np.flatnonzero(edge[1:] == edge[:-1])
    first, second = edges.half_edges[meet], edges.half_edges[meet + 1]
    tail = F[:, [1, 2, 0]].T.ravel()
    return Neighbours(first, second, tail[first] != tail[second], edge[meet])


def across_two_faces(pairs, edges):
    """Those of `neighbours` that meet at an edge with just two faces."""
    two = edges.faces_of_edge[pairs.edge] == 2
    return pairs if two.all() else Neighbours(*(column[two] for column in pairs))


def fans(F, pairs):
    """Group the corners of faces into fans: runs of faces around a vertex.

    Two corners at one vertex are in one fan when a walk from face to face
    across the given pairs of half-edges, always around this vertex, leads
    from one to the other. On a manifold every vertex has one fan.

    Parameters
    ----------
    F : ndarray of int64, shape (m, 3)
    pairs : Neighbours

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
    return joined(i, j, corners)[1].reshape(3, -1)


def _around(h, m):
    """Corners (numbered as half-edges are: corner k of face f is k m + f) at h's two ends."""
    return (h + m) % (3 * m), (h + 2 * m) % (3 * m)


def boundary_loops(edges, corner_fans):
    """Number the loops of the boundary.

    Where the surface touches itself at a vertex, the loops through it are
    told apart by the fans that they go around.

    Parameters
    ----------
    edges : Edges
    corner_fans : ndarray of integers, shape (3, m)
        As `fans` gives them, for all pairs of neighbours.

    Returns
    -------
    int
        Number of loops.
    """
    on_boundary = edges.half_edges[edges.start[:-1][edges.faces_of_edge == 1]]
    ends = corner_fans.ravel()[np.stack(_around(on_boundary, corner_fans.shape[1]))]
    at, links = np.unique(ends, return_inverse=True)
    return joined(*links.reshape(2, -1), len(at))[0]


class Orientation(NamedTuple):
    """How faces are turned against each other, and which to turn over."""

    patch: np.ndarray
    """Number of each face's patch: faces that hang together across edges; int, shape (m,)."""
    turn: np.ndarray
    """The faces to turn over for all of a patch to agree: the fewer of its two
    sides, and on equal numbers the side without its first face; bool, shape (m,)."""
    one_sided: np.ndarray
    """Faces of a patch where that cannot be, as on a Moebius strip; bool, shape (m,)."""


def orientation(F, pairs):
    """Find the faces to turn over so that neighbours agree.

    Parameters
    ----------
    F : ndarray of int64, shape (m, 3)
    pairs : Neighbours
        Those `across_two_faces`: where more than two meet, no two of them are
        neighbours more than the others.

    Returns
    -------
    Orientation
    """
    m = len(F)
    f, g = pairs.first % m, pairs.second % m
    count, patch = joined(f, g, m)
    # Each face twice: as it is (f) and turned over (f + m). Neighbours that agree
    # are joined like to like, others like to turned; so the two sides of a patch
    # fall apart into two groups, unless it is one-sided.
    swap = np.where(pairs.opposed, 0, m)
    _, side = joined(np.concatenate([f, f + m]), np.concatenate([g + swap, g + m - swap]), 2 * m)
    one_sided = side[:m] == side[m:]
    leader = np.unique(patch, return_index=True)[1]
    against = side[:m] != side[leader[patch]]
    most = 2 * np.bincount(patch, against, count) > np.bincount(patch, minlength=count)
    return Orientation(patch, (against ^ most[patch]) & ~one_sided, one_sided)
