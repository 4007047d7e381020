"""Distances of points from triangles, pair by pair."""

import numpy as np

from meshfair.checks import Floats


def squared_distances(X: Floats, T: Floats) -> Floats:
    """Squared distance of each point from the triangle of the same row.

    Parameters
    ----------
    X : ndarray of float64, shape (k, 3)
    T : ndarray of float64, shape (k, 3, 3)
        Corners.

    Returns
    -------
    ndarray of float64, shape (k,)
    """
    found = np.full(len(X), np.inf)
    normal = np.cross(T[:, 1] - T[:, 0], T[:, 2] - T[:, 0])
    inside = _dot(normal, normal) > 0  # without area only the edges count
    for i in range(3):
        start, way = T[:, i], T[:, (i + 1) % 3] - T[:, i]
        seen = X - start
        along = np.clip(_dot(seen, way) / np.maximum(_dot(way, way), 1e-300), 0, 1)
        gap = seen - along[:, None] * way
        found = np.minimum(found, _dot(gap, gap))
        # Above the triangle where it is on the inner side of all edges.
        inside &= _dot(np.cross(way, seen), normal) >= 0
    height = _dot(X - T[:, 0], normal)
    squared = height**2 / np.where(inside, _dot(normal, normal), 1)
    return np.where(inside, squared, found)


def _dot(a: Floats, b: Floats) -> Floats:
    return np.einsum("ij,ij->i", a, b)
