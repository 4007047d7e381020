"""Bilateral mesh denoising: the image filter's idea, on heights over the tangent plane.

References
----------
.. [FDCo03] S. Fleishman, I. Drori, D. Cohen-Or, "Bilateral mesh denoising", ACM Transactions
   on Graphics 22(3), 2003.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from meshfair import _fast, weights
from meshfair.checks import (
    Booleans,
    Floats,
    check_count,
    check_fixed,
    check_mesh,
    check_number,
)
from meshfair.filters.neighbourhoods import (
    LARGEST_RADIUS,
    check_pairs,
    entries,
    squared_distances,
    within,
)
from meshfair.mesh import Edges, face_shapes, normalised
from meshfair.mesh.geometry import incidence

# The least sigma_s, in sigma_c: on a plane all heights are 0, and so is their deviation.
LEAST_DEVIATION = 1e-6


def bilateral(
    V: ArrayLike,
    F: ArrayLike,
    *,
    iterations: int = 5,
    radius: float = 2.0,
    fixed: ArrayLike | None = None,
) -> Iterator[tuple[float, Floats]]:
    """Bilateral mesh denoising [FDCo03]_, as an iterator: vertices move along their normals.

    Each vertex moves along its normal n by a mean of the heights
    h = <q - v, n> of the vertices q around it (itself among them),

        v <- v + n (sum w h / sum w),
        w = exp(-|q - v|^2 / 2 sigma_c^2) exp(-h^2 / 2 sigma_s^2),

    with sigma_c the shortest edge at v and sigma_s the standard deviation of
    |h| around it. Normals are computed anew in each iteration; all faces at a
    vertex count the same in them.

    Parameters
    ----------
    V, F, fixed
        As in `meshfair.filters.averaging`.
    iterations : int
    radius : float
        How far the neighbourhood goes, in sigma_c; it is grown through the mesh. One beyond
        the mesh's diameter means all of it, where memory holds that.

    Yields
    ------
    progress, V
        As `meshfair.filters.averaging`.

    Raises
    ------
    MeshError, ValueError
        As `meshfair.filters.averaging`.
    """
    V, F = check_mesh(V, F)
    iterations = check_count(iterations, "iterations")
    radius = check_number(radius, "radius", 0, LARGEST_RADIUS, open_low=True)
    fixed = check_fixed(fixed, len(V))
    edges, B = Edges(F, len(V)), incidence(F, len(V))
    for step in range(1, iterations + 1):
        lengths = weights.distance(V, edges)
        sigma_c = shortest_edges(lengths)
        if step == 1:
            check_pairs(V, radius * sigma_c, radius)
        near = within(V, lengths, radius * sigma_c)
        N = normalised(B @ face_shapes(V, F)[0], np.diff(B.indptr))
        V = move_along_normals(V, N, near, sigma_c, fixed)
        yield step / iterations, V


def shortest_edges(lengths: csr_array) -> Floats:
    """The length of the shortest edge at each vertex; 0 at one without edges.

    Parameters
    ----------
    lengths : csr_array, shape (n, n)
        Distance weights, see `meshfair.weights.distance`.

    Returns
    -------
    ndarray of float64, shape (n,)
    """
    shortest = np.zeros(lengths.shape[0])
    connected = np.diff(lengths.indptr) > 0
    starts = lengths.indptr[:-1][connected]
    shortest[connected] = np.minimum.reduceat(lengths.data, starts)
    return shortest


def move_along_normals(
    V: Floats, N: Floats, near: csr_array, sigma_c: Floats, fixed: Booleans
) -> Floats:
    """Move each vertex along its normal by the weighted mean height of those near it.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    N : ndarray of float64, shape (n, 3)
        Unit normals; a vertex whose normal is zero keeps its place.
    near : csr_array, shape (n, n)
        Row i lists the vertices q around vertex i, and itself.
    sigma_c : ndarray of float64, shape (n,)
        In the units of ``V``; a vertex where it is 0 keeps its place.
    fixed : ndarray of bool, shape (n,)

    Returns
    -------
    ndarray of float64, shape (n, 3)
    """
    if _fast.wanted(len(V), _fast.FILTER_ROWS):
        return _fast.filters.move_along_normals(V, N, near, sigma_c, LEAST_DEVIATION, fixed)

    i, j = entries(near)

    def mean_around(x: Floats, w: Floats) -> Floats:
        return np.bincount(i, w * x, len(V)) / np.bincount(i, w, len(V))

    h = np.sum((V[j] - V[i]) * N[i], axis=1)
    size, equal = np.abs(h), np.ones_like(h)
    variance = mean_around((size - mean_around(size, equal)[i]) ** 2, equal)
    moves = ~fixed & (sigma_c > 0)
    sigma_c = np.where(moves, sigma_c, 1.0)
    sigma_s = np.maximum(np.sqrt(variance), LEAST_DEVIATION * sigma_c)
    w = np.exp(-squared_distances(V, i, j) / (2 * sigma_c[i] ** 2) - h**2 / (2 * sigma_s[i] ** 2))
    return V + np.where(moves, mean_around(h, w), 0.0)[:, None] * N
