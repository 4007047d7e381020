"""What all filters ask of a mesh: what lies around what, and the faces' shapes.

Neighbourhoods are sparse matrices: row i lists what is near i.
"""

import numpy as np
from scipy.sparse import csr_array

from meshfair.kernels import compiled, on_all_cores

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


def face_shapes(V, F):
    """Normals, areas and centroids of the faces, in one compiled pass.

    As `meshfair.mesh.face_normals` and `meshfair.mesh.face_areas` have them;
    filters need them in every iteration.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)

    Returns
    -------
    N : ndarray of float64, shape (m, 3)
        Unit normals; zero for a face without area.
    area : ndarray of float64, shape (m,)
    C : ndarray of float64, shape (m, 3)
    """
    N, area, C = np.empty((len(F), 3)), np.empty(len(F)), np.empty((len(F), 3))
    on_all_cores(_face_shapes, len(F), V, F, N, area, C, block=BLOCK)
    return N, area, C


@compiled
def _face_shapes(first, last, V, F, N, area, C):
    for f in range(first, last):
        a, b, c = F[f, 0], F[f, 1], F[f, 2]
        ux, uy, uz = V[b, 0] - V[a, 0], V[b, 1] - V[a, 1], V[b, 2] - V[a, 2]
        vx, vy, vz = V[c, 0] - V[a, 0], V[c, 1] - V[a, 1], V[c, 2] - V[a, 2]
        x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        length = np.sqrt(x * x + y * y + z * z)
        scale = 1 / length if length > 0 else 0.0
        N[f, 0], N[f, 1], N[f, 2] = scale * x, scale * y, scale * z
        area[f] = length / 2
        for axis in range(3):
            C[f, axis] = (V[a, axis] + V[b, axis] + V[c, axis]) / 3


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
