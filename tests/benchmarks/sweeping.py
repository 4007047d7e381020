"""What a sweep costs beside its cells: 20,000 cells of a millisecond, on a cluster of two workers.

    python tests/benchmarks/sweeping.py

writes report/results/sweeping.csv. Each row is one sweep, with a journal, in a process of its own:

    where             here (this process alone); cluster (two workers of `connect`); one a message
                      (the same, with one cell in each message to a worker: the most that the
                      scheduler is asked for)
                      or light submissions: files without functions, marked on the cluster
    cells, workers
    seconds           of the whole sweep, without the start of the workers
    client_ms         processor time of the client and the scheduler, by cell; where the
                      cells run here, too, beyond their own
    worker_ms         processor time of the workers beyond that of the cells themselves, by cell
                      (for submissions, which run in processes of their own, all of the workers')
    peak_bytes        most memory of client and scheduler, beyond that before the first cell
    written, read     rows of the journal by second, written one by one, and read (submissions
                      have records instead: NaN)
"""

import argparse
import json
import math
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from functools import partial
from pathlib import Path

import measuring

from meshfair.experiments import dispatch, journal
from meshfair.experiments.cluster import connect
from meshfair.experiments.sweep import Sweep
from meshfair_grading.cluster import PACKAGES, marks_on
from meshfair_grading.generate import ASSIGNMENTS
from meshfair_grading.isolation import Isolation, Limits
from meshfair_grading.marking import grade
from meshfair_grading.source import Source

RESULTS = Path(__file__).resolve().parents[2] / "report" / "results"
CELL_SECONDS = 1e-3
WORKERS = 2
CELLS = 20_000
GRADING = "light submissions"
ROWS = [
    ("here", CELLS),
    ("cluster", CELLS // 10),
    ("cluster", CELLS),
    ("one a message", CELLS // 10),
    (GRADING, 200),
]


def busy(x, seconds):
    """Use a processor for a time."""
    end = time.thread_time() + seconds
    while time.thread_time() < end:
        pass
    return {"half": x / 2}


def measure(where, count):
    """One row of the table."""
    if where == "one a message":
        dispatch.BATCH_SECONDS, dispatch.MESSAGES = 1e-9, math.inf
    grid = {"experiment": busy, "x": list(range(count)), "seconds": CELL_SECONDS}
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        path = Path(folder) / "rows.jsonl"
        sweep, cluster = Sweep([grid], path=path), None
        if where != "here":
            cluster = stack.enter_context(connect(workers=WORKERS))
            cluster.client.wait_for_workers(WORKERS)
        before = _processor_seconds(cluster)
        peak, (seconds, _) = measuring.peak_memory(
            lambda: measuring.timed(lambda: sweep.run(cluster, progress=False))
        )
        client, workers = (
            1e3 * (after - first) / count
            for after, first in zip(_processor_seconds(cluster), before, strict=True)
        )
        if sweep.failed or sweep.waiting:
            raise RuntimeError(f"{sweep.failed} cells failed, {sweep.waiting} did not run")
        written, read = _journal(path, Path(folder) / "again.jsonl")
    own = 1e3 * CELL_SECONDS
    return {
        "where": where, "cells": count, "workers": WORKERS if cluster else 1, "seconds": seconds,
        "client_ms": client if cluster else client - own,
        "worker_ms": workers - own if cluster else 0.0,
        "peak_bytes": peak, "written": written, "read": read,
    }  # fmt: skip


def measure_grading(count):
    """One row of the table: submissions in place of cells."""
    source, limits = Source.read(ASSIGNMENTS / "source" / "a2.py"), Limits()
    with tempfile.TemporaryDirectory() as folder, connect(workers=WORKERS, packages=PACKAGES) as c:
        c.client.wait_for_workers(WORKERS)
        submissions = Path(folder) / "submissions"
        submissions.mkdir()
        for k in range(count):
            (submissions / f"student{k:05}.py").write_text(f"# {k}\n")
        mark = partial(marks_on, c, source=source, limits=limits, without_walls=True)
        out, isolation = Path(folder) / "marks.csv", Isolation(limits)
        before = _processor_seconds(c)
        peak, (seconds, marks) = measuring.peak_memory(
            lambda: measuring.timed(
                lambda: grade(submissions, source, out, isolation, seed=7, elsewhere=mark)
            )
        )
        client, workers = (
            1e3 * (after - first) / count
            for after, first in zip(_processor_seconds(c), before, strict=True)
        )
    if {mark.status for mark in marks} != {"graded"}:
        raise RuntimeError("not all submissions were marked")
    return {
        "where": GRADING, "cells": count, "workers": WORKERS, "seconds": seconds,
        "client_ms": client, "worker_ms": workers, "peak_bytes": peak,
        "written": math.nan, "read": math.nan,
    }  # fmt: skip


def _processor_seconds(cluster):
    """Processor time of this process until now, and of the workers together."""
    workers = cluster.client.run(time.process_time).values() if cluster else ()
    return time.process_time(), sum(workers)


def _journal(path, again):
    """Rows by second: written one by one, and read."""
    seconds, rows = measuring.timed(lambda: journal.read(path))

    def write():
        with journal.Journal(again) as file:
            for row in rows.items():
                file.append([row])

    return len(rows) / measuring.timed(write)[0], len(rows) / seconds


def table(quick=False):
    """Measure each row in a process of its own; print and return the rows."""
    print("sweeps of cells of a millisecond: overhead a cell, memory of the client, journal")
    rows = []
    for where, count in [("cluster", 200)] if quick else ROWS:
        command = [sys.executable, __file__, "--row", where, str(count)]
        done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
        rows.append(json.loads(done.stdout))
        print(
            "  "
            + "  ".join(f"{k} {v if k == 'where' else f'{v:,.4g}'}" for k, v in rows[-1].items())
        )
    return rows


def _short(value):
    return value if isinstance(value, str) else f"{value:,.4g}"


def main():
    """Print one row as JSON, or write them all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--row", nargs=2, metavar=("WHERE", "CELLS"), help="measure this alone")
    options = parser.parse_args()
    if options.row:
        where, count = options.row[0], int(options.row[1])
        print(json.dumps(measure_grading(count) if where == GRADING else measure(where, count)))
        return
    measuring.write(RESULTS / "sweeping.csv", table())


if __name__ == "__main__":
    main()
