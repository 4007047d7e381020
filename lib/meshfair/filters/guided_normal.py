"""Guided normal filtering: the normals of the most consistent patches show where edges are.

References
----------
.. [Zhang15] W. Zhang, B. Deng, J. Zhang, S. Bouaziz, L. Liu, "Guided mesh normal filtering",
   Computer Graphics Forum 34(7), 2015.
"""

from collections.abc import Iterator
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from meshfair import _fast
from meshfair.checks import (
    Floats,
    Integers,
    check_count,
    check_fixed,
    check_mesh,
    check_number,
)
from meshfair.filters.neighbourhoods import (
    LARGEST_RADIUS,
    adjacent_faces,
    check_pairs,
    entries,
    face_rings,
    within,
)
from meshfair.filters.normal_filtering import (
    joint_bilateral,
    mean_distance,
    move_vertices,
    spatial_weights,
)
from meshfair.mesh import face_shapes, normalised
from meshfair.mesh.geometry import incidence

# Keeps the saliency of a flat patch finite; differences of unit normals are of size 1.
FLAT = 1e-9


def guided_normal(
    V: ArrayLike,
    F: ArrayLike,
    *,
    sigma_normal: float = 0.35,
    sigma_space: float = 1.0,
    radius: float = 2.0,
    iterations: int = 20,
    vertex_iterations: int = 10,
    fixed: ArrayLike | None = None,
) -> Iterator[tuple[float, Floats]]:
    """Guided normal filtering [Zhang15]_, as an iterator: patches tell which normals are similar.

    A joint bilateral filter: the weights

        w_ij = area_j exp(-|c_i - c_j|^2 / 2 sigma_c^2) exp(-|g_i - g_j|^2 / 2 sigma_s^2)

    over the faces j around face i compare guidance normals g, see
    `guidance`, not the noisy ones. Guidance, normals and positions are
    computed anew in each iteration.

    Parameters
    ----------
    V, F, fixed
        As in `meshfair.filters.averaging`.
    sigma_normal : float
        sigma_s: the difference of two guidance normals from which on the
        normals hardly mix.
    sigma_space : float
        sigma_c, in mean distances of the centroids of adjacent faces.
    radius : float
        How far the centroids of the faces j may be from that of face i, in
        mean distances of adjacent centroids of the input. One beyond the mesh's
        diameter means all of it, where memory holds that.
    iterations, vertex_iterations : int
        How often the normals are filtered, and how often the vertices are
        moved each time.

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
    radius = check_number(radius, "radius", 0, LARGEST_RADIUS, open_low=True)
    iterations = check_count(iterations, "iterations")
    vertex_iterations = check_count(vertex_iterations, "vertex_iterations", 1)
    fixed = check_fixed(fixed, len(V))
    B = incidence(F, len(V))
    patches = Patches(face_rings(B))
    _, _, C = face_shapes(V, F)
    reach = np.full(len(F), radius * mean_distance(C, patches.adjacent))
    check_pairs(C, reach, radius)
    near = within(C, patches.rings, reach)
    for step in range(1, iterations + 1):
        N, area, C = face_shapes(V, F)
        G = guidance(patches, N, area)
        S = spatial_weights(near, C, area, sigma_space * mean_distance(C, patches.adjacent))
        N = joint_bilateral(S, N, G, sigma_normal)
        for _ in range(vertex_iterations):
            V = move_vertices(V, F, B, N, fixed)
        yield step / iterations, V


class Patches:
    """The patch around each face: all faces that share a vertex with it, itself among them.

    Parameters
    ----------
    rings : csr_array, shape (m, m)
        Row i lists the faces of patch i, see
        `meshfair.filters.neighbourhoods.face_rings`.
    """

    def __init__(self, rings: csr_array) -> None:
        self.rings = rings
        self.adjacent = adjacent_faces(rings)

    @cached_property
    def across(self) -> csr_array:
        """Which faces share an edge; shape (m, m)."""
        return csr_array(self.rings == 2)

    @cached_property
    def edges(self) -> csr_array:
        """Which edges lie inside which patch: row i has 1 where both faces are in patch i.

        Columns are in the order of ``adjacent``; shape (m, k).
        """
        f, g = self.adjacent
        ones = np.ones(self.rings.nnz, dtype=bool)
        member = csr_array((ones, self.rings.indices, self.rings.indptr), shape=self.rings.shape)
        return csr_array(member[:, f].multiply(member[:, g]))


def guidance(patches: Patches, N: Floats, area: Floats) -> Floats:
    """The guidance normals: the mean normal of the most consistent patch that has the face.

    The patches are the faces around a face, each with all that share a vertex
    with it. Their inconsistency (smaller is better) is

        H = max |n_j - n_k| * max_e |n_j - n_k| / (FLAT + sum_e |n_j - n_k|),

    with the first maximum over all pairs of faces in the patch, and e the
    edges inside it: few strong edges, or none at all, make a good patch.

    Parameters
    ----------
    patches : Patches
    N : ndarray of float64, shape (m, 3)
        Unit normals.
    area : ndarray of float64, shape (m,)

    Returns
    -------
    ndarray of float64, shape (m, 3)
        Unit vectors; zero where the patch's normals cancel.
    """
    R = patches.rings
    if _fast.wanted(len(N), _fast.FILTER_ROWS):
        return _fast.filters.guidance(R, patches.across, N, area, FLAT)
    f, g = patches.adjacent
    difference = np.linalg.norm(N[f] - N[g], axis=1)
    patch, e = entries(patches.edges)
    strongest, total = np.zeros(len(N)), np.bincount(patch, difference[e], len(N))
    np.maximum.at(strongest, patch, difference[e])
    H = widest_differences(R, N) * strongest / (FLAT + total)
    member = R.astype(bool)
    mean = normalised(member @ (area[:, None] * N), member @ area)
    return mean[_least_around(R, H)]


def widest_differences(R: csr_array, N: Floats) -> Floats:
    """max |n_j - n_k| over all pairs of faces that a row of R lists.

    Parameters
    ----------
    R : csr_array, shape (m, m)
    N : ndarray of float64, shape (m, 3)

    Returns
    -------
    ndarray of float64, shape (m,)
    """
    size = np.diff(R.indptr)
    widest = np.zeros(len(size))
    for k in np.unique(size):  # all rows of k faces at once
        rows = np.flatnonzero(size == k)
        faces = R.indices[R.indptr[rows] + np.arange(k)[:, None]]
        normals = N.T[:, faces]
        for apart in range(1, k):
            squared = np.sum((normals[:, apart:] - normals[:, :-apart]) ** 2, axis=0)
            widest[rows] = np.maximum(widest[rows], np.sqrt(squared.max(axis=0)))
    return widest


def _least_around(R: csr_array, H: Floats) -> Integers:
    """The face with the least H in each row of R: face i itself, or the first of them."""
    i, j = entries(R)
    least = np.minimum.reduceat(H[j], R.indptr[:-1])
    where = np.flatnonzero(H[j] == least[i])
    _, first = np.unique(i[where], return_index=True)
    return np.where(H == least, np.arange(len(H)), j[where[first]])
