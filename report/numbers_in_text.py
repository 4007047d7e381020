"""Every number that the report's text names, computed from the experiments' tables."""

import pandas as pd

import grid_results
import numbers_of_learning
from meshfair import _fast, shapes
from meshfair.checks import Floats
from meshfair.denoising import estimate_noise
from meshfair.experiments import PAIRS, load_mesh, noisy_pair
from meshfair.experiments.original import F16_DECIBELS, KNOT_DECIBELS, TAU, TIME
from meshfair.mesh import Edges, components, mean_edge_length, unique_faces
from tables import BUNNY_STEPS, JET_NOISE, JET_TIMES, QUALITY_NOISE, SEED

Tables = dict[str, pd.DataFrame]
Texts = dict[str, str]

SHORT = {"combinatorial": "comb", "distance": "dist", "cotangent": "cot"}


def numbers(data: Tables) -> dict[str, str | bool]:
    """Format the numbers of the text.

    Parameters
    ----------
    data : dict of str to pandas.DataFrame
        The experiments' tables by name, some of which may be missing, and those of
        ``report/results``, which ``make bench``, ``make grid`` and ``make train`` have written.

    Returns
    -------
    dict of str to str or bool
        What ``#n("key")`` in report.typ stands for. Keys under ``has-`` tell
        which of the optional experiments there are.
    """
    found: dict[str, str | bool] = {
        "tau": f"{TAU:g}",
        "time": f"{TIME:g}",
        "knot-decibels": f"{KNOT_DECIBELS:g}",
        "f16-decibels": f"{F16_DECIBELS:g}",
        "jet-size": f"{JET_NOISE['size']:g}",
        "bunny-shown": str(BUNNY_STEPS),
    }
    found |= {f"jet-{when}": f"{time:g}" for when, time in JET_TIMES.items()}
    for name in ("f16", "bunny"):
        found[f"has-{name}"] = name in data
    found["has-pairs"] = set(PAIRS) <= set(data["quality"]["mesh"])
    for part in (
        _performance,
        _meshes,
        _table_1,
        _knot,
        _spectrum,
        _jets,
        _large,
        _reduction,
        _origin_shift,
        _agreement,
        _quality,
        numbers_of_learning.numbers,
        grid_results.numbers,
    ):
        new = part(data)
        if taken := found.keys() & new.keys():
            raise ValueError(f"{part.__name__} takes keys that are in use: {', '.join(taken)}")
        found |= new
    return found


def _best(table: pd.DataFrame, column: str = "snr") -> pd.Series:
    return table.loc[table[column].idxmax()]


def _meshes(data: Tables) -> Texts:
    found: Texts = {}
    names = ["knot", "jet", "jet without missiles", "large sphere"]
    names += [name for name in ("f16", "bunny") if name in data]
    for name in names:
        V, F = load_mesh(name)
        key = name.replace(" ", "-")
        found[f"{key}-vertices"] = f"{len(V):,}"
        found[f"{key}-faces"] = f"{len(F):,}"
        found[f"{key}-components"] = str(components(F, len(V))[0])
    if "f16" in data:
        F = load_mesh("f16")[1]
        found["f16-duplicates"] = str(len(F) - len(unique_faces(F)))
        faces_of_edge = Edges(F).faces_of_edge
        found["f16-boundary"] = str((faces_of_edge == 1).sum())
        found["f16-nonmanifold"] = str((faces_of_edge > 2).sum())
    V, F = shapes.jet()
    missile, _ = shapes.jet_parts()["tip missile left"]
    found["missile-edges"] = f"{_tube_width(missile) / mean_edge_length(V, F):.1f}"
    return found


def _tube_width(V: Floats) -> float:
    """Width of a missile's tube: the extent of its foremost third, which has no fins."""
    front = V[V[:, 0] > V[:, 0].max() - (V[:, 0].max() - V[:, 0].min()) / 3]
    return front[:, 2].max() - front[:, 2].min()


def _table_1(data: Tables) -> Texts:
    table = data["table_1"]
    found = {"draws": f"{table['draws'].iloc[0]}"}
    uniform = table[table["noise"] == "uniform"]
    for name, short in SHORT.items():
        rows = uniform[uniform["weights"] == name]
        off = (rows["snr_mean"] - rows["original_snr"]).abs()
        steps = ((rows["time_mean"] - rows["original_time"]) / TAU).abs()
        found[f"t1-{short}-off"] = f"{off.max():.2f}"
        found[f"t1-{short}-off-low"] = f"{(rows['snr_mean'] - rows['original_snr']).min():.2f}"
        found[f"t1-{short}-off-high"] = f"{(rows['snr_mean'] - rows['original_snr']).max():.2f}"
        found[f"t1-{short}-steps"] = f"{steps.max():.1f}"
    found["t1-gain-low"] = f"{uniform['gain_mean'].min():.1f}"
    found["t1-gain-high"] = f"{uniform['gain_mean'].max():.1f}"
    cell = uniform[(uniform["weights"] == "cotangent") & (uniform["row"] < 13)].iloc[0]
    found |= {
        "t1-last-time": f"{cell['time_mean']:.2f}",
        "t1-last-time-std": f"{cell['time_std']:.2f}",
        "t1-last-snr": f"{cell['snr_mean']:.2f}",
        "t1-last-original-time": f"{cell['original_time']:.1f}",
        "t1-last-original-snr": f"{cell['original_snr']:.2f}",
        "t1-last-row": f"{cell['row']:.2f}",
    }
    first = table[table["row"] == table["row"].iloc[0]].set_index(["noise", "weights"])
    found["t1-first-row"] = f"{table['row'].iloc[0]:.2f}"
    for name, short in SHORT.items():
        for noise in ("uniform", "normals"):
            found[f"t1-first-{noise}-{short}"] = f"{first.loc[(noise, name), 'snr_mean']:.1f}"
    readings = data["distance_readings"]
    found["readings"] = str(readings["reading"].nunique())
    return found


def _knot(data: Tables) -> Texts:
    table = data["knot"]
    found: Texts = {}
    for name, rows in table.groupby("weights"):
        short = SHORT[name]
        rows = rows.set_index("time")
        for steps in (1, 2, 10, 20):
            found[f"knot-{short}-{steps}"] = f"{rows.loc[steps, 'snr']:.2f}"
            found[f"knot-{short}-angle-{steps}"] = f"{rows.loc[steps, 'normal_angle']:.1f}"
            found[f"knot-{short}-volume-{steps}"] = f"{-100 * rows.loc[steps, 'volume_change']:.0f}"
        found[f"knot-{short}-best"] = f"{rows['snr'].idxmax():.0f}"
        found[f"knot-{short}-angle-best"] = f"{rows['normal_angle'].min():.1f}"
        found[f"knot-{short}-angle-best-steps"] = f"{rows['normal_angle'].idxmin():.0f}"
    found["knot-noisy-angle"] = f"{table['normal_angle'].iloc[0]:.1f}"
    return found


def _spectrum(data: Tables) -> Texts:
    largest = data["eigenvalues"].groupby("weights")["mu"].max()
    found = {f"mu-{SHORT[name]}": f"{mu:.2f}" for name, mu in largest.items()}
    return found | {"tau-max-cot": f"{2 / largest['cotangent']:.2f}"}


def _jets(data: Tables) -> Texts:
    found: Texts = {}
    for key in ("jet", "jet_without_missiles", *(["f16"] if "f16" in data else [])):
        table, dashed = data[key], key.replace("_", "-")
        found[f"{dashed}-noisy"] = f"{table['snr'].iloc[0]:.1f}"
        for name, rows in table.groupby("weights"):
            best = _best(rows)
            found[f"{dashed}-{SHORT[name]}-best"] = f"{best['snr']:.2f}"
            found[f"{dashed}-{SHORT[name]}-time"] = f"{best['time']:.1f}"
            found[f"{dashed}-{SHORT[name]}-end"] = f"{rows['snr'].iloc[-1]:.2f}"
    parts = data["jet_parts"].pivot_table(index=["part", "weights"], columns="time", values="error")
    for part in ("missiles", "aircraft"):
        found[f"{part}-noisy"] = f"{parts.loc[part].iloc[0, 0]:.2f}"
        for name, short in SHORT.items():
            row = parts.loc[part, name]
            found[f"{part}-{short}-least"] = f"{row.min():.2f}"
            found[f"{part}-{short}-least-time"] = f"{row.idxmin():.1f}"
            found[f"{part}-{short}-end"] = f"{row.iloc[-1]:.2f}"
    return found


def _large(data: Tables) -> Texts:
    found: Texts = {}
    for key in ("large_sphere", "bunny"):
        if key not in data:
            continue
        dashed = key.replace("_", "-")
        found[f"{dashed}-noisy"] = f"{data[key]['snr'].iloc[0]:.1f}"
        for name, rows in data[key].groupby("weights"):
            best = _best(rows)
            found[f"{dashed}-{SHORT[name]}-best"] = f"{best['snr']:.1f}"
            found[f"{dashed}-{SHORT[name]}-steps"] = f"{best['time']:.0f}"
    found["large-steps"] = f"{data['large_sphere']['time'].max():.0f}"
    return found


def _reduction(data: Tables) -> Texts:
    table = data["reduction"].set_index(["cell", "treatment"])
    first = table.loc[table.index[0][0]]
    twice, once = (
        first.loc["duplicate faces counted twice"],
        first.loc["duplicate faces counted once"],
    )
    split = first.loc["dropped and split"]
    V, _ = load_mesh("fine knot")
    return {
        "reduced-from": f"{len(V):,}",
        "reduced-to": f"{twice['vertices']:,.0f}",
        "reduced-duplicates": f"{twice['duplicates']:.0f}",
        "reduced-nonmanifold": f"{twice['nonmanifold']:.0f}",
        "reduced-boundary": f"{twice['boundary']:.0f}",
        "reduced-error": f"{100 * twice['weight_error']:.1f}",
        "reduced-snr-twice": f"{twice['snr']:.2f}",
        "reduced-snr-once": f"{once['snr']:.2f}",
        "reduced-snr-split": f"{split['snr']:.2f}",
        "reduced-split-boundary": f"{split['boundary']:.0f}",
    }


def _performance(data: Tables) -> Texts:
    bench, scaling = data["bench"], data["scaling"]
    seconds = bench.set_index(["task", "contender"])["seconds"]
    times_copy = bench[bench["contender"] == "ours"].set_index("task")["times_copy"]
    growth = scaling.set_index("vertices")["whole_flow_ns"]
    measured = data["filters"].set_index("method")
    front, filters = measured.loc["auto"], measured.drop("auto")
    slowest = filters["seconds"].sort_values(ascending=False)
    plain = filters["plain_seconds"] / filters["seconds"]
    learned = data["learned"].set_index("faces")

    def times(task: str, theirs: str, ours: str = "ours") -> str:
        return f"{seconds[task, theirs] / seconds[task, ours]:.1f}"

    others = seconds["implicit"].drop("ours")
    sweeps = data["sweeping"].set_index(["where", "cells"])
    most = sweeps.loc["cluster"].index.max()
    many, alone = sweeps.loc["cluster", most], sweeps.loc["one a message"].iloc[0]
    return {
        "bench-vertices": f"{bench['vertices'].max():,}",
        "bench-libigl": times("weights", "libigl", "ours, from nothing"),
        "bench-libigl-known": times("weights", "libigl", "ours, edges known"),
        "bench-plain": times("weights", "plain NumPy", "ours, from nothing"),
        "bench-step-scipy": times("step", "SciPy product"),
        "bench-steps-scipy": times("steps", "SciPy product"),
        "fast-from": f"{_fast.ROWS:,}",
        "bench-step-open3d": times("step", "Open3D"),
        "bench-step-trimesh": times("step", "trimesh"),
        "bench-steps-open3d": times("steps", "Open3D"),
        "bench-steps-trimesh": times("steps", "trimesh"),
        "bench-implicit": times("implicit", others.idxmin()),
        "bench-implicit-other": others.idxmin(),
        "bench-ordered-open3d": times("steps in order", "Open3D"),
        "bench-ordered-trimesh": times("steps in order", "trimesh"),
        "bench-step-copy": f"{times_copy['step']:.1f}",
        "bench-steps-copy": f"{times_copy['steps']:.1f}",
        "bench-ordered-copy": f"{times_copy['steps in order']:.1f}",
        "scaling-smallest": f"{growth.index[1]:,}",
        "scaling-largest": f"{growth.index[-1]:,}",
        "scaling-growth": f"{growth.iloc[-1] / growth.iloc[1]:.2f}",
        "scaling-bytes": f"{scaling['peak_bytes_per_vertex'].max():.0f}",
        "sweep-cells": f"{most:,}",
        "sweep-seconds": f"{many['seconds']:.1f}",
        "sweep-client": f"{1000 * many['client_ms']:.0f}",
        "sweep-worker": f"{1000 * many['worker_ms']:.0f}",
        "sweep-peak": f"{many['peak_bytes'] / 1e6:.0f}",
        "sweep-alone": f"{alone['client_ms']:.1f}",
        # A hundred messages a second, the most that are sent, and the cells in what time is left.
        "sweep-workers": f"{(1 - 100 * alone['client_ms'] / 1000) / many['client_ms']:.0f}",
        "filters-faces": f"{data['filters']['faces'].iloc[0]:,}",
        "filters-slowest": slowest.index[0],
        "filters-slowest-seconds": f"{slowest.iloc[0]:.2g}",
        "filters-second": slowest.index[1],
        "filters-second-seconds": f"{slowest.iloc[1]:.2g}",
        "filters-plain-low": f"{plain.min():.1f}",
        "filters-plain-high": f"{plain.max():.0f}",
        "filters-memory": f"{measured['peak_bytes'].max() / 1e6:.0f}",
        "front-seconds": f"{front['seconds']:.2g}",
        "learned-faces-smallest": f"{learned.index[0]:,}",
        "learned-faces-largest": f"{learned.index[-1]:,}",
        "learned-us-smallest": f"{learned['face_us'].iloc[0]:.0f}",
        "learned-us-largest": f"{learned['face_us'].iloc[-1]:.0f}",
        "learned-bytes": f"{learned['peak_bytes_per_face'].max() / 1000:.1f}",
        "bench-flow-plain": times("flow", "plain NumPy, SciPy product"),
    }


def _origin_shift(data: Tables) -> Texts:
    snr = data["origin_shift"].astype({"where": str}).set_index("where")["snr"]
    moved = snr.drop("as stored")
    return {
        "origin-stored": f"{snr['as stored']:.1f}",
        "origin-centred": f"{moved.iloc[0]:.1f}",
        "origin-far": f"{moved.iloc[-1]:.1f}",
        "origin-far-diagonals": f"{float(moved.index[-1]):g}",
    }


def _agreement(data: Tables) -> Texts:
    table = data["agreement"]
    ratio = table["angle_time"] / table["snr_time"]
    return {
        "agree-ratio-low": f"{ratio.min():.1f}",
        "agree-ratio-high": f"{ratio.max():.0f}",
        "agree-volume-snr": f"{-100 * table['volume_at_snr_time'].min():.0f}",
        "agree-volume-angle": f"{-100 * table['volume_at_angle_time'].min():.0f}",
    }


def _quality(data: Tables) -> Texts:
    table = data["quality"]
    angle = table[table["method"] != "none"].pivot(
        index=["mesh", "method"], columns="parameters", values="normal_angle"
    )
    excess = angle["auto"] / angle["tuned"]
    jet = table[table["mesh"] == "jet"].set_index(["method", "parameters"])
    automatic = jet.xs("auto", level="parameters")
    smoothest = automatic.drop("learned")["normal_angle"].idxmin()
    missiles = automatic["missile_error"]
    averaging = data["missiles"].set_index("weights")["missile_error"]
    volume = table.set_index(["mesh", "method", "parameters"])["volume_change"].mul(-100)
    found = {
        "torus-averaging-volume": f"{volume['torus', 'averaging', 'tuned']:.0f}",
        "torus-learned-volume": f"{volume['torus', 'learned', 'tuned']:.1f}",
        "knot-averaging-volume": f"{volume['knot', 'averaging', 'tuned']:.0f}",
        "quality-noise": f"{QUALITY_NOISE:g}",
        "quality-methods": str(table["method"].nunique() - 1),
        "quality-excess": f"{100 * (excess.median() - 1):.0f}",
        "quality-near": str((excess < 1.1).sum()),
        "quality-all": str(len(excess)),
        "jet-missiles-noisy": f"{jet.loc[('none', 'default'), 'missile_error']:.3f}",
        "jet-missiles-best": f"{missiles.min():.3f}",
        "jet-missiles-best-method": missiles.idxmin(),
        "jet-smoothest": smoothest,
        "jet-smoothest-angle": f"{automatic.loc[smoothest, 'normal_angle']:.1f}",
        "jet-smoothest-snr": f"{automatic.loc[smoothest, 'snr']:.1f}",
        "jet-noisy-snr": f"{jet.loc[('none', 'default'), 'snr']:.1f}",
        "jet-missiles-averaging": f"{averaging.min():.3f}",
        "jet-missiles-averaging-weights": averaging.idxmin(),
    }
    for by in ("lengths", "differences"):
        guesses = {}
        for mesh in ("box", "torus", "knot", "jet"):
            noisy, _, F = noisy_pair(mesh, QUALITY_NOISE, SEED)
            guesses[mesh] = estimate_noise(noisy, F, by)
        lowest = min(guesses, key=guesses.get)
        found[f"{by}-low-mesh"], found[f"{by}-low"] = lowest, f"{guesses[lowest]:.3f}"
        found[f"{by}-high"] = f"{max(guesses.values()):.3f}"
    if PAIRS.keys() <= set(table["mesh"]):
        for mesh, short in (("fandisk", "fandisk"), ("bunny pair", "pair")):
            auto = angle.loc[mesh]["auto"]
            found[f"{short}-best"] = f"{auto.min():.2f}"
            found[f"{short}-best-method"] = auto.idxmin()
            found[f"{short}-size"] = f"{PAIRS[mesh].size:g}"
    return found
