"""The same shape at five sizes: how time and memory grow with the number of vertices."""

import multiprocessing
from pathlib import Path

import igl
import measuring
import numpy as np

from meshfair import datasets, flow, mesh, operators, shapes, weights

LEVELS = 5  # the bunny, and its faces split in four, four times
MAIN = 2  # the level that libraries are compared on
STEPS = 20


def meshes(folder, quick=False):
    """Write the mesh of each level to a file; return files with numbers of vertices and faces."""
    V, F = shapes.torus(sections=30, sides=20) if quick else _bunny()
    written = []
    for level in range(2 if quick else LEVELS):
        if level:
            V, F = igl.upsample(V, F, 1)
        file = Path(folder) / f"level{level}.npz"
        np.savez(file, V=V, F=F.astype(np.int64))
        written.append((file, len(V), len(F)))
    return written


def _bunny():
    """The Stanford bunny's referenced vertices, or a torus with about as many."""
    try:
        V, F = igl.read_triangle_mesh(str(datasets.fetch("bunny")))
    except datasets.DownloadError as error:
        print(f"without the bunny, on a torus: {error}")
        return shapes.torus(sections=292, sides=120)
    used = np.unique(F)
    return V[used], np.searchsorted(used, F)


def table(meshes, rounds):
    """Measure each level in a process of its own; print and return the rows."""
    print(
        "by size, nanoseconds a vertex (step: each of twenty; whole_flow: twenty, the SNR at each)"
    )
    rows = []
    for file, _, _ in meshes:
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            rows.append(pool.apply(measure, (file, rounds)))
        print("  " + "  ".join(f"{key} {value:,.6g}" for key, value in rows[-1].items()))
    return rows


def measure(file, rounds):
    """One row of the table."""
    explicit_flow(*shapes.icosphere(6), np.random.default_rng(0))()  # compiles
    with np.load(file) as arrays:
        V, F = arrays["V"], arrays["F"]
    n = len(V)
    whole = explicit_flow(V, F, np.random.default_rng(0))
    peak, _ = measuring.peak_memory(whole)
    edges = mesh.Edges(F, n)
    W = weights.cotangent(V, edges)
    A = operators.averaging(weights.combinatorial(edges, n))
    tasks = {
        "edges": lambda: mesh.Edges(F, n).sparsity,
        "cotangent": lambda: weights.cotangent(V, edges),
        "averaging": lambda: operators.averaging(W),
        "step": lambda: flow.average(V, A, STEPS),
        "whole_flow": whole,
    }
    row = {"vertices": n, "faces": len(F)}
    for name, run in tasks.items():
        seconds = measuring.median(measuring.timed(run)[0] for _ in range(rounds))
        row[f"{name}_ns"] = 1e9 * seconds / n / (STEPS if name == "step" else 1)
    return {**row, "peak_bytes_per_vertex": peak / n}


def explicit_flow(V, F, rng):
    """The flow from positions and faces on: weights, operator, steps, the SNR at each."""
    edge = mesh.mean_edge_length(V, F[:1000])  # that of a part, to leave memory alone
    V_noisy = V + 0.2 * edge * rng.standard_normal(V.shape)
    return lambda: flow.snr_curve(
        V_noisy, V, operators.averaging(weights.distance(V_noisy, F)), 1.0, STEPS
    )
