"""Mark a class on dask's cluster: each submission behind the walls of the worker that has it."""

from __future__ import annotations

import atexit
import functools
import shutil
import tempfile
import threading
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from meshfair.experiments.cells import Cell
from meshfair.experiments.cluster import Cluster
from meshfair.experiments.dispatch import dispatch
from meshfair_grading import walls
from meshfair_grading.assignment import Assignment
from meshfair_grading.gradebook import Mark
from meshfair_grading.isolation import Isolation, Limits, NoWallsError
from meshfair_grading.marking import dry_run, mark, not_marked
from meshfair_grading.source import Source
from meshfair_grading.submissions import Submission, read

PACKAGES = ("meshfair", "meshfair_grading")
"""What must be the same on each worker."""

_PREPARING = threading.Lock()


def missing_walls(cluster: Cluster) -> dict[str, str]:
    """Which workers have no walls around submissions.

    Parameters
    ----------
    cluster : meshfair.experiments.cluster.Cluster

    Returns
    -------
    dict of str to str
        Their addresses, and why; see `meshfair_grading.walls.trouble`.
    """
    found = cluster.on_each_worker(walls.trouble)
    return {worker: why for worker, why in found.items() if why}


def check_walls(cluster: Cluster, *, without_walls: bool) -> list[str]:
    """Say which workers lack walls, or refuse to mark on them.

    Parameters
    ----------
    cluster : meshfair.experiments.cluster.Cluster
    without_walls : bool
        Mark there all the same.

    Returns
    -------
    list of str
        Lines for the teacher.

    Raises
    ------
    NoWallsError
        A worker has none, and they are wanted.
    """
    lacking = missing_walls(cluster)
    lines = [f"worker {worker}: NO walls: {why}" for worker, why in lacking.items()]
    if lacking and not without_walls:
        raise NoWallsError(
            f"submissions would run without walls on {len(lacking)} workers: {'; '.join(lines)}; "
            "install it there, stop these workers, or give --without-walls where all of their "
            "machines can be thrown away"
        )
    return [*lines, f"{cluster.slots() - len(lacking)} of {cluster.slots()} workers have walls"]


def marks_on(
    cluster: Cluster,
    submissions: Sequence[Submission],
    seed: int,
    *,
    source: Source,
    limits: Limits,
    without_walls: bool = False,
) -> Iterator[Mark]:
    """Mark submissions on a cluster.

    Parameters
    ----------
    cluster : meshfair.experiments.cluster.Cluster
    submissions : sequence of meshfair_grading.submissions.Submission
        Read here; workers need not see these files.
    seed : int
    source : meshfair_grading.source.Source
    limits : meshfair_grading.isolation.Limits
    without_walls : bool
        As `meshfair_grading.isolation.Isolation.detect`.

    Yields
    ------
    Mark
        As they come.

    Raises
    ------
    ValueError
        The solution does not get all points.
    SweepStoppedError
        The cluster is gone.
    """
    assignment = source.load()
    common = {"source": source, "limits": limits, "seed": seed, "without_walls": without_walls}
    # Before anybody is marked; a worker that comes later does it with its first submission.
    cluster.on_each_worker(_get_ready, source, limits, seed, without_walls)
    cells, of = [], {}
    for one in submissions:
        try:
            parameters = {"student": one.student, "content": read(one), "remark": one.remark}
        except ValueError:  # nothing to run
            yield mark(one, assignment, Isolation(limits), seed)
            continue
        of[one.student] = one
        cells.append(Cell(one.student, _marked, parameters | common))
    for rows in dispatch(cluster, cells):
        for cell, row in rows:
            if "result" in row:
                yield Mark.from_record(row["result"])
            else:
                yield not_marked(of[cell.key], assignment, row["error"])


def _marked(
    student: str,
    content: bytes,
    remark: str,
    source: Source,
    limits: Limits,
    seed: int,
    without_walls: bool,
) -> dict[str, Any]:
    """On a worker: the record of one submission's mark."""
    assignment, isolation = _prepared(source, limits, seed, without_walls)
    with tempfile.TemporaryDirectory(prefix="meshfair-") as folder:
        path = Path(folder) / f"{source.name}.py"
        path.write_bytes(content)
        submission = Submission(student, path, remark, own=path.parent)
        return asdict(mark(submission, assignment, isolation, seed))


def _get_ready(source: Source, limits: Limits, seed: int, without_walls: bool) -> None:
    _prepared(source, limits, seed, without_walls)


def _prepared(
    source: Source, limits: Limits, seed: int, without_walls: bool
) -> tuple[Assignment, Isolation]:
    """On a worker: the assignment, and the walls, tried out with the solution."""
    with _PREPARING:
        return _prepare(source, limits, seed, without_walls)


@functools.lru_cache(maxsize=4)
def _prepare(
    source: Source, limits: Limits, seed: int, without_walls: bool
) -> tuple[Assignment, Isolation]:
    cache = Path(tempfile.mkdtemp(prefix="meshfair-"))
    atexit.register(shutil.rmtree, cache, ignore_errors=True)
    walls.give(cache)
    isolation = Isolation.detect(limits, without_walls=without_walls)
    isolation = replace(isolation, numba_cache=cache)
    assignment = source.load()
    dry_run(source, assignment, isolation, seed)
    return assignment, isolation
