"""The elements of a triangle mesh: one structure of its edges, one measure of its triangles."""

from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_array, csr_array

from meshfair import _fast
from meshfair.checks import (
    CANCELLED,
    DEGENERATE,
    ROUNDED,
    Booleans,
    Floats,
    Integers,
    MeshError,
    check_faces,
    check_mesh,
    warn,
)
from meshfair.mesh.duplicates import unique_faces


def half_edges(F: Integers) -> Integers:
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


class Edges:
    """The edges of a list of triangles, each once, with the half-edges on it.

    A flow that moves the vertices asks for them once, and builds its weights
    on them again and again: the faces alone decide, not where vertices are.

    Parameters
    ----------
    F : array_like of integers, shape (m, 3)
        Not to be changed while the edges are in use. Duplicate faces count once.
    n : int, optional
        Number of vertices; if it is not given, as many as ``F`` names.

    Attributes
    ----------
    n : int
        Number of vertices.

    Raises
    ------
    MeshError
        No triangles, or an index outside 0 .. n - 1.
    """

    def __init__(self, F: ArrayLike, n: int | None = None) -> None:
        self.n = int(np.max(F, initial=0)) + 1 if n is None else n
        self._stored = check_faces(F, self.n)

    @classmethod
    def of_all(cls, F: Integers, n: int) -> Self:
        """The edges of checked faces, or of none, where duplicates count each.

        Parameters
        ----------
        F : ndarray of int64, shape (m, 3)
        n : int
            Number of vertices.

        Returns
        -------
        Edges
        """
        edges = cls.__new__(cls)
        edges.n, edges._stored = n, F
        edges.F = F
        return edges

    @cached_property
    def F(self) -> Integers:
        """The faces, each once; int64, shape (m', 3)."""
        return unique_faces(self._stored)

    @cached_property
    def _groups(self) -> tuple[Integers, Integers, Integers]:
        """Half-edges sorted into edges: `ends`, `start`, `half_edges`."""
        H = half_edges(self.F)
        # One integer for each edge sorts many times faster than rows of two.
        low, high = np.minimum(H[:, 0], H[:, 1]), np.maximum(H[:, 0], H[:, 1])
        keys = low * self.n + high
        order = np.argsort(keys, kind="stable")
        keys = keys[order]
        if (loop := low == high).any():  # only a face that names a vertex twice has such a side
            proper = ~loop[order]
            order, keys = order[proper], keys[proper]
        first = np.flatnonzero(np.diff(keys, prepend=-1))
        ends = np.column_stack(np.divmod(keys[first], self.n))
        return ends, np.append(first, len(keys)), order

    @property
    def ends(self) -> Integers:
        """Rows (i, j) with i < j, sorted; int64, shape (k, 2)."""
        return self._groups[0]

    @property
    def start(self) -> Integers:
        """Edge e has the half-edges ``half_edges[start[e]:start[e + 1]]``; shape (k + 1,)."""
        return self._groups[1]

    @property
    def half_edges(self) -> Integers:
        """Rows of `half_edges`, grouped by edge, in rising order within each."""
        return self._groups[2]

    @property
    def faces_of_edge(self) -> Integers:
        """How many faces each edge has: 1 on the boundary, 2 inside; int64, shape (k,)."""
        return np.diff(self.start)

    @property
    def of_half_edge(self) -> Integers:
        """The edge that each of the grouped half-edges lies on; int64, shape (3m',)."""
        return np.repeat(np.arange(len(self)), self.faces_of_edge)

    @cached_property
    def sparsity(self) -> Any:
        """Where the entries of `matrix` stand, found by compiled loops for large meshes."""
        return _fast.pattern.Pattern(self._stored, self.n)

    def __len__(self) -> int:
        """The number of edges k."""
        return len(self.ends)

    def lengths(self, V: Floats) -> Floats:
        """The length |v_i - v_j| of each edge; float64, shape (k,).

        Parameters
        ----------
        V : ndarray of float64, shape (n, 3)

        Returns
        -------
        ndarray of float64, shape (k,)
            In the units of ``V``.
        """
        i, j = self.ends.T
        return np.linalg.norm(V[i] - V[j], axis=1)

    def sums(self, X: Floats) -> Floats:
        """Add up a value of each half-edge on its edge.

        Parameters
        ----------
        X : ndarray, shape (3, m')
            X[c, f] belongs to the side of face f that lies opposite its corner c.

        Returns
        -------
        ndarray of float64, shape (k,)
        """
        values = X.ravel()[self.half_edges]
        return np.bincount(self.of_half_edge, values, minlength=len(self)).astype(float)

    def matrix(self, w: Floats) -> csr_array:
        """The symmetric matrix with w_e at (i, j) and at (j, i) for each edge e = (i, j).

        Parameters
        ----------
        w : ndarray of float64, shape (k,)

        Returns
        -------
        csr_array of float64, shape (n, n)
        """
        i, j = self.ends.T
        rows, columns = np.concatenate([i, j]), np.concatenate([j, i])
        return coo_array((np.tile(w, 2), (rows, columns)), shape=(self.n, self.n)).tocsr()


def as_edges(F: ArrayLike | Edges, n: int) -> Edges:
    """The edges of faces, or the edges that were given for them.

    Parameters
    ----------
    F : array_like of integers, shape (m, 3), or Edges
    n : int
        Number of vertices.

    Returns
    -------
    Edges

    Raises
    ------
    MeshError
        No triangles, an index outside 0 .. n - 1, or the edges of another number of vertices.
    """
    if not isinstance(F, Edges):
        return Edges(F, n)
    if F.n != n:
        raise MeshError(f"the edges are those of {F.n} vertices, but V has {n}; find them anew")
    return F


class Triangles:
    """The measures of all triangles, each computed when it is asked for.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Raises
    ------
    MeshError
        No mesh.
    """

    def __init__(self, V: ArrayLike, F: ArrayLike) -> None:
        V, F = check_mesh(V, F)
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
    def _longest(self) -> Floats:
        """Squared length of the longest edge; shape (m,)."""
        # An edge's squared length is the sum of the dot products at its two ends.
        dots = self._dots
        return np.maximum(np.maximum(dots[0] + dots[1], dots[1] + dots[2]), dots[2] + dots[0])

    @property
    def flatness(self) -> Floats:
        """Height over the longest edge, as a part of it; 0 for a point; shape (m,)."""
        area, longest = self.doubled_area, self._longest
        return np.divide(area, longest, out=np.zeros_like(area), where=longest > 0)

    @cached_property
    def degenerate(self) -> Booleans:
        """Which have no area to speak of, see `degenerate_faces`; shape (m,)."""
        longest = self._longest
        largest = np.max([np.abs(X).max(axis=0) for X in self._corners], axis=0)
        rounded = ROUNDED * largest * np.sqrt(longest)
        return self.doubled_area <= np.maximum(DEGENERATE * longest, rounded)

    @cached_property
    def cotangents(self) -> Floats:
        """cot = u . v / |u x v| at the three corners; 0 in degenerate triangles; shape (3, m)."""
        dots = self._dots
        return np.divide(dots, self.doubled_area, out=np.zeros_like(dots), where=~self.degenerate)


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
        warn(
            f"{degenerate.sum()} of {len(F)} faces are degenerate (the first has vertices "
            f"{F[degenerate][0].tolist()}); they {effect}"
        )


def normalised(X: Floats, total: Floats | None = None) -> Floats:
    """Rows of length one; a row without a direction becomes zero.

    Parameters
    ----------
    X : ndarray of float64, shape (m, 3)
    total : ndarray of float64, shape (m,), optional
        Where the rows are sums of vectors: the sums of their lengths. Vectors that
        cancel leave rounding, and no direction.

    Returns
    -------
    ndarray of float64, shape (m, 3)
    """
    length = np.linalg.norm(X, axis=1, keepdims=True)
    least = 0.0 if total is None else CANCELLED * total[:, None]
    return np.divide(X, length, out=np.zeros_like(X), where=length > least)


def _dot(u: Floats, v: Floats) -> Floats:
    """Dot products of the columns of two arrays of shape (3, m)."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
