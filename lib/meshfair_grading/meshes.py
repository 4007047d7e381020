"""Meshes that students have not seen: random ones, the same for the same seed."""

import numpy as np

from meshfair.checks import Floats, Integers
from meshfair.noise import gaussian
from meshfair.shapes import icosphere, torus


def unseen(seed: int, *, ring: bool = False, opened: bool = False) -> tuple[Floats, Integers]:
    """A small random mesh: stretched, bent, rough, turned, moved, its vertices shuffled.

    Some of its triangles are obtuse, so that some cotangent weights are
    negative, and no two of its vertices have the same neighbourhood.

    Parameters
    ----------
    seed : int
    ring : bool
        A deformed torus (180 vertices) instead of a sphere (162).
    opened : bool
        Cut about a fifth of it off, so that it has a boundary.

    Returns
    -------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
        Outward; every vertex is in a face.
    """
    rng = np.random.default_rng([seed, ring, opened])
    V, F = torus(sections=18, sides=10) if ring else icosphere(2)
    V = V * rng.uniform(0.6, 1.8, 3)
    direction, phase = rng.standard_normal((3, 3)), rng.uniform(0, 2 * np.pi, 3)
    V = V + 0.15 * np.sin(V @ direction + phase)
    V = gaussian(V, F, 0.12, rng)
    if opened:
        height = V[F].mean(axis=1)[:, 2]
        used, F = np.unique(F[height < np.quantile(height, 0.8)], return_inverse=True)
        V, F = V[used], F.reshape(-1, 3)
    return disguised(V, F, rng)[:2]


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
