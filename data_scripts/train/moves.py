"""What comes of the normals that a stage wants, and the slopes of that.

`meshfair.filters.normal_filtering.move_vertices`, some times over, and the normals of the faces
then: a stage learns what makes these right, and not only what it says of each face by itself.
Vertex i has the faces ``faces[start[i]:start[i + 1]]``, as in the rows of a CSR matrix.
"""

import numba
import numpy as np
from scipy.sparse import csr_array

from meshfair.checks import Floats, Integers
from meshfair.filters.learned import MOVES
from meshfair.filters.normal_filtering import move_vertices

SMALLEST = 0.05  # of the mean area: the slope of the normal of a smaller face is cut off
LEAST = 1e-300  # what no face is smaller than, where it is divided by

loop = numba.njit(nogil=True, cache=True, error_model="numpy")


def places(V: Floats, N: Floats, F: Integers, B: csr_array) -> Floats:
    """The vertices before each move and after the last, shape (MOVES + 1, n, 3)."""
    X, free = [V], np.zeros(len(V), dtype=bool)
    for _ in range(MOVES):
        X.append(move_vertices(X[-1], F, B, N, free))
    return np.stack(X)


@loop
def slopes(X, N, F, start, faces, g):
    """The slopes of sum(g * normals of X[-1]) by N, shape (m, 3); X from `places`."""
    gN, gX = np.zeros_like(N), _slopes_of_normals(X[-1], F, g)
    before, c, gc = np.empty_like(gX), np.empty_like(N), np.empty_like(N)
    for k in range(len(X) - 2, -1, -1):
        V = X[k]
        before[:], gc[:] = gX, 0
        for f in range(len(F)):
            for axis in range(3):
                c[f, axis] = (V[F[f, 0], axis] + V[F[f, 1], axis] + V[F[f, 2], axis]) / 3
        for i in range(len(V)):
            count = start[i + 1] - start[i]
            for p in range(start[i], start[i + 1]):
                f = faces[p]
                along = _dot(gX, i, N, f) / count
                way = (_dot(N, f, c, f) - _dot(N, f, V, i)) / count
                for axis in range(3):
                    gN[f, axis] += way * gX[i, axis] + along * (c[f, axis] - V[i, axis])
                    before[i, axis] -= along * N[f, axis]
                    gc[f, axis] += along * N[f, axis]
        for f in range(len(F)):
            for corner in range(3):
                for axis in range(3):
                    before[F[f, corner], axis] += gc[f, axis] / 3
        gX, before = before, gX
    return gN


@loop
def _slopes_of_normals(V, F, g):
    """The slopes of sum(g * normals of V) by V, shape (n, 3); those of tiny faces held down."""
    gV, N, across = np.zeros_like(V), _areas(V, F), np.empty_like(g)
    size = np.sqrt((N * N).sum(axis=1))
    least = max(SMALLEST * size.mean(), LEAST)
    for f in range(len(F)):
        along = _dot(g, f, N, f) / max(size[f], LEAST) ** 2
        for axis in range(3):
            across[f, axis] = (g[f, axis] - along * N[f, axis]) / max(size[f], least)
        for corner in range(3):
            a, b, c = F[f, corner], F[f, (corner + 1) % 3], F[f, (corner + 2) % 3]
            for x in range(3):
                y, z = (x + 1) % 3, (x + 2) % 3
                gV[a, x] += (V[b, y] - V[c, y]) * across[f, z]
                gV[a, x] -= (V[b, z] - V[c, z]) * across[f, y]
    return gV


@loop
def _areas(V, F):
    """Normals of twice the area of each face."""
    N = np.empty((len(F), 3))
    for f in range(len(F)):
        a, b, c = F[f]
        for x in range(3):
            y, z = (x + 1) % 3, (x + 2) % 3
            N[f, x] = (V[b, y] - V[a, y]) * (V[c, z] - V[a, z])
            N[f, x] -= (V[b, z] - V[a, z]) * (V[c, y] - V[a, y])
    return N


@loop
def _dot(a, i, b, j):
    return a[i, 0] * b[j, 0] + a[i, 1] * b[j, 1] + a[i, 2] * b[j, 2]
