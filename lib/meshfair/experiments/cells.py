"""Cells: one combination of parameters each, and how a worker runs them."""

from __future__ import annotations

import hashlib
import itertools
import json
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from meshfair import __version__
from meshfair.experiments.meshes import Mesh, digest, given, load_mesh, parts

Experiment = Callable[..., Mapping[str, Any]]
Row = dict[str, Any]


class Cell(NamedTuple):
    """One combination of parameters."""

    key: str
    """What its row is kept under: version, experiment, parameters, and the mesh's own bytes."""
    experiment: Experiment
    parameters: dict[str, Any]

    @property
    def meshes(self) -> tuple[str, ...]:
        """The names of the meshes that it needs."""
        name = self.parameters.get("mesh")
        return parts(name) if isinstance(name, str) else ()

    def __str__(self) -> str:
        return ", ".join(f"{name} {value}" for name, value in self.parameters.items())


def cells(grids: Sequence[Mapping[str, Any]]) -> list[Cell]:
    """All combinations of parameters, in the order of the grids, the last axis fastest.

    Parameters
    ----------
    grids : sequence of dict
        As in `meshfair.experiments.sweep`.

    Returns
    -------
    list of Cell

    Raises
    ------
    ValueError
        No function under ``experiment``, or no cell.
    """
    found: list[Cell] = []
    digests: dict[str, str] = {}
    for grid in grids:
        axes = dict(grid)
        experiment = axes.pop("experiment", None)
        if not callable(experiment):
            raise ValueError(
                "the grid needs a function under 'experiment', such as experiments.stopping"
            )
        axes = {k: v if isinstance(v, (list, tuple)) else (v,) for k, v in axes.items()}
        if empty := ", ".join(name for name, values in axes.items() if not len(values)):
            raise ValueError(f"the grid has no cell; these axes are empty: {empty}")
        for values in itertools.product(*axes.values()):
            cell = Cell("", experiment, dict(zip(axes, values, strict=True)))
            found.append(cell._replace(key=_key(cell, digests)))
    return found


def _key(cell: Cell, digests: dict[str, str]) -> str:
    function = [__version__, cell.experiment.__module__, cell.experiment.__qualname__]
    text = json.dumps([*function, cell.parameters], sort_keys=True)
    for name in cell.meshes:
        if name not in digests:
            try:
                digests[name] = digest(load_mesh(name))
            except Exception:
                digests[name] = "no mesh"  # the cell itself will say what is wrong with it
        text += digests[name]
    return hashlib.sha256(text.encode()).hexdigest()[:24]


def run_batch(
    batch: Sequence[Cell], limit: float, meshes: Mapping[str, Mesh] | None = None
) -> tuple[list[Row], float]:
    """Run cells one after the other, until the time is over.

    Parameters
    ----------
    batch : sequence of Cell
        At least the first is run.
    limit : float
        Seconds after which no other cell is begun.
    meshes : dict of str to (V, F), optional
        As `meshfair.experiments.meshes.given`.

    Returns
    -------
    rows : list of dict
        A row for each of the first cells, those that were run: see `attempt`.
    seconds : float
        What they took together.
    """
    rows: list[Row] = []
    begun = time.perf_counter()
    seconds = 0.0
    with given(meshes or {}):
        for cell in batch:
            rows.append(attempt(cell))
            seconds = time.perf_counter() - begun
            if seconds > limit:
                break
    return rows, seconds


def attempt(cell: Cell) -> Row:
    """Run one cell; a failure is a row too, so that it costs no other cell.

    Parameters
    ----------
    cell : Cell

    Returns
    -------
    dict
        ``error``, a message; or ``result``, what the experiment returned as it comes back
        from JSON, and ``meshes``, those of its values that are meshes.
    """
    try:
        found = cell.experiment(**cell.parameters)
        meshes = {name: value for name, value in found.items() if _is_mesh(value)}
        rest = {k: None if k in meshes else _plain(value) for k, value in found.items()}
        return {"result": json.loads(json.dumps(rest)), **({"meshes": meshes} if meshes else {})}
    except Exception as error:
        return failure(error)


def failure(error: Exception) -> Row:
    """The row of a cell that failed.

    Parameters
    ----------
    error : Exception

    Returns
    -------
    dict
    """
    return {"error": f"{type(error).__name__}: {error}"}


def _is_mesh(value: Any) -> bool:
    return isinstance(value, tuple) and [type(part) for part in value] == [np.ndarray] * 2


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value
