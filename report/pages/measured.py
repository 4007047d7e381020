"""Tables of the pages, from what the report's experiments and `make bench` measured."""

from pathlib import Path

import numpy as np
import pandas as pd

REPORT = Path(__file__).resolve().parent.parent
WAYS = {"default": "default", "auto": "automatic", "tuned": "tuned"}
METRICS = {
    "normal_angle": ("Mean normal angle, in degrees", 1),
    "snr": ("Signal-to-noise ratio, in decibels", 1),
}
TASKS = {
    "weights": "Cotangent weights",
    "step": "One averaging step",
    "step in order": "One averaging step on the reordered mesh",
    "steps": "Each of twenty steps in one call",
    "steps in order": "Each of twenty steps in one call, on the reordered mesh",
    "implicit": "One implicit step",
    "flow": "A whole flow",
}


def markdown(header: list[str], rows: list[list[str]]) -> str:
    """A table with its first column to the left and numbers to the right."""
    lines = ["| " + " | ".join(header) + " |", "|---|" + "--:|" * (len(header) - 1)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def quality(metric: str) -> str:
    """The report's table of filters and meshes: one table for each way to choose parameters."""
    table = pd.read_csv(REPORT / "build" / "tables" / "quality.csv")
    _, digits = METRICS[metric]
    tabs = []
    for way, words in WAYS.items():
        some = table[(table["parameters"] == way) & (table["method"] != "none")]
        grid = some.pivot(index="method", columns="mesh", values=metric)
        grid = grid.loc[some["method"].unique(), some["mesh"].unique()]
        best = grid.max() if metric == "snr" else grid.min()
        noisy = table[table["method"] == "none"].set_index("mesh")[metric]
        rows = [["*noisy*", *(f"{noisy[mesh]:.{digits}f}" for mesh in grid.columns)]]
        for method, values in grid.iterrows():
            marked = [
                f"**{value:.{digits}f}**" if value == best[mesh] else f"{value:.{digits}f}"
                for mesh, value in values.items()
            ]
            rows.append([f"[{method}](gallery/{method}.ipynb)", *marked])
        tabs.append(
            f":::{{tab-item}} {words}\n\n{markdown(['filter', *grid.columns], rows)}\n\n:::"
        )
    return "::::{tab-set}\n\n" + "\n\n".join(tabs) + "\n\n::::"


def best() -> str:
    """For each mesh the filters with the smallest normal angle, with automatic parameters."""
    table = pd.read_csv(REPORT / "build" / "tables" / "quality.csv")
    some = table[(table["parameters"] == "auto") & (table["method"] != "none")]
    rows = []
    for mesh, group in some.groupby("mesh", sort=False):
        first = group.nsmallest(3, "normal_angle")
        cells = [
            f"[{m}](gallery/{m}.ipynb) {a:.1f}°"
            for m, a in zip(first["method"], first["normal_angle"], strict=True)
        ]
        rows.append([str(mesh), *cells])
    return markdown(["mesh", "best", "second", "third"], rows)


def machine() -> str:
    """On which machine the times were measured."""
    facts = pd.read_csv(REPORT / "results" / "machine.csv").set_index("what")["value"]
    return (
        f"{facts['cores']} cores of an {facts['processor']}, {facts['system']}, "
        f"Python {facts['python']}, NumPy {facts['numpy']}, "
        f"SciPy {facts['scipy']}, numba {facts['numba']}"
    )


def written(ratio: float) -> str:
    """A ratio with two digits: 0.85, 2.3, 14, 160."""
    return np.format_float_positional(ratio, precision=2, unique=False, fractional=False, trim="-")


def vertices() -> str:
    """The number of vertices of the mesh that most times are of."""
    bench = pd.read_csv(REPORT / "results" / "bench.csv")
    return f"{bench.loc[bench['task'] == 'step', 'vertices'].iloc[0]:,}"


def bench() -> str:
    """Times beside other libraries, a table a task."""
    table = pd.read_csv(REPORT / "results" / "bench.csv")
    parts = []
    for task, group in table.groupby("task", sort=False):
        rows = [
            [
                f"**{row.contender}**" if row.contender.startswith("ours") else row.contender,
                f"{1e3 * row.seconds:.3g}",
                written(row.times_ours),
                f"{row.peak_bytes / 1e6:.0f}",
            ]
            for row in group.itertuples()
        ]
        head = ["", "milliseconds", "times ours", "peak memory, MB"]
        words = TASKS.get(str(task), str(task))
        parts.append(
            f"### {words}\n\n{group['vertices'].iloc[0]:,} vertices.\n\n{markdown(head, rows)}"
        )
    return "\n\n".join(parts)


def filters() -> str:
    """Seconds of each filter with default parameters."""
    table = pd.read_csv(REPORT / "results" / "filters.csv")
    rows = [[row.method, f"{row.seconds:.3g}"] for row in table.itertuples()]
    return f"{table['faces'].iloc[0]:,} triangles.\n\n" + markdown(["filter", "seconds"], rows)


def scaling() -> str:
    """How times grow with the mesh."""
    table = pd.read_csv(REPORT / "results" / "scaling.csv")
    names = {
        "edges_ns": "edges", "cotangent_ns": "cotangent weights",
        "averaging_ns": "averaging operator", "step_ns": "a step", "whole_flow_ns": "a whole flow",
    }  # fmt: skip
    rows = [
        [
            f"{row['vertices']:,.0f}",
            *(f"{row[key]:.3g}" for key in names),
            f"{row['peak_bytes_per_vertex']:.0f}",
        ]
        for _, row in table.iterrows()
    ]
    return markdown(["vertices", *names.values(), "peak bytes a vertex"], rows)
