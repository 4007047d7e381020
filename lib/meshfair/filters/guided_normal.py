"""Guided normal filtering: the normals of the most consistent patches show where edges are."""

import numpy as np
from scipy.sparse import csr_array

from meshfair._fast.kernels import compiled, on_all_cores
from meshfair.checks import check_count, check_fixed, check_mesh, check_number
from meshfair.filters.neighbourhoods import (
    BLOCK,
    adjacent_faces,
    face_rings,
    incidence,
    within,
)
from meshfair.filters.normal_filtering import (
    joint_bilateral,
    mean_distance,
    move_vertices,
    spatial_weights,
)
from meshfair.mesh import face_shapes

# Keeps the saliency of a flat patch finite; differences of unit normals are of size 1.
FLAT = 1e-9


def guided_normal(
    V, F, *, sigma_normal=0.35, sigma_space=1.0, radius=2.0, iterations=20, vertex_iterations=10,
    fixed=None,
):  # fmt: skip
    """Guided mesh normal filtering [ZDZBL15], as an iterator.

    A joint bilateral filter: the weights

        w_ij = area_j exp(-|c_i - c_j|^2 / 2 sigma_c^2) exp(-|g_i - g_j|^2 / 2 sigma_s^2)

    over the faces j around face i compare guidance normals g, see
    `guidance`, not the noisy ones. Guidance, normals and positions are
    computed anew in each iteration.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    sigma_normal : float
        sigma_s: the difference of two guidance normals from which on the
        normals hardly mix.
    sigma_space : float
        sigma_c, in mean distances of the centroids of adjacent faces.
    radius : float
        How far the centroids of the faces j may be from that of face i, in
        mean distances of adjacent centroids of the input.
    iterations, vertex_iterations : int
        How often the normals are filtered, and how often the vertices are
        moved each time.
    fixed : array_like, optional
        Vertices that keep their place, as a boolean mask (n,) or as indices.

    Yields
    ------
    progress : float
        The part of the work that is done; 1 at the end.
    V : ndarray of float64, shape (n, 3)

    Raises
    ------
    MeshError, ValueError
        No mesh, or a parameter outside its range.
    """
    V, F = check_mesh(V, F)
    sigma_normal = check_number(sigma_normal, "sigma_normal", 0, open_low=True)
    sigma_space = check_number(sigma_space, "sigma_space", 0, open_low=True)
    radius = check_number(radius, "radius", 0, open_low=True)
    iterations = check_count(iterations, "iterations")
    vertex_iterations = check_count(vertex_iterations, "vertex_iterations", 1)
    held = check_fixed(fixed, len(V))
    B = incidence(F, len(V))
    R = face_rings(B)
    pairs = adjacent_faces(R)
    across = csr_array(R == 2)
    _, _, C = face_shapes(V, F)
    near = within(C, R, np.full(len(F), radius * mean_distance(C, pairs)))
    for step in range(1, iterations + 1):
        N, area, C = face_shapes(V, F)
        G = guidance(R, across, N, area)
        S = spatial_weights(near, C, area, sigma_space * mean_distance(C, pairs))
        N = joint_bilateral(S, N, G, sigma_normal)
        for _ in range(vertex_iterations):
            V = move_vertices(V, F, B, N, held)
        yield step / iterations, V


def guidance(R, across, N, area):
    """The guidance normals: the mean normal of the most consistent patch that has the face.

    The patches are the faces around a face, each with all that share a vertex
    with it. Their consistency (smaller is better) is

        H = max |n_j - n_k| * max_e |n_j - n_k| / (FLAT + sum_e |n_j - n_k|),

    with the first maximum over all pairs of faces in the patch, and e the
    edges inside it: few strong edges, or none at all, make a good patch.

    Parameters
    ----------
    R : csr_array, shape (m, m)
        See `meshfair.filters.neighbourhoods.face_rings`.
    across : csr_array, shape (m, m)
        Which faces share an edge.
    N : ndarray of float64, shape (m, 3)
        Unit normals.
    area : ndarray of float64, shape (m,)

    Returns
    -------
    ndarray of float64, shape (m, 3)
        Unit vectors; zero where the patch's normals cancel.
    """
    consistency, mean = np.empty(len(N)), np.empty_like(N)
    on_all_cores(
        _patches,
        len(N),
        R.indptr,
        R.indices,
        across.indptr,
        across.indices,
        N,
        area,
        consistency,
        mean,
        block=BLOCK,
    )
    G = np.empty_like(N)
    on_all_cores(_choose, len(N), R.indptr, R.indices, consistency, mean, G, block=BLOCK)
    return G


@compiled
def _patches(first, last, start, ring, start_across, across, N, area, consistency, mean):
    """The consistency H of the patch around each face, and its mean normal."""
    in_patch_of = np.full(len(N), -1, dtype=np.int32)
    for i in range(first, last):
        faces = ring[start[i] : start[i + 1]]
        for j in faces:
            in_patch_of[j] = i
        x = y = z = 0.0
        widest = strongest = total = 0.0
        for a in range(len(faces)):
            j = faces[a]
            x += area[j] * N[j, 0]
            y += area[j] * N[j, 1]
            z += area[j] * N[j, 2]
            for b in range(a):
                k = faces[b]
                dx, dy, dz = N[j, 0] - N[k, 0], N[j, 1] - N[k, 1], N[j, 2] - N[k, 2]
                widest = max(widest, dx * dx + dy * dy + dz * dz)
            for p in range(start_across[j], start_across[j + 1]):
                k = across[p]
                if k < j and in_patch_of[k] == i:
                    dx, dy, dz = N[j, 0] - N[k, 0], N[j, 1] - N[k, 1], N[j, 2] - N[k, 2]
                    difference = np.sqrt(dx * dx + dy * dy + dz * dz)
                    strongest = max(strongest, difference)
                    total += difference
        consistency[i] = np.sqrt(widest) * strongest / (FLAT + total)
        length = np.sqrt(x * x + y * y + z * z)
        scale = 1 / length if length > 0 else 0.0
        mean[i, 0], mean[i, 1], mean[i, 2] = x * scale, y * scale, z * scale


@compiled
def _choose(first, last, start, ring, consistency, mean, G):
    """The mean normal of the most consistent of the patches around each face."""
    for i in range(first, last):
        best = i
        for p in range(start[i], start[i + 1]):
            if consistency[ring[p]] < consistency[best]:
                best = ring[p]
        G[i, 0], G[i, 1], G[i, 2] = mean[best, 0], mean[best, 1], mean[best, 2]
