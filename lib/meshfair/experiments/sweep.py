"""One loop for every experiment: a grid of parameters, a row for each cell."""

from __future__ import annotations

import os
import re
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import TYPE_CHECKING, Any

from meshfair import io
from meshfair.checks import check_choice, needed_for
from meshfair.experiments.cells import Cell, Row, attempt, cells
from meshfair.experiments.dispatch import (
    ExecutorWorkers,
    Rows,
    SweepStoppedError,
    Workers,
    dispatch,
)
from meshfair.experiments.journal import Journal, read
from meshfair.experiments.meshes import Mesh, digest

if TYPE_CHECKING:
    import pandas as pd

Grid = Mapping[str, Any]

# A sweep can be given up when so many cells have run and all have failed alike.
FIRST = 10


def sweep(
    grid: Grid | Sequence[Grid],
    executor: Executor | Workers | None = None,
    *,
    path: str | os.PathLike[str] | None = None,
    progress: bool = True,
    failures: str = "warn",
) -> pd.DataFrame:
    """Run an experiment on every combination of parameters; a row for each.

    Parameters
    ----------
    grid : dict, or sequence of dicts
        ``experiment``: a function of an importable module that takes one
        value of each axis by name and returns a dict, the row's results. Every
        other entry is an axis: a list or tuple of values, or one value (text
        is one value). Values are numbers, text, booleans or None; an axis
        named ``mesh`` holds names for `meshfair.experiments.load_mesh`. A result
        that is a mesh (V, F) goes to a file beside ``path``. Several grids make one table.
    executor : concurrent.futures.Executor or meshfair.experiments.cluster.Cluster, optional
        Where the cells run: a ``ProcessPoolExecutor``, an ``MPIPoolExecutor``, dask's cluster
        (see `meshfair.experiments.cluster.connect`). By default they run here, one after the other.
    path : path, optional
        A file that keeps each row as soon as it is finished (JSON lines).
        Started again with the same file, a sweep goes on where it stopped,
        whatever stopped it; a cell that failed is tried again.
    progress : bool
        Show a progress bar, where standard error is a terminal.
    failures : {"warn", "raise"}
        What to do, after the last cell, where a cell has failed.

    Returns
    -------
    pandas.DataFrame
        A row a cell, in the order of the grid, the last axis fastest:
        the parameters, the results, and where a cell failed a column
        ``error`` with its message; the others go on.

    Raises
    ------
    ValueError
        No function under ``experiment``, or no cell.
    SweepStoppedError
        The workers are gone; finished rows are kept.
    RuntimeError
        A cell has failed, and this is wanted; the message has the first one's parameters.

    Warns
    -----
    RuntimeWarning
        Cells have failed.
    """
    check_choice(failures, "failures", ("warn", "raise"))
    with needed_for("an experiment"):
        import pandas  # noqa: F401  now, and not after the last cell
        import tqdm  # noqa: F401

    run = Sweep([grid] if isinstance(grid, Mapping) else grid, path=path)
    run.run(executor, progress=progress)
    if run.first_failure:
        cell, error = run.first_failure
        said = f"a cell of the sweep failed ({cell}): {error}"
        if failures == "raise":
            raise RuntimeError(said)
        others = f"{run.failed} of {len(run.cells)} cells; see the table's column error"
        warnings.warn(f"{said}; so did {others}", RuntimeWarning, stacklevel=2)
    return run.table()


class Sweep:
    """A sweep with its counts; `sweep` is this in one call.

    Parameters
    ----------
    grids : sequence of dict
        As in `sweep`.
    path : path, optional
        As in `sweep`.
    """

    def __init__(self, grids: Sequence[Grid], *, path: str | os.PathLike[str] | None) -> None:
        self._path = None if path is None else Path(path)
        self.cells = cells(grids)
        kept = read(path) if path else {}
        self._finished = {
            cell.key: kept[cell.key] for cell in self.cells if "result" in kept.get(cell.key, {})
        }
        self._waiting = {cell.key: cell for cell in self.cells if cell.key not in self._finished}
        self.from_journal = len(self.cells) - sum(c.key in self._waiting for c in self.cells)
        """How many cells had their rows already."""
        self.failed = 0
        """How many cells have failed."""

    @property
    def run_now(self) -> int:
        """How many cells have run since the start, failed ones among them."""
        return sum(c.key in self._finished for c in self.cells) - self.from_journal

    @property
    def waiting(self) -> int:
        """How many cells have no row yet."""
        return len(self.cells) - self.run_now - self.from_journal

    def run(
        self,
        executor: Executor | Workers | None = None,
        *,
        progress: bool = True,
        on_first_failure: Callable[[Cell, str], None] | None = None,
        give_up: bool = False,
    ) -> None:
        """Run the cells that have no row yet.

        Parameters
        ----------
        executor, progress
            As in `sweep`.
        on_first_failure : callable, optional
            Called with the first cell that fails and its message, as soon as it does.
        give_up : bool
            Begin with cells from all over the grid, and stop where all of these fail alike.

        Raises
        ------
        SweepStoppedError
            Given up, or the workers are gone.
        """
        with needed_for("an experiment"):
            from tqdm import tqdm

        waiting = _in_order(list(self._waiting.values()), FIRST if give_up else 0)
        begun, kinds = 0, set()
        with (
            Journal(self._path) as journal,
            tqdm(
                total=len(self.cells),
                initial=self.from_journal,
                disable=None if progress else True,
                unit="cell",
            ) as bar,
        ):
            for rows in _run(waiting, executor):
                rows = [(cell, self._with_files(row)) for cell, row in rows]
                journal.append((cell.key, row) for cell, row in rows)
                for cell, row in rows:
                    if self._note(cell, row) and on_first_failure:
                        with bar.external_write_mode(sys.stderr):
                            on_first_failure(cell, row["error"])
                    begun += 1
                    kinds.add(_kind(row))
                if self.failed:
                    bar.set_postfix_str(f"{self.failed} failed", refresh=False)
                bar.update(len(rows))
                if give_up and self.failed == begun >= FIRST and len(kinds) == 1:
                    raise SweepStoppedError(
                        f"given up, since all of the first {begun} cells failed, and failed alike"
                    )

    def _note(self, cell: Cell, row: Row) -> bool:
        """Count a row; return whether it is the first that failed."""
        self._finished[cell.key] = row
        self.failed += "error" in row
        return "error" in row and self.failed == 1

    @property
    def first_failure(self) -> tuple[Cell, str] | None:
        """Of the cells that have failed, the first in the grids, with its message."""
        for cell in self.cells:
            if "error" in (row := self._finished.get(cell.key, {})):
                return cell, row["error"]
        return None

    def _with_files(self, row: Row) -> Row:
        """A row whose meshes are files, named by what is in them."""
        meshes: dict[str, Mesh] = row.get("meshes", {})
        if not meshes:
            return row
        if self._path is None:
            return {"error": "ValueError: results that are meshes need a journal, to lie beside it"}
        folder = self._path.with_name(f"{self._path.stem}_meshes")
        folder.mkdir(exist_ok=True)
        result = dict(row["result"])
        for name, (V, F) in meshes.items():
            file = folder / f"{digest((V, F))[:24]}.ply"
            io.write(file, V, F)
            result[name] = f"{folder.name}/{file.name}"
        return {"result": result}

    def table(self) -> pd.DataFrame:
        """The rows that are finished, in the order of the grids.

        Returns
        -------
        pandas.DataFrame
            As `sweep`.
        """
        import pandas as pd

        return pd.DataFrame(
            [_row(c, self._finished[c.key]) for c in self.cells if c.key in self._finished]
        )


def _row(cell: Cell, finished: Row) -> Row:
    error = {"error": finished["error"]} if "error" in finished else {}
    return {**cell.parameters, **finished.get("result", {}), **error}


def _run(waiting: Sequence[Cell], executor: Executor | Workers | None) -> Iterator[Rows]:
    if executor is None:
        return ([(cell, attempt(cell))] for cell in waiting)
    workers = ExecutorWorkers(executor) if isinstance(executor, Executor) else executor
    return dispatch(workers, waiting)


def _in_order(waiting: list[Cell], first: int) -> list[Cell]:
    """Cells in the order in which they run: some from all over, then mesh by mesh.

    So that one bad value does not look like a bad grid, and that a worker has few meshes at a
    time. The table does not depend on it.
    """
    step = max(len(waiting) // first, 1) if first else 1
    chosen = range(0, len(waiting), step)[:first]
    meshes: dict[tuple[str, ...], int] = {}
    for cell in waiting:
        meshes.setdefault(cell.meshes, len(meshes))
    rest = [cell for k, cell in enumerate(waiting) if k not in chosen]
    return [waiting[k] for k in chosen] + sorted(rest, key=lambda cell: meshes[cell.meshes])


def _kind(row: Row) -> str:
    """A row's error without its numbers and quoted words; nothing for a result."""
    return re.sub(r"'[^']*'|[\d.]+", "", row.get("error", ""))
