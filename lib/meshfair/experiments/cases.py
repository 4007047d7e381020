"""What the explorers still ask for by name: noise models, weights."""

import numpy as np

from meshfair import noise, weights
from meshfair.operators import averaging

WEIGHTS, NOISE = weights.BY_NAME, noise.MODELS


def add_noise(V, F, model, seed, *, size=None, decibels=None):
    """A noisy mesh, from a model's name and a whole number as seed.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    model : str
        One of `NOISE`.
    seed : int
        Seed of the random numbers; the same one gives the same noise.
    size : float, optional
        The model's own size: a fraction of the mean edge length, or for
        "uniform" the amplitude in units of length.
    decibels : float, optional
        Instead of ``size``: scale the noise to this SNR.

    Returns
    -------
    ndarray of float64, shape (n, 3)

    Raises
    ------
    ValueError
        An unknown model, or not exactly one of ``size`` and ``decibels``.
    """
    if model not in NOISE:
        raise ValueError(f"no noise model is called {model!r}; there are {', '.join(NOISE)}")
    if (size is None) == (decibels is None):
        raise ValueError("give the noise either a size or its decibels")
    rng = np.random.default_rng(seed)
    if decibels is None:
        return NOISE[model](V, F, size, rng)
    return noise.at_snr(V, NOISE[model](V, F, 1.0, rng) - V, decibels)


def operator(V, F, name):
    """The averaging operator of a mesh for weights by name.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    name : str
        One of `WEIGHTS`.

    Returns
    -------
    csr_array of float64, shape (n, n)

    Raises
    ------
    ValueError
        Unknown weights.
    """
    if name not in WEIGHTS:
        raise ValueError(f"no weights are called {name!r}; there are {', '.join(WEIGHTS)}")
    return averaging(WEIGHTS[name](V, F))
