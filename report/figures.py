"""The report's figures: name -> function(folder, data) that draws it.

Here are the curves: SVG files, as wide as the page is, whose numbers come from the
experiments' tables in ``data``. Those of meshes are in pictures.py.
"""

from pathlib import Path

import numpy as np
import pandas as pd

from grid_results import regret_figure
from meshfair import filters, plotting
from meshfair.experiments import noisy_pair
from meshfair.plotting import OTHER_COLORS, WEIGHT_COLORS, WEIGHT_MARKS, shades
from meshfair.sure import SURE, true_risk
from numbers_of_learning import cells
from pictures import PICTURES
from tables import QUALITY_NOISE, SEED

Tables = dict[str, pd.DataFrame]


def cotangent_angles(folder: Path, _: Tables) -> None:
    """The two angles opposite an edge (the original report's Figure 1)."""
    i, j, a, b = np.array([[0, 0], [0.25, 2.0], [-1.7, 1.25], [2.0, 0.85]])
    with plotting.figure(folder / "cotangent-angles.svg", (2.9, 2.0)) as axes:
        for corner, colour in ((a, OTHER_COLORS[0]), (b, OTHER_COLORS[1])):
            axes.fill(*np.stack([i, j, corner]).T, color=colour, alpha=0.08, lw=0)
            axes.plot(*np.stack([i, corner, j]).T, color="0.35", lw=1.1)
        axes.plot(*np.stack([i, j]).T, color="black", lw=2.2)
        for corner, name, colour in (
            (a, r"$\alpha_{ij}$", OTHER_COLORS[0]),
            (b, r"$\beta_{ij}$", OTHER_COLORS[1]),
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


def knot_curves(folder: Path, data: Tables) -> None:
    """Figure 3, and the normal angle beside it."""
    with plotting.figure(folder / "knot-curves.svg", columns=2) as (left, right):
        plotting.draw_curves(left, data["knot"], "snr", best="max")
        left.set(xlabel="iterations", ylabel="SNR (dB)", xticks=range(0, 21, 5))
        plotting.draw_curves(right, data["knot"], "normal_angle", best="min")
        right.set(xlabel="iterations", ylabel="mean normal angle (degrees)", xticks=range(0, 21, 5))
        right.set_ylim(bottom=0)
        plotting.legend(left, "best iteration")


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
        right.axhspan(-1.6, -1, color="0.5", alpha=0.2, lw=0)
        right.text(0.05, -1.16, "grows", fontsize=8, color="0.3", va="center")
        right.set(xlabel=r"eigenvalue $\mu$", ylabel=r"factor of one step, $1 - \tau\mu$")
        right.set_ylim(-1.4, 1.05)
        right.legend(loc="lower left", bbox_to_anchor=(0, 0.16))


def jet_curves(folder: Path, data: Tables) -> None:
    """Figure 6: SNR with and without missiles, and the missiles' own error."""
    with plotting.figure(folder / "jet-curves.svg", columns=2, sharey=True) as (left, right):
        plotting.draw_curves(left, data["jet"], "snr", best="max")
        left.set(title="with missiles", xlabel="time", ylabel="SNR (dB)")
        plotting.draw_curves(right, data["jet_without_missiles"], "snr", best="max")
        right.set(title="without missiles", xlabel="time")
        plotting.legend(left, "best time")
    with plotting.figure(folder / "jet-parts.svg", columns=2, sharey=True) as panels:
        for axes, part in zip(panels, ("missiles", "aircraft"), strict=True):
            rows = data["jet_parts"].query("part == @part")
            plotting.draw_curves(axes, rows, "error", best="min")
            axes.axhline(rows["error"].iloc[0], color="0.3", lw=0.8, ls="--")
            axes.set(title=part, xlabel="time")
            axes.set_ylim(bottom=0)
        panels[0].set_ylabel("mean error (mean edge lengths)")
        plotting.legend(panels[0], "least error", loc="upper left")


def f16_curves(folder: Path, data: Tables) -> None:
    """The original report's own F-16, where it is downloaded."""
    if "f16" not in data:
        return
    with plotting.figure(folder / "f16-curves.svg", (4.2, 2.3)) as axes:
        plotting.draw_curves(axes, data["f16"], "snr", best="max")
        axes.set(xlabel="time", ylabel="SNR (dB)")
        plotting.legend(axes, "best time")


def full_resolution(folder: Path, data: Tables) -> None:
    """Averaging at the bunny's full resolution."""
    names = [name for name in ("bunny", "large_sphere") if name in data]
    size = (6.3, 2.5) if len(names) == 2 else (4.2, 2.3)
    with plotting.figure(
        folder / "full-resolution.svg", size, columns=len(names), squeeze=False
    ) as panels:
        for axes, name in zip(panels[0], names, strict=True):
            plotting.draw_curves(axes, data[name], "snr", best="max")
            axes.set(title=name.replace("_", " "), xlabel="iterations", xticks=range(0, 21, 5))
        panels[0][0].set_ylabel("SNR (dB)")
        plotting.legend(panels[0][-1], "best iteration")


def agreement(folder: Path, data: Tables) -> None:
    """Where SNR and normal angle would stop the flow."""
    table = data["agreement"]
    labels = list(dict.fromkeys(table["mesh"]))
    panels = (("snr_time", "angle_time"), ("angle_at_snr_time", "angle_at_angle_time"))
    with plotting.figure(folder / "agreement.svg", (6.3, 2.7), columns=2, sharey=True) as both:
        for axes, (at_snr, at_angle) in zip(both, panels, strict=True):
            for k, (name, rows) in enumerate(table.groupby("weights", sort=False)):
                y = np.arange(len(rows)) + 0.22 * (k - 1)
                style = {"color": WEIGHT_COLORS[name], "marker": WEIGHT_MARKS[name]}
                axes.hlines(y, rows[at_snr], rows[at_angle], color=style["color"], lw=1)
                axes.plot(rows[at_snr], y, ls="", ms=5, label=name, **style)
                axes.plot(rows[at_angle], y, ls="", ms=5, mfc="white", **style)
        left, right = both
        left.set(xlabel="stopping time", yticks=range(len(labels)), yticklabels=labels)
        left.invert_yaxis()
        right.set(xlabel="mean normal angle (degrees)")
        for face, label in ((None, "where the SNR is best"), ("white", "where the angle is least")):
            right.plot([], [], "o", color="0.4", ms=5, mfc=face, label=label)
        handles, names = right.get_legend_handles_labels()
        left.figure.legend(handles, names, loc="outside upper center", ncols=5, columnspacing=1.2)


def risk(folder: Path, _: Tables) -> None:
    """SURE beside the true risk, over the iterations of two filters."""
    with plotting.figure(folder / "risk.svg", columns=2, sharey=True) as panels:
        for axes, mesh in zip(panels, ("torus", "jet"), strict=True):
            noisy, V, F = noisy_pair(mesh, QUALITY_NOISE, SEED)
            estimated = SURE(noisy, F, np.random.default_rng(SEED))
            unit = true_risk(noisy, V, F)
            for method, colour in zip(("taubin", "bilateral"), OTHER_COLORS, strict=False):
                apply = getattr(filters, method)
                meshes = noisy, estimated.V_perturbed
                runs = zip(*(apply(X, F, iterations=15) for X in meshes), strict=True)
                states = [meshes, *((X, Y) for (_, X), (_, Y) in runs)]
                guess = np.array([estimated(X, Y) for X, Y in states]) / unit
                truth = np.array([true_risk(X, V, F) for X, _ in states]) / unit
                for risks, style, face in ((guess, "-", colour), (truth, "--", "white")):
                    least = risks.argmin()
                    axes.plot(
                        risks, style, color=colour, marker="o", markevery=[least], ms=5, mfc=face,
                        label=f"{method}, {'SURE' if style == '-' else 'true'}",
                    )  # fmt: skip
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
    with plotting.figure(folder / "scaling.svg", (5.2, 2.7)) as axes:
        for (column, label), mark in zip(labels.items(), "osD^v", strict=True):
            axes.loglog(table["vertices"], table[column], f"{mark}-", ms=4, label=label)
        axes.set(xlabel="vertices", ylabel="nanoseconds a vertex")
        axes.set_ylim(top=axes.get_ylim()[1] * 3)
        axes.legend(ncols=2, loc="upper center", fontsize=7.5)


def learned(folder: Path, data: Tables) -> None:
    """The curve of training, and every cell of the validation."""
    with plotting.figure(folder / "learned-training.svg", columns=2) as (left, right):
        for stage, rows in data["training"].groupby("stage"):
            colour = OTHER_COLORS[stage - 1]
            left.plot(rows["step"], rows["loss"], color=colour, label=f"stage {stage}")
            marked = rows.dropna(subset=["sharp", "smooth"])
            for kind, style in (("sharp", "-"), ("smooth", "--")):
                label = f"stage {stage}, {kind}"
                right.plot(marked["step"], marked[kind], style, color=colour, label=label)
        left.set(xlabel="step", ylabel="loss", yscale="log")
        left.set_yticks((0.2, 0.5, 1), labels=("0.2", "0.5", "1"))
        left.minorticks_off()
        right.set(xlabel="step", ylabel="mean normal angle (degrees)", ylim=(0, None))
        left.legend()
        right.legend(ncols=2, fontsize=7.5)
    ratios = cells(data["validation"])["ratio"].reset_index()
    sizes = sorted(ratios["size"].unique())
    with plotting.figure(folder / "learned-cells.svg", (6.3, 3.0), columns=2, sharex=True) as both:
        for axes, level in zip(both, ("noise", "shape"), strict=True):
            names = list(ratios[level].unique())
            for k, (size, shade) in enumerate(zip(sizes, shades(len(sizes)), strict=True)):
                rows = ratios[ratios["size"] == size]
                y = rows[level].map(names.index) + 0.18 * (k - (len(sizes) - 1) / 2)
                axes.plot(rows["ratio"], y, ".", color=shade, ms=5, label=f"{size:g} edges")
            axes.axvline(1, color="0.3", lw=0.8)
            axes.set(xscale="log", yticks=range(len(names)), yticklabels=names)
            axes.set_xticks((0.2, 0.5, 1, 2), labels=("0.2", "0.5", "1", "2"))
            axes.minorticks_off()
            axes.set(xlabel="angle over the best other's")
            axes.invert_yaxis()
        handles, labels = both[0].get_legend_handles_labels()
        both[0].figure.legend(handles, labels, loc="outside upper center", ncols=len(sizes))


FIGURES = PICTURES | {
    draw.__name__: draw
    for draw in (
        cotangent_angles, knot_curves, spectrum, jet_curves, f16_curves, full_resolution, scaling,
        agreement, risk, learned, regret_figure,
    )
}  # fmt: skip
