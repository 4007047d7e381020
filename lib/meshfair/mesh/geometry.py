"""Areas, normals, angles, lengths and volume of a triangle mesh."""

import warnings
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from meshfair import _fast
from meshfair.checks import (
    DEGENERATE,
    Booleans,
    Floats,
    Integers,
    MeshError,
    MeshWarning,
    check_mesh,
)
from meshfair.mesh.edges import Edges


class Triangles:
    """The measures of all triangles, each computed when it is asked for.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    """

    def __init__(self, V: Floats, F: Integers) -> None:
        # Coordinate by coordinate, so that each array is long and contiguous.
        X = np.ascontiguousarray(V.T)
        self._corners = [np.take(X, F[:, k], axis=1) for k in range(3)]

    @cached_property
    def _dots(self) -> Floats:
        """u . v of the two edge vectors at each of the three corners; shape (3, m)."""
        A, B, C = self._corners
        a, b, c = C - B, A - C, B - A
        return -np.stack([_dot(b, c), _dot(c, a), _dot(a, b)])

    @cached_property
    def cross(self) -> Floats:
        """Cross product of two edges: the normal times twice the area; shape (3, m)."""
        A, B, C = self._corners
        u, v = B - A, C - A
        return np.stack([u[i] * v[j] - u[j] * v[i] for i, j in ((1, 2), (2, 0), (0, 1))])

    @cached_property
    def doubled_area(self) -> Floats:
        """Twice the area; shape (m,)."""
        return np.sqrt(_dot(self.cross, self.cross))

    @property
    def area(self) -> Floats:
        """Area, in squared units of length; shape (m,)."""
        return self.doubled_area / 2

    @property
    def area_vectors(self) -> Floats:
        """Normal times area; shape (m, 3)."""
        return self.cross.T / 2

    @property
    def normals(self) -> Floats:
        """Unit normals; zero for a triangle without area; shape (m, 3)."""
        return normalised(self.cross.T)

    @property
    def centroids(self) -> Floats:
        """Mean of the three corners; shape (m, 3)."""
        A, B, C = self._corners
        return np.ascontiguousarray(((A + B + C) / 3).T)

    @cached_property
    def degenerate(self) -> Booleans:
        """Which have no area to speak of, see `degenerate_faces`; shape (m,)."""
        # An edge's squared length is the sum of the dot products at its two ends.
        dots = self._dots
        longest = np.maximum(np.maximum(dots[0] + dots[1], dots[1] + dots[2]), dots[2] + dots[0])
        return self.doubled_area <= DEGENERATE * longest

    @cached_property
    def cotangents(self) -> Floats:
        """cot = u . v / |u x v| at the three corners; 0 in degenerate triangles; shape (3, m)."""
        dots = self._dots
        return np.divide(dots, self.doubled_area, out=np.zeros_like(dots), where=~self.degenerate)


def normalised(X: Floats) -> Floats:
    """Rows of length one; a row of zeros, which has no direction, stays zero."""
    length = np.linalg.norm(X, axis=1, keepdims=True)
    return np.divide(X, length, out=np.zeros_like(X), where=length > 0)


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
    return Triangles(*check_mesh(V, F)).area


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
    return Triangles(*check_mesh(V, F)).normals


def vertex_normals(V: ArrayLike, F: ArrayLike) -> Floats:
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
    return normalised(scatter(Triangles(V, F).area_vectors, F, len(V)))


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

    Returns
    -------
    ndarray of float64, shape (k,)
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
        True where the height over the longest edge is at most 1e-12 of it.
    """
    return Triangles(*check_mesh(V, F)).degenerate


def warn_of_degenerate_faces(V: Floats, F: Integers, effect: str) -> None:
    """Warn of degenerate faces, if there are any: how many, the first, and what they do.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    effect : str
        How the sentence ends that begins with "they".

    Warns
    -----
    MeshWarning
    """
    degenerate = Triangles(V, F).degenerate
    if degenerate.any():
        warnings.warn(
            f"{degenerate.sum()} of {len(F)} faces are degenerate (the first has vertices "
            f"{F[degenerate][0].tolist()}); they {effect}",
            MeshWarning,
            stacklevel=3,
        )


def _dot(u: Floats, v: Floats) -> Floats:
    """Dot products of the columns of two arrays of shape (3, m)."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def area(V: ArrayLike, F: ArrayLike) -> float:
    """Area of the surface, in squared units of length."""
    return float(face_areas(V, F).sum())


def volume(V: ArrayLike, F: ArrayLike) -> float:
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
    return float(np.einsum("ij,ij->", X[F[:, 0]], Triangles(X, F).area_vectors) / 3)
