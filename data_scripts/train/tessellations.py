"""Triangulations as real meshes have them, fine detail, and boundaries."""

import numpy as np
import pymeshlab as ml
from arrays import Mesh, compact
from waves import waves

from meshfair import mesh
from meshfair.checks import Floats, Integers

CREASE = 25  # degrees: dihedral angles above are kept by remeshing


def isotropic(V: Floats, F: Integers, faces: int, rng: np.random.Generator) -> Mesh:
    """Triangles of one size."""
    length = np.sqrt(mesh.area(V, F) / faces * 4 / np.sqrt(3))
    tool = ml.MeshSet()
    tool.add_mesh(ml.Mesh(V, F))
    tool.meshing_merge_close_vertices()
    tool.meshing_isotropic_explicit_remeshing(
        iterations=int(rng.integers(3, 9)),
        targetlen=ml.PureValue(length),
        featuredeg=CREASE,
        checksurfdist=False,
    )
    return _taken(tool)


def anisotropic(V: Floats, F: Integers, faces: int, rng: np.random.Generator) -> Mesh:
    """Triangles stretched along a direction, up to three times."""
    Q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    S = Q @ np.diag([1, rng.uniform(1, 1.7), rng.uniform(1.3, 3)]) @ Q.T
    V, F = isotropic(V @ S, F, faces, rng)
    return V @ np.linalg.inv(S), F


def decimated(V: Floats, F: Integers, faces: int, rng: np.random.Generator) -> Mesh:
    """Triangles of many sizes: a finer mesh, simplified where it is flat first."""
    tool = ml.MeshSet()
    tool.add_mesh(ml.Mesh(*isotropic(V, F, int(faces * rng.uniform(2, 5)), rng)))
    tool.meshing_decimation_quadric_edge_collapse(
        targetfacenum=faces, planarquadric=True, planarweight=0.01, preservenormal=True
    )
    return _taken(tool)


def jittered(V: Floats, F: Integers, faces: int, rng: np.random.Generator) -> Mesh:
    """Irregular triangles: vertices of an isotropic mesh moved inside the surface."""
    V, F = isotropic(V, F, faces, rng)
    N, normals = mesh.face_normals(V, F), mesh.vertex_normals(V, F)
    least = np.ones(len(V))
    np.minimum.at(least, F, np.sum(N[:, None] * normals[F], axis=2))
    shift = rng.normal(size=V.shape) * rng.uniform(0.1, 0.25) * mesh.mean_edge_length(V, F)
    shift -= np.sum(shift * normals, axis=1, keepdims=True) * normals
    return V + shift * (least > 0.995)[:, None], F


def subdivided(V: Floats, F: Integers, faces: int, rng: np.random.Generator) -> Mesh:
    """What halving the longest edges of a coarse triangulation gives: many obtuse ones."""
    tool = ml.MeshSet()
    tool.add_mesh(ml.Mesh(V, F))
    tool.meshing_merge_close_vertices()
    length = 1.8 * np.sqrt(mesh.area(V, F) / faces * 4 / np.sqrt(3))
    tool.meshing_surface_subdivision_midpoint(iterations=6, threshold=ml.PureValue(length))
    return _taken(tool)


WAYS = {isotropic: 0.56, anisotropic: 0.14, decimated: 0.12, jittered: 0.12, subdivided: 0.06}


def with_detail(V: Floats, F: Integers, rng: np.random.Generator) -> Floats:
    """Bumps, ripples or wrinkles, 1.5 to 12 edges wide, on parts of the surface or all of it."""
    length = mesh.mean_edge_length(V, F)
    N = mesh.vertex_normals(V, F)
    for _ in range(rng.integers(1, 4)):
        width = length * np.exp(rng.uniform(np.log(1.5), np.log(12)))
        steepness = np.exp(rng.uniform(np.log(0.04), np.log(0.6)))
        f = waves(V, 2 * np.pi / (2 * width), rng)
        kind = rng.integers(4)
        if kind == 1:  # wrinkles: sharp along lines
            f = -np.abs(f)
        elif kind == 2:  # ripples along one direction
            k = rng.normal(size=3)
            f = np.sin(V @ k * np.pi / (width * np.linalg.norm(k)) + 1.5 * f)
        elif kind == 3:  # separate bumps, or dents
            f = rng.choice([-1, 1]) * np.maximum(f - 0.5, 0) * 2
        if rng.random() < 0.6:
            mask = waves(V, 2 * np.pi / (length * rng.uniform(20, 60)), rng)
            f = f * np.clip(0.5 + 2 * mask, 0, 1)
        V = V + (steepness * width / np.pi * f)[:, None] * N
    return V


def with_roughness(V: Floats, F: Integers, rng: np.random.Generator) -> Floats:
    """Bumps of all widths from about one edge to 20, finer ones lower by a power of the width."""
    length, N = mesh.mean_edge_length(V, F), mesh.vertex_normals(V, F)
    widths = rng.uniform(0.7, 1.4) * 2.0 ** np.arange(5)
    steepness = widths ** rng.uniform(-0.6, 0.4)
    steepness *= np.exp(rng.uniform(np.log(0.03), np.log(0.4))) / np.linalg.norm(steepness)
    f = sum(
        s * w / np.pi * waves(V, np.pi / (w * length), rng)
        for s, w in zip(steepness, widths, strict=True)
    )
    if rng.random() < 0.5:
        f = f * np.clip(0.6 + waves(V, 2 * np.pi / (length * rng.uniform(20, 60)), rng), 0, 1)
    return V + (length * f)[:, None] * N


def near(V: Floats, F: Integers, faces: int, rng: np.random.Generator) -> Mesh:
    """The part of a mesh that is near to one of its vertices, about this many faces."""
    C = V[F].mean(axis=1)
    away = np.linalg.norm(C - V[rng.integers(len(V))], axis=1)
    return compact(V, F[np.argsort(away)[:faces]])


def cut(V: Floats, F: Integers, rng: np.random.Generator) -> Mesh:
    """The part on one side of a plane, and perhaps with a hole in it."""
    C = V[F].mean(axis=1)
    n = rng.normal(size=3)
    n /= np.linalg.norm(n)
    keep = C @ n < np.quantile(C @ n, rng.uniform(0.5, 0.95))
    if rng.random() < 0.3:
        keep &= np.linalg.norm(C - C[rng.integers(len(C))], axis=1) > rng.uniform(0.05, 0.3)
    return compact(V, F[keep])


def _taken(tool: ml.MeshSet) -> Mesh:
    mesh = tool.current_mesh()
    return mesh.vertex_matrix(), mesh.face_matrix().astype(np.int64)
