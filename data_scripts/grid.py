"""Compare the choices of methods and parameters, for the report: `make grid`.

    python data_scripts/grid.py [--processes N] [--pairs FOLDER]

Writes to report/results:

    choices.csv        every method with default, automatic and tuned parameters, and the
                       front's own choice, on the grid of `meshfair.experiments.choices`
    missile_draws.csv  the jet's missiles over ten draws of the noise
    knot_draws.csv     the knot over ten draws, at three sizes
    pairs.csv          only with --pairs: every default and the front's choice on pairs of meshes
                       SOURCE/NAME-noisy.obj and SOURCE/NAME-clean.obj, such as other works publish

Finished cells are kept in data/grid: interrupt it at any time. `make data` before adds the public
pairs to the grid.
"""

import argparse
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pandas as pd

from meshfair import _fast, denoising, experiments, io
from meshfair.mesh import mean_edge_length

ROOT = Path(__file__).resolve().parents[1]
SEED = 1
TABLES: dict[str, Callable[..., pd.DataFrame]] = {
    "missile_draws": experiments.missile_draws,
    "knot_draws": experiments.knot_draws,
    "choices": lambda **options: experiments.compare_choices(seed=SEED, **options),
}


def main() -> None:
    """Make the tables that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--processes", type=int, default=2, metavar="N")
    parser.add_argument("--pairs", type=Path, metavar="FOLDER", help="pairs to score, and no more")
    parser.add_argument("--results", type=Path, default=ROOT / "report" / "results")
    parser.add_argument("--journals", type=Path, default=ROOT / "data" / "grid")
    options = parser.parse_args()
    if options.pairs:
        write(pairs(options.pairs), options.results / "pairs.csv")
        return
    options.journals.mkdir(parents=True, exist_ok=True)
    context = get_context("spawn")  # a forked process would inherit numba's threads
    with ProcessPoolExecutor(options.processes, context, initializer=begin) as pool:
        for name, make in TABLES.items():
            journal = options.journals / f"{name}.jsonl"
            table = make(executor=pool, path=journal, progress=True)
            write(table.drop(columns="used", errors="ignore"), options.results / f"{name}.csv")


def begin() -> None:
    """Make a worker ready: one core each, and the loops for small meshes too."""
    _fast.use_one_core()
    _fast.FILTER_ROWS = 0  # they are loaded anyway


def pairs(folder: Path) -> pd.DataFrame:
    """The noisy mesh, every default and the front's own choice, for each pair of a folder.

    Parameters
    ----------
    folder : Path
        Of SOURCE/NAME-noisy and SOURCE/NAME-clean files of one format, with the same faces;
        SOURCE is the work's key in report/references.bib.

    Returns
    -------
    pandas.DataFrame
        source, pair, faces, size (of the noise, in mean edge lengths), method, and what
        `meshfair.experiments.outcome` returns.
    """
    rows = []
    for file in sorted(folder.glob("*/*-noisy.*")):
        name = file.name.partition("-noisy.")[0]
        V_noisy, F = io.read(file)
        V, _ = io.read(file.with_name(file.name.replace("-noisy.", "-clean.")))
        moved = np.linalg.norm(V_noisy - V, axis=1)
        size = np.sqrt(np.mean(moved**2)) / mean_edge_length(V, F)
        for method in ["none", "auto", *denoising.methods()]:
            found = experiments.outcome(V_noisy, V, F, method, "default")
            pair = {"source": file.parent.name, "pair": name, "faces": len(F), "size": size}
            rows.append(pair | {"method": method} | found)
        print(name, flush=True)
    return pd.DataFrame(rows).drop(columns="used")


def write(table: pd.DataFrame, path: Path) -> None:
    """A table as a file, with five digits."""
    table.to_csv(path, index=False, float_format="%.5g", lineterminator="\n")
    print(f"{path}: {len(table):,} rows")


if __name__ == "__main__":
    main()
