"""The learned filter beside the defaults of all others, on the validation shapes."""

import csv
from collections.abc import Iterable
from itertools import product
from multiprocessing import Pool
from pathlib import Path

import numpy as np
from examples import correlated, impulsive, uniform
from validation import SHAPES

from meshfair import denoising, metrics, noise

NOISES = {
    "normals": noise.along_normals,
    "gaussian": noise.gaussian,
    "uniform": uniform,
    "impulsive": impulsive,
    "correlated": correlated,
}
SIZES = (0.1, 0.2, 0.35, 0.6)
CELLS = [
    (shape, kind, f"{size:g}") for shape, kind, size in product(SHAPES, NOISES, SIZES)
]  # as text, as they stand in a table
COLUMNS = ["shape", "noise", "size", "method", "normal_angle", "snr", "seconds"]

Row = dict[str, str]


def score(folder: Path, path: Path, processes: int = 2) -> None:
    """Write all cells to a table, and print how often the learned filter is the best.

    Parameters
    ----------
    folder : Path
        Where the scores of the other filters are kept, which training does not change.
    path : Path
        The table.
    processes : int
    """
    others = ["noisy", *(name for name in denoising.methods() if name != "learned")]
    rows = scored(folder / "others.csv", others, processes)
    new = folder / "learned.csv"
    new.unlink(missing_ok=True)
    rows += scored(new, ["learned"], processes)
    order = {place: k for k, place in enumerate(CELLS)}
    rows.sort(key=lambda row: order[_place(row)])  # the methods stay in their order
    with path.open("w", newline="") as file:
        table = csv.DictWriter(file, COLUMNS)
        table.writeheader()
        table.writerows(rows)
    summary(rows)


def scored(path: Path, methods: Iterable[str], processes: int) -> list[Row]:
    """The rows of these methods for all cells; those that the table has are not made again."""
    if not path.exists():
        path.write_text(",".join(COLUMNS) + "\n")
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    there = {_place(row) for row in rows}
    jobs = [(place, tuple(methods)) for place in CELLS if place not in there]
    with path.open("a", newline="") as file, Pool(processes) as pool:
        table = csv.DictWriter(file, COLUMNS)
        for done, made in enumerate(pool.imap(_cell, jobs), start=1):
            table.writerows(made)
            file.flush()
            rows += made
            print(f"\rscoring: {done} of {len(jobs)}", end="", flush=True)
    print()
    return rows


def _place(row: Row) -> tuple[str, str, str]:
    return row["shape"], row["noise"], row["size"]


def _cell(job: tuple[tuple[str, str, str], tuple[str, ...]]) -> list[Row]:
    """Rows of one shape with one noise."""
    (shape, kind, size), methods = job
    V, F = SHAPES[shape]()
    rng = np.random.default_rng([list(SHAPES).index(shape), list(NOISES).index(kind)])
    V_noisy = NOISES[kind](V, F, float(size), rng)
    rows = []
    for method in methods:
        X, seconds = V_noisy, 0.0
        if method != "noisy":
            found = denoising.denoise(V_noisy, F, method)
            X, seconds = found.V, found.seconds
        angle, ratio = metrics.normal_angle(X, V, F), metrics.snr(V, X)
        values = shape, kind, size, method, f"{angle:.4f}", f"{ratio:.3f}", f"{seconds:.3f}"
        rows.append(dict(zip(COLUMNS, values, strict=True)))
    return rows


def summary(rows: list[Row]) -> None:
    """Print the share of cells in which the learned filter beats the best other default."""
    cells: dict[tuple[str, ...], dict[str, float]] = {}
    for row in rows:
        cells.setdefault(_place(row), {})[row["method"]] = float(row["normal_angle"])
    groups: dict[str, list[float]] = {}
    for place, angles in cells.items():
        best = min(x for name, x in angles.items() if name not in ("learned", "noisy"))
        for group in ("all", *place):
            groups.setdefault(group, []).append(angles["learned"] / best)
    for group, ratios in groups.items():
        print(
            f"{group}: better in {np.mean(np.array(ratios) < 1):.0%} of {len(ratios)}, "
            f"angle over the best other's: median {np.median(ratios):.3f}, worst {max(ratios):.3f}"
        )
