"""What all filters ask of a mesh: what lies around what, and the faces' shapes.

Neighbourhoods are sparse matrices: row i lists what is near i.
"""

import numpy as np
from scipy.sparse import csr_array

from meshfair._fast.kernels import compiled, on_all_cores

# Rows that a thread takes at a time, where a row is as much work as here.
BLOCK = 4096


def incidence(F, n):
    """Which faces each vertex has.

    Parameters
    ----------
    F : ndarray of int64, shape (m, 3)
    n : int
        Number of vertices.

    Returns
    -------
    B : csr_array of int8, shape (n, m)
        1 where the vertex is a corner of the face: row i lists the faces of
        vertex i, ``B.indices[B.indptr[i] : B.indptr[i + 1]]``.
    """
    faces = np.repeat(np.arange(len(F)), 3)
    ones = np.ones(3 * len(F), dtype=np.int8)
    B = csr_array((ones, (F.ravel(), faces)), shape=(n, len(F)))
    B.data[:] = 1  # a degenerate face may have a vertex twice
    return B


def face_rings(B):
    """Which faces share a vertex with each face.

    Parameters
    ----------
    B : csr_array, shape (n, m)
        See `incidence`.

    Returns
    -------
    R : csr_array of int8, shape (m, m)
        R = B' B, the number of vertices that two faces share: 1, or 2 where
        they share an edge, or 3 for a face with itself (and its duplicates).
    """
    return (B.T @ B).T  # symmetric; the transpose of SciPy's product is stored by rows


def adjacent_faces(R):
    """The pairs of faces that share an edge.

    Parameters
    ----------
    R : csr_array, shape (m, m)
        See `face_rings`.

    Returns
    -------
    f, g : ndarrays of int32, shape (k,)
        Each pair once, f < g.
    """
    f, g = (R == 2).nonzero()
    return f[f < g], g[f < g]


def within(P, graph, radius):
    """The points near each point, as far as they are reached through near points.

    Region growing: from each point along the graph's edges, never past a point
    that is as far away as the radius, so that the other side of a thin sheet
    is not reached.

    Parameters
    ----------
    P : ndarray of float64, shape (k, 3)
        Vertices, or centroids of faces.
    graph : csr_array, shape (k, k)
        Which points are connected.
    radius : ndarray of float64, shape (k,)
        In the units of ``P``.

    Returns
    -------
    csr_array of int8, shape (k, k)
        Row i lists the points nearer to point i than its radius, itself first.
    """
    count = np.empty(len(P), dtype=np.int64)
    rows = on_all_cores(_within, len(P), P, graph.indptr, graph.indices, radius, count, block=BLOCK)
    near = np.concatenate(rows)
    start = np.concatenate([[0], np.cumsum(count)])
    return csr_array((np.ones(len(near), dtype=np.int8), near, start), shape=graph.shape)


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
                    x, y, z = P[k, 0] - P[i, 0], P[k, 1] - P[i, 1], P[k, 2] - P[i, 2]
                    if x * x + y * y + z * z < radius[i] ** 2:
                        near[end] = k
                        end += 1
        count[i] = end
        while filled + end > len(rows):
            rows = np.concatenate((rows, rows))
        rows[filled : filled + end] = near[:end]
        filled += end
    return rows[:filled]
