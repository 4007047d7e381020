"""Bilateral mesh denoising: the image filter's idea, on heights over the tangent plane."""

import numpy as np

from meshfair import weights
from meshfair._fast.kernels import compiled, on_all_cores
from meshfair.checks import check_count, check_fixed, check_mesh, check_number
from meshfair.filters.neighbourhoods import BLOCK, incidence, within
from meshfair.mesh import Edges, face_shapes


def bilateral(V, F, *, iterations=5, radius=2.0, fixed=None):
    """Bilateral mesh denoising [FDCo03], as an iterator.

    Each vertex moves along its normal n by a mean of the heights
    h = <q - v, n> of the vertices q around it (itself among them),

        v <- v + n (sum w h / sum w),
        w = exp(-|q - v|^2 / 2 sigma_c^2) exp(-h^2 / 2 sigma_s^2),

    with sigma_c the shortest edge at v and sigma_s the standard deviation of
    |h| around it. Normals are computed anew in each iteration; all faces at a
    vertex count the same in them.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    iterations : int
    radius : float
        How far the neighbourhood goes, in sigma_c; it is grown through the mesh.
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
    iterations = check_count(iterations, "iterations")
    radius = check_number(radius, "radius", 0, open_low=True)
    held = check_fixed(fixed, len(V))
    edges, B = Edges(F, len(V)), incidence(F, len(V))
    for step in range(1, iterations + 1):
        lengths = weights.distance(V, edges)
        sigma_c = shortest_edges(lengths)
        near = within(V, lengths, radius * sigma_c)
        N = B @ face_shapes(V, F)[0]
        moved = np.empty_like(V)
        on_all_cores(
            _bilateral, len(V), V, N, near.indptr, near.indices, sigma_c, held, moved, block=BLOCK
        )
        V = moved
        yield step / iterations, V


def shortest_edges(lengths):
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


@compiled
def _bilateral(first, last, V, N, start, near, sigma_c, held, moved):
    for i in range(first, last):
        moved[i, 0], moved[i, 1], moved[i, 2] = V[i, 0], V[i, 1], V[i, 2]
        length = np.sqrt(N[i, 0] ** 2 + N[i, 1] ** 2 + N[i, 2] ** 2)
        if held[i] or length == 0 or sigma_c[i] == 0:
            continue
        nx, ny, nz = N[i, 0] / length, N[i, 1] / length, N[i, 2] / length
        count = start[i + 1] - start[i]
        h = np.empty(count)
        for p in range(count):
            q = near[start[i] + p]
            x, y, z = V[q, 0] - V[i, 0], V[q, 1] - V[i, 1], V[q, 2] - V[i, 2]
            h[p] = x * nx + y * ny + z * nz
        variance = max(np.var(np.abs(h)), (1e-6 * sigma_c[i]) ** 2)
        total = height = 0.0
        for p in range(count):
            q = near[start[i] + p]
            x, y, z = V[q, 0] - V[i, 0], V[q, 1] - V[i, 1], V[q, 2] - V[i, 2]
            w = np.exp(
                -(x * x + y * y + z * z) / (2 * sigma_c[i] ** 2) - h[p] ** 2 / (2 * variance)
            )
            total += w
            height += w * h[p]
        moved[i, 0] += nx * height / total
        moved[i, 1] += ny * height / total
        moved[i, 2] += nz * height / total
