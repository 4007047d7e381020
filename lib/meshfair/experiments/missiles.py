"""How far the jet's missiles are off: the fine detail that averaging takes for noise."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from meshfair import flow
from meshfair.checks import Booleans, Floats, Integers, needed_for
from meshfair.experiments.meshes import load_noisy_mesh
from meshfair.experiments.original import TAU, TIME
from meshfair.mesh import mean_edge_length
from meshfair.metrics import compare
from meshfair.operators import averaging
from meshfair.shapes import jet_labels
from meshfair.weights import BY_NAME

if TYPE_CHECKING:
    import pandas as pd

JET = "jet"  # the one mesh whose parts are known


@cache
def missile_vertices() -> Booleans:
    """Which vertices of the jet belong to its missiles.

    Returns
    -------
    ndarray of bool, shape (n,), read-only
    """
    labels, names = jet_labels()
    missile = np.array(["missile" in name for name in names])[labels]
    missile.flags.writeable = False  # the cache hands it out again
    return missile


def part_errors(V: Floats, V_true: Floats, F: Integers) -> dict[str, float]:
    """How far the jet's missiles and its other parts are from the ground truth.

    Parameters
    ----------
    V, V_true : ndarray of float64, shape (n, 3)
        A noisy or denoised jet, and the ground truth.
    F : ndarray of int64, shape (m, 3)

    Returns
    -------
    dict
        "missiles" and "aircraft" -> mean distance of the part's vertices from
        where they are in the ground truth, in mean edge lengths.
    """
    distance = np.linalg.norm(V - V_true, axis=1) / mean_edge_length(V_true, F)
    missile = missile_vertices()
    return {
        "missiles": float(distance[missile].mean()),
        "aircraft": float(distance[~missile].mean()),
    }


def part_error_curves(
    noise: str,
    seed: int,
    *,
    size: float | None = None,
    decibels: float | None = None,
    tau: float = TAU,
    time: float = TIME,
) -> pd.DataFrame:
    """The errors of the jet's parts along the heat flow with each of the three weights.

    Parameters
    ----------
    noise, seed, size, decibels, tau, time
        As in `meshfair.experiments.curves`.

    Returns
    -------
    pandas.DataFrame
        weights, time, part ("missiles" or "aircraft"), error as in `part_errors`.
    """
    with needed_for("an experiment"):
        import pandas as pd

    V_noisy, V, F = load_noisy_mesh(JET, noise, seed, size=size, decibels=decibels)
    rows = []
    for name, build in BY_NAME.items():
        for t, V_t in flow.heat(V_noisy, averaging(build(V_noisy, F)), tau, time):
            for part, error in part_errors(V_t, V, F).items():
                rows.append({"weights": name, "time": t, "part": part, "error": error})
    return pd.DataFrame(rows)


def averaging_for_missiles(
    size: float = 0.2, seed: int = 0, *, tau: float = TAU, time: float = TIME
) -> pd.DataFrame:
    """The three heat flows on the jet, each stopped when its missiles are best.

    Parameters
    ----------
    size, seed
        As in `meshfair.experiments.quality`, with the same noise.
    tau, time : float
        Step and longest time.

    Returns
    -------
    pandas.DataFrame
        weights, time, the values of `meshfair.metrics.compare`, and missile_error, the
        missiles' error as in `part_errors`.
    """
    with needed_for("an experiment"):
        import pandas as pd

    V_noisy, V, F = load_noisy_mesh(JET, "normals", seed, size=size)
    rows = []
    for name, build in BY_NAME.items():
        states = flow.heat(V_noisy, averaging(build(V_noisy, F)), tau, time)
        errors = ((part_errors(X, V, F)["missiles"], t, X) for t, X in states)
        error, best, X = min(errors, key=lambda state: state[0])
        found = {name: measure.value for name, measure in compare(X, F, V, F).items()}
        rows.append({"weights": name, "time": best} | found | {"missile_error": error})
    return pd.DataFrame(rows)
