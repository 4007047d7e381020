"""Every filter on sharp and smooth meshes, with default, automatic and tuned parameters."""

from __future__ import annotations

import json
from collections.abc import Sequence
from concurrent.futures import Executor
from os import PathLike
from typing import TYPE_CHECKING, Any

from meshfair import denoising
from meshfair.checks import Floats, Integers
from meshfair.experiments.dispatch import Workers
from meshfair.experiments.meshes import PAIRS, load_mesh, load_noisy_mesh
from meshfair.experiments.missiles import JET, part_errors
from meshfair.experiments.sweep import sweep
from meshfair.metrics import compare

if TYPE_CHECKING:
    import pandas as pd

PARAMETERS = ("default", "auto", "tuned")


def noisy_pair(mesh: str, size: float, seed: int) -> tuple[Floats, Floats, Integers]:
    """A noisy mesh and its ground truth.

    Parameters
    ----------
    mesh : str
        A name for `meshfair.experiments.load_mesh`, or one of `PAIRS`, of which the
        noisy file is the public one.
    size : float
        Noise along the normals, as a fraction of the mean edge length; unused for a pair.
    seed : int
        Of the noise; unused for a pair.

    Returns
    -------
    V_noisy, V_true : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)

    Raises
    ------
    NotDownloadedError
        A mesh that ``make data`` has not fetched.
    """
    if mesh in PAIRS:
        (V, F), (V_noisy, _) = load_mesh(PAIRS[mesh].ground_truth), load_mesh(PAIRS[mesh].noisy)
        return V_noisy, V, F
    return load_noisy_mesh(mesh, "normals", seed, size=size)


def denoised(
    mesh: str, method: str, parameters: str, size: float, seed: int
) -> tuple[denoising.Denoised, Floats, Integers]:
    """One method on one noisy mesh.

    Parameters
    ----------
    mesh, size, seed
        As in `noisy_pair`.
    method : str
        One of `meshfair.denoising.methods`.
    parameters : {"default", "auto", "tuned"}
        Tuned ones are those that come closest to the ground truth on another draw of
        the noise, with seed + 1; here they only prove themselves.

    Returns
    -------
    result : meshfair.denoising.Denoised
    V_true : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    """
    V_noisy, V, F = noisy_pair(mesh, size, seed)
    if parameters == "tuned":
        name = PAIRS[mesh].ground_truth if mesh in PAIRS else mesh
        other, _, _ = load_noisy_mesh(name, "normals", seed + 1, size=size)
        chosen = denoising.tune(other, F, method, V).parameters
        return denoising.denoise(V_noisy, F, method, **chosen), V, F
    return denoising.denoise(V_noisy, F, method, parameters=parameters), V, F


def account(result: denoising.Denoised) -> dict[str, Any]:
    """How a result came about, as columns of a table.

    Parameters
    ----------
    result : meshfair.denoising.Denoised

    Returns
    -------
    dict
        used, the parameters as JSON, and seconds.
    """
    used = {name: value for name, value in result.parameters.items() if name != "fixed"}
    return {"used": json.dumps(used), "seconds": result.seconds}


def score(
    mesh: str, method: str, parameters: str, size: float, seed: int, keep_mesh: bool = False
) -> dict[str, Any]:
    """Every metric of one method on one noisy mesh; "none" leaves the mesh noisy.

    Parameters
    ----------
    mesh, method, parameters, size, seed
        As in `denoised`.
    keep_mesh : bool
        Return the denoised mesh, too.

    Returns
    -------
    dict
        The values of `meshfair.metrics.compare`; on the jet missile_error, see
        `meshfair.experiments.part_errors`; used, the parameters as JSON, and seconds; and
        with ``keep_mesh`` denoised, (V, F).
    """
    if method == "none":
        X, V, F = noisy_pair(mesh, size, seed)
        facts: dict[str, Any] = {"used": "{}", "seconds": 0.0}
    else:
        result, V, F = denoised(mesh, method, parameters, size, seed)
        X, facts = result.V, account(result)
    missiles = {"missile_error": part_errors(X, V, F)["missiles"]} if mesh == JET else {}
    metrics = {name: measure.value for name, measure in compare(X, F, V, F).items()}
    kept = {"denoised": (X, F)} if keep_mesh else {}
    return metrics | missiles | facts | kept


def quality(
    meshes: Sequence[str],
    size: float = 0.2,
    seed: int = 0,
    *,
    methods: Sequence[str] | None = None,
    executor: Executor | Workers | None = None,
    path: str | PathLike[str] | None = None,
    progress: bool = False,
) -> pd.DataFrame:
    """Every method on several meshes, with each way to choose parameters.

    Parameters
    ----------
    meshes : sequence of str
        As in `noisy_pair`.
    size : float
        Noise of the meshes that are not pairs.
    seed : int
        Of the noise.
    methods : sequence of str, optional
        All, if not given.
    executor, path, progress
        As in `meshfair.experiments.sweep`.

    Returns
    -------
    pandas.DataFrame
        mesh, size, seed, method, parameters, and what `score` returns; method "none"
        with parameters "default" is the noisy mesh.

    Raises
    ------
    RuntimeError
        A method failed; the message says which and why.
    """
    methods = denoising.methods() if methods is None else list(methods)
    grids = []
    for mesh in meshes:
        noise = PAIRS[mesh].size if mesh in PAIRS else size
        common = {"experiment": score, "mesh": mesh, "size": noise, "seed": seed}
        for which, ways in ((["none"], ["default"]), (methods, PARAMETERS)):
            grids.append(common | {"method": which, "parameters": ways})
    return sweep(grids, executor, path=path, progress=progress, failures="raise")
