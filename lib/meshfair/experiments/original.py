"""The seed's own experiments: the knot, Table 1, the jets."""

from functools import cache
from importlib.resources import files

import numpy as np
import pandas as pd

from meshfair import flow, metrics, weights
from meshfair.checks import MeshError
from meshfair.experiments.cases import WEIGHTS, add_noise, load_mesh, operator
from meshfair.experiments.sweep import sweep
from meshfair.mesh import mean_edge_length
from meshfair.operators import averaging
from meshfair.shapes import jet_labels

TAU = 0.2  # the seed's time step (section 3)
TIME = 4.0  # and its longest flow
KNOT_DECIBELS = 22.71  # SNR of the noisy knot in the seed's Figure 2
F16_DECIBELS = 22.7  # "similar initial noise values" (the seed, before Figure 5)


def stopping(mesh, noise, weights, seed, size=None, decibels=None, tau=TAU, time=TIME):
    """Best stopping time of one heat flow: a cell of Table 1, for `sweep`.

    Parameters
    ----------
    mesh, noise, weights : str
        Names, see `meshfair.experiments.cases`.
    seed : int
    size, decibels : float, optional
        One of them: how much noise, see `meshfair.experiments.cases.add_noise`.
    tau, time : float
        Step and length of the flow.

    Returns
    -------
    dict
        noisy_snr and snr in decibels, the stopping time, gain in percent.
    """
    V, F = load_mesh(mesh)
    V_noisy = add_noise(V, F, noise, seed, size=size, decibels=decibels)
    best = flow.best_stopping(V_noisy, V, operator(V_noisy, F, weights), tau, time)
    return {"noisy_snr": metrics.snr(V, V_noisy), **best._asdict()}


def curves(mesh, noise, seed, *, size=None, decibels=None, tau=TAU, time=TIME, angles=False):
    """SNR along the heat flow with each of the three weights (Figures 3 and 6).

    Weights are built once, from the noisy mesh.

    Parameters
    ----------
    mesh, noise : str
    seed : int
    size, decibels, tau, time
        As in `stopping`; ``tau=1`` is iterated averaging.
    angles : bool
        Measure the mean normal angle, surface distance and volume too.

    Returns
    -------
    pandas.DataFrame
        A row for each weights and time: weights, time, snr, and with
        ``angles`` normal_angle (degrees), surface_distance (mean edge
        lengths) and volume_change (a fraction).
    """
    V, F = load_mesh(mesh)
    V_noisy = add_noise(V, F, noise, seed, size=size, decibels=decibels)
    rows = []
    for name in WEIGHTS:
        for t, V_t in flow.heat(V_noisy, operator(V_noisy, F, name), tau, time):
            row = {"weights": name, "time": t, "snr": metrics.snr(V, V_t)}
            if angles:
                row["normal_angle"] = metrics.normal_angle(V_t, V, F)
                row["surface_distance"] = metrics.surface_distance(V_t, V, F)
                row["volume_change"] = metrics.volume_change(V_t, V, F)
            rows.append(row)
    return pd.DataFrame(rows)


def published_table_1():
    """The seed's Table 1 as printed there.

    Returns
    -------
    pandas.DataFrame
        amplitude (of the uniform noise that gives the SNR; not in the seed), snr of
        the noisy mesh, weights, time, best_snr, gain in percent.
    """
    return pd.read_csv(files("meshfair").joinpath("experiments/table1.csv"))


def table_1(draws=20, executor=None, *, path=None, progress=True):
    """The seed's Table 1 with both noise models, each cell over several noise draws.

    "uniform" is the noise that the seed's figures were made with; "normals"
    is the noise that it defines, scaled to the same SNR.

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
        ...), the number of draws, and the seed's own figures (``original_time``,
        ``original_snr``, ``original_gain``).

    Raises
    ------
    ValueError
        No draws.
    RuntimeError
        A cell that failed, with its message.
    """
    printed = published_table_1()
    amplitudes = dict(zip(printed["snr"], printed["amplitude"], strict=True))
    common = {
        "experiment": stopping, "mesh": "knot",
        "weights": tuple(WEIGHTS), "seed": tuple(range(draws)),
    }  # fmt: skip
    parts = []
    for noise, axis, values in (
        ("uniform", "size", tuple(float(a) for a in amplitudes.values())),
        ("normals", "decibels", tuple(amplitudes)),
    ):
        part = sweep(
            {**common, "noise": noise, axis: values}, executor, path=path, progress=progress
        )
        _raise_failures(part)
        by_value = dict(zip(values, amplitudes, strict=True))
        parts.append(part.assign(row=part[axis].map(by_value)))
    rows = pd.concat(parts)
    table = rows.groupby(["noise", "row", "weights"])[["noisy_snr", "time", "snr", "gain"]].agg(
        ["mean", "std"]
    )
    table.columns = ["_".join(column) for column in table.columns]
    seed = printed.rename(
        columns={
            "snr": "row",
            "time": "original_time",
            "best_snr": "original_snr",
            "gain": "original_gain",
        }
    )
    table["draws"] = draws
    table = table.reset_index().merge(seed, on=["row", "weights"])
    order = {"noise": ["uniform", "normals"], "row": list(amplitudes), "weights": list(WEIGHTS)}
    for column, values in order.items():
        table[column] = pd.Categorical(table[column], values, ordered=True)
    return table.sort_values(list(order), ignore_index=True).astype({"row": float})


DISTANCE_READINGS = {
    "w = |v_i - v_j|": lambda V, F: averaging(weights.distance(V, F)),
    "w = |v_i - v_j|^2": lambda V, F: averaging(weights.distance(V, F) ** 2),
    "w = 1 / |v_i - v_j|": lambda V, F: averaging(_inverted(weights.distance(V, F))),
    "w = 1 / |v_i - v_j|^2": lambda V, F: averaging(_inverted(weights.distance(V, F) ** 2)),
    "columns normalised": lambda V, F: averaging(weights.distance(V, F)).T.tocsr(),
}


def _inverted(W):
    W = W.copy()
    W.data = 1 / W.data
    return W


def distance_readings(draws=5):
    """Table 1's distance column under other readings of "the distance".

    The seed's distance column lies below what its formula gives. Here are
    other weights that one might have programmed, on the same meshes.

    Parameters
    ----------
    draws : int
        Noise draws a cell.

    Returns
    -------
    pandas.DataFrame
        reading, row (the seed's SNR), time, snr: means over the draws.
    """
    V, F = load_mesh("knot")
    printed = published_table_1()
    rows = []
    for reading, build in DISTANCE_READINGS.items():
        for row, amplitude in printed[["snr", "amplitude"]].drop_duplicates().values:
            best = []
            for seed in range(draws):
                V_noisy = add_noise(V, F, "uniform", seed, size=amplitude)
                best.append(flow.best_stopping(V_noisy, V, build(V_noisy, F), TAU, TIME))
            time, snr, _ = np.mean(best, axis=0)
            rows.append({"reading": reading, "row": row, "time": time, "snr": snr})
    return pd.DataFrame(rows)


def knot_meshes(seed=1, steps=(1, 10)):
    """The meshes of Figures 2 and 4: the noisy knot, and averaged by each weights.

    Parameters
    ----------
    seed : int
    steps : sequence of int
        After how many iterations.

    Returns
    -------
    dict
        ("noisy", 0) and (weights, s) -> ndarray of shape (1440, 3).
    """
    V, F = load_mesh("knot")
    V_noisy = add_noise(V, F, "uniform", seed, decibels=KNOT_DECIBELS)
    meshes = {("noisy", 0): V_noisy}
    for name in WEIGHTS:
        A = operator(V_noisy, F, name)
        meshes |= {(name, s): flow.average(V_noisy, A, s) for s in steps}
    return meshes


@cache
def missile_vertices():
    """Which vertices of the jet belong to its missiles.

    Returns
    -------
    ndarray of bool, shape (n,), read-only
    """
    labels, names = jet_labels()
    missile = np.array(["missile" in name for name in names])[labels]
    missile.flags.writeable = False  # the cache hands it out again
    return missile


def part_errors(mesh, noise, seed, *, size=None, decibels=None, tau=TAU, time=TIME):
    """How far the jet's missiles and its other parts are from the clean ones.

    Parameters
    ----------
    mesh : str
        "jet", the one mesh whose parts are known.
    noise, seed, size, decibels, tau, time
        As in `curves`.

    Returns
    -------
    pandas.DataFrame
        weights, time, part ("missiles" or "aircraft"), error: the mean
        distance of the part's vertices from their clean places, in mean
        edge lengths.

    Raises
    ------
    MeshError
        A mesh without missiles.
    """
    if mesh != "jet":
        raise MeshError(f"{mesh!r} has no missiles that are known as such; give 'jet'")
    V, F = load_mesh(mesh)
    missile = missile_vertices()
    unit = mean_edge_length(V, F)
    V_noisy = add_noise(V, F, noise, seed, size=size, decibels=decibels)
    rows = []
    for name in WEIGHTS:
        for t, V_t in flow.heat(V_noisy, operator(V_noisy, F, name), tau, time):
            error = np.linalg.norm(V_t - V, axis=1) / unit
            for part, where in (("missiles", missile), ("aircraft", ~missile)):
                rows.append(
                    {"weights": name, "time": t, "part": part, "error": error[where].mean()}
                )
    return pd.DataFrame(rows)


def _raise_failures(table):
    if "error" in table and table["error"].notna().any():
        raise RuntimeError(f"a cell of the sweep failed: {table['error'].dropna().iloc[0]}")
