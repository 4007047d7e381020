"""The report's figures: name -> function(folder, data) that draws it.

Meshes are PNG files, all of one mesh from one camera; curves are SVG. Numbers
in curves come from the experiments' tables in ``data``.
"""

import json
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from PIL import Image

from meshfair import denoising, experiments, filters, flow, plotting
from meshfair.checks import Booleans, Floats, Integers
from meshfair.experiments import load_mesh, load_noisy_mesh, noisy_pair
from meshfair.experiments.original import F16_DECIBELS, TAU, TIME
from meshfair.mesh import cluster, inspect, repair, unique_faces
from meshfair.metrics import normal_angles
from meshfair.operators import averaging
from meshfair.shapes import jet_parts
from meshfair.sure import SURE, true_risk
from meshfair.viewer import CMAPS, Camera, render
from meshfair.viewer.coloring import displacement
from meshfair.weights import BY_NAME
from numbers_of_learning import cells
from tables import JET_NOISE, QUALITY_NOISE, SEED

Tables = dict[str, pd.DataFrame]

PIXELS = (1000, 750)
WIDE = (1400, 700)
LOW = (1000, 480)
LOW_PIXELS = (600, 450)
LOW_WIDE = (800, 400)
ERRORS = "viridis"
ANGLES = "reds"


def photograph(
    path: Path,
    V: Floats,
    F: Integers,
    camera: Camera,
    size: tuple[int, int] = PIXELS,
    **options: Any,
) -> None:
    """Render a mesh into a PNG file."""
    Image.fromarray(render(V, F, camera, size=size, **options)).save(path)


def colour_bar(path: Path, limits: tuple[float, float], label: str, cmap: str = ERRORS) -> None:
    """A colour bar of its own, to stand below a row of meshes; ``cmap`` as Polyscope has it."""
    with plotting.figure(path, (4.0, 0.5)) as axes:
        axes.imshow(
            np.linspace(0, 1, 256)[None],
            aspect="auto",
            extent=(*limits, 0, 1),
            cmap=CMAPS[cmap],
        )
        axes.set(yticks=[], xlabel=label)
        axes.grid(False)


def cotangent_angles(folder: Path, _: Tables) -> None:
    """The two angles opposite an edge (the original report's Figure 1)."""
    i, j, a, b = np.array([[0, 0], [0.25, 2.0], [-1.7, 1.25], [2.0, 0.85]])
    with plotting.figure(folder / "cotangent-angles.svg", (2.9, 2.0)) as axes:
        for corner, colour in ((a, "#0072B2"), (b, "#D55E00")):
            axes.fill(*np.stack([i, j, corner]).T, color=colour, alpha=0.08, lw=0)
            axes.plot(*np.stack([i, corner, j]).T, color="0.35", lw=1.1)
        axes.plot(*np.stack([i, j]).T, color="black", lw=2.2)
        for corner, name, colour in (
            (a, r"$\alpha_{ij}$", "#0072B2"),
            (b, r"$\beta_{ij}$", "#D55E00"),
        ):
            ends = [np.arctan2(*(end - corner)[::-1]) for end in (i, j)]
            if abs(ends[1] - ends[0]) > np.pi:  # the arc across the branch cut
                ends = [angle % (2 * np.pi) for angle in ends]
            turn = np.linspace(*ends, 40)
            axes.plot(
                *(corner[:, None] + 0.42 * np.stack([np.cos(turn), np.sin(turn)])), color=colour
            )
            middle = corner + 0.68 * np.array([np.cos(np.mean(ends)), np.sin(np.mean(ends))])
            axes.text(*middle, name, color=colour, ha="center", va="center", fontsize=11)
        for point, name, shift in ((i, "$v_i$", (0, -0.24)), (j, "$v_j$", (0, 0.2))):
            axes.plot(*point, "o", color="black", ms=4)
            axes.text(*(point + shift), name, ha="center", va="center", fontsize=11)
        axes.set_aspect("equal")
        axes.margins(0.05)
        axes.axis("off")


def knot_meshes(folder: Path, _: Tables) -> None:
    """Figures 2 and 4: the knot, noisy, and after one and ten iterations."""
    V, F = load_mesh("knot")
    meshes = experiments.knot_meshes(SEED, iterations=(1, 10))
    error = displacement(V, F)
    in_view = np.concatenate([V, meshes["noisy", 0]])
    camera = Camera.around(in_view, (0.35, -1.0, 0.45))
    photograph(folder / "knot-clean.png", V, F, camera)
    limits = (0.0, 2.0)
    for (name, iterations), V_now in meshes.items():
        photograph(folder / f"knot-{name}-{iterations}.png", V_now, F, camera)
        photograph(
            folder / f"knot-{name}-{iterations}-error.png", V_now, F, camera,
            values=error(V_now), limits=limits, cmap=ERRORS, smooth=True,
        )  # fmt: skip
    colour_bar(
        folder / "knot-errors.svg", limits, "distance from the ground truth, in mean edge lengths"
    )


def knot_curves(folder: Path, data: Tables) -> None:
    """Figure 3, and the normal angle beside it."""
    with plotting.figure(folder / "knot-curves.svg", columns=2) as (left, right):
        plotting.draw_curves(left, data["knot"], "snr", best="max")
        left.set(xlabel="iterations", ylabel="SNR (dB)", xticks=range(0, 21, 5))
        plotting.draw_curves(right, data["knot"], "normal_angle", best="min")
        right.set(xlabel="iterations", ylabel="mean normal angle (degrees)", xticks=range(0, 21, 5))
        right.set_ylim(bottom=0)
        left.legend()


def spectrum(folder: Path, data: Tables) -> None:
    """Eigenvalues of I - W~, and what one step makes of each."""
    table = data["eigenvalues"]
    with plotting.figure(folder / "spectrum.svg", columns=2) as (left, right):
        plotting.draw_curves(left, table, "mu", x="index")
        left.axhline(2, color="0.3", lw=0.8, ls="--")
        left.text(15, 2.04, r"bound for $\tau = 1$", fontsize=8, color="0.3", va="bottom")
        left.set(xlabel="eigenvalue number", ylabel=r"eigenvalue $\mu$ of $I - \widetilde{W}$")
        left.set_ylim(0, 2.6)
        left.legend(loc="lower right")
        mu = np.linspace(0, table["mu"].max(), 300)
        for tau, style in ((0.2, "-"), (2 / 3, "--"), (1.0, ":")):
            label = {0.2: "0.2", 1.0: "1"}.get(tau, "2/3")
            right.plot(mu, 1 - tau * mu, style, color="0.15", label=rf"$\tau = {label}$")
        right.axhspan(-1.6, -1, color="#D55E00", alpha=0.12, lw=0)
        right.text(0.05, -1.16, "grows", fontsize=8, color="#A04000", va="center")
        right.set(xlabel=r"eigenvalue $\mu$", ylabel=r"factor of one step, $1 - \tau\mu$")
        right.set_ylim(-1.4, 1.05)
        right.legend(loc="lower left", bbox_to_anchor=(0, 0.16))


JET_CAMERA: dict[str, Any] = {"direction": (0.75, 0.85, 0.5), "aspect": 2.0}
MISSILE_CAMERA: dict[str, Any] = {"direction": (0.9, 1.0, 0.45), "margin": 0.0}
MISSILES_IN_VIEW = ("tip missile left", "outer missile left")


def jet_states(
    name: str, times: tuple[float, ...]
) -> tuple[Floats, Integers, dict[tuple[str, float], Floats]]:
    """V, F, and {(weights, time): V} of the jet's heat flows; time 0 is the noisy mesh."""
    V_noisy, V, F = load_noisy_mesh(name, JET_NOISE["noise"], SEED, size=JET_NOISE["size"])
    states = {("noisy", 0.0): V_noisy}
    for kind, build in BY_NAME.items():
        for time, V_now in flow.heat(V_noisy, averaging(build(V_noisy, F)), TAU, max(times)):
            if time in times:
                states[kind, time] = V_now
    return V, F, states


def jet_meshes(folder: Path, _: Tables) -> None:
    """Figures 5 and 7: the jet with missiles under the flow, whole and close by."""
    V, F, states = jet_states("jet", (0.6, 2.0, 4.0))
    camera = Camera.around(V, **JET_CAMERA)
    parts = jet_parts()
    in_view = np.concatenate([parts[name][0] for name in MISSILES_IN_VIEW])
    close = Camera.around(in_view, **MISSILE_CAMERA, aspect=LOW[0] / LOW[1])
    states["clean", 0.0] = V
    for (name, time), V_now in states.items():
        photograph(folder / f"jet-{name}-{time:g}.png", V_now, F, camera, WIDE)
        photograph(folder / f"missiles-{name}-{time:g}.png", V_now, F, close, LOW)


def jet_without_missiles(folder: Path, data: Tables) -> None:
    """Figure 8: the jet without missiles, each weights at its best time."""
    table = data["jet_without_missiles"]
    best = table.loc[table.groupby("weights")["snr"].idxmax()].set_index("weights")["time"]
    V, F, states = jet_states("jet without missiles", tuple(best))
    camera = Camera.around(V, **JET_CAMERA)
    photograph(folder / "plain-noisy.png", states["noisy", 0.0], F, camera, WIDE)
    for name in BY_NAME:
        photograph(folder / f"plain-{name}.png", states[name, best[name]], F, camera, WIDE)


def jet_curves(folder: Path, data: Tables) -> None:
    """Figure 6: SNR with and without missiles, and the missiles' own error."""
    with plotting.figure(folder / "jet-curves.svg", columns=2, sharey=True) as (left, right):
        plotting.draw_curves(left, data["jet"], "snr", best="max")
        left.set(title="with missiles", xlabel="time", ylabel="SNR (dB)")
        plotting.draw_curves(right, data["jet_without_missiles"], "snr", best="max")
        right.set(title="without missiles", xlabel="time")
        left.legend()
    with plotting.figure(folder / "jet-parts.svg", columns=2, sharey=True) as panels:
        for axes, part in zip(panels, ("missiles", "aircraft"), strict=True):
            rows = data["jet_parts"].query("part == @part")
            plotting.draw_curves(axes, rows, "error", best="min")
            axes.axhline(rows["error"].iloc[0], color="0.3", lw=0.8, ls="--")
            axes.set(title=part, xlabel="time")
            axes.set_ylim(bottom=0)
        panels[0].set_ylabel("mean error (mean edge lengths)")
        panels[0].legend(loc="upper left")


def f16(folder: Path, data: Tables) -> None:
    """The original report's own F-16, where it is downloaded."""
    if "f16" not in data:
        return
    with plotting.figure(folder / "f16-curves.svg", (3.6, 2.5)) as axes:
        plotting.draw_curves(axes, data["f16"], "snr", best="max")
        axes.set(xlabel="time", ylabel="SNR (dB)")
        axes.legend()
    V_noisy, V, F = load_noisy_mesh("f16", "uniform", SEED, decibels=F16_DECIBELS)
    in_view = np.concatenate([V, V_noisy])
    camera = Camera.around(in_view, (-0.75, 0.5, 0.85), up=(0, 1, 0), aspect=2.0)
    photograph(folder / "f16-clean.png", V, F, camera, WIDE)
    photograph(folder / "f16-noisy.png", V_noisy, F, camera, WIDE)
    for name in ("combinatorial", "cotangent"):
        A = averaging(BY_NAME[name](V_noisy, F))
        V_now = dict(flow.heat(V_noisy, A, TAU, TIME))[TIME]
        photograph(folder / f"f16-{name}.png", V_now, F, camera, WIDE)


def full_resolution(folder: Path, data: Tables) -> None:
    """Averaging at the bunny's full resolution."""
    names = [name for name in ("bunny", "large_sphere") if name in data]
    width = 3.4 * len(names) if len(names) == 2 else 3.8
    with plotting.figure(
        folder / "full-resolution.svg", (width, 2.5), columns=len(names), squeeze=False
    ) as panels:
        for axes, name in zip(panels[0], names, strict=True):
            plotting.draw_curves(axes, data[name], "snr", best="max")
            axes.set(title=name.replace("_", " "), xlabel="iterations", xticks=range(0, 21, 5))
        panels[0][0].set_ylabel("SNR (dB)")
        panels[0][-1].legend()
    if "bunny" in data:
        V_noisy, V, F = load_noisy_mesh("bunny", "normals", SEED, size=0.2)
        camera = Camera.around(V[np.unique(F)], (0.1, 0.25, 1.0), up=(0, 1, 0), aspect=1.0)
        states = {"noisy": V_noisy} | {
            name: flow.average(V_noisy, averaging(build(V_noisy, F)), 5)
            for name, build in BY_NAME.items()
        }
        for name, V_now in states.items():
            photograph(folder / f"bunny-{name}.png", V_now, F, camera, (900, 900))


def agreement(folder: Path, data: Tables) -> None:
    """Where SNR and normal angle would stop the flow."""
    table = data["agreement"]
    labels = list(dict.fromkeys(table["mesh"]))
    panels = (("snr_time", "angle_time"), ("angle_at_snr_time", "angle_at_angle_time"))
    with plotting.figure(folder / "agreement.svg", (6.3, 2.7), columns=2, sharey=True) as both:
        for axes, (at_snr, at_angle) in zip(both, panels, strict=True):
            for k, (name, rows) in enumerate(table.groupby("weights", sort=False)):
                y = np.arange(len(rows)) + 0.22 * (k - 1)
                style = {
                    "color": plotting.WEIGHT_COLORS[name],
                    "marker": plotting.WEIGHT_MARKS[name],
                }
                axes.hlines(y, rows[at_snr], rows[at_angle], color=style["color"], lw=1)
                axes.plot(rows[at_snr], y, ls="", ms=5, label=name, **style)
                axes.plot(rows[at_angle], y, ls="", ms=5, mfc="white", **style)
        left, right = both
        left.set(xlabel="stopping time", yticks=range(len(labels)), yticklabels=labels)
        left.invert_yaxis()
        right.set(xlabel="mean normal angle (degrees)")
        handles, names = right.get_legend_handles_labels()
        left.figure.legend(handles, names, loc="outside upper center", ncols=3)


def reduction(folder: Path, data: Tables) -> None:
    """The reduced knot's bad triangles, before and after the repair."""
    V, F = cluster(*load_mesh("fine knot"), data["reduction"]["cell"].max())
    camera = Camera.around(V, (0.35, -1.0, 0.45))
    split = repair(V, F, duplicates=True, split=True)
    sides = []
    for X, T in ((V, F), (split.V, split.F)):
        bad = bad_faces(X, T).astype(float)
        sides.append(
            render(X, T, camera, size=PIXELS, values=bad, limits=(0, 1), cmap="reds", edges=True)
        )
    Image.fromarray(np.concatenate(sides, axis=1)).save(folder / "reduction.png")


def bad_faces(V: Floats, F: Integers) -> Booleans:
    """Duplicate faces, and those with an edge that has more than two faces, each counted once."""
    F = np.sort(F, axis=1)
    stored = {found.kind: found.where for found in inspect(V, F).findings}
    once = {found.kind: found.where for found in inspect(V, unique_faces(F)).findings}
    duplicates = set(map(tuple, F[stored.get("duplicate_faces", [])].tolist()))
    crowded = set(map(tuple, once.get("nonmanifold_edges", np.empty((0, 2))).tolist()))
    return np.array(
        [
            tuple(face) in duplicates or not crowded.isdisjoint(combinations(face, 2))
            for face in F.tolist()
        ]
    )


GALLERIES: dict[str, dict[str, Any]] = {
    "jet": JET_CAMERA,
    "torus": {"direction": (0.3, -0.7, 0.75)},
}
GALLERY_ANGLES = (0.0, 30.0)


def gallery(folder: Path, data: Tables) -> None:
    """Every method with automatic parameters, coloured by the angle to the true normals."""
    table = data["quality"]
    for mesh in GALLERIES:
        rows = table[(table["mesh"] == mesh) & (table["parameters"] == "auto")]
        noisy, V, F = noisy_pair(mesh, QUALITY_NOISE, SEED)
        camera = Camera.around(np.concatenate([V, noisy]), **GALLERIES[mesh])
        size = LOW_WIDE if GALLERIES[mesh].get("aspect") == 2.0 else LOW_PIXELS
        options = {"limits": GALLERY_ANGLES, "cmap": ANGLES}
        photograph(
            folder / f"gallery-{mesh}-none.png", noisy, F, camera, size,
            values=normal_angles(noisy, V, F), **options,
        )  # fmt: skip
        for row in rows.itertuples():
            X = denoising.denoise(noisy, F, row.method, **json.loads(row.used)).V
            photograph(
                folder / f"gallery-{mesh}-{row.method}.png", X, F, camera, size,
                values=normal_angles(X, V, F), **options,
            )  # fmt: skip
    label = "angle to the true normal, in degrees"
    colour_bar(folder / "gallery-angles.svg", GALLERY_ANGLES, label, ANGLES)


def risk(folder: Path, _: Tables) -> None:
    """SURE beside the true risk, over the iterations of two filters."""
    with plotting.figure(folder / "risk.svg", columns=2, sharey=True) as panels:
        for axes, mesh in zip(panels, ("torus", "jet"), strict=True):
            noisy, V, F = noisy_pair(mesh, QUALITY_NOISE, SEED)
            estimated = SURE(noisy, F, np.random.default_rng(SEED))
            unit = true_risk(noisy, V, F)
            for method, colour in (("taubin", "#0072B2"), ("bilateral", "#D55E00")):
                apply = getattr(filters, method)
                meshes = noisy, estimated.V_perturbed
                runs = zip(*(apply(X, F, iterations=15) for X in meshes), strict=True)
                states = [meshes, *((X, Y) for (_, X), (_, Y) in runs)]
                guess = np.array([estimated(X, Y) for X, Y in states]) / unit
                truth = np.array([true_risk(X, V, F) for X, _ in states]) / unit
                for risks, style, face in ((guess, "-", colour), (truth, "--", "white")):
                    label = f"{method}, {'SURE' if style == '-' else 'true'}"
                    axes.plot(risks, style, color=colour, label=label)
                    least = risks.argmin()
                    axes.plot(least, risks[least], "o", color=colour, ms=5, mfc=face)
            axes.set(title=mesh, xlabel="iterations", xticks=range(0, 16, 5))
        panels[0].set_ylabel("risk, relative to the noisy mesh")
        panels[0].legend(fontsize=7.5)


def scaling(folder: Path, data: Tables) -> None:
    """Time per vertex at five sizes, as `make bench` measured it."""
    table = data["scaling"]
    labels = {
        "edges_ns": "finding the edges", "cotangent_ns": "filling the cotangent weights",
        "averaging_ns": r"$D^{-1} W$", "step_ns": "one averaging step",
        "whole_flow_ns": "all of a flow of 20 steps",
    }  # fmt: skip
    with plotting.figure(folder / "scaling.svg", (4.6, 2.7)) as axes:
        for column, label in labels.items():
            axes.loglog(table["vertices"], table[column], "o-", ms=4, label=label)
        axes.set(xlabel="vertices", ylabel="nanoseconds a vertex")
        axes.set_ylim(top=axes.get_ylim()[1] * 3)
        axes.legend(ncols=2, loc="upper center", fontsize=7.5)


def learned(folder: Path, data: Tables) -> None:
    """The curve of training, and every cell of the validation."""
    with plotting.figure(folder / "learned-training.svg", columns=2) as (left, right):
        for stage, rows in data["training"].groupby("stage"):
            colour = ("#0072B2", "#D55E00")[stage - 1]
            left.plot(rows["step"], rows["loss"], color=colour, label=f"stage {stage}")
            marked = rows.dropna(subset=["sharp", "smooth"])
            for kind, style in (("sharp", "o-"), ("smooth", "s--")):
                label = f"stage {stage}, {kind}"
                right.plot(marked["step"], marked[kind], style, ms=3, color=colour, label=label)
        left.set(xlabel="step", ylabel="loss", ylim=(0, None))
        right.set(xlabel="step", ylabel="mean normal angle (degrees)", ylim=(0, None))
        left.legend()
        right.legend(ncols=2, fontsize=7.5)
    ratios = cells(data["validation"])["ratio"].reset_index()
    sizes = sorted(ratios["size"].unique())
    with plotting.figure(folder / "learned-cells.svg", (6.3, 3.0), columns=2, sharex=True) as both:
        for axes, level in zip(both, ("noise", "shape"), strict=True):
            names = list(ratios[level].unique())
            for k, size in enumerate(sizes):
                rows = ratios[ratios["size"] == size]
                y = rows[level].map(names.index) + 0.18 * (k - (len(sizes) - 1) / 2)
                shade = f"{0.7 - 0.7 * k / (len(sizes) - 1):.2f}"  # a grey
                axes.plot(rows["ratio"], y, ".", color=shade, ms=5, label=f"{size:g} edges")
            axes.axvline(1, color="0.3", lw=0.8)
            axes.set(xscale="log", yticks=range(len(names)), yticklabels=names)
            axes.set_xticks((0.2, 0.5, 1, 2), labels=("0.2", "0.5", "1", "2"))
            axes.minorticks_off()
            axes.set(xlabel="angle over the best other's")
            axes.invert_yaxis()
        handles, labels = both[0].get_legend_handles_labels()
        both[0].figure.legend(handles, labels, loc="outside upper center", ncols=len(sizes))


FIGURES = {
    draw.__name__: draw
    for draw in (
        cotangent_angles, knot_meshes, knot_curves, spectrum, jet_meshes, jet_curves,
        jet_without_missiles, f16, full_resolution, scaling, reduction, agreement, gallery, risk,
        learned,
    )
}  # fmt: skip
