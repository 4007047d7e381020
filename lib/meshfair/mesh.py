"""Topology, normals, areas: what the other modules ask of a triangle mesh."""

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from meshfair.checks import check_faces, check_mesh

# A triangle is degenerate when its height over its longest edge is this small
# a part of that edge: below it, rounding decides the normal and the cotangents.
DEGENERATE = 1e-12


def half_edges(F):
    """The three directed edges of each triangle.

    Parameters
    ----------
    F : ndarray of int64, shape (m, 3)

    Returns
    -------
    ndarray of int64, shape (3m, 2)
        Rows 0 .. m-1 are the edges opposite each triangle's first corner,
        then those opposite its second, then its third.
    """
    return np.concatenate([F[:, [1, 2]], F[:, [2, 0]], F[:, [0, 1]]])


def edges(F):
    """Edges without orientation, each once, and how many faces have each.

    Parameters
    ----------
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    E : ndarray of int64, shape (k, 2)
        Rows (i, j) with i < j, sorted. An edge from a vertex to itself, which
        only a degenerate triangle has, is left out.
    faces_of_edge : ndarray of int64, shape (k,)
        Number of triangles at each edge, duplicate faces counted once: 1 on
        the boundary, 2 inside, more where the mesh is not manifold.
    """
    F = unique_faces(F)
    n = F.max() + 1
    H = half_edges(F)
    low, high = H.min(axis=1), H.max(axis=1)
    # One integer for each edge sorts many times faster than rows of two.
    keys, faces_of_edge = np.unique((low * n + high)[low != high], return_counts=True)
    return np.column_stack(np.divmod(keys, n)), faces_of_edge


def unique_faces(F):
    """The faces without repetitions, the first of each kept, in their order.

    Two faces are duplicates where they have the same three vertices, whatever
    their orientation.

    Parameters
    ----------
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    ndarray of int64, shape (m', 3)
    """
    F = check_faces(F, np.max(F, initial=0) + 1)
    corners = np.sort(F, axis=1)
    order = np.lexsort(corners.T)  # stable, so the first of equals leads its run
    repeated = np.all(corners[order[1:]] == corners[order[:-1]], axis=1)
    return F if not repeated.any() else np.delete(F, order[1:][repeated], axis=0)


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
    return bool(np.all(edges(F)[1] == 2))


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
    F = check_faces(F, n)
    H = half_edges(F)
    graph = csr_array((np.ones(len(H), dtype=np.int8), (H[:, 0], H[:, 1])), shape=(n, n))
    _, raw = connected_components(graph, directed=False)
    labels = np.full(n, -1)
    used = np.unique(F)
    _, labels[used] = np.unique(raw[used], return_inverse=True)
    return int(labels.max()) + 1, labels


def area_vectors(V, F):
    """Each face's normal times its area: half the cross product of two edges."""
    a, b, c = V[F[:, 0]], V[F[:, 1]], V[F[:, 2]]
    return 0.5 * np.cross(b - a, c - a)


def _normalised(X):
    """Rows of length one; a row of zeros, which has no direction, stays zero."""
    length = np.linalg.norm(X, axis=1, keepdims=True)
    return np.divide(X, length, out=np.zeros_like(X), where=length > 0)


def face_areas(V, F):
    """Areas of the triangles, in squared units of length.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    ndarray of float64, shape (m,)
    """
    return np.linalg.norm(area_vectors(*check_mesh(V, F)), axis=1)


def face_normals(V, F):
    """Unit normals of the triangles, outward where faces are counter-clockwise.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    ndarray of float64, shape (m, 3)
        Unit vectors; zero for a triangle without area.
    """
    return _normalised(area_vectors(*check_mesh(V, F)))


def vertex_normals(V, F):
    """Unit normals of the vertices: the mean of the faces' around, by area.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    ndarray of float64, shape (n, 3)
        Unit vectors; zero at a vertex without faces.
    """
    V, F = check_mesh(V, F)
    return _normalised(scatter(area_vectors(V, F), F, len(V)))


def scatter(X, F, n):
    """Sum a value of each face at its three vertices.

    Parameters
    ----------
    X : ndarray, shape (m,) or (m, k)
        One value, or one row, for each face.
    F : ndarray of int64, shape (m, 3)
    n : int
        Number of vertices.

    Returns
    -------
    ndarray of float64, shape (n,) or (n, k)
    """
    faces = np.repeat(np.arange(len(F)), 3)
    incidence = csr_array((np.ones(3 * len(F)), (F.ravel(), faces)), shape=(n, len(F)))
    return incidence @ X


def edge_lengths(V, F):
    """Lengths of the edges, each edge once, in the order of `edges`.

    Returns
    -------
    ndarray of float64, shape (k,)
    """
    V, F = check_mesh(V, F)
    E, _ = edges(F)
    return np.linalg.norm(V[E[:, 0]] - V[E[:, 1]], axis=1)


def mean_edge_length(V, F):
    """Mean length of the edges, each counted once: the package's unit of noise.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    float
        In the units of ``V``.
    """
    return float(edge_lengths(V, F).mean())


def degenerate_faces(V, F):
    """Which triangles have no area to speak of.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    ndarray of bool, shape (m,)
        True where the height over the longest edge is at most 1e-12 of it.
    """
    V, F = check_mesh(V, F)
    H = half_edges(F)
    squared = ((V[H[:, 0]] - V[H[:, 1]]) ** 2).sum(axis=1).reshape(3, -1).max(axis=0)
    doubled_area = 2 * np.linalg.norm(area_vectors(V, F), axis=1)
    return doubled_area <= DEGENERATE * squared


def area(V, F):
    """Area of the surface, in squared units of length."""
    return float(face_areas(V, F).sum())


def volume(V, F):
    """Signed volume that a closed mesh encloses, in cubed units of length.

    The sum of the signed volumes of the tetrahedra that the faces span with
    the vertices' centre (the divergence theorem). On an open mesh it is the
    volume of the cone over the surface from that centre.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    float
        Positive where the faces are counter-clockwise seen from outside.
    """
    V, F = check_mesh(V, F)
    X = V - V.mean(axis=0)  # keeps the sum accurate far from the origin
    return float(np.einsum("ij,ij->", X[F[:, 0]], area_vectors(X, F)) / 3)
