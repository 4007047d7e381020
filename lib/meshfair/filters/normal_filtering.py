"""Filters that smooth the faces' normals first, and then move the vertices to fit them.

Two steps make such a filter. The normals are averaged over the faces around,

    n_i <- sum_j w_ij n_j,  normalised,

with weights that are small across sharp edges; the filters differ in w. Then
`move_vertices` finds positions at which the faces have these normals, the
same way for all filters.
"""

import numpy as np
from scipy.sparse import csr_array

from meshfair._fast.kernels import compiled, on_all_cores, unsigned
from meshfair.checks import check_count, check_fixed, check_mesh, check_number
from meshfair.filters.neighbourhoods import (
    BLOCK,
    adjacent_faces,
    face_rings,
    incidence,
)
from meshfair.mesh import boundary_vertices, face_shapes


def sun(
    V,
    F,
    *,
    threshold=0.5,
    normal_iterations=20,
    vertex_iterations=50,
    fix_boundary=True,
    fixed=None,
):
    """Fast and effective feature-preserving denoising [SRML07], as an iterator.

    The weights are, over the faces that share a vertex with face i, itself
    among them,

        w_ij = max(0, <n_i, n_j> - T)^2.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    threshold : float
        T, at least -1 and at most 1: normals that differ by more than acos(T)
        do not mix.
    normal_iterations, vertex_iterations : int
        How often the normals are averaged, and then the vertices moved.
    fix_boundary : bool
        Keep the vertices of an open mesh's boundary in their place.
    fixed : array_like, optional
        Vertices that keep their place, as a boolean mask (n,) or as indices.

    Yields
    ------
    progress : float
        The part of the work that is done; 1 at the end.
    V : ndarray of float64, shape (n, 3)
        The input until the normals are done, then new positions.

    Raises
    ------
    MeshError, ValueError
        No mesh, or a parameter outside its range.
    """
    V, F = check_mesh(V, F)
    T = check_number(threshold, "threshold", -1, 1)
    B = incidence(F, len(V))
    R = face_rings(B)

    def mean_normals(N):
        mean = np.empty_like(N)
        on_all_cores(_sun, len(F), R.indptr, R.indices, N, T, mean, block=BLOCK)
        return mean

    held = check_fixed(fixed, len(V))
    if fix_boundary:
        held[boundary_vertices(F)] = True
    yield from _two_stages(V, F, B, mean_normals, normal_iterations, vertex_iterations, held)


def bilateral_normal(
    V,
    F,
    *,
    sigma_normal=0.35,
    sigma_space=1.0,
    normal_iterations=20,
    vertex_iterations=10,
    fix_boundary=True,
    fixed=None,
):
    """Bilateral normal filtering, the local scheme [ZFAT11], as an iterator.

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
        As in `sun`.

    Raises
    ------
    MeshError, ValueError
        No mesh, or a parameter outside its range.
    """
    V, F = check_mesh(V, F)
    sigma_normal = check_number(sigma_normal, "sigma_normal", 0, open_low=True)
    sigma_space = check_number(sigma_space, "sigma_space", 0, open_low=True)
    B = incidence(F, len(V))
    near = face_rings(B)
    _, area, C = face_shapes(V, F)
    sigma_space *= mean_distance(C, adjacent_faces(near))
    near.setdiag(0)
    near.eliminate_zeros()

    S = spatial_weights(near, C, area, sigma_space)

    def mean_normals(N):
        return joint_bilateral(S, N, N, sigma_normal)

    held = check_fixed(fixed, len(V))
    if fix_boundary:
        held[boundary_vertices(F)] = True
    yield from _two_stages(V, F, B, mean_normals, normal_iterations, vertex_iterations, held)


def _two_stages(V, F, B, mean_normals, normal_iterations, vertex_iterations, held):
    """All normal iterations, then all vertex iterations; yields progress and V."""
    normal_iterations = check_count(normal_iterations, "normal_iterations")
    vertex_iterations = check_count(vertex_iterations, "vertex_iterations")
    steps = normal_iterations + vertex_iterations
    N, _, _ = face_shapes(V, F)
    for step in range(1, steps + 1):
        if step <= normal_iterations:
            N = mean_normals(N)
        else:
            V = move_vertices(V, F, B, N, held)
        yield step / steps, V


def mean_distance(C, pairs):
    """Mean distance of the points C[f] and C[g] over pairs (f, g); 0 without pairs."""
    f, g = pairs
    return float(np.linalg.norm(C[f] - C[g], axis=1).mean()) if len(f) else 0.0


def spatial_weights(near, C, area, sigma_space):
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
    S = np.empty(near.nnz)
    rows = unsigned(near.indptr, near.indices)
    on_all_cores(_spatial_weights, len(C), *rows, C, area, sigma_space, S, block=BLOCK)
    return csr_array((S, near.indices, near.indptr), shape=near.shape)


def joint_bilateral(S, N, G, sigma_normal):
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
    mean = np.empty_like(N)
    rows = (*unsigned(S.indptr, S.indices), S.data)
    on_all_cores(_joint_bilateral, len(N), *rows, N, G, sigma_normal, mean, block=BLOCK)
    return mean


def move_vertices(V, F, B, N, held):
    """Move each vertex towards the planes that its faces should lie in [SRML07].

    v_i <- v_i + 1/|F_i| sum_f n_f <n_f, c_f - v_i> over the faces f of vertex
    i, with centroids c_f: a step of gradient descent that turns the faces
    until their normals are the n_f.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    B : csr_array, shape (n, m)
        See `meshfair.filters.neighbourhoods.incidence`.
    N : ndarray of float64, shape (m, 3)
        The normals that the faces should have.
    held : ndarray of bool, shape (n,)
        Vertices that keep their place.

    Returns
    -------
    ndarray of float64, shape (n, 3)
    """
    height, moved = np.empty(len(F)), np.empty_like(V)
    on_all_cores(_plane_heights, len(F), V, F, N, height, block=BLOCK)
    on_all_cores(
        _move_vertices, len(V), V, B.indptr, B.indices, N, height, held, moved, block=BLOCK
    )
    return moved


@compiled
def _sun(first, last, start, faces, N, T, mean):
    for i in range(first, last):
        x = y = z = 0.0
        for p in range(start[i], start[i + 1]):
            j = faces[p]
            excess = N[i, 0] * N[j, 0] + N[i, 1] * N[j, 1] + N[i, 2] * N[j, 2] - T
            if excess > 0:
                w = excess * excess
                x += w * N[j, 0]
                y += w * N[j, 1]
                z += w * N[j, 2]
        length = np.sqrt(x * x + y * y + z * z)
        if length > 0:
            mean[i, 0], mean[i, 1], mean[i, 2] = x / length, y / length, z / length
        else:
            mean[i, 0], mean[i, 1], mean[i, 2] = N[i, 0], N[i, 1], N[i, 2]


@compiled
def _spatial_weights(first, last, start, faces, C, area, sigma, S):
    per_square = 1 / (2 * sigma**2)
    for i in range(first, last):
        for p in range(start[i], start[i + 1]):
            j = faces[p]
            x, y, z = C[i, 0] - C[j, 0], C[i, 1] - C[j, 1], C[i, 2] - C[j, 2]
            S[p] = area[j] * np.exp(-per_square * (x * x + y * y + z * z))


@compiled
def _joint_bilateral(first, last, start, faces, S, N, G, sigma, mean):
    per_square = 1 / (2 * sigma**2)
    for i in range(first, last):
        x = y = z = 0.0
        for p in range(start[i], start[i + 1]):
            j = faces[p]
            gx, gy, gz = G[i, 0] - G[j, 0], G[i, 1] - G[j, 1], G[i, 2] - G[j, 2]
            w = S[p] * np.exp(-per_square * (gx * gx + gy * gy + gz * gz))
            x += w * N[j, 0]
            y += w * N[j, 1]
            z += w * N[j, 2]
        length = np.sqrt(x * x + y * y + z * z)
        if length > 0:
            mean[i, 0], mean[i, 1], mean[i, 2] = x / length, y / length, z / length
        else:
            mean[i, 0], mean[i, 1], mean[i, 2] = N[i, 0], N[i, 1], N[i, 2]


@compiled
def _plane_heights(first, last, V, F, N, height):
    """<n_f, c_f>: where the plane through the centroid with normal n_f lies."""
    for f in range(first, last):
        a, b, c = F[f, 0], F[f, 1], F[f, 2]
        height[f] = (
            N[f, 0] * (V[a, 0] + V[b, 0] + V[c, 0])
            + N[f, 1] * (V[a, 1] + V[b, 1] + V[c, 1])
            + N[f, 2] * (V[a, 2] + V[b, 2] + V[c, 2])
        ) / 3


@compiled
def _move_vertices(first, last, V, start, faces, N, height, held, moved):
    for i in range(first, last):
        x, y, z = V[i, 0], V[i, 1], V[i, 2]
        dx = dy = dz = 0.0
        count = start[i + 1] - start[i]
        if count > 0 and not held[i]:
            for p in range(start[i], start[i + 1]):
                f = faces[p]
                nx, ny, nz = N[f, 0], N[f, 1], N[f, 2]
                distance = height[f] - (nx * x + ny * y + nz * z)
                dx += nx * distance
                dy += ny * distance
                dz += nz * distance
            x += dx / count
            y += dy / count
            z += dz / count
        moved[i, 0], moved[i, 1], moved[i, 2] = x, y, z
