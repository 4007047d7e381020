"""One loop for every experiment: a grid of parameters, a row for each cell."""

import hashlib
import itertools
import json
import os
from concurrent.futures import as_completed
from pathlib import Path

import numpy as np
import pandas as pd
from tqdm import tqdm

from meshfair.experiments import cases


def sweep(grid, executor=None, *, path=None, progress=True):
    """Run an experiment on every combination of parameters; a row for each.

    Parameters
    ----------
    grid : dict
        ``experiment``: a function of an importable module that takes one
        value of each axis by name and returns a dict, the row's results. Every
        other entry is an axis: a list or tuple of values, or one value (text
        is one value). Values are numbers, text, booleans or None; an axis
        named ``mesh`` holds names for `meshfair.experiments.cases.load_mesh`.
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


def _row(cell, finished):
    error = {"error": finished["error"]} if "error" in finished else {}
    return {**cell, **finished.get("result", {}), **error}


def _run(experiment, waiting, executor):
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


def _attempt(experiment, cell):
    """Run one cell; a failure is a row too, so that it costs no other cell."""
    try:
        return {"result": {k: _plain(v) for k, v in experiment(**cell).items()}}
    except Exception as error:
        return {"error": f"{type(error).__name__}: {error}"}


def _plain(value):
    return value.item() if isinstance(value, np.generic) else value


def _key(experiment, cell):
    """What a row is kept under: the experiment, its parameters, and the mesh's own bytes."""
    text = json.dumps([experiment.__module__, experiment.__qualname__, cell], sort_keys=True)
    digest = hashlib.sha256(text.encode())
    if "mesh" in cell:
        digest.update(_mesh_digest(cell["mesh"]))
    return digest.hexdigest()[:24]


def _mesh_digest(name):
    try:
        V, F = cases.load_mesh(name)
    except Exception:
        return b"no mesh"  # the cell itself will say what is wrong with it
    return hashlib.sha256(V.tobytes() + F.tobytes()).digest()


def _read(path):
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

    def __init__(self, path):
        self._path = path

    def __enter__(self):
        self._file = None
        if self._path:
            Path(self._path).parent.mkdir(parents=True, exist_ok=True)
            self._file = open(self._path, "ab")
            self._file.write(b"\n")  # ends a line that a kill left unfinished
        return self

    def append(self, row):
        if self._file:
            self._file.write(json.dumps(row).encode() + b"\n")
            self._file.flush()
            os.fsync(self._file.fileno())

    def __exit__(self, *_):
        if self._file:
            self._file.close()
