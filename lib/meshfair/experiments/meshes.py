"""The experiments' meshes by name: as they are, and with noise."""

from collections.abc import Callable
from functools import lru_cache, partial
from pathlib import Path

import numpy as np

from meshfair import datasets, io, noise, shapes
from meshfair.checks import Floats, Integers

MESHES: dict[str, Callable[[], tuple[Floats, Integers]]] = {
    "knot": shapes.knot,
    "fine knot": partial(shapes.knot, 480, 48),
    "torus": shapes.torus,
    "sphere": shapes.icosphere,
    "large sphere": partial(shapes.icosphere, 6),
    "box": shapes.box,
    "jet": shapes.jet,
    "jet without missiles": partial(shapes.jet, missiles=False),
}
"""The built-in shapes that the experiments use, each as a function without arguments."""


class NotDownloadedError(LookupError):
    """A real mesh that is not in the cache; the message says how to get it."""


@lru_cache(maxsize=16)
def load_mesh(name: str) -> tuple[Floats, Integers]:
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


def load_noisy_mesh(
    name: str,
    model: str,
    seed: int,
    *,
    size: float | None = None,
    decibels: float | None = None,
) -> tuple[Floats, Floats, Integers]:
    """A mesh by its name, with noise and without.

    Parameters
    ----------
    name : str
        As in `load_mesh`.
    model : str
        Noise model, one of `meshfair.noise.MODELS`.
    seed : int
        Of the random numbers; the same seed gives the same noise.
    size, decibels : float, optional
        One of them: how much noise, see `meshfair.noise.add`.

    Returns
    -------
    V_noisy, V_true : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)

    Raises
    ------
    NotDownloadedError, MeshError, ValueError
        As `load_mesh` and `meshfair.noise.add`.
    """
    V, F = load_mesh(name)
    rng = np.random.default_rng(seed)
    return noise.add(V, F, model, rng, size=size, decibels=decibels), V, F
