"""Shapes that filters are compared on: sharp, smooth, thin, open, with detail, and unevenly meshed.

Each is in closed form, as those of `meshfair.shapes`, or has random points with a seed of its own.
"""

import numpy as np
from scipy.spatial import ConvexHull

from meshfair import shapes
from meshfair.checks import Floats, Integers
from meshfair.operators import averaging
from meshfair.weights import combinatorial

Mesh = tuple[Floats, Integers]


def pulley() -> Mesh:
    """A turned part: a rim with a groove, sharp circular edges, planes and cylinders.

    Returns
    -------
    V : ndarray of float64, shape (2304, 3)
    F : ndarray of int64, shape (4608, 3)
    """
    # The profile's corners (r, z), counter-clockwise, and cells between each and the next.
    corners = np.array([[0.5, -0.4], [1.0, -0.4], [1.0, -0.15], [0.8, -0.15], [0.8, 0.15]])
    corners = np.concatenate([corners, [[1.0, 0.15], [1.0, 0.4], [0.5, 0.4]]])
    cells = [6, 3, 2, 4, 2, 3, 6, 10]
    sides = zip(corners, np.roll(corners, -1, axis=0), cells, strict=True)
    r, z = np.concatenate([a + (b - a) * (np.arange(k) / k)[:, None] for a, b, k in sides]).T
    sections = 64
    _, F = shapes.torus(sections=sections, sides=len(r))
    phi = 2 * np.pi * np.arange(sections)[:, None] / sections
    V = np.stack([r * np.cos(phi), r * np.sin(phi), z + 0 * phi], axis=-1)
    return V.reshape(-1, 3), F


def plate() -> Mesh:
    """A box whose thickness is one edge.

    Returns
    -------
    V : ndarray of float64, shape (1276, 3)
    F : ndarray of int64, shape (2548, 3)
    """
    return shapes.box((2.0, 1.5, 0.0725), (28, 21, 1))


def golf_ball() -> Mesh:
    """A sphere with dimples of some four edges across.

    Returns
    -------
    V : ndarray of float64, shape (2562, 3)
    F : ndarray of int64, shape (5120, 3)
    """
    V, F = shapes.icosphere(4)
    waves = np.sin(22 * V[:, 0]) * np.sin(22 * V[:, 1]) * np.sin(22 * V[:, 2])
    return V * (1 + 0.04 * waves)[:, None], F


def landscape() -> Mesh:
    """Hills, a ridge with a sharp crest, furrows and a plain: open all around.

    Returns
    -------
    V : ndarray of float64, shape (1681, 3)
    F : ndarray of int64, shape (3200, 3)
    """
    n = 41
    i, j = np.divmod(np.arange(n * n), n)
    x, y = i.astype(float), j.astype(float)
    z = 6 * np.exp(-((x - 12) ** 2 + (y - 26) ** 2) / 60)
    z += np.maximum(4 - np.abs(y - 8 - x / 8), 0)
    z += 0.5 * np.sin(1.1 * y) * (x > 26) * (y > 18)
    a = (n * np.arange(n - 1)[:, None] + np.arange(n - 1)).ravel()
    quads = np.stack([a, a + n, a + n + 1, a, a + n + 1, a + 1], axis=1)
    return np.stack([x, y, z], axis=1), quads.reshape(-1, 3)


def boulder() -> Mesh:
    """A rounded stone with a flat cut, coarse, through points that lie at random.

    Returns
    -------
    V : ndarray of float64, shape (1200, 3)
    F : ndarray of int64, shape (2396, 3)
    """
    P = _on_sphere(np.random.default_rng(5).standard_normal((1200, 3)))
    for _ in range(2):  # so that few triangles are slivers
        F = ConvexHull(P).simplices.astype(np.int64)
        P = _on_sphere(P + averaging(combinatorial(F, len(P))) @ P)
    F = ConvexHull(P).simplices.astype(np.int64)
    N = np.cross(P[F[:, 1]] - P[F[:, 0]], P[F[:, 2]] - P[F[:, 0]])
    inward = np.sum(N * P[F[:, 0]], axis=1) < 0
    F[inward] = F[inward][:, ::-1]
    r = 1 + 0.15 * np.sin(3 * P[:, 0] + 1) * np.sin(4 * P[:, 1])
    r = np.minimum(r, 0.75 / np.maximum(P @ [0.6, 0.0, 0.8], 1e-9))
    return P * r[:, None], F


def _on_sphere(P: Floats) -> Floats:
    return P / np.linalg.norm(P, axis=1, keepdims=True)
