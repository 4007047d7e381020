"""A mesh as two arrays, vertices and faces, as every part of the training passes it on."""

from typing import TypeAlias

import manifold3d as m3
import numpy as np

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
