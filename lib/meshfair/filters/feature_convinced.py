"""Feature-convinced denoising: find the creases first, and never average across them."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from meshfair._fast.kernels import compiled, on_all_cores
from meshfair.checks import check_count, check_fixed, check_mesh, check_number
from meshfair.filters.diffusion import taubin
from meshfair.filters.neighbourhoods import BLOCK, face_rings, incidence
from meshfair.filters.normal_filtering import joint_bilateral, move_vertices, spatial_weights, sun
from meshfair.mesh import Edges, edge_lengths, face_shapes
from meshfair.mesh.dihedral import dihedral_angles, interior_edges

PATCH = 12  # faces at most in the mean that guides a face
STRAIGHT = 2.5  # radians: consecutive edges of a crease line meet at a wider angle


class Effort(NamedTuple):
    """How much work a level of noise asks for."""

    noise: float
    """Meant for estimated noise below this, in mean edge lengths."""
    taubin_iterations: int
    """Iterations of Taubin's filter on the copy in which creases are found."""
    sun_iterations: int
    """Iterations of Sun's filter on it."""
    crease_cosine: float
    """Edges may be creases where the cosine of their two normals is smaller."""
    normal_iterations: int
    """Iterations of the joint bilateral filter in an iteration."""
    iterations: int
    """How often all is done."""


# [LLL+19]
EFFORTS = (
    Effort(0.10, 0, 5, 0.75, 3, 3),
    Effort(0.25, 1, 8, 0.85, 4, 4),
    Effort(0.45, 2, 10, 0.82, 6, 6),
    Effort(np.inf, 2, 12, 0.78, 8, 8),
)


def effort_for(noise):
    """The first of `EFFORTS` that is meant for this noise."""
    return next(effort for effort in EFFORTS if noise < effort.noise)


def noise_by_lengths(V: ArrayLike, F: ArrayLike) -> float:
    """The size of the noise, by the lengths of the edges [LLL19]_.

    Noise makes edges longer. With normal displacements of standard deviation
    sigma, the mean squared edge length grows by 2 sigma^2. Against a copy that
    Sun's filter has smoothed (T = 0.4, 4 normal and 4 vertex iterations),

        sigma / mean edge = sqrt( msel(V) / (2 msel(smoothed)) - 1/2 ).

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    float
        As a fraction of the noisy mesh's mean edge length.

    Raises
    ------
    MeshError
        No mesh.
    """
    V, F = check_mesh(V, F)
    # The filters build on this module's successors; so this cannot be imported above.
    from meshfair.filters.normal_filtering import sun

    *_, (_, smoothed) = sun(
        V, F, threshold=0.4, normal_iterations=4, vertex_iterations=4, fix_boundary=False
    )
    before, after = (np.mean(edge_lengths(X, F) ** 2) for X in (V, smoothed))
    return float(np.sqrt(max(0.0, before / after - 1) / 2)) if after > 0 else 0.0


def fill_in(V, F, parameters):
    """The parameters of `feature_convinced`, with those that are None chosen from the mesh.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    parameters : dict
        With the keys noise and iterations, and any others.

    Returns
    -------
    dict
    """
    noise, iterations = parameters["noise"], parameters["iterations"]
    noise = noise_by_lengths(V, F) if noise is None else check_number(noise, "noise", 0)
    iterations = (
        effort_for(noise).iterations
        if iterations is None
        else check_count(iterations, "iterations")
    )
    return parameters | {"noise": noise, "iterations": iterations}


def feature_convinced(
    V,
    F,
    *,
    noise=None,
    iterations=None,
    vertex_iterations=2,
    sigma_normal=0.35,
    gap=5,
    shortest=2,
    fixed=None,
):
    """Feature-convinced mesh denoising [LLL+19], as an iterator.

    In each iteration

    1. a copy is smoothed by Taubin's and by Sun's filter, and the lines of its
       creases are traced, see `crease_edges`;
    2. each face gets a guidance normal, the mean over up to 12 faces around
       it that are reached without crossing a crease, see `crease_guidance`;
    3. the normals are averaged by the joint bilateral filter over the faces
       that share a vertex;
    4. the vertices are moved to fit them; one that would move further than an
       edge (the root of the mean squared length) keeps its place.

    How much of each is done depends on the noise: see `EFFORTS`.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    noise : float, optional
        Size of the noise, as a fraction of the mean edge length. If it is not
        given, `noise_by_lengths` estimates it.
    iterations : int, optional
        As many as the noise asks for if not given.
    vertex_iterations : int
        How often the vertices are moved in an iteration.
    sigma_normal : float
        The difference of two guidance normals from which on normals hardly mix.
    gap : int
        So many edges that are no candidates may be bridged along a crease.
    shortest : int
        Crease lines of fewer edges are dropped.
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
    vertex_iterations = check_count(vertex_iterations, "vertex_iterations", 1)
    sigma_normal = check_number(sigma_normal, "sigma_normal", 0, open_low=True)
    gap, shortest = check_count(gap, "gap"), check_count(shortest, "shortest")
    held = check_fixed(fixed, len(V))
    noise, iterations = fill_in(V, F, {"noise": noise, "iterations": iterations}).values()
    effort = effort_for(noise)
    H = interior_edges(F)
    edges = Edges(F, len(V))
    B = incidence(F, len(V))
    R = face_rings(B)
    for k in range(1, iterations + 1):
        crease = crease_edges(
            prefiltered(V, F, effort), H, effort.crease_cosine, gap=gap, shortest=shortest
        )
        N, area, C = face_shapes(V, F)
        G = crease_guidance(H.faces[~crease], N, area, C)
        longest = float(np.sqrt(np.mean(edges.lengths(V) ** 2)))
        S = spatial_weights(R, C, area, longest)
        for _ in range(effort.normal_iterations):
            N = joint_bilateral(S, N, G, sigma_normal)
        for _ in range(vertex_iterations):
            moved = move_vertices(V, F, B, N, held)
            too_far = np.linalg.norm(moved - V, axis=1) > longest
            V = np.where(too_far[:, None], V, moved)
        yield k / iterations, V


def prefiltered(V, F, effort):
    """A copy smooth enough to find creases in."""
    copies = taubin(V, F, lam=0.6, mu=-0.636, iterations=effort.taubin_iterations)
    for _, copy in copies:
        V = copy
    copies = sun(
        *(V, F),
        threshold=0.4,
        normal_iterations=effort.sun_iterations,
        vertex_iterations=4,
        fix_boundary=False,
    )
    for _, copy in copies:
        V = copy
    return V


def crease_edges(V, H, cosine, *, gap, shortest):
    """Trace the lines of creases.

    Candidates are the edges whose two normals have a smaller cosine than the
    given one. From each, the most bent first, a line is followed to both
    sides: at each vertex along the most bent edge that goes on nearly
    straight (by more than 2.5 radians), a candidate where there is one. Other
    edges bridge gaps: they belong to the line if it comes to a candidate, or to
    an earlier line, within ``gap`` of them.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
        A smooth copy of the mesh.
    H : InteriorEdges, with k edges
    cosine : float
    gap : int
    shortest : int
        Lines of fewer edges are dropped.

    Returns
    -------
    ndarray of bool, shape (k,)
    """
    bend = dihedral_angles(V, H)
    candidate = np.cos(bend) < cosine
    seeds = np.flatnonzero(candidate)
    seeds = seeds[np.argsort(-bend[seeds], kind="stable")]
    ends = H.ends
    by_vertex = np.argsort(ends.ravel(), kind="stable")
    start = np.searchsorted(ends.ravel()[by_vertex], np.arange(len(V) + 1))
    crease = np.zeros(len(ends), dtype=bool)
    straight = np.cos(STRAIGHT)
    _trace_lines(
        *(seeds, V, ends, start, by_vertex // 2, bend, candidate),
        *(gap, shortest, straight, crease),
    )
    return crease


@compiled
def _trace_lines(seeds, V, ends, start, edges_at, bend, candidate, gap, shortest, straight, crease):
    line = np.empty(len(ends), dtype=np.int64)
    used = np.zeros(len(ends), dtype=np.bool_)
    on_line = np.zeros(len(V), dtype=np.bool_)
    for seed in seeds:
        if used[seed]:
            continue
        used[seed] = True
        line[0] = seed
        sure = 1  # edges that belong to the line; those after them may bridge a gap
        for side in range(2):
            edge, v, length = seed, ends[seed, side], sure
            while not on_line[v] and length - sure <= gap:
                u = ends[edge, 0] + ends[edge, 1] - v  # the other end
                bx, by, bz = V[u, 0] - V[v, 0], V[u, 1] - V[v, 1], V[u, 2] - V[v, 2]
                best = -1
                for p in range(start[v], start[v + 1]):
                    e = edges_at[p]
                    w = ends[e, 0] + ends[e, 1] - v
                    x, y, z = V[w, 0] - V[v, 0], V[w, 1] - V[v, 1], V[w, 2] - V[v, 2]
                    lengths = np.sqrt((bx * bx + by * by + bz * bz) * (x * x + y * y + z * z))
                    if used[e] or bx * x + by * y + bz * z > straight * lengths:
                        continue
                    if best < 0 or (candidate[e], bend[e]) > (candidate[best], bend[best]):
                        best = e
                if best < 0:
                    break
                used[best] = True
                line[length] = edge = best
                v = ends[best, 0] + ends[best, 1] - v
                length += 1
                if candidate[best]:
                    sure = length
            if on_line[v]:
                sure = length
            for p in range(sure, length):
                used[line[p]] = False
        if sure >= shortest:
            for p in range(sure):
                crease[line[p]] = True
                on_line[ends[line[p], 0]] = on_line[ends[line[p], 1]] = True


def crease_guidance(pairs, N, area, C):
    """The mean normal, by area, of the faces around each face on its side of the creases.

    From each face a patch is grown: again and again by the adjacent face whose
    centroid is nearest, up to `PATCH` faces, never across a crease.

    Parameters
    ----------
    pairs : ndarray of int64, shape (k, 2)
        Adjacent faces with no crease between them.
    N : ndarray of float64, shape (m, 3)
        Normals.
    area : ndarray of float64, shape (m,)
    C : ndarray of float64, shape (m, 3)
        Centroids.

    Returns
    -------
    ndarray of float64, shape (m, 3)
        Unit vectors; zero where the patch's normals cancel.
    """
    f, g = pairs.T
    ones = np.ones(2 * len(f), dtype=np.int8)
    graph = csr_array((ones, (np.append(f, g), np.append(g, f))), shape=(len(N), len(N)))
    G = np.empty_like(N)
    on_all_cores(
        _patch_means, len(N), graph.indptr, graph.indices, N, area, C, PATCH, G, block=BLOCK
    )
    return G


@compiled
def _patch_means(first, last, start, adjacent, N, area, C, size, G):
    patch = np.empty(size, dtype=np.int64)
    in_patch_of = np.full(len(N), -1, dtype=np.int32)
    for i in range(first, last):
        nearest, count = i, 0
        x = y = z = 0.0
        while nearest >= 0 and count < size:
            patch[count] = nearest
            in_patch_of[nearest] = i
            count += 1
            x += area[nearest] * N[nearest, 0]
            y += area[nearest] * N[nearest, 1]
            z += area[nearest] * N[nearest, 2]
            nearest, least = -1, np.inf
            for a in range(count):
                for p in range(start[patch[a]], start[patch[a] + 1]):
                    j = adjacent[p]
                    dx, dy, dz = C[j, 0] - C[i, 0], C[j, 1] - C[i, 1], C[j, 2] - C[i, 2]
                    squared = dx * dx + dy * dy + dz * dz
                    if in_patch_of[j] != i and squared < least:
                        nearest, least = j, squared
        length = np.sqrt(x * x + y * y + z * z)
        scale = 1 / length if length > 0 else 0.0
        G[i, 0], G[i, 1], G[i, 2] = scale * x, scale * y, scale * z
