"""Crease lines followed edge by edge, and patches grown face by face."""

import numpy as np

from meshfair._fast.filters import set_unit
from meshfair._fast.kernels import compiled, on_all_cores
from meshfair._fast.neighbourhoods import BLOCK, squared_distance


def trace_lines(seeds, V, ends, bend, candidate, gap, shortest, straight):
    """As `meshfair.filters.creases.trace_lines`, from these seeds."""
    by_vertex = np.argsort(ends.ravel(), kind="stable")
    start = np.searchsorted(ends.ravel()[by_vertex], np.arange(len(V) + 1))
    crease = np.zeros(len(ends), dtype=bool)
    _trace_lines(
        seeds, V, ends, start, by_vertex // 2, bend, candidate, gap, shortest, straight, crease
    )
    return crease


def patch_means(graph, N, area, C, size):
    """As `meshfair.filters.creases.crease_guidance`, for this graph of faces."""
    G = np.empty_like(N)
    on_all_cores(
        _patch_means, len(N), graph.indptr, graph.indices, N, area, C, size, G, block=BLOCK
    )
    return G


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
                around = edges_at[start[v] : start[v + 1]]
                edge = _best_onward(edge, v, around, V, ends, bend, candidate, straight, used)
                if edge < 0:
                    break
                used[edge] = True
                line[length] = edge
                v = _other_end(ends, edge, v)
                length += 1
                if candidate[edge]:
                    sure = length
            if on_line[v]:
                sure = length
            for p in range(sure, length):
                used[line[p]] = False
        if sure >= shortest:
            for p in range(sure):
                crease[line[p]] = True
                on_line[ends[line[p], 0]] = on_line[ends[line[p], 1]] = True


@compiled
def _other_end(ends, edge, v):
    return ends[edge, 0] + ends[edge, 1] - v


@compiled
def _best_onward(edge, v, around, V, ends, bend, candidate, straight, used):
    """The best of the edges around v that goes on from an edge; -1 where there is none."""
    u = _other_end(ends, edge, v)
    best = -1
    for e in around:
        if used[e] or not _goes_straight(V, u, v, _other_end(ends, e, v), straight):
            continue
        if best < 0 or (candidate[e], bend[e]) > (candidate[best], bend[best]):
            best = e
    return best


@compiled
def _goes_straight(V, u, v, w, straight):
    """Whether the cosine of the angle at v, from u to w, is at most ``straight``."""
    bx, by, bz = V[u, 0] - V[v, 0], V[u, 1] - V[v, 1], V[u, 2] - V[v, 2]
    x, y, z = V[w, 0] - V[v, 0], V[w, 1] - V[v, 1], V[w, 2] - V[v, 2]
    lengths = np.sqrt((bx * bx + by * by + bz * bz) * (x * x + y * y + z * z))
    return bx * x + by * y + bz * z <= straight * lengths


@compiled
def _patch_means(first, last, start, adjacent, N, area, C, size, G):
    patch = np.empty(size, dtype=np.int64)
    in_patch_of = np.full(len(N), -1, dtype=np.int32)
    for i in range(first, last):
        nearest, count = i, 0
        x = y = z = total = 0.0
        while nearest >= 0 and count < size:
            patch[count] = nearest
            in_patch_of[nearest] = i
            count += 1
            x += area[nearest] * N[nearest, 0]
            y += area[nearest] * N[nearest, 1]
            z += area[nearest] * N[nearest, 2]
            total += area[nearest]
            nearest = _nearest_beside(patch[:count], start, adjacent, in_patch_of, C, i)
        set_unit(G, i, x, y, z, total)


@compiled
def _nearest_beside(patch, start, adjacent, in_patch_of, C, i):
    """The face beside patch i whose centroid is nearest to face i's; -1 where there is none."""
    nearest, least = -1, np.inf
    for f in patch:
        for p in range(start[f], start[f + 1]):
            j = adjacent[p]
            squared = squared_distance(C, j, i)
            if in_patch_of[j] != i and squared < least:
                nearest, least = j, squared
    return nearest
