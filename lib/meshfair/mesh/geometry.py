"""Areas, normals, angles, lengths and volume of a triangle mesh."""

from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from meshfair.checks import MeshError, check_mesh
from meshfair.mesh.topology import edges

# A triangle is degenerate when its height over its longest edge is this small
# a part of that edge: below it, rounding decides the normal and the cotangents.
DEGENERATE = 1e-12


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

    Raises
    ------
    MeshError
        No mesh, or one whose faces have all collapsed to points.
    """
    lengths = edge_lengths(V, F)
    if not len(lengths):
        raise MeshError("every face names one vertex three times, so there is no edge at all")
    return float(lengths.mean())


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
    return measure(*check_mesh(V, F)).degenerate


class Triangles(NamedTuple):
    """Measures of triangles, in long contiguous rows; see `measure`."""

    cross: np.ndarray
    """Normals times twice the area, one coordinate a row; shape (3, m)."""
    doubled_area: np.ndarray
    """Shape (m,)."""
    degenerate: np.ndarray
    """Which have no area to speak of, see `degenerate_faces`; bool, shape (m,)."""
    cotangents: np.ndarray
    """Of the angles at the three corners; 0 in degenerate triangles; shape (3, m)."""


def measure(V, F):
    """Measure the areas and angles of all triangles.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)

    Returns
    -------
    Triangles
    """
    # Coordinate by coordinate, so that each array is long and contiguous.
    X = np.ascontiguousarray(V.T)
    A, B, C = (np.take(X, F[:, k], axis=1) for k in range(3))
    a, b, c = C - B, A - C, B - A
    dot = -np.stack([_dot(b, c), _dot(c, a), _dot(a, b)])
    cross = np.stack([a[i] * b[j] - a[j] * b[i] for i, j in ((1, 2), (2, 0), (0, 1))])
    doubled_area = np.sqrt(_dot(cross, cross))
    # An edge's squared length is the sum of the dot products at its two ends.
    longest = np.maximum(np.maximum(dot[0] + dot[1], dot[1] + dot[2]), dot[2] + dot[0])
    degenerate = doubled_area <= DEGENERATE * longest
    cotangents = np.divide(dot, doubled_area, out=np.zeros_like(dot), where=~degenerate)
    return Triangles(cross, doubled_area, degenerate, cotangents)


def _dot(u, v):
    """Dot products of the columns of two arrays of shape (3, m)."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


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
