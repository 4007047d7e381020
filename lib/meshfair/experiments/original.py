"""The original report's own experiments: the knot, Table 1, the jets.

The original report is "Denoising of Triangulated Meshes", a student's report of 2021
with which this package began; sections, figures and tables are those of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from importlib.resources import files
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.sparse import csr_array

from meshfair import flow, metrics
from meshfair.checks import Floats, Integers, check_choice, needed_for
from meshfair.experiments.meshes import load_noisy_mesh
from meshfair.experiments.sweep import sweep
from meshfair.operators import averaging
from meshfair.weights import BY_NAME, distance

if TYPE_CHECKING:
    import pandas as pd

TAU = 0.2  # time step (section 3)
TIME = 4.0  # the longest flow
KNOT_DECIBELS = 22.71  # SNR of the noisy knot in Figure 2
F16_DECIBELS = 22.7  # "similar initial noise values" (before Figure 5)


def stopping(
    mesh: str,
    noise: str,
    weights: str,
    seed: int,
    size: float | None = None,
    decibels: float | None = None,
    tau: float = TAU,
    time: float = TIME,
) -> dict[str, float]:
    """Best stopping time of one heat flow: a cell of Table 1, for `sweep`.

    Parameters
    ----------
    mesh : str
        A name for `meshfair.experiments.load_mesh`.
    noise : str
        One of `meshfair.noise.MODELS`.
    weights : str
        One of `meshfair.weights.BY_NAME`.
    seed : int
        Of the noise.
    size, decibels : float, optional
        One of them: how much noise, see `meshfair.noise.add`.
    tau, time : float
        Step and length of the flow.

    Returns
    -------
    dict
        noisy_snr and snr in decibels, the stopping time, gain in percent.

    Raises
    ------
    ValueError
        Weights that are none of these; as `meshfair.experiments.load_noisy_mesh`.
    """
    V_noisy, V, F = load_noisy_mesh(mesh, noise, seed, size=size, decibels=decibels)
    check_choice(weights, "weights", BY_NAME)
    best = flow.best_stopping(V_noisy, V, averaging(BY_NAME[weights](V_noisy, F)), tau, time)
    return {"noisy_snr": metrics.snr(V, V_noisy), **best._asdict()}


def curves(
    mesh: str,
    noise: str,
    seed: int,
    *,
    size: float | None = None,
    decibels: float | None = None,
    tau: float = TAU,
    time: float = TIME,
    angles: bool = False,
) -> pd.DataFrame:
    """SNR along the heat flow with each of the three weights (Figures 3 and 6).

    Weights are built once, from the noisy mesh.

    Parameters
    ----------
    mesh, noise, seed, size, decibels, tau, time
        As in `stopping`; ``tau=1`` is iterated averaging.
    angles : bool
        Measure the mean normal angle, vertex distance and volume too.

    Returns
    -------
    pandas.DataFrame
        A row for each weights and time: weights, time, snr, and with
        ``angles`` normal_angle (degrees), vertex_distance (mean edge
        lengths) and volume_change (a fraction).
    """
    with needed_for("an experiment"):
        import pandas as pd

    V_noisy, V, F = load_noisy_mesh(mesh, noise, seed, size=size, decibels=decibels)
    rows = []
    for name, build in BY_NAME.items():
        for t, V_t in flow.heat(V_noisy, averaging(build(V_noisy, F)), tau, time):
            row: dict[str, Any] = {"weights": name, "time": t, "snr": metrics.snr(V, V_t)}
            if angles:
                row["normal_angle"] = metrics.normal_angle(V_t, V, F)
                row["vertex_distance"] = metrics.vertex_distance(V_t, V, F)
                row["volume_change"] = metrics.volume_change(V_t, V, F)
            rows.append(row)
    return pd.DataFrame(rows)


def published_table_1() -> pd.DataFrame:
    """The original report's Table 1 as printed there.

    Returns
    -------
    pandas.DataFrame
        amplitude (of the uniform noise that gives the SNR; not in the original
        report), snr of the noisy mesh, weights, time, best_snr, gain in percent.
    """
    with needed_for("an experiment"):
        import pandas as pd

    return pd.read_csv(files("meshfair").joinpath("experiments/table1.csv"))


def table_1(
    draws: int = 20,
    executor: Executor | None = None,
    *,
    path: str | PathLike[str] | None = None,
    progress: bool = True,
) -> pd.DataFrame:
    """Table 1 with both noise models, each cell over several noise draws.

    "uniform" is the noise that the original report's figures were made with;
    "normals" is the noise that it defines, scaled to the same SNR.

    Parameters
    ----------
    draws : int
        Noise draws (seeds 0, 1, ...) a cell, at least 1.
    executor, path, progress
        As in `sweep`.

    Returns
    -------
    pandas.DataFrame
        A row for each noise, snr and weights: means and standard deviations
        over the draws of time, snr and gain (``time_mean``, ``time_std``,
        ...), the number of draws, and the original report's own figures
        (``original_time``, ``original_snr``, ``original_gain``).

    Raises
    ------
    ValueError
        No draws.
    RuntimeError
        A cell that failed.
    """
    with needed_for("an experiment"):
        import pandas as pd

    printed = published_table_1()
    amplitudes = dict(zip(printed["snr"], printed["amplitude"], strict=True))
    common = {
        "experiment": stopping, "mesh": "knot",
        "weights": tuple(BY_NAME), "seed": tuple(range(draws)),
    }  # fmt: skip
    parts = []
    for noise, axis, values in (
        ("uniform", "size", tuple(float(a) for a in amplitudes.values())),
        ("normals", "decibels", tuple(amplitudes)),
    ):
        grid = {**common, "noise": noise, axis: values}
        part = sweep(grid, executor, path=path, progress=progress, failures="raise")
        by_value = dict(zip(values, amplitudes, strict=True))
        parts.append(part.assign(row=part[axis].map(by_value)))
    rows = pd.concat(parts)
    table = rows.groupby(["noise", "row", "weights"])[["noisy_snr", "time", "snr", "gain"]].agg(
        ["mean", "std"]
    )
    table.columns = ["_".join(column) for column in table.columns]
    table["draws"] = draws
    printed = printed.rename(
        columns={
            "snr": "row",
            "time": "original_time",
            "best_snr": "original_snr",
            "gain": "original_gain",
        }
    )
    table = table.reset_index().merge(printed, on=["row", "weights"])
    order = {"noise": ["uniform", "normals"], "row": list(amplitudes), "weights": list(BY_NAME)}
    for column, ranked in order.items():
        table[column] = pd.Categorical(table[column], ranked, ordered=True)
    return table.sort_values(list(order), ignore_index=True).astype({"row": float})


def _inverted(W: csr_array) -> csr_array:
    W = W.copy()
    W.data = 1 / W.data
    return W


DISTANCE_READINGS: dict[str, Callable[[Floats, Integers], csr_array]] = {
    "w = |v_i - v_j|": lambda V, F: averaging(distance(V, F)),
    "w = |v_i - v_j|^2": lambda V, F: averaging(distance(V, F) ** 2),
    "w = 1 / |v_i - v_j|": lambda V, F: averaging(_inverted(distance(V, F))),
    "w = 1 / |v_i - v_j|^2": lambda V, F: averaging(_inverted(distance(V, F) ** 2)),
    "columns normalised": lambda V, F: averaging(distance(V, F)).T.tocsr(),
}
"""Averaging operators that "the distance" may have meant, by their formula."""


def distance_readings(draws: int = 5) -> pd.DataFrame:
    """Table 1's distance column under other readings of "the distance".

    The original report's distance column lies below what its formula gives.
    Here are other weights that one might have programmed, on the same meshes.

    Parameters
    ----------
    draws : int
        Noise draws a cell.

    Returns
    -------
    pandas.DataFrame
        reading, row (the original report's SNR), time, snr: means over the draws.
    """
    with needed_for("an experiment"):
        import pandas as pd

    levels = published_table_1()[["snr", "amplitude"]].drop_duplicates()
    rows = []
    for reading, build in DISTANCE_READINGS.items():
        for row, amplitude in levels.to_numpy():
            best = []
            for seed in range(draws):
                V_noisy, V, F = load_noisy_mesh("knot", "uniform", seed, size=amplitude)
                best.append(flow.best_stopping(V_noisy, V, build(V_noisy, F), TAU, TIME))
            time, snr, _ = np.mean(best, axis=0)
            rows.append({"reading": reading, "row": row, "time": time, "snr": snr})
    return pd.DataFrame(rows)


def knot_meshes(
    seed: int = 1, iterations: Sequence[int] = (1, 10)
) -> dict[tuple[str, int], Floats]:
    """The meshes of Figures 2 and 4: the noisy knot, and averaged by each weights.

    Parameters
    ----------
    seed : int
        Of the noise.
    iterations : sequence of int
        After how many of them.

    Returns
    -------
    dict
        ("noisy", 0) and (weights, s) -> ndarray of shape (1440, 3).
    """
    V_noisy, _, F = load_noisy_mesh("knot", "uniform", seed, decibels=KNOT_DECIBELS)
    meshes = {("noisy", 0): V_noisy}
    for name, build in BY_NAME.items():
        A = averaging(build(V_noisy, F))
        meshes |= {(name, s): flow.average(V_noisy, A, s) for s in iterations}
    return meshes
