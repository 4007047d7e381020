"""Filters that smooth the faces' normals first, and then move the vertices to fit them.

Two steps make such a filter. The normals are averaged over the faces around,

    n_i <- sum_j w_ij n_j,  normalised,

with weights that are small across sharp edges; the filters differ in w. Then
`move_vertices` finds positions at which the faces have these normals, the
same way for all filters.

References
----------
.. [Sun07] X. Sun, P. L. Rosin, R. R. Martin, F. C. Langbein, "Fast and effective
   feature-preserving mesh denoising", IEEE Transactions on Visualization and Computer
   Graphics 13(5), 2007.
.. [Zheng11] Y. Zheng, H. Fu, O. K.-C. Au, C.-L. Tai, "Bilateral normal filtering for mesh
   denoising", IEEE Transactions on Visualization and Computer Graphics 17(10), 2011.
"""

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from meshfair import _fast
from meshfair.checks import (
    Booleans,
    Floats,
    Integers,
    check_count,
    check_fixed,
    check_mesh,
    check_number,
)
from meshfair.filters.neighbourhoods import (
    adjacent_faces,
    entries,
    face_rings,
    squared_distances,
)
from meshfair.mesh import boundary_vertices, face_shapes, normalised
from meshfair.mesh.geometry import incidence


def sun(
    V: ArrayLike,
    F: ArrayLike,
    *,
    threshold: float = 0.5,
    normal_iterations: int = 20,
    vertex_iterations: int = 50,
    fix_boundary: bool = True,
    fixed: ArrayLike | None = None,
) -> Iterator[tuple[float, Floats]]:
    """Fast, feature-preserving denoising [Sun07]_, as an iterator: similar normals are averaged.

    The weights are, over the faces that share a vertex with face i, itself
    among them,

        w_ij = max(0, <n_i, n_j> - T)^2.

    Parameters
    ----------
    V, F, fixed
        As in `meshfair.filters.averaging`. Until the normals are done it yields the input.
    threshold : float
        T, at least -1 and at most 1: normals that differ by more than acos(T)
        do not mix.
    normal_iterations, vertex_iterations : int
        How often the normals are averaged, and then the vertices moved.
    fix_boundary : bool
        Keep the vertices of an open mesh's boundary in their place.

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
    T = check_number(threshold, "threshold", -1, 1)
    R = face_rings(incidence(F, len(V)))
    fixed = _fixed_vertices(F, len(V), fixed, fix_boundary)

    def mean_normals(N: Floats) -> Floats:
        return sun_normals(R, N, T)

    yield from _two_stages(V, F, mean_normals, normal_iterations, vertex_iterations, fixed)


def bilateral_normal(
    V: ArrayLike,
    F: ArrayLike,
    *,
    sigma_normal: float = 0.35,
    sigma_space: float = 1.0,
    normal_iterations: int = 20,
    vertex_iterations: int = 10,
    fix_boundary: bool = True,
    fixed: ArrayLike | None = None,
) -> Iterator[tuple[float, Floats]]:
    """Bilateral normal filtering [Zheng11]_, as an iterator: near and similar normals are averaged.

    The weights are, over the faces j that share a vertex with face i, but not
    for face i itself,

        w_ij = area_j exp(-|c_i - c_j|^2 / 2 sigma_c^2) exp(-|n_i - n_j|^2 / 2 sigma_s^2)

    with the centroids c. Areas and centroids are those of the noisy mesh.

    Parameters
    ----------
    V, F, normal_iterations, vertex_iterations, fix_boundary, fixed
        As in `sun`.
    sigma_normal : float
        sigma_s: the difference of two unit normals from which on they hardly
        mix.
    sigma_space : float
        sigma_c, in mean distances of the centroids of adjacent faces.

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
    sigma_normal = check_number(sigma_normal, "sigma_normal", 0, open_low=True)
    sigma_space = check_number(sigma_space, "sigma_space", 0, open_low=True)
    R = face_rings(incidence(F, len(V)))
    _, area, C = face_shapes(V, F)
    sigma_space *= mean_distance(C, adjacent_faces(R))
    R.setdiag(0)
    R.eliminate_zeros()
    S = spatial_weights(R, C, area, sigma_space)
    fixed = _fixed_vertices(F, len(V), fixed, fix_boundary)

    def mean_normals(N: Floats) -> Floats:
        return joint_bilateral(S, N, N, sigma_normal)

    yield from _two_stages(V, F, mean_normals, normal_iterations, vertex_iterations, fixed)


def _fixed_vertices(F: Integers, n: int, fixed: ArrayLike | None, fix_boundary: bool) -> Booleans:
    mask = check_fixed(fixed, n)
    if fix_boundary:
        mask[boundary_vertices(F)] = True
    return mask


def _two_stages(
    V: Floats,
    F: Integers,
    mean_normals: Callable[[Floats], Floats],
    normal_iterations: int,
    vertex_iterations: int,
    fixed: Booleans,
) -> Iterator[tuple[float, Floats]]:
    """All normal iterations, then all vertex iterations; yields progress and V."""
    normal_iterations = check_count(normal_iterations, "normal_iterations")
    vertex_iterations = check_count(vertex_iterations, "vertex_iterations")
    steps = normal_iterations + vertex_iterations
    B = incidence(F, len(V))
    N, _, _ = face_shapes(V, F)
    for step in range(1, steps + 1):
        if step <= normal_iterations:
            N = mean_normals(N)
        else:
            V = move_vertices(V, F, B, N, fixed)
        yield step / steps, V


def mean_distance(C: Floats, pairs: tuple[Integers, Integers]) -> float:
    """Mean distance of the points C[f] and C[g] over pairs (f, g); 0 without pairs."""
    f, g = pairs
    return float(np.linalg.norm(C[f] - C[g], axis=1).mean()) if len(f) else 0.0


def sun_normals(R: csr_array, N: Floats, T: float) -> Floats:
    """Average normals with the weights w_ij = max(0, <n_i, n_j> - T)^2 of [Sun07]_.

    Parameters
    ----------
    R : csr_array, shape (m, m)
        Row i lists the faces j that face i averages over.
    N : ndarray of float64, shape (m, 3)
        Unit normals.
    T : float

    Returns
    -------
    ndarray of float64, shape (m, 3)
        Unit vectors; where all weights vanish, the normal as it was.
    """
    if _fast.wanted(len(N), _fast.FILTER_ROWS):
        return _fast.filters.sun_normals(R, N, T)
    i, j = entries(R)
    cosine = sum(n[i] * n[j] for n in N.T)
    w = np.maximum(0, cosine - T) ** 2
    return _mean_directions(w, R, N)


def gaussian(squared: Floats, sigma: float) -> Floats:
    """exp(-x^2 / 2 sigma^2) of x^2; with sigma 0, 1 at 0 and 0 elsewhere."""
    with np.errstate(over="ignore"):  # what is too large for a number leads to 1, or to 0
        return np.exp(-squared / max(2 * np.square(sigma), np.finfo(np.float64).tiny))


def spatial_weights(near: csr_array, C: Floats, area: Floats, sigma_space: float) -> csr_array:
    """The part of `joint_bilateral`'s weights that does not depend on normals.

    s_ij = area_j exp(-|c_i - c_j|^2 / 2 sigma_c^2)

    Parameters
    ----------
    near : csr_array, shape (m, m)
        Row i lists the faces j that face i averages over.
    C : ndarray of float64, shape (m, 3)
        Centroids.
    area : ndarray of float64, shape (m,)
    sigma_space : float
        sigma_c, in the units of ``C``.

    Returns
    -------
    csr_array of float64, shape (m, m)
    """
    if _fast.wanted(len(C), _fast.FILTER_ROWS):
        return _fast.filters.spatial_weights(near, C, area, sigma_space)
    i, j = entries(near)
    s = area[j] * gaussian(squared_distances(C, i, j), sigma_space)
    return csr_array((s, near.indices, near.indptr), shape=near.shape)


def joint_bilateral(S: csr_array, N: Floats, G: Floats, sigma_normal: float) -> Floats:
    """Average normals with weights that compare guidance normals.

    n_i <- sum_j w_ij n_j, normalised, with w_ij = s_ij exp(-|g_i - g_j|^2 / 2 sigma_s^2).

    Parameters
    ----------
    S : csr_array, shape (m, m)
        See `spatial_weights`.
    N, G : ndarrays of float64, shape (m, 3)
        Normals, guidance normals (N itself in the plain bilateral filter).
    sigma_normal : float
        sigma_s.

    Returns
    -------
    ndarray of float64, shape (m, 3)
        Unit vectors; where all weights vanish, the normal as it was.
    """
    if _fast.wanted(len(N), _fast.FILTER_ROWS):
        return _fast.filters.joint_bilateral(S, N, G, sigma_normal)
    i, j = entries(S)
    w = S.data * gaussian(squared_distances(G, i, j), sigma_normal)
    return _mean_directions(w, S, N)


def _mean_directions(w: Floats, near: csr_array, N: Floats) -> Floats:
    """sum_j w_ij n_j, normalised; where these cancel, n_i as it was."""
    W = csr_array((w, near.indices, near.indptr), shape=near.shape)
    mean = normalised(W @ N, W.sum(axis=1))
    return np.where(mean.any(axis=1, keepdims=True), mean, N)


def move_vertices(V: Floats, F: Integers, B: csr_array, N: Floats, fixed: Booleans) -> Floats:
    """Move each vertex towards the planes that its faces should lie in [Sun07]_.

    v_i <- v_i + 1/|F_i| sum_f n_f <n_f, c_f - v_i> over the faces f of vertex
    i, with centroids c_f: a step of gradient descent that turns the faces
    until their normals are the n_f.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    B : csr_array, shape (n, m)
        See `meshfair.mesh.geometry.incidence`.
    N : ndarray of float64, shape (m, 3)
        The normals that the faces should have.
    fixed : ndarray of bool, shape (n,)
        Vertices that keep their place.

    Returns
    -------
    ndarray of float64, shape (n, 3)
    """
    if _fast.wanted(len(F), _fast.FILTER_ROWS):
        return _fast.filters.move_vertices(V, F, B, N, fixed)
    i, f = entries(B)
    centroids = (V[F[:, 0]] + V[F[:, 1]] + V[F[:, 2]]) / 3
    distance = np.sum(N[f] * (centroids[f] - V[i]), axis=1)
    shift = csr_array((distance, B.indices, B.indptr), shape=B.shape) @ N
    faces = np.maximum(1, np.diff(B.indptr))  # a vertex without faces stays
    return V + np.where(fixed, 0.0, 1 / faces)[:, None] * shift
