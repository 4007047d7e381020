"""Normals, areas and centroids of triangles in one pass."""

import numpy as np

from meshfair._fast.kernels import compiled, helper, on_all_cores

# Faces that a thread takes at a time.
BLOCK = 4096


def face_shapes(V, F):
    """As `meshfair.mesh.face_shapes`."""
    N, area, C = np.empty((len(F), 3)), np.empty(len(F)), np.empty((len(F), 3))
    on_all_cores(_face_shapes, len(F), V, F, N, area, C, block=BLOCK)
    return N, area, C


@helper
def _area_vector(V, a, b, c):
    """The cross product of two edges, and its length."""
    ux, uy, uz = V[b, 0] - V[a, 0], V[b, 1] - V[a, 1], V[b, 2] - V[a, 2]
    vx, vy, vz = V[c, 0] - V[a, 0], V[c, 1] - V[a, 1], V[c, 2] - V[a, 2]
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    return x, y, z, np.sqrt(x * x + y * y + z * z)


@compiled
def _face_shapes(first, last, V, F, N, area, C):
    for f in range(first, last):
        a, b, c = F[f, 0], F[f, 1], F[f, 2]
        x, y, z, length = _area_vector(V, a, b, c)
        scale = 1 / length if length > 0 else 0.0
        N[f, 0], N[f, 1], N[f, 2] = scale * x, scale * y, scale * z
        area[f] = length / 2
        for axis in range(3):
            C[f, axis] = (V[a, axis] + V[b, axis] + V[c, axis]) / 3


@compiled
def corner_areas(V, F, m):
    """Add a third of each face's area at its three corners."""
    for f in range(len(F)):
        a, b, c = F[f, 0], F[f, 1], F[f, 2]
        area = _area_vector(V, a, b, c)[3] / 2
        for i in (a, b, c):
            m[i] += area / 3
