"""The learned filter beside the defaults of all others, on the validation shapes."""

import csv
from collections.abc import Iterable
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
COLUMNS = ["shape", "noise", "size", "method", "normal_angle", "snr", "seconds"]


def cell(job: tuple[str, str, float, tuple[str, ...]]) -> list[dict[str, object]]:
    """Rows of one shape with one noise: the noisy mesh, and what each method makes of it."""
    shape, kind, size, methods = job
    V, F = SHAPES[shape]()
    rng = np.random.default_rng([list(SHAPES).index(shape), list(NOISES).index(kind)])
    V_noisy = NOISES[kind](V, F, size, rng)
    rows = []
    for method in ("noisy", *methods):
        X, seconds = V_noisy, 0.0
        if method != "noisy":
            X, *_, seconds, _ = denoising.denoise(V_noisy, F, method)
        rows.append(
            {
                "shape": shape, "noise": kind, "size": size, "method": method,
                "normal_angle": f"{metrics.normal_angle(X, V, F):.4f}",
                "snr": f"{metrics.snr(V, X):.3f}", "seconds": f"{seconds:.3f}",
            }
        )  # fmt: skip
    return rows


def score(path: Path, methods: Iterable[str], processes: int = 2) -> None:
    """Write all cells to a table, and print how often the learned filter is the best."""
    methods = tuple(methods)
    jobs = [(shape, kind, size, methods) for shape in SHAPES for kind in NOISES for size in SIZES]
    with path.open("w", newline="") as file:
        table = csv.DictWriter(file, COLUMNS)
        table.writeheader()
        with Pool(processes) as pool:
            for done, rows in enumerate(pool.imap(cell, jobs), start=1):
                table.writerows(rows)
                print(f"\rscoring: {done} of {len(jobs)}", end="", flush=True)
    print()
    summary(path)


def summary(path: Path) -> None:
    """Print the share of cells in which the learned filter beats the best other default."""
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    cells: dict[tuple[str, str, str], dict[str, float]] = {}
    for row in rows:
        place = row["shape"], row["noise"], row["size"]
        cells.setdefault(place, {})[row["method"]] = float(row["normal_angle"])
    for k, what in ((None, "all"), (0, "shape"), (1, "noise"), (2, "size")):
        groups: dict[str, list[float]] = {}
        for place, angles in cells.items():
            best = min(x for name, x in angles.items() if name not in ("learned", "noisy"))
            groups.setdefault(what if k is None else place[k], []).append(angles["learned"] / best)
        for group, ratios in groups.items():
            print(
                f"{what} {group}: better in {np.mean(np.array(ratios) < 1):.0%} of {len(ratios)}, "
                f"angle over the best other's: median {np.median(ratios):.3f}, "
                f"worst {max(ratios):.3f}"
            )
