"""Random functions of space, of one size and one coarseness."""

import numpy as np

from meshfair.checks import Floats

COUNT = 8


def waves(P: Floats, frequency: float, rng: np.random.Generator) -> Floats:
    """Sines along random directions, about this frequency; their sum has mean 0, variance 1.

    Parameters
    ----------
    P : ndarray of float64, shape (..., 3)
        Points.
    frequency : float
        Radians per unit of length.
    rng : numpy.random.Generator

    Returns
    -------
    ndarray of float64, shape (...)
    """
    f = np.zeros(P.shape[:-1])
    for _ in range(COUNT):
        k = rng.normal(size=3)
        k *= frequency * rng.uniform(0.5, 1.2) / np.linalg.norm(k)
        f += np.sin(P @ k + rng.uniform(0, 2 * np.pi))
    return f * np.sqrt(2 / COUNT)
