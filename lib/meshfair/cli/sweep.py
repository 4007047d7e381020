"""Run an experiment on a grid of parameters, here or on a cluster.

A grid is a TOML file: an experiment (stopping, quality, choices, or
module:function of your own), and its axes, such as

    experiment = "stopping"
    mesh = ["knot", "scans/*.ply"]
    noise = "normals"
    size = [0.1, 0.2, 0.4]
    weights = ["combinatorial", "cotangent"]
    seed = { from = 0, to = 199 }

table-1, quality and choices are the names of grids that come with meshfair. Each
finished cell is kept in a journal beside the table. What stops the sweep
(Ctrl-C, a power cut, a cluster that goes away) costs only the cells that were
running: the same command goes on. Cells that failed are tried again by it.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from meshfair.cli import files, printing

if TYPE_CHECKING:
    from meshfair.experiments.cells import Cell
    from meshfair.experiments.sweep import Sweep


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the subcommand's arguments."""
    parser.add_argument(
        "grid", metavar="GRID", help="the grid file, or table-1, quality or choices"
    )
    parser.add_argument(
        "--out", type=Path, required=True, metavar="TABLE.csv", help="the table to write"
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--workers", type=int, metavar="N", help="run in N processes")
    where.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="run on the dask cluster of this scheduler: its address or its scheduler file",
    )
    parser.add_argument(
        "--wait",
        type=float,
        default=60.0,
        metavar="SECONDS",
        help="how long to wait for a worker where there is none (default 60)",
    )
    parser.add_argument(
        "--journal", type=Path, help="where finished cells are kept (default: TABLE.jsonl)"
    )
    parser.add_argument(
        "--keep-going", action="store_true", help="go on when the first cells all fail alike"
    )
    parser.add_argument("--force", action="store_true", help="replace a table without a journal")
    files.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the sweep, write the table, and say what happened.

    Returns
    -------
    int
        0, or 1 where a cell failed or the sweep had to stop.

    Raises
    ------
    ValueError, OSError
        A wrong grid, or a table that would replace another.
    NotInstalledError
        A library is missing.
    """
    from meshfair.experiments.dispatch import SweepStoppedError
    from meshfair.experiments.grids import read_grids
    from meshfair.experiments.sweep import Sweep
    from meshfair.io.saving import replace_file

    journal = options.journal or options.out.with_suffix(".jsonl")
    _check_output(options.out, journal, options.force)
    sweep = Sweep(read_grids(options.grid), path=journal)
    try:
        _work(sweep, options)
    except (SweepStoppedError, KeyboardInterrupt) as stop:
        done = sweep.from_journal + sweep.run_now - sweep.failed
        kept = f"the results of {done:,} of {len(sweep.cells):,} cells are in {journal}, "
        kept += "and the same command goes on"
        _say(f"{str(stop) or 'stopped'}; {kept if done else 'no cell has its result yet'}")
        if isinstance(stop, KeyboardInterrupt):
            raise
        return 1
    table = sweep.table().to_csv(index=False, lineterminator="\n")
    replace_file(options.out, table.encode())
    _summarize(sweep, options)
    return 1 if sweep.failed else 0


def _check_output(out: Path, journal: Path, force: bool) -> None:
    """Refuse a table that cannot be written, or would replace one that is not this sweep's."""
    if out.suffix.lower() != ".csv":
        raise ValueError(f"{out}: the table is a CSV; give it a name that ends in .csv")
    files.check_folder(out)
    if out.exists() and not journal.exists() and not force:
        raise FileExistsError(
            f"{out} is there already, and no journal {journal} that it came from; replace it with "
            "--force, or choose another name"
        )


def _work(sweep: Sweep, options: argparse.Namespace) -> None:
    """Run the cells where the options say."""
    if not sweep.waiting or (options.workers is None and options.scheduler is None):
        sweep.run(on_first_failure=_say_failure, give_up=not options.keep_going)
        return
    from meshfair.experiments.cluster import connect

    with connect(options.scheduler, workers=options.workers, wait=options.wait) as cluster:
        sweep.run(cluster, on_first_failure=_say_failure, give_up=not options.keep_going)


def _say(message: str) -> None:
    print(f"meshfair sweep: {message}", file=sys.stderr)


def _say_failure(cell: Cell, error: str) -> None:
    _say(f"a cell failed ({cell}): {error}")


def _summarize(sweep: Sweep, options: argparse.Namespace) -> None:
    """Print the closing line."""
    first = sweep.first_failure
    row = sweep.cells.index(first[0]) + 1 if first else None
    if options.json:
        printing.print_json(
            {
                "out": options.out,
                "cells": len(sweep.cells),
                "run": sweep.run_now,
                "from_journal": sweep.from_journal,
                "failed": sweep.failed,
                "first_failure": first
                and {"row": row, "parameters": first[0].parameters, "error": first[1]},
            }
        )
        return
    print(
        f"{options.out}: {len(sweep.cells):,} cells, {sweep.run_now:,} run now, "
        f"{sweep.from_journal:,} from the journal, {sweep.failed:,} failed"
        + (f", first in row {row} ({first[0]}): {first[1]}" if first else "")
    )
