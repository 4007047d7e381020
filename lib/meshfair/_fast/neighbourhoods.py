"""Neighbourhoods grown point by point, without a matrix for each step."""

import numpy as np
from scipy.sparse import csr_array

from meshfair._fast.kernels import compiled, on_all_cores

# Points that a thread takes at a time, where each is as much work as here.
BLOCK = 4096


def within(P, graph, radius):
    """As `meshfair.filters.neighbourhoods.within`; each row begins with its own point."""
    count = np.empty(len(P), dtype=np.int64)
    rows = on_all_cores(_within, len(P), P, graph.indptr, graph.indices, radius, count, block=BLOCK)
    near = np.concatenate(rows)
    start = np.concatenate([[0], np.cumsum(count)])
    return csr_array((np.ones(len(near), dtype=bool), near, start), shape=graph.shape)


@compiled
def squared_distance(P, i, j):
    """|p_i - p_j|^2."""
    x, y, z = P[i, 0] - P[j, 0], P[i, 1] - P[j, 1], P[i, 2] - P[j, 2]
    return x * x + y * y + z * z


@compiled
def _within(first, last, P, start, neighbours, radius, count):
    """The rows of `within`, one after the other; their lengths go to ``count``."""
    rows, filled = np.empty(16 * (last - first), dtype=np.int32), 0
    near = np.empty(len(P), dtype=np.int32)  # the row that is being found
    reached_from = np.full(len(P), -1, dtype=np.int32)
    for i in range(first, last):
        reached_from[i] = i
        near[0] = i
        head, end = 0, 1
        while head < end:
            j = near[head]
            head += 1
            for a in range(start[j], start[j + 1]):
                k = neighbours[a]
                if reached_from[k] != i:
                    reached_from[k] = i
                    if squared_distance(P, k, i) < radius[i] ** 2:
                        near[end] = k
                        end += 1
        count[i] = end
        while filled + end > len(rows):
            rows = np.concatenate((rows, rows))
        rows[filled : filled + end] = near[:end]
        filled += end
    return rows[:filled]
