"""Over several draws of the noise: the jet's missiles, and the knot."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from os import PathLike
from typing import TYPE_CHECKING, Any

from meshfair import denoising
from meshfair.experiments.choices import by_front, choice
from meshfair.experiments.missiles import JET, averaging_for_missiles, part_errors
from meshfair.experiments.quality import noisy_pair
from meshfair.experiments.sweep import sweep

if TYPE_CHECKING:
    import pandas as pd

DRAWS = 10
STOPPED = "averaging, stopped"


def missiles_of(mesh: str, size: float, seed: int, method: str, parameters: str) -> dict[str, Any]:
    """The errors of the jet's parts with one method, noise along the normals.

    Parameters
    ----------
    mesh : {"jet"}
    size, seed
        As in `meshfair.experiments.noisy_pair`.
    method : str
        "none"; "auto" for the front's own choice; one of `meshfair.denoising.methods`; or
        "averaging, stopped": of the three heat flows, each stopped where the missiles are best, the
        one that is best for them, which nobody can know without the ground truth.
    parameters : {"default", "auto"}

    Returns
    -------
    dict
        missiles and aircraft, as in `meshfair.experiments.part_errors`, and chosen, the method
        that made the result.
    """
    if method == STOPPED:
        flows = averaging_for_missiles(size, seed).set_index("weights")["missile_error"]
        return {"missiles": flows.min(), "chosen": flows.idxmin()}
    X, V, F = noisy_pair(mesh, size, seed)
    chosen = method
    if method != "none":
        result = by_front(X, F, method, parameters)
        X, chosen = result.V, result.method
    return part_errors(X, V, F) | {"chosen": chosen}


def missile_draws(
    draws: int = DRAWS,
    size: float = 0.2,
    *,
    methods: Sequence[str] | None = None,
    executor: Executor | None = None,
    path: str | PathLike[str] | None = None,
    progress: bool = False,
) -> pd.DataFrame:
    """The missiles' errors over several draws: averaging at its best, automatic filters, the front.

    Parameters
    ----------
    draws : int
        How many, with the seeds 0, 1, ...
    size : float
        Noise along the normals, in mean edge lengths.
    methods : sequence of str, optional
        Which run with default and with automatic parameters; all, if not given.
    executor, path, progress
        As in `meshfair.experiments.sweep`.

    Returns
    -------
    pandas.DataFrame
        mesh, size, seed, method, parameters, and what `missiles_of` returns.
    """
    methods = denoising.methods() if methods is None else list(methods)
    common = {"experiment": missiles_of, "mesh": JET, "size": size, "seed": list(range(draws))}
    grids = [
        common | {"method": ["none", STOPPED, "auto"], "parameters": "default"},
        common | {"method": methods, "parameters": ["default", "auto"]},
    ]
    return sweep(grids, executor, path=path, progress=progress, failures="raise")


def knot_draws(
    draws: int = DRAWS,
    sizes: Sequence[float] = (0.1, 0.2, 0.3),
    *,
    executor: Executor | None = None,
    path: str | PathLike[str] | None = None,
    progress: bool = False,
) -> pd.DataFrame:
    """The knot over several draws of noise along the normals: each default, and the front.

    Parameters
    ----------
    draws : int
        How many, with the seeds 0, 1, ...
    sizes : sequence of float
        Of the noise, in mean edge lengths.
    executor, path, progress
        As in `meshfair.experiments.sweep`.

    Returns
    -------
    pandas.DataFrame
        As `meshfair.experiments.compare_choices`.
    """
    grid = {
        "experiment": choice,
        "mesh": "knot",
        "kind": "normals",
        "size": list(sizes),
        "seed": list(range(draws)),
        "method": ["none", "auto", *denoising.methods()],
        "parameters": "default",
    }
    return sweep(grid, executor, path=path, progress=progress, failures="raise")
