"""One loop for every experiment: a grid of parameters, a row for each cell."""

from __future__ import annotations

import hashlib
import itertools
import json
import os
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, as_completed
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from meshfair.checks import needed_for
from meshfair.experiments.meshes import load_mesh

if TYPE_CHECKING:
    import pandas as pd

Experiment = Callable[..., Mapping[str, Any]]
Row = dict[str, Any]
Cell = dict[str, Any]


def sweep(
    grid: Mapping[str, Any],
    executor: Executor | None = None,
    *,
    path: str | os.PathLike[str] | None = None,
    progress: bool = True,
) -> pd.DataFrame:
    """Run an experiment on every combination of parameters; a row for each.

    Parameters
    ----------
    grid : dict
        ``experiment``: a function of an importable module that takes one
        value of each axis by name and returns a dict, the row's results. Every
        other entry is an axis: a list or tuple of values, or one value (text
        is one value). Values are numbers, text, booleans or None; an axis
        named ``mesh`` holds names for `meshfair.experiments.load_mesh`.
    executor : concurrent.futures.Executor, optional
        Where the cells run: a ``ProcessPoolExecutor``, dask's
        ``client.get_executor()``, an ``MPIPoolExecutor``, ... By default they
        run here, one after the other.
    path : path, optional
        A file that keeps each row as soon as it is finished (JSON lines).
        Started again with the same file, a sweep goes on where it stopped,
        whatever stopped it; a cell that failed is tried again.
    progress : bool
        Show a progress bar, where standard error is a terminal.

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
    """
    with needed_for("an experiment"):
        import pandas as pd
        from tqdm import tqdm

    grid = dict(grid)
    experiment = grid.pop("experiment", None)
    if not callable(experiment):
        raise ValueError(
            "the grid needs a function under 'experiment', such as experiments.stopping"
        )
    axes = {k: v if isinstance(v, (list, tuple)) else (v,) for k, v in grid.items()}
    cells = [dict(zip(axes, values, strict=True)) for values in itertools.product(*axes.values())]
    if not cells:
        empty = ", ".join(name for name, values in axes.items() if not len(values))
        raise ValueError(f"the grid has no cell; these axes are empty: {empty}")

    keys = [_key(experiment, cell) for cell in cells]
    finished = _read(path) if path else {}
    waiting = {
        k: c for k, c in zip(keys, cells, strict=True) if "result" not in finished.get(k, {})
    }
    with (
        _Journal(path) as journal,
        tqdm(
            total=len(cells), initial=len(cells) - len(waiting), disable=None if progress else True
        ) as bar,
    ):
        for key, row in _run(experiment, waiting, executor):
            finished[key] = row
            journal.append({"key": key, **row})
            bar.update()
    return pd.DataFrame([_row(cell, finished[key]) for cell, key in zip(cells, keys, strict=True)])


def check_finished(table: pd.DataFrame) -> None:
    """Raise an error if a cell of a sweep failed.

    Parameters
    ----------
    table : pandas.DataFrame
        From `sweep`.

    Raises
    ------
    RuntimeError
        With the first failed cell's parameters and message.
    """
    if "error" in table and table["error"].notna().any():
        cell = table[table["error"].notna()].iloc[0].dropna()  # it has no results
        at = ", ".join(f"{name} {value}" for name, value in cell.drop("error").items())
        raise RuntimeError(f"a cell of the sweep failed ({at}): {cell['error']}")


def _row(cell: Cell, finished: Row) -> Row:
    error = {"error": finished["error"]} if "error" in finished else {}
    return {**cell, **finished.get("result", {}), **error}


def _run(
    experiment: Experiment, waiting: dict[str, Cell], executor: Executor | None
) -> Iterator[tuple[str, Row]]:
    """Yield (key, row) as the cells finish."""
    if executor is None:
        for key, cell in waiting.items():
            yield key, _attempt(experiment, cell)
        return
    futures = {executor.submit(_attempt, experiment, cell): key for key, cell in waiting.items()}
    for future in as_completed(futures):
        try:
            row = future.result()
        except Exception as error:  # the worker itself died
            row = {"error": f"{type(error).__name__}: {error}"}
        yield futures[future], row


def _attempt(experiment: Experiment, cell: Cell) -> Row:
    """Run one cell; a failure is a row too, so that it costs no other cell."""
    try:
        return {"result": {k: _plain(v) for k, v in experiment(**cell).items()}}
    except Exception as error:
        return {"error": f"{type(error).__name__}: {error}"}


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def _key(experiment: Experiment, cell: Cell) -> str:
    """What a row is kept under: the experiment, its parameters, and the mesh's own bytes."""
    text = json.dumps([experiment.__module__, experiment.__qualname__, cell], sort_keys=True)
    digest = hashlib.sha256(text.encode())
    if "mesh" in cell:
        digest.update(_mesh_digest(cell["mesh"]))
    return digest.hexdigest()[:24]


def _mesh_digest(name: str) -> bytes:
    try:
        V, F = load_mesh(name)
    except Exception:
        return b"no mesh"  # the cell itself will say what is wrong with it
    return hashlib.sha256(V.tobytes() + F.tobytes()).digest()


def _read(path: str | os.PathLike[str]) -> dict[str, Row]:
    """The rows that an earlier sweep finished; a line cut short by a kill is none."""
    path = Path(path)
    if not path.exists():
        return {}
    rows = {}
    for line in path.read_bytes().split(b"\n"):
        try:
            row = json.loads(line)
            rows[row.pop("key")] = row
        except (ValueError, KeyError, AttributeError, TypeError):
            continue
    return rows


class _Journal:
    """Appends rows to a file, each on the disk before the next cell's."""

    def __init__(self, path: str | os.PathLike[str] | None) -> None:
        self._path = path
        self._file: BinaryIO | None = None

    def __enter__(self) -> _Journal:
        if self._path:
            Path(self._path).parent.mkdir(parents=True, exist_ok=True)
            self._file = open(self._path, "ab")
            self._file.write(b"\n")  # ends a line that a kill left unfinished
        return self

    def append(self, row: Row) -> None:
        if self._file:
            self._file.write(json.dumps(row).encode() + b"\n")
            self._file.flush()
            os.fsync(self._file.fileno())

    def __exit__(self, *_: object) -> None:
        if self._file:
            self._file.close()
