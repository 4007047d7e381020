"""A mesh as two arrays, vertices and faces, as every part of the training passes it on."""

from typing import TypeAlias

import manifold3d as m3
import numpy as np
from scipy.spatial import ConvexHull

from meshfair.checks import Floats, Integers

Mesh: TypeAlias = tuple[Floats, Integers]


def triangles(body: m3.Manifold) -> Mesh:
    """The vertices and faces of a solid."""
    mesh = body.to_mesh()
    return np.array(mesh.vert_properties[:, :3], float), np.array(mesh.tri_verts, np.int64)


def compact(V: Floats, F: Integers) -> Mesh:
    """Without the vertices that no face has."""
    used, F = np.unique(F, return_inverse=True)
    return V[used], F.reshape(-1, 3)


def convex_hull(P: Floats) -> Mesh:
    """The surface around some points, its faces outward."""
    hull = ConvexHull(P)
    F = hull.simplices.astype(np.int64)
    N = np.cross(P[F[:, 1]] - P[F[:, 0]], P[F[:, 2]] - P[F[:, 0]])
    inward = np.sum(N * hull.equations[:, :3], axis=1) < 0
    F[inward] = F[inward][:, ::-1]
    return compact(P, F)
