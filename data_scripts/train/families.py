"""Families of shapes for the choice between filters.

The learned filter was trained on none of them but most of the reliefs, and these on other shapes.
"""

import manifold3d as m3
import numpy as np
from arrays import Mesh, convex_hull, triangles
from reliefs import RELIEFS, lattices, with_relief
from skimage.measure import marching_cubes
from tessellations import WAYS, cut, isotropic, subdivided

from meshfair import shapes

FACES = 600, 2_500  # the least and the most that are asked for
FEWEST, MOST = 300, 6_000  # what may come of it


def polyhedron(rng: np.random.Generator) -> Mesh:
    """A convex polyhedron of random facets."""
    P = rng.normal(size=(int(rng.integers(6, 60)), 3))
    return convex_hull(P / np.linalg.norm(P, axis=1, keepdims=True) * rng.uniform(0.5, 1.3, 3))


def superquadric(rng: np.random.Generator) -> Mesh:
    """Between a box, a sphere and an octahedron, by a power."""
    V, F = shapes.icosphere(5)
    p = np.exp(rng.uniform(np.log(0.9), np.log(9)))
    return V / (np.abs(V) ** p).sum(axis=1, keepdims=True) ** (1 / p) * rng.uniform(0.5, 1.3, 3), F


def prism(rng: np.random.Generator) -> Mesh:
    """A star or a wheel with teeth, drawn out, perhaps twisted."""
    teeth = int(rng.integers(3, 16))
    angle = 2 * np.pi * np.arange(4 * teeth) / (4 * teeth)
    r = np.tile([1.0, 1.0, rng.uniform(0.5, 0.95), rng.uniform(0.5, 0.95)], teeth)
    ring = np.column_stack([np.cos(angle), np.sin(angle)]) * r[:, None]
    twist = float(rng.choice([0.0, rng.uniform(-60, 60)]))
    body = m3.CrossSection([ring]).extrude(rng.uniform(0.2, 1.5), 24 if twist else 0, twist)
    if rng.random() < 0.5:
        body -= m3.Manifold.cylinder(4, *[rng.uniform(0.1, 0.4)] * 2, 48, True)
    return triangles(body)


def turned(rng: np.random.Generator) -> Mesh:
    """A profile of steps, cones and arcs round an axis."""
    n = int(rng.integers(4, 12))
    height = np.cumsum(rng.uniform(0.0, 0.4, n) * (rng.random(n) < 0.8))
    radius = rng.uniform(0.15, 0.9, n)
    corners = [(0.0, 0.0), *zip(radius, height, strict=True), (0.0, height[-1] + 0.05)]
    return triangles(m3.CrossSection([np.array(corners)]).revolve(96))


def minimal(rng: np.random.Generator) -> Mesh:
    """A sheet of a gyroid or Schwarz surface in a ball, thick or thin."""
    x = np.linspace(-2.6, 2.6, 40)
    X, Y, Z = np.meshgrid(x, x, x, indexing="ij")
    X, Y, Z = (a * rng.uniform(0.6, 1.1) + rng.uniform(0, 6) for a in (X, Y, Z))
    if rng.random() < 0.5:
        f = np.sin(X) * np.cos(Y) + np.sin(Y) * np.cos(Z) + np.sin(Z) * np.cos(X)
    else:
        f = np.cos(X) + np.cos(Y) + np.cos(Z)
    X, Y, Z = np.meshgrid(x, x, x, indexing="ij")
    ball = np.sqrt(X**2 + Y**2 + Z**2) - 2.3
    f = np.maximum(np.abs(f) - rng.uniform(0.3, 0.7), ball) if rng.random() < 0.6 else f
    inside = np.maximum(f, ball)
    if inside.min() >= 0:  # a sheet so thin that it slips between the samples
        return minimal(rng)
    V, F, _, _ = marching_cubes(inside, 0, gradient_direction="descent")
    return V.astype(float), F.astype(np.int64)


def carved(rng: np.random.Generator) -> Mesh:
    """A sphere or torus with bumps, furrows and strands by functions of direction."""
    V, F = shapes.icosphere(5) if rng.random() < 0.6 else shapes.torus(160, 64)
    N = V / np.linalg.norm(V, axis=1, keepdims=True)
    r = np.ones(len(V))
    for _ in range(rng.integers(2, 9)):
        c = rng.normal(size=3)
        c /= np.linalg.norm(c)
        d2 = np.sum((N - c) ** 2, axis=1)
        r += rng.uniform(-0.3, 0.4) * np.exp(-d2 / np.exp(rng.uniform(np.log(0.01), np.log(0.5))))
    if rng.random() < 0.6:
        k = rng.normal(size=3) * rng.uniform(5, 25)
        r += rng.uniform(0.005, 0.03) * np.sin(N @ k + 2 * np.sin(N @ rng.normal(size=3) * 4))
    return V * np.maximum(r, 0.3)[:, None], F


def terrain(rng: np.random.Generator) -> Mesh:
    """A landscape, open all around, on a regular grid."""
    n, k = rng.integers(20, 48, 2)
    x, y = np.meshgrid(np.arange(n, dtype=float), np.arange(k, dtype=float), indexing="ij")
    z = np.zeros_like(x)
    for _ in range(rng.integers(2, 9)):
        q = rng.normal(size=2) / np.exp(rng.uniform(np.log(1.5), np.log(20)))
        s = np.sin(q[0] * x + q[1] * y + rng.uniform(0, 6.3)) / np.linalg.norm(q)
        z += rng.uniform(0.1, 0.8) * (-np.abs(s) if rng.random() < 0.3 else s)
    z = np.maximum(z, rng.uniform(-20, 0)) if rng.random() < 0.3 else z
    a = (np.arange(n - 1)[:, None] * k + np.arange(k - 1)).ravel()
    F = np.concatenate([np.stack([a, a + k, a + k + 1], 1), np.stack([a, a + k + 1, a + 1], 1)])
    return np.stack([x, y, z], axis=-1).reshape(-1, 3), F


def tube(rng: np.random.Generator) -> Mesh:
    """A knotted or wavy closed tube on a coarse regular grid."""
    sections, sides = int(rng.integers(40, 200)), int(rng.integers(6, 20))
    p, q = [(2, 3), (3, 2), (2, 5), (1, 0), (1, 4), (3, 4)][rng.integers(6)]
    t = 2 * np.pi * np.arange(sections) / sections
    R, a = rng.uniform(1.8, 3), rng.uniform(0.4, 1.0)
    r = R + a * np.cos(q * t)
    C = np.column_stack([r * np.cos(p * t), r * np.sin(p * t), a * np.sin(q * t) * 1.3])
    T = np.roll(C, -1, 0) - np.roll(C, 1, 0)
    T /= np.linalg.norm(T, axis=1, keepdims=True)
    up = np.array([0.0, 0.0, 1.0])
    A = np.cross(T, up)
    A /= np.linalg.norm(A, axis=1, keepdims=True)
    B = np.cross(A, T)
    v = 2 * np.pi * np.arange(sides) / sides
    w = rng.uniform(0.15, 0.45)
    V = C[:, None] + w * (np.cos(v)[:, None] * A[:, None] + np.sin(v)[:, None] * B[:, None])
    i, j = np.divmod(np.arange(sections * sides), sides)
    i1, j1 = (i + 1) % sections, (j + 1) % sides
    a0, b0, c0, d0 = i * sides + j, i1 * sides + j, i1 * sides + j1, i * sides + j1
    F = np.concatenate([np.stack([a0, b0, c0], 1), np.stack([a0, c0, d0], 1)])
    V = V.reshape(-1, 3)
    N = np.cross(V[F[:, 1]] - V[F[:, 0]], V[F[:, 2]] - V[F[:, 0]])
    inward = np.sum(N * (V[F[:, 0]] - np.repeat(C, sides, 0)[F[:, 0]]), axis=1).sum() < 0
    return V, F[:, ::-1] if inward else F


def jets(rng: np.random.Generator) -> Mesh:
    """Bodies with wings and thin rods, at a coarse resolution."""
    body = m3.Manifold.sphere(1, 64).scale((rng.uniform(1.5, 3), 0.4, rng.uniform(0.3, 0.5)))
    body += m3.Manifold.cube((0.6, rng.uniform(2, 4), 0.08), True)
    for y in rng.uniform(-1.5, 1.5, rng.integers(1, 5)):
        r = rng.uniform(0.05, 0.12)
        rod = m3.Manifold.cylinder(rng.uniform(0.5, 1.2), r, r, 16, True)
        body += rod.rotate((0, 90, 0)).translate((0, float(y), -0.1))
    return triangles(body)


def bristles(rng: np.random.Generator) -> Mesh:
    """A plump or a flat body with many rods, that stick out or lie along it."""
    size = rng.uniform(0.3, 1.2, 3)
    body = m3.Manifold.cube(2 * size, True) if rng.random() < 0.5 else m3.Manifold.sphere(1, 48)
    body = body if rng.random() < 0.5 else body.scale(size)
    lying, sides = rng.random() < 0.5, int(rng.choice([4, 6, 8, 16]))
    radius, length = rng.uniform(0.04, 0.12), rng.uniform(0.5, 1.5)
    for _ in range(rng.integers(3, 13)):
        rod = m3.Manifold.cylinder(length, radius, radius * rng.choice([0.4, 1, 1]), sides, True)
        way = (0.0, 90.0, 0.0) if lying else tuple(rng.uniform(-180, 180, 3))
        place = rng.normal(size=3)
        place *= size / np.linalg.norm(place) * (1 + radius if lying else 1)
        body += rod.rotate(way).translate(tuple(place))
    return triangles(max(body.decompose(), key=lambda part: part.surface_area()))


AS_THEY_ARE = terrain, tube
SMOOTH = superquadric, minimal, carved
PLAIN = (polyhedron, prism, turned, jets, bristles, *SMOOTH, *AS_THEY_ARE)
ALL_RELIEFS = (*RELIEFS, lattices)
FAMILIES = (*PLAIN, *ALL_RELIEFS)


def family(number: int) -> Mesh:
    """A shape of one of the families, from its number; a relief is on one of the plain ones."""
    for attempt in range(50):
        rng = np.random.default_rng([7, number, attempt])
        made = FAMILIES[number % len(FAMILIES)]
        make = PLAIN[rng.integers(len(PLAIN))] if made in ALL_RELIEFS else made
        V, F = make(rng)
        if make not in AS_THEY_ARE:
            way = list(WAYS)[rng.choice(len(WAYS), p=np.array(list(WAYS.values())))]
            if make in SMOOTH and way is subdivided:
                way = isotropic
            V, F = way(V, F, int(np.exp(rng.uniform(*np.log(FACES)))), rng)
        if rng.random() < 0.1:
            V, F = cut(V, F, rng)
        if FEWEST <= len(F) <= MOST:
            return (with_relief(made, V, F, rng) if made in ALL_RELIEFS else V), F
    raise RuntimeError(f"shape {number} has not come about in 50 attempts")
