"""Areas, normals, angles, lengths and volume of a triangle mesh."""

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from meshfair import _fast
from meshfair.checks import Booleans, Floats, Integers, MeshError, check_mesh
from meshfair.mesh.elements import Edges, Triangles, normalised


def face_areas(V: ArrayLike, F: ArrayLike) -> Floats:
    """Areas of the triangles, in squared units of length.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    ndarray of float64, shape (m,)
    """
    return Triangles(V, F).area


def face_normals(V: ArrayLike, F: ArrayLike) -> Floats:
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
    return Triangles(V, F).normals


def vertex_normals(V: ArrayLike, F: ArrayLike) -> Floats:
    """Unit normals of the vertices: the mean of the faces' around, by area.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    ndarray of float64, shape (n, 3)
        Unit vectors; zero at a vertex without faces, and where normals cancel.

    Raises
    ------
    MeshError
        No mesh.
    """
    V, F = check_mesh(V, F)
    T, B = Triangles(V, F), incidence(F, len(V))
    return normalised(B @ T.area_vectors, B @ T.area)


def scatter(X: Floats, F: Integers, n: int) -> Floats:
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
    return incidence(F, n) @ X


def incidence(F: Integers, n: int) -> csr_array:
    """Which faces each vertex has.

    Parameters
    ----------
    F : ndarray of int64, shape (m, 3)
    n : int
        Number of vertices.

    Returns
    -------
    B : csr_array of int8, shape (n, m)
        1 where the vertex is a corner of the face: row i lists the faces of
        vertex i, ``B.indices[B.indptr[i] : B.indptr[i + 1]]``.
    """
    faces = np.repeat(np.arange(len(F)), 3)
    ones = np.ones(3 * len(F), dtype=np.int8)
    B = csr_array((ones, (F.ravel(), faces)), shape=(n, len(F)))
    B.data[:] = 1  # a degenerate face may have a vertex twice
    return B


def face_shapes(V: Floats, F: Integers) -> tuple[Floats, Floats, Floats]:
    """Normals, areas and centroids of the faces, which filters need in every iteration.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)

    Returns
    -------
    N : ndarray of float64, shape (m, 3)
        Unit normals; zero for a face without area.
    area : ndarray of float64, shape (m,)
    C : ndarray of float64, shape (m, 3)
        Centroids.
    """
    if _fast.wanted(len(F)):
        return _fast.faces.face_shapes(V, F)
    T = Triangles(V, F)
    return T.normals, T.area, T.centroids


def edge_lengths(V: ArrayLike, F: ArrayLike) -> Floats:
    """Lengths of the edges, each edge once, in the order of `Edges`.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    ndarray of float64, shape (k,)
        In the units of ``V``.

    Raises
    ------
    MeshError
        No mesh.
    """
    V, F = check_mesh(V, F)
    return Edges(F, len(V)).lengths(V)


def mean_edge_length(V: ArrayLike, F: ArrayLike) -> float:
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
        No mesh, or one whose faces name a single vertex each.
    """
    lengths = edge_lengths(V, F)
    if not len(lengths):
        raise MeshError("every face names one vertex three times, so there is no edge at all")
    return float(lengths.mean())


def degenerate_faces(V: ArrayLike, F: ArrayLike) -> Booleans:
    """Which triangles have no area to speak of.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    ndarray of bool, shape (m,)
        True where the height over the longest edge is at most 1e-12 of it, or no more than
        the rounding of the corners' coordinates makes of three points on a line.
    """
    return Triangles(V, F).degenerate


def area(V: ArrayLike, F: ArrayLike) -> float:
    """Area of the surface: the sum over all faces.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    float
        In squared units of length.
    """
    return float(face_areas(V, F).sum())


def volume(V: ArrayLike, F: ArrayLike) -> float:
    """Signed volume that a closed mesh encloses, in cubed units of length.

    The sum of the signed volumes of the tetrahedra that the faces span with
    the centre of their vertices (the divergence theorem). On an open mesh it is
    the volume of the cone over the surface from that centre.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    float
        Positive where the faces are counter-clockwise seen from outside.

    Raises
    ------
    MeshError
        No mesh.
    """
    V, F = check_mesh(V, F)
    # Keeps the sum accurate far from the origin.
    X = V - V[np.unique(F)].mean(axis=0)
    return float(np.einsum("ij,ij->", X[F[:, 0]], Triangles(X, F).area_vectors) / 3)
