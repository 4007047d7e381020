"""The grid that choices are judged by: shapes, kinds and sizes of noise, every method."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from itertools import product
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from meshfair import datasets, denoising, noise
from meshfair.checks import Floats, Integers, check_choice
from meshfair.experiments.meshes import PAIRS, load_mesh
from meshfair.experiments.quality import PARAMETERS, account, noisy_pair
from meshfair.experiments.sweep import sweep
from meshfair.mesh import mean_edge_length
from meshfair.metrics import normal_angle, snr, vertex_distance

if TYPE_CHECKING:
    import pandas as pd

SHAPES = (
    "box", "pulley", "plate", "torus", "golf ball", "landscape", "boulder", "knot", "coarse jet",
)  # fmt: skip
"""Names for `meshfair.experiments.load_mesh`: three sharp shapes, six with curved parts."""

SIZES = (0.1, 0.2, 0.4, 0.6)
"""Standard deviations of the noise, in mean edge lengths."""

PUBLISHED_NOISE = "published"
"""The kind of noise of a public pair: that of its noisy file."""


def _uniform(V: Floats, F: Integers, sigma: float, rng: np.random.Generator) -> Floats:
    """Uniform noise in each coordinate, of this standard deviation and of mean zero."""
    amplitude = np.sqrt(12) * sigma * mean_edge_length(V, F)
    return noise.uniform(V, amplitude, rng) - amplitude / 2


def _impulsive(V: Floats, F: Integers, sigma: float, rng: np.random.Generator) -> Floats:
    """Noise on half of the vertices."""
    return noise.impulsive(V, F, sigma, 0.5, rng)


KINDS: dict[str, Callable[[Floats, Integers, float, np.random.Generator], Floats]] = {
    "normals": noise.along_normals,
    "gaussian": noise.gaussian,
    "uniform": _uniform,
    "impulsive": _impulsive,
    "correlated": noise.correlated,
}
"""Kinds of noise, as functions of V, F, the size and the generator; all have mean zero."""


def conditions() -> list[tuple[str, str, float]]:
    """All noisy meshes of the grid; the public pairs are last, where they are downloaded.

    Returns
    -------
    list of (mesh, kind, size)
        For `noisy_mesh`.
    """
    found = list(product(SHAPES, KINDS, SIZES))
    for mesh, pair in PAIRS.items():
        if datasets.find(pair.ground_truth) and datasets.find(pair.noisy):
            found.append((mesh, PUBLISHED_NOISE, pair.size))
    return found


def noisy_mesh(mesh: str, kind: str, size: float, seed: int) -> tuple[Floats, Floats, Integers]:
    """A noisy mesh of the grid, and its ground truth.

    Parameters
    ----------
    mesh : str
        A name for `meshfair.experiments.load_mesh`, or one of
        `meshfair.experiments.PAIRS`, whose kind is "published".
    kind : str
        One of `KINDS`, or "published".
    size : float
        Standard deviation of the noise, in mean edge lengths; unused for a pair.
    seed : int
        Of the noise, together with its kind and size; unused for a pair.

    Returns
    -------
    V_noisy, V_true : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)

    Raises
    ------
    NotDownloadedError, ValueError
        A mesh that ``make data`` has not fetched; no such mesh or kind.
    """
    if mesh in PAIRS:
        check_choice(kind, f"kind (of {mesh})", (PUBLISHED_NOISE,))
        return noisy_pair(mesh, size, seed)
    check_choice(kind, "kind", KINDS)
    V, F = load_mesh(mesh)
    rng = np.random.default_rng([seed, list(KINDS).index(kind), round(1000 * size)])
    return KINDS[kind](V, F, size, rng), V, F


def choice(
    mesh: str, kind: str, size: float, seed: int, method: str, parameters: str
) -> dict[str, Any]:
    """One method on one noisy mesh of the grid: an experiment for `meshfair.experiments.sweep`.

    Parameters
    ----------
    mesh, kind, size, seed
        As in `noisy_mesh`.
    method, parameters
        As in `outcome`.

    Returns
    -------
    dict
        As `outcome`.
    """
    return outcome(*noisy_mesh(mesh, kind, size, seed), method, parameters)


def by_front(V: Floats, F: Integers, method: str, parameters: str) -> denoising.Denoised:
    """Denoise as a user does who names a method, or with "auto" neither method nor parameters.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    method : str
        "auto", or one of `meshfair.denoising.methods`.
    parameters : {"default", "auto"}

    Returns
    -------
    meshfair.denoising.Denoised
    """
    if method == "auto":
        return denoising.denoise(V, F)
    return denoising.denoise(V, F, method, parameters=parameters)


def outcome(
    V_noisy: Floats, V: Floats, F: Integers, method: str, parameters: str
) -> dict[str, Any]:
    """What a method makes of a noisy mesh; "none" leaves it as it is.

    Parameters
    ----------
    V_noisy, V : ndarray of float64, shape (n, 3)
        The noisy mesh and the ground truth.
    F : ndarray of int64, shape (m, 3)
    method : str
        "none", or as in `by_front`.
    parameters : {"default", "auto", "tuned"}
        Tuned ones come closest to the ground truth of this very mesh: what the method
        can do at best.

    Returns
    -------
    dict
        normal_angle (degrees), snr (decibels), vertex_distance (mean edge lengths), chosen, the
        method that made the result, strength, the part of the way that was gone, used, its
        parameters as JSON, and seconds.
    """
    X, facts = V_noisy, {"chosen": method, "strength": 1.0, "used": "{}", "seconds": 0.0}
    if method != "none":
        if parameters == "tuned":
            result = denoising.tune(V_noisy, F, method, V)
        else:
            result = by_front(V_noisy, F, method, parameters)
        part = result.parameters.get("strength", 1.0)
        X, facts = result.V, {"chosen": result.method, "strength": part} | account(result)
    return {
        "normal_angle": normal_angle(X, V, F),
        "snr": snr(V, X),
        "vertex_distance": vertex_distance(X, V, F),
    } | facts


def compare_choices(
    cells: Sequence[tuple[str, str, float]] | None = None,
    seed: int = 0,
    *,
    methods: Sequence[str] | None = None,
    executor: Executor | None = None,
    path: str | PathLike[str] | None = None,
    progress: bool = False,
) -> pd.DataFrame:
    """Every method with each way to choose parameters, and the front's own choice, on the grid.

    Parameters
    ----------
    cells : sequence of (mesh, kind, size), optional
        All of `conditions`, if not given.
    seed : int
        Of the noise.
    methods : sequence of str, optional
        All, if not given.
    executor, path, progress
        As in `meshfair.experiments.sweep`.

    Returns
    -------
    pandas.DataFrame
        mesh, kind, size, seed, method, parameters, and what `choice` returns. Method "none" is
        the noisy mesh, and "auto" the front's own choice, both with parameters "default".

    Raises
    ------
    RuntimeError
        A method failed; the message says which and why.
    """
    methods = denoising.methods() if methods is None else list(methods)
    grids: list[dict[str, Any]] = []
    for mesh, kind, size in conditions() if cells is None else cells:
        common = {"experiment": choice, "mesh": mesh, "kind": kind, "size": size, "seed": seed}
        for which, ways in ((["none", "auto"], ["default"]), (methods, PARAMETERS)):
            grids.append(common | {"method": which, "parameters": ways})
    return sweep(grids, executor, path=path, progress=progress, failures="raise")
