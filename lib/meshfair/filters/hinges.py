"""Hinges: the edges between two triangles, and how far they are bent."""

import numpy as np

from meshfair import weights
from meshfair.mesh import half_edges


def hinges(F, n):
    """The edges with two triangles: each edge's ends, and the two vertices opposite it.

    Parameters
    ----------
    F : array_like of integers, shape (m, 3)
    n : int
        Number of vertices.

    Returns
    -------
    ndarray of int64, shape (k, 4)
        Rows (p1, p2, p3, p4): the edge from p1 to p3 with the triangles
        p1 p2 p3 and p1 p3 p4. Edges with one triangle, or with more than two,
        are left out.
    """
    pattern = weights.Pattern(F, n)
    two = np.flatnonzero(np.diff(pattern.first) == 2)
    p1, p3 = pattern.indices[pattern.lower[two]], pattern.indices[pattern.upper[two]]  # p1 < p3
    p2, p4 = (pattern.opposite[pattern.first[two] + side] for side in (0, 1))
    return np.column_stack([p1, p2, p3, p4]).astype(np.int64)


def bending(V, H):
    """The absolute angle by which each hinge is bent, in radians: 0 where it is flat.

    Unsigned: noise bends edges both ways, and would cancel in a mean of signed angles.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    H : ndarray of int64, shape (k, 4)
        See `hinges`.

    Returns
    -------
    ndarray of float64, shape (k,)
        0 to pi; 0 at a degenerate triangle.
    """
    p1, p2, p3, p4 = (V[corner] for corner in H.T)
    n2, n4 = np.cross(p3 - p1, p2 - p1), np.cross(p4 - p1, p3 - p1)
    sine = np.linalg.norm(np.cross(n2, n4), axis=1)
    return np.arctan2(sine, np.sum(n2 * n4, axis=1))


def faces_of_hinges(H, F, n):
    """The two faces at each hinge.

    Parameters
    ----------
    H : ndarray of int64, shape (k, 4)
        See `hinges`.
    F : ndarray of int64, shape (m, 3)
    n : int
        Number of vertices.

    Returns
    -------
    ndarray of int64, shape (k, 2)
    """
    low, high = np.sort(half_edges(F), axis=1).T
    keys = low * n + high
    order = np.argsort(keys, kind="stable")
    first = np.searchsorted(keys[order], H[:, 0] * n + H[:, 2])
    return np.column_stack([order[first], order[first + 1]]) % len(F)
