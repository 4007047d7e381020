"""Smooth surfaces on regular grids, often coarse, their cells cut along either diagonal."""

import numpy as np
from arrays import Mesh

from meshfair.checks import Floats, Integers


def grid(rng: np.random.Generator) -> Mesh:
    """A bent torus or ellipsoid, or an open sheet; cells up to four times as long as wide."""
    kind = rng.integers(5)
    sides = int(np.exp(rng.uniform(np.log(7), np.log(40))))
    faces = np.exp(rng.uniform(np.log(500), np.log(4000)))
    along = max(8, int(faces / 2 / sides))
    u, v = np.meshgrid(np.arange(along) / along, np.arange(sides) / sides, indexing="ij")
    if kind <= 2:  # a long or a short tube
        F = _cells(along, sides, True, True, rng)
        major = np.clip(along / sides * rng.uniform(0.5, 2), 1.3, 8)
        r = major + np.cos(2 * np.pi * v)
        V = [r * np.cos(2 * np.pi * u), r * np.sin(2 * np.pi * u), np.sin(2 * np.pi * v)]
        bend = rng.uniform(0, 2.5)
    elif kind == 3:  # open at both poles
        F = _cells(along, sides, False, True, rng)
        angle = np.pi * (0.05 + 0.9 * u * along / (along - 1))
        length = rng.uniform(0.6, 3)
        V = [np.sin(angle) * np.cos(2 * np.pi * v), np.sin(angle) * np.sin(2 * np.pi * v)]
        V.append(length * np.cos(angle))
        bend = rng.uniform(0, 0.3)
    else:
        F = _cells(along, sides, False, False, rng)
        width = rng.uniform(3, 10)
        V = [width * along / sides * u, width * v, 0 * u]
        bend = rng.uniform(0.1, 0.7)
    P = np.stack(V, axis=-1).reshape(-1, 3)
    return _bent(P, bend, rng), F


def _cells(n: int, k: int, round_n: bool, round_k: bool, rng: np.random.Generator) -> Integers:
    """Two triangles a cell of a grid of n x k vertices, closed along the axes that are round."""
    i, j = np.divmod(np.arange(n * k), k)
    inside = (round_n | (i < n - 1)) & (round_k | (j < k - 1))
    i, j = i[inside], j[inside]
    a, b = k * i + j, k * ((i + 1) % n) + j
    c, d = k * ((i + 1) % n) + (j + 1) % k, k * i + (j + 1) % k
    ways = np.stack([a, b, c, a, c, d], axis=1), np.stack([a, b, d, b, c, d], axis=1)
    other = rng.random(len(a)) < rng.choice([0.0, 1.0, 0.5])
    return np.where(other[:, None], ways[1], ways[0]).reshape(-1, 3)


def _bent(P: Floats, size: float, rng: np.random.Generator) -> Floats:
    """Space bent by a few waves that are longer than what is bent is thick."""
    for _ in range(3):
        k = rng.normal(size=3)
        k *= rng.uniform(0.2, 0.8) / np.linalg.norm(k)
        P = P + size * rng.normal(size=3) * np.sin(P @ k + rng.uniform(0, 6.3))[:, None]
    return P
