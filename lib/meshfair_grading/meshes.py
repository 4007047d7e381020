"""Meshes that students have not seen: random ones, the same for the same seed."""

import numpy as np
from scipy.spatial import ConvexHull

from meshfair.checks import Floats, Integers
from meshfair.noise import gaussian
from meshfair.shapes import torus


def unseen(seed: int, *, ring: bool = False, opened: bool = False) -> tuple[Floats, Integers]:
    """A small random mesh: stretched, bent, rough, turned, moved, its vertices shuffled.

    Some of its triangles are obtuse, so that some cotangent weights are
    negative, and no two of its vertices have the same neighbourhood. Every
    seed has another number of vertices, which no file can know.

    Parameters
    ----------
    seed : int
    ring : bool
        A deformed torus (140 to 200 vertices) instead of a sphere (130 to 190).
    opened : bool
        Cut about a fifth of it off, so that it has a boundary.

    Returns
    -------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
        Outward; every vertex is in a face.
    """
    rng = np.random.default_rng([seed, ring, opened])
    if ring:
        sides = int(rng.integers(7, 13))
        V, F = torus(sections=int(rng.integers(140, 201)) // sides, sides=sides)
    else:
        V, F = sphere(int(rng.integers(130, 191)), rng)
    V = V * rng.uniform(0.6, 1.8, 3)
    direction, phase = rng.standard_normal((3, 3)), rng.uniform(0, 2 * np.pi, 3)
    V = V + 0.15 * np.sin(V @ direction + phase)
    V = gaussian(V, F, 0.12, rng)
    if opened:
        height = V[F].mean(axis=1)[:, 2]
        used, F = np.unique(F[height < np.quantile(height, 0.8)], return_inverse=True)
        V, F = V[used], F.reshape(-1, 3)
    return disguised(V, F, rng)[:2]


def sphere(n: int, rng: np.random.Generator) -> tuple[Floats, Integers]:
    """The unit sphere with any number of vertices, spread irregularly but evenly.

    Parameters
    ----------
    n : int
        Number of vertices.
    rng : numpy.random.Generator

    Returns
    -------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (2 n - 4, 3)
        Outward.
    """
    place = np.arange(n) + 0.5
    z, angle = 1 - 2 * place / n, place * np.pi * (3 - 5**0.5)  # a spiral
    radius = np.sqrt(1 - z**2)
    V = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])
    V = _on_sphere(V + 0.6 / np.sqrt(n) * rng.standard_normal((n, 3)))
    for _ in range(10):  # like charges, that push each other away
        between = V[:, None] - V
        cubes = ((between**2).sum(axis=2) + np.eye(n)) ** 1.5
        V = _on_sphere(V + 0.3 / n**1.5 * (between / cubes[:, :, None]).sum(axis=1))
    F = ConvexHull(V).simplices.astype(np.int64)
    a, b, c = V[F[:, 0]], V[F[:, 1]], V[F[:, 2]]
    inward = (np.cross(b - a, c - a) * a).sum(axis=1) < 0
    F[inward] = F[inward, ::-1]
    return V, F


def tower(rng: np.random.Generator) -> tuple[Floats, Integers]:
    """A closed tower of rings with a random number of vertices (22 to 98) and no obtuse angle.

    Parameters
    ----------
    rng : numpy.random.Generator

    Returns
    -------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (2 n - 4, 3)
        Outward.
    """
    sides, rings = rng.integers((5, 4), (9, 13))
    turn = np.arange(rings)[:, None] / 2 + np.arange(sides)  # each ring half a step further
    angle = (2 * np.pi / sides * turn).ravel()
    edge = 2 * np.sin(np.pi / sides)
    height = np.repeat(0.87 * edge * np.arange(rings), sides)
    walls = np.column_stack([np.cos(angle), np.sin(angle), height])
    V = np.concatenate([walls, [[0, 0, -0.4], [0, 0, height[-1] + 0.4]]])
    V += 0.05 * edge * rng.standard_normal(V.shape)
    a = np.arange(sides * rings).reshape(rings, sides)
    b = np.roll(a, -1, axis=1)
    bottom, top = np.full(sides, sides * rings), np.full(sides, sides * rings + 1)
    triangles = [
        (a[:-1], b[:-1], a[1:]), (b[:-1], b[1:], a[1:]),
        (bottom, b[0], a[0]), (top, a[-1], b[-1]),
    ]  # fmt: skip
    F = np.concatenate([np.column_stack([np.ravel(x) for x in corners]) for corners in triangles])
    return V, F.astype(np.int64)


def _on_sphere(V: Floats) -> Floats:
    return V / np.linalg.norm(V, axis=1, keepdims=True)


def disguised(
    V: Floats, F: Integers, rng: np.random.Generator
) -> tuple[Floats, Integers, Integers]:
    """The same surface elsewhere in space, with vertices and faces in another order.

    Parameters
    ----------
    V : ndarray, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    rng : numpy.random.Generator

    Returns
    -------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    order : ndarray of int64, shape (n,)
        Where each of the new vertices was before.
    """
    Q, R = np.linalg.qr(rng.standard_normal((3, 3)))
    Q = Q * np.sign(np.diag(R))
    Q[:, 0] *= np.linalg.det(Q)  # a rotation: the faces stay outward
    order = rng.permutation(len(V))
    new_index = np.argsort(order)
    F = new_index[F[rng.permutation(len(F))]]
    corner = (np.arange(3) + rng.integers(3, size=(len(F), 1))) % 3
    V = (V @ Q.T + rng.uniform(-3, 3, 3))[order]
    return V, np.take_along_axis(F, corner, axis=1), order
