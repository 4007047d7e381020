"""The sums of the filters, face by face and vertex by vertex."""

import numpy as np
from scipy.sparse import csr_array

from meshfair._fast.kernels import compiled, on_all_cores, unsigned
from meshfair._fast.neighbourhoods import BLOCK, squared_distance
from meshfair.checks import CANCELLED


def move_along_normals(V, N, near, sigma_c, least_deviation, fixed):
    """As `meshfair.filters.bilateral.move_along_normals`."""
    moved = np.empty_like(V)
    on_all_cores(
        _move_along_normals, len(V), V, N, near.indptr, near.indices,
        sigma_c, least_deviation, fixed, moved, block=BLOCK,
    )  # fmt: skip
    return moved


def sun_normals(R, N, T):
    """As `meshfair.filters.normal_filtering.sun_normals`."""
    mean = np.empty_like(N)
    on_all_cores(_sun, len(N), R.indptr, R.indices, N, T, mean, block=BLOCK)
    return mean


def spatial_weights(near, C, area, sigma):
    """As `meshfair.filters.normal_filtering.spatial_weights`."""
    S = np.empty(near.nnz)
    rows = unsigned(near.indptr, near.indices)
    on_all_cores(_spatial_weights, len(C), *rows, C, area, sigma, S, block=BLOCK)
    return csr_array((S, near.indices, near.indptr), shape=near.shape)


def joint_bilateral(S, N, G, sigma):
    """As `meshfair.filters.normal_filtering.joint_bilateral`."""
    mean = np.empty_like(N)
    rows = (*unsigned(S.indptr, S.indices), S.data)
    on_all_cores(_joint_bilateral, len(N), *rows, N, G, sigma, mean, block=BLOCK)
    return mean


def move_vertices(V, F, B, N, fixed):
    """As `meshfair.filters.normal_filtering.move_vertices`."""
    height, moved = np.empty(len(F)), np.empty_like(V)
    on_all_cores(_plane_heights, len(F), V, F, N, height, block=BLOCK)
    on_all_cores(
        _move_vertices, len(V), V, B.indptr, B.indices, N, height, fixed, moved, block=BLOCK
    )
    return moved


def guidance(R, across, N, area, flat):
    """As `meshfair.filters.guided_normal.guidance`."""
    inconsistency, mean = np.empty(len(N)), np.empty_like(N)
    on_all_cores(
        _patches, len(N), R.indptr, R.indices, across.indptr, across.indices,
        N, area, flat, inconsistency, mean, block=BLOCK,
    )  # fmt: skip
    G = np.empty_like(N)
    on_all_cores(_choose, len(N), R.indptr, R.indices, inconsistency, mean, G, block=BLOCK)
    return G


@compiled
def _dot(X, i, Y, j):
    return X[i, 0] * Y[j, 0] + X[i, 1] * Y[j, 1] + X[i, 2] * Y[j, 2]


@compiled
def _falloff(sigma):
    """1 / 2 sigma^2, or a number so large that all but 0 times it vanishes."""
    return 1 / max(2 * sigma**2, np.finfo(np.float64).tiny)


@compiled
def _set_direction(out, i, x, y, z, total, N):
    """Row i of ``out`` becomes (x, y, z) at length one; where its terms cancel, row i of N."""
    length = np.sqrt(x * x + y * y + z * z)
    if length > CANCELLED * total:
        out[i, 0], out[i, 1], out[i, 2] = x / length, y / length, z / length
    else:
        out[i, 0], out[i, 1], out[i, 2] = N[i, 0], N[i, 1], N[i, 2]


@compiled
def set_unit(out, i, x, y, z, total):
    """Row i of ``out`` becomes (x, y, z) at length one; where its terms cancel, zero."""
    length = np.sqrt(x * x + y * y + z * z)
    scale = 1 / length if length > CANCELLED * total else 0.0
    out[i, 0], out[i, 1], out[i, 2] = x * scale, y * scale, z * scale


@compiled
def _move_along_normals(first, last, V, N, start, near, sigma_c, least_deviation, fixed, moved):
    for i in range(first, last):
        shift = 0.0
        if not fixed[i] and sigma_c[i] > 0:
            around = near[start[i] : start[i + 1]]
            shift = _mean_height(V, N, i, around, sigma_c[i], least_deviation)
        for axis in range(3):
            moved[i, axis] = V[i, axis] + shift * N[i, axis]


@compiled
def _mean_height(V, N, i, around, sigma_c, least_deviation):
    h = np.empty(len(around))
    for a in range(len(around)):
        h[a] = (
            (V[around[a], 0] - V[i, 0]) * N[i, 0]
            + (V[around[a], 1] - V[i, 1]) * N[i, 1]
            + (V[around[a], 2] - V[i, 2]) * N[i, 2]
        )
    variance = max(np.var(np.abs(h)), (least_deviation * sigma_c) ** 2)
    total = height = 0.0
    for a in range(len(around)):
        distance = squared_distance(V, around[a], i)
        w = np.exp(-distance / (2 * sigma_c**2) - h[a] ** 2 / (2 * variance))
        total += w
        height += w * h[a]
    return height / total


@compiled
def _sun(first, last, start, faces, N, T, mean):
    for i in range(first, last):
        x = y = z = total = 0.0
        for p in range(start[i], start[i + 1]):
            j = faces[p]
            w = max(0.0, _dot(N, i, N, j) - T) ** 2
            x += w * N[j, 0]
            y += w * N[j, 1]
            z += w * N[j, 2]
            total += w
        _set_direction(mean, i, x, y, z, total, N)


@compiled
def _spatial_weights(first, last, start, faces, C, area, sigma, S):
    falloff = _falloff(sigma)
    for i in range(first, last):
        for p in range(start[i], start[i + 1]):
            j = faces[p]
            S[p] = area[j] * np.exp(-falloff * squared_distance(C, i, j))


@compiled
def _joint_bilateral(first, last, start, faces, S, N, G, sigma, mean):
    falloff = _falloff(sigma)
    for i in range(first, last):
        x = y = z = total = 0.0
        for p in range(start[i], start[i + 1]):
            j = faces[p]
            w = S[p] * np.exp(-falloff * squared_distance(G, i, j))
            x += w * N[j, 0]
            y += w * N[j, 1]
            z += w * N[j, 2]
            total += w
        _set_direction(mean, i, x, y, z, total, N)


@compiled
def _plane_heights(first, last, V, F, N, height):
    """<n_f, c_f>: where the plane through the centroid with normal n_f lies."""
    for f in range(first, last):
        height[f] = (_dot(N, f, V, F[f, 0]) + _dot(N, f, V, F[f, 1]) + _dot(N, f, V, F[f, 2])) / 3


@compiled
def _move_vertices(first, last, V, start, faces, N, height, fixed, moved):
    for i in range(first, last):
        x = y = z = 0.0
        count = start[i + 1] - start[i]
        if count > 0 and not fixed[i]:
            for p in range(start[i], start[i + 1]):
                f = faces[p]
                distance = (height[f] - _dot(N, f, V, i)) / count
                x += distance * N[f, 0]
                y += distance * N[f, 1]
                z += distance * N[f, 2]
        moved[i, 0], moved[i, 1], moved[i, 2] = V[i, 0] + x, V[i, 1] + y, V[i, 2] + z


@compiled
def _patches(first, last, start, ring, start_across, across, N, area, flat, inconsistency, mean):
    """The inconsistency H of the patch around each face, and its mean normal."""
    in_patch_of = np.full(len(N), -1, dtype=np.int32)
    for i in range(first, last):
        faces = ring[start[i] : start[i + 1]]
        for j in faces:
            in_patch_of[j] = i
        x = y = z = 0.0
        strongest = total = size = 0.0
        for j in faces:
            x += area[j] * N[j, 0]
            y += area[j] * N[j, 1]
            z += area[j] * N[j, 2]
            size += area[j]
            for p in range(start_across[j], start_across[j + 1]):
                k = across[p]
                if k < j and in_patch_of[k] == i:
                    difference = np.sqrt(squared_distance(N, j, k))
                    strongest = max(strongest, difference)
                    total += difference
        inconsistency[i] = _widest(N, faces) * strongest / (flat + total)
        set_unit(mean, i, x, y, z, size)


@compiled
def _widest(N, faces):
    """max |n_j - n_k| over all pairs of these faces."""
    squared = 0.0
    for a in range(len(faces)):
        for b in range(a):
            squared = max(squared, squared_distance(N, faces[a], faces[b]))
    return np.sqrt(squared)


@compiled
def _choose(first, last, start, ring, inconsistency, mean, G):
    """The mean normal of the most consistent of the patches around each face."""
    for i in range(first, last):
        best = i
        for p in range(start[i], start[i + 1]):
            if inconsistency[ring[p]] < inconsistency[best]:
                best = ring[p]
        G[i, 0], G[i, 1], G[i, 2] = mean[best, 0], mean[best, 1], mean[best, 2]
