"""What the experiments are made of, by name: meshes, noise models, weights."""

from functools import lru_cache, partial
from pathlib import Path

import numpy as np

from meshfair import datasets, io, noise, shapes, weights
from meshfair.operators import averaging

MESHES = {
    "knot": shapes.knot,
    "fine knot": partial(shapes.knot, 480, 48),
    "torus": shapes.torus,
    "sphere": shapes.icosphere,
    "large sphere": partial(shapes.icosphere, 6),
    "box": shapes.box,
    "jet": shapes.jet,
    "jet without missiles": partial(shapes.jet, missiles=False),
}

WEIGHTS, NOISE = weights.BY_NAME, noise.MODELS


class NotDownloadedError(LookupError):
    """A real mesh that is not in the cache; the message says how to get it."""


@lru_cache(maxsize=16)
def load_mesh(name):
    """A mesh by its name: a built-in shape, a downloaded mesh, or a file.

    Parameters
    ----------
    name : str
        One of `MESHES`, one of `meshfair.datasets.SOURCES`, or a path.

    Returns
    -------
    V : ndarray of float64, shape (n, 3), read-only
    F : ndarray of int64, shape (m, 3), read-only

    Raises
    ------
    NotDownloadedError
        A real mesh that ``make data`` has not fetched.
    MeshError
        A file that is no mesh.
    ValueError
        A name that is none of these.
    """
    if name in MESHES:
        V, F = MESHES[name]()
    elif name in datasets.SOURCES:
        path = datasets.find(name)
        if path is None:
            raise NotDownloadedError(f"{name} is not downloaded; run: make data")
        V, F = io.read(path)
    elif Path(name).suffix:
        V, F = io.read(name)
    else:
        known = ", ".join([*MESHES, *datasets.SOURCES])
        raise ValueError(f"no mesh is called {name!r}; there are {known}, or give a file's path")
    V.flags.writeable = F.flags.writeable = False  # the cache hands them out again
    return V, F


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
