"""The shapes that networks are chosen and scored by: of other generators than those in `shapes`.

A network that only knows its training shapes by heart does badly on these. No
mesh that was downloaded is among them.
"""

from collections.abc import Callable

import manifold3d as m3
import numpy as np
from arrays import Mesh, convex_hull, triangles
from skimage.measure import marching_cubes
from tessellations import decimated, isotropic

from meshfair import shapes as built_in

FACES = 6_000


def gear() -> Mesh:
    """A wheel with sharp teeth, a hub and a bore."""
    teeth, angle = 14, []
    radius: list[float] = []
    for k in range(teeth):
        a = 2 * np.pi * k / teeth
        for part, r in ((0, 0.8), (0.2, 0.8), (0.3, 1.0), (0.6, 1.0), (0.7, 0.8)):
            angle.append(a + 2 * np.pi * part / teeth)
            radius.append(r)
    ring = np.column_stack([np.cos(angle), np.sin(angle)]) * np.array(radius)[:, None]
    body = m3.CrossSection([ring]).extrude(0.3)
    body += m3.CrossSection.circle(0.4, 80).extrude(0.55)
    body -= m3.CrossSection.circle(0.2, 80).extrude(2).translate((0, 0, -1))
    return _remeshed(triangles(body))


def turned() -> Mesh:
    """A turned part: a profile with steps, cones and fillets, round an axis."""
    corners = [(0, 0), (0.9, 0), (0.9, 0.15), (0.5, 0.3)]
    arc = np.linspace(0, np.pi / 2, 12)
    fillet = np.column_stack([0.5 - 0.25 * np.sin(arc), 0.55 - 0.25 * np.cos(arc)])
    corners += [tuple(p) for p in fillet]
    corners += [(0.25, 1.2), (0.45, 1.35), (0.45, 1.5), (0, 1.7)]
    return _remeshed(triangles(m3.CrossSection([np.array(corners)]).revolve(120)))


def crystal() -> Mesh:
    """A convex polyhedron with many facets, blunt and sharp edges."""
    rng = np.random.default_rng(3)
    P = rng.normal(size=(28, 3))
    P = P / np.linalg.norm(P, axis=1, keepdims=True) * [1, 0.8, 1.2]
    return _remeshed(convex_hull(P))


def bracket() -> Mesh:
    """Two thin plates at an angle, with ribs and bolt holes, simplified unevenly."""
    body = m3.Manifold.cube((1.6, 1.0, 0.12)) + m3.Manifold.cube((0.12, 1.0, 1.1))
    for y in (0.15, 0.78):
        rib = m3.CrossSection([np.array([(0.0, 0.0), (0.8, 0.0), (0.0, 0.7)])]).extrude(0.08)
        body += rib.rotate((90, 0, 0)).translate((0.1, y, 0.1))
    for x, y in ((1.2, 0.25), (1.2, 0.75), (0.7, 0.5)):
        body -= m3.Manifold.cylinder(1, 0.09, 0.09, 40, True).translate((x, y, 0))
    return decimated(*triangles(body), FACES, np.random.default_rng(1))


def superquadric() -> Mesh:
    """Between a box and a sphere: edges that are rounded by a power."""
    V, F = _icosphere()
    return V / (np.abs(V) ** 5).sum(axis=1, keepdims=True) ** (1 / 5) * [1.2, 0.8, 0.6], F


def head() -> Mesh:
    """A round shape with a nose, brows and strands, by spherical functions."""
    V, F = _icosphere()
    x, y, z = V.T
    r = 1 + 0.15 * x * y - 0.12 * z**2 + 0.35 * np.exp(-((y - 0.1) ** 2 + z**2) / 0.03) * (x > 0)
    r += 0.06 * np.exp(-((z - 0.35) ** 2) / 0.004) * np.exp(-(y**2) / 0.2) * (x > 0)
    strands = np.sin(24 * np.arctan2(y, x) + 3 * np.sin(6 * z))
    r += 0.02 * strands * (z > 0.45) * np.sqrt(1 - np.minimum(z**2, 1))
    return V * r[:, None], F


def gyroid() -> Mesh:
    """A thick gyroid sheet, as marching cubes leaves it."""
    x = np.linspace(-2.6, 2.6, 34)
    X, Y, Z = np.meshgrid(x, x, x, indexing="ij")
    f = np.sin(X) * np.cos(Y) + np.sin(Y) * np.cos(Z) + np.sin(Z) * np.cos(X)
    f = np.maximum(np.abs(f) - 0.5, np.sqrt(X**2 + Y**2 + Z**2) - 2.3)
    V, F, _, _ = marching_cubes(f, 0, gradient_direction="descent")
    return V.astype(float), F.astype(np.int64)


def terrain() -> Mesh:
    """A landscape with ridges and a plain, open all around, on a regular grid."""
    n = 56
    x, y = np.meshgrid(np.arange(n, dtype=float), np.arange(n, dtype=float), indexing="ij")
    z = 5 * np.exp(-((x - 18) ** 2 + (y - 30) ** 2) / 200) - 3 * np.abs(np.sin(x / 9 + y / 23))
    z += 0.6 * np.sin(x / 2.1 + np.sin(y / 4)) * (y > 28)
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    F = np.concatenate([np.stack([a, a + n, a + n + 1], 1), np.stack([a, a + n + 1, a + 1], 1)])
    return np.stack([x, y, z], axis=-1).reshape(-1, 3), F


def knot() -> Mesh:
    """The package's knot, coarse and anisotropic, as it is."""
    return built_in.knot()


def jet() -> Mesh:
    """The package's jet with its missiles, less than two edges across."""
    return built_in.jet()


SHARP: dict[str, Callable[[], Mesh]] = {
    "gear": gear,
    "turned": turned,
    "crystal": crystal,
    "bracket": bracket,
}
SMOOTH: dict[str, Callable[[], Mesh]] = {
    "superquadric": superquadric,
    "head": head,
    "gyroid": gyroid,
    "terrain": terrain,
    "knot": knot,
    "jet": jet,
}
SHAPES = SHARP | SMOOTH


def _icosphere() -> Mesh:
    return isotropic(*built_in.icosphere(5), FACES, np.random.default_rng(0))


def _remeshed(raw: Mesh) -> Mesh:
    return isotropic(*raw, FACES, np.random.default_rng(0))
