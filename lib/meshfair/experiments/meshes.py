"""The experiments' meshes by name: as they are, and with noise."""

import hashlib
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache, partial
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from meshfair import datasets, io, noise, shapes
from meshfair.checks import Floats, Integers
from meshfair.experiments import specimens
from meshfair.experiments.specimens import Mesh

MESHES: dict[str, Callable[[], Mesh]] = {
    "knot": shapes.knot,
    "fine knot": partial(shapes.knot, 480, 48),
    "torus": shapes.torus,
    "sphere": shapes.icosphere,
    "large sphere": partial(shapes.icosphere, 6),
    "box": shapes.box,
    "jet": shapes.jet,
    "jet without missiles": partial(shapes.jet, missiles=False),
    "coarse jet": partial(shapes.jet, detail=0.5),
    "pulley": specimens.pulley,
    "plate": specimens.plate,
    "golf ball": specimens.golf_ball,
    "landscape": specimens.landscape,
    "boulder": specimens.boulder,
}
"""The built-in shapes that the experiments use, each as a function without arguments."""

_GIVEN: ContextVar[Mapping[str, Mesh]] = ContextVar("given", default=MappingProxyType({}))


class Pair(NamedTuple):
    """A mesh that is published both without noise and with it."""

    ground_truth: str
    """The name in `meshfair.datasets.SOURCES` of the one without noise."""
    noisy: str
    """The name there of the one with noise."""
    size: float
    """The noise of the noisy one, in mean edge lengths."""


PAIRS = {
    "fandisk": Pair("fandisk-clean", "fandisk-noisy", 0.3),
    "bunny pair": Pair("bunny-clean", "bunny-noisy", 0.2),
}


class NotDownloadedError(LookupError):
    """A real mesh that is not in the cache; the message says how to get it."""


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
    if name in (given := _GIVEN.get()):
        return given[name]
    if name in MESHES:
        return _built(name)
    path: Path | None
    if name in datasets.SOURCES:
        path = datasets.find(name)
        if path is None:
            raise NotDownloadedError(f"{name} is not downloaded; run: make data")
    elif Path(name).suffix:
        path = Path(name)
    else:
        known = ", ".join([*MESHES, *datasets.SOURCES])
        raise ValueError(f"no mesh is called {name!r}; there are {known}, or give a file's path")
    state = os.stat(path) if path.is_file() else None
    return _read(path, state and (state.st_mtime_ns, state.st_size))


@lru_cache(maxsize=16)
def _built(name: str) -> Mesh:
    return _read_only(*MESHES[name]())


@lru_cache(maxsize=16)
def _read(path: Path, state: tuple[int, int] | None) -> Mesh:
    """A file's mesh; ``state`` is that of the file, so that a changed one is read anew."""
    return _read_only(*io.read(path))


def _read_only(V: Floats, F: Integers) -> Mesh:
    V.flags.writeable = F.flags.writeable = False  # the cache hands them out again
    return V, F


def parts(name: str) -> tuple[str, ...]:
    """The meshes that a name stands for: one of `PAIRS` for two, any other for itself.

    Parameters
    ----------
    name : str

    Returns
    -------
    tuple of str
        Names for `load_mesh`.
    """
    return PAIRS[name][:2] if name in PAIRS else (name,)


@contextmanager
def given(meshes: Mapping[str, Mesh]) -> Iterator[None]:
    """Let `load_mesh` return these meshes for these names in this block.

    Parameters
    ----------
    meshes : dict of str to (V, F)
        As another process has loaded them, on whose files this one does not depend.
    """
    token = _GIVEN.set(meshes)
    try:
        yield
    finally:
        _GIVEN.reset(token)


def digest(mesh: Mesh) -> str:
    """What tells a mesh from any other: sha256 of its arrays, in hexadecimal.

    Parameters
    ----------
    mesh : (V, F)

    Returns
    -------
    str
    """
    V, F = mesh
    return hashlib.sha256(V.tobytes() + F.tobytes()).hexdigest()


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
