"""Solids with sharp edges, as machines have them: unions and differences of simple ones."""

import manifold3d as m3
import numpy as np
from arrays import Mesh, triangles


def solid(rng: np.random.Generator) -> Mesh:
    """One to five simple solids, some at odd angles, joined to or cut from each other."""
    body = _placed(_simple(rng), rng, 0.1)
    for _ in range(rng.integers(0, 5)):
        other = _placed(_simple(rng), rng, 0.45)
        body = body + other if rng.random() < 0.5 else body - other
    parts = body.decompose()
    return triangles(max(parts, key=lambda part: part.surface_area()) if parts else body)


def thin(rng: np.random.Generator) -> Mesh:
    """A body with plates, rods and fins, a few edges thick."""
    body = _placed(_simple(rng), rng, 0.1)
    for _ in range(rng.integers(1, 6)):
        kind = rng.integers(3)
        if kind == 0:
            size = rng.uniform(0.6, 1.8, 3)
            size[rng.integers(3)] = rng.uniform(0.06, 0.25)
            part = m3.Manifold.cube(size, True)
        elif kind == 1:
            radius = rng.uniform(0.06, 0.18)
            low = radius * rng.choice([1, 1, 0.3])
            part = m3.Manifold.cylinder(rng.uniform(0.8, 2.4), low, radius, 48, True)
        else:
            ring = m3.CrossSection.circle(rng.uniform(0.05, 0.12), 32)
            part = ring.translate((rng.uniform(0.4, 1), 0)).revolve(96)
        part = _placed(part, rng, 0.5)
        body = body + part if rng.random() < 0.8 else body - part
    return triangles(body)


def _simple(rng: np.random.Generator) -> m3.Manifold:
    kind = rng.integers(7)
    if kind <= 1:
        return m3.Manifold.cube(rng.uniform(0.3, 1.6, 3), True)
    if kind == 2:
        radius = rng.uniform(0.2, 0.7)
        return m3.Manifold.cylinder(rng.uniform(0.3, 1.8), radius, radius, 96, True)
    if kind == 3:
        low, high = rng.uniform(0.3, 0.8), rng.uniform(0, 0.3)
        return m3.Manifold.cylinder(rng.uniform(0.5, 1.6), low, high, 96, True)
    if kind == 4:
        return m3.Manifold.sphere(rng.uniform(0.3, 0.8), 96).scale(rng.uniform(0.7, 1.3, 3))
    if kind == 5:
        circle = m3.CrossSection.circle(rng.uniform(0.1, 0.3), 48)
        return circle.translate((rng.uniform(0.4, 0.8), 0)).revolve(96)
    corners = rng.integers(3, 10)
    angle = 2 * np.pi * (np.arange(corners) + rng.uniform(-0.3, 0.3, corners)) / corners
    ring = np.column_stack([np.cos(angle), np.sin(angle)]) * rng.uniform(0.35, 1, (corners, 1))
    height, twist, top = rng.uniform(0.2, 1.5), 0.0, 1.0
    if rng.random() < 0.4:
        twist, top = rng.choice([0.0, rng.uniform(-50, 50)]), rng.uniform(0.3, 1)
    return m3.CrossSection([ring]).extrude(height, 24 if twist else 0, twist, (top, top))


def _placed(part: m3.Manifold, rng: np.random.Generator, shift: float) -> m3.Manifold:
    if rng.random() < 0.5:
        part = part.rotate(rng.uniform(-180, 180, 3))
    return part.translate(rng.uniform(-shift, shift, 3))
