"""Relief that filters take for noise: dimples, strokes, knurls, ripples, lattices of bumps."""

from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from meshfair import mesh
from meshfair.checks import Floats, Integers

Relief = Callable[[Floats, Floats, float, np.random.Generator], Floats]


def with_relief(make: Relief, V: Floats, F: Integers, rng: np.random.Generator) -> Floats:
    """Positions with a relief along the normals, on all of the surface or a part of it.

    Parameters
    ----------
    make : function
        One of this module's: from positions, normals, and the mean edge, to heights.
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    rng : numpy.random.Generator
    """
    N, edge = mesh.vertex_normals(V, F), mesh.mean_edge_length(V, F)
    height = make(V, N, edge, rng)
    if rng.random() < 0.3:
        k = rng.normal(size=3)
        height *= V @ k > np.quantile(V @ k, rng.uniform(0.2, 0.6))
    return V + height[:, None] * N


def with_any_relief(V: Floats, F: Integers, rng: np.random.Generator) -> Floats:
    """Positions with one of this module's reliefs, see `with_relief`."""
    return with_relief(RELIEFS[rng.integers(len(RELIEFS))], V, F, rng)


def dimples(V: Floats, N: Floats, edge: float, rng: np.random.Generator) -> Floats:
    """Dents or knobs of one size, at about equal distances."""
    distance = edge * _between(2.5, 10, rng)
    radius = distance * rng.uniform(0.3, 0.6)
    near, _ = cKDTree(V[_apart(V, distance, rng)]).query(V)
    near = np.minimum(near / radius, 1)
    profile = [np.cos(np.pi / 2 * near) ** 2, np.sqrt(1 - near**2), 1.0 * (near < 0.95)]
    return rng.choice([-1, 1]) * _between(0.1, 0.8, rng) * radius * profile[rng.integers(3)]


def strokes(V: Floats, N: Floats, edge: float, rng: np.random.Generator) -> Floats:
    """Short grooves or ribs in a few directions, as writing has them."""
    distance, width = edge * _between(4, 14, rng), edge * _between(0.7, 3, rng)
    directions = rng.normal(size=(3, 3))
    depth = np.zeros(len(V))
    tree, sharp = cKDTree(V), rng.random() < 0.5
    for centre in _apart(V, distance, rng):
        for _ in range(rng.integers(1, 4)):
            along = directions[rng.integers(3)]
            along = along - N[centre] * (along @ N[centre])
            across = np.cross(N[centre], along / np.linalg.norm(along))
            middle = V[centre] + rng.uniform(-0.3, 0.3) * distance * across
            near = tree.query_ball_point(middle, distance * rng.uniform(0.4, 0.7))
            d = np.abs((V[near] - middle) @ across) / (width / 2)
            depth[near] = np.maximum(depth[near], d < 1 if sharp else np.maximum(1 - d, 0))
    return rng.choice([-1, -1, 1]) * _between(0.15, 0.9, rng) * width * depth


def knurls(V: Floats, N: Floats, edge: float, rng: np.random.Generator) -> Floats:
    """Two waves that cross: their product, or the higher one."""
    one, other = _wave(V, edge, rng), _wave(V, edge, rng)
    width = edge * rng.uniform(0.1, 0.6)
    return width * (one * other if rng.random() < 0.5 else np.maximum(np.abs(one), np.abs(other)))


def ripples(V: Floats, N: Floats, edge: float, rng: np.random.Generator) -> Floats:
    """One wave, round or sharp along its crests."""
    wave = _wave(V, edge, rng)
    return edge * _between(0.1, 1, rng) * (wave if rng.random() < 0.6 else np.abs(wave))


def lattices(V: Floats, N: Floats, edge: float, rng: np.random.Generator) -> Floats:
    """Bumps and dents that repeat in two or three directions: waves of one length, 2 to 5 edges."""
    length, count = edge * _between(2, 5, rng), int(rng.integers(2, 4))
    ways = rng.normal(size=(count, 3))
    if rng.random() < 0.5:
        ways = np.linalg.qr(ways.T)[0].T
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    waves = np.sin(2 * np.pi * V @ ways.T / length + rng.uniform(0, 2 * np.pi, count))
    bumps = waves.prod(axis=1) if rng.random() < 0.5 else waves.mean(axis=1)
    return edge * _between(0.15, 1, rng) * bumps


def _wave(V: Floats, edge: float, rng: np.random.Generator) -> Floats:
    """A sine of 3 to 12 edges, along a direction, or round a point."""
    length, k = edge * _between(3, 12, rng), rng.normal(size=3)
    if rng.random() < 0.7:
        way = V @ (k / np.linalg.norm(k))
    else:
        way = np.linalg.norm(V - V.mean(axis=0) - k * V.std(axis=0), axis=1)
    return np.sin(2 * np.pi * way / length + rng.uniform(0, 2 * np.pi))


def _apart(V: Floats, distance: float, rng: np.random.Generator) -> Integers:
    """Vertices, none of them nearer to another than this, and no place left for more."""
    free, found, tree = np.ones(len(V), bool), [], cKDTree(V)
    for vertex in rng.permutation(len(V)):
        if free[vertex]:
            found.append(vertex)
            free[tree.query_ball_point(V[vertex], distance)] = False
    return np.array(found)


def _between(low: float, high: float, rng: np.random.Generator) -> float:
    """A number whose logarithm is uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


RELIEFS = dimples, strokes, knurls, ripples
"""Those on shapes that the learned filter was trained on."""
