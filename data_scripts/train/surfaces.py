"""Smooth surfaces and rounded solids, as level sets of functions of space."""

import numpy as np
from arrays import Mesh
from skimage.measure import marching_cubes
from waves import waves

from meshfair.checks import Floats

HALF = 1.5  # the level sets lie in a cube of twice this


def blobs(rng: np.random.Generator, cells: int) -> Mesh:
    """Some Gaussian blobs that flow into each other."""
    P = _grid(cells)
    f = np.zeros(P.shape[:3])
    for _ in range(rng.integers(2, 14)):
        centre, size = rng.uniform(-0.8, 0.8, 3), rng.uniform(0.1, 0.5)
        f += np.exp(-(((P - centre) * rng.uniform(0.5, 1.3, 3)) ** 2).sum(-1) / (2 * size**2))
    f += rng.uniform(0, 0.12) * waves(P, rng.uniform(3, 9), rng)
    return _level_set(rng.uniform(0.3, 0.55) - f)


def rounded(rng: np.random.Generator, cells: int) -> Mesh:
    """Boxes, cylinders and spheres with fillets, joined by or cut out with soft creases."""
    P = _grid(cells)
    f = _distance(P, rng, 0.15)
    for _ in range(rng.integers(0, 4)):
        other = _distance(P, rng, 0.6)
        soft = rng.choice([0.001, rng.uniform(0.02, 0.25)])
        if rng.random() < 0.35:
            f = -_soft_minimum(-f, other, soft)
        else:
            f = _soft_minimum(f, other, soft)
    return _level_set(f)


def sheets(rng: np.random.Generator, cells: int) -> Mesh:
    """The zero set of a random sum of waves: saddles and necks everywhere, open at a sphere."""
    P = _grid(cells)
    f = waves(P, rng.uniform(2, 4.5), rng)
    outside = np.linalg.norm(P, axis=-1) - rng.uniform(0.9, 1.3)
    return _level_set(_soft_maximum(f * 0.15, outside, 0.02))


def _grid(cells: int) -> Floats:
    x = np.linspace(-HALF, HALF, cells)
    return np.stack(np.meshgrid(x, x, x, indexing="ij"), axis=-1)


def _distance(P: Floats, rng: np.random.Generator, shift: float) -> Floats:
    """The signed distance to a box, a cylinder or an ellipsoid, rounded, somewhere."""
    Q = (P - rng.uniform(-shift, shift, 3)) @ np.linalg.qr(rng.normal(size=(3, 3)))[0]
    radius, kind = rng.uniform(0, 0.2), rng.integers(4)
    size = rng.uniform(0.15, 0.9, 3)
    if kind == 0:
        return (np.linalg.norm(Q / size, axis=-1) - 1) * size.min()
    if kind == 1:
        across = np.linalg.norm(Q[..., :2], axis=-1) - size[0]
        q = np.stack([across, np.abs(Q[..., 2]) - size[2]], axis=-1) + radius
    else:
        q = np.abs(Q) - size + radius
    return np.linalg.norm(np.maximum(q, 0), axis=-1) + np.minimum(q.max(axis=-1), 0) - radius


def _soft_minimum(f: Floats, g: Floats, width: float) -> Floats:
    h = np.maximum(width - np.abs(f - g), 0) / width
    return np.minimum(f, g) - h**2 * width / 4


def _soft_maximum(f: Floats, g: Floats, width: float) -> Floats:
    return -_soft_minimum(-f, -g, width)


def _level_set(f: Floats) -> Mesh:
    """The surface f = 0 around where f is negative; empty where there is none."""
    step = 2 * HALF / (len(f) - 1)
    closed = np.pad(f[1:-1, 1:-1, 1:-1], 1, constant_values=np.abs(f).max())
    if closed.min() >= 0:
        return np.empty((0, 3)), np.empty((0, 3), np.int64)
    V, F, _, _ = marching_cubes(closed, 0, spacing=(step,) * 3, gradient_direction="descent")
    return V.astype(float) - HALF, F.astype(np.int64)
