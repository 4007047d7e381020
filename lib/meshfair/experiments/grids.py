"""Grids as TOML files: an experiment by name, axes as lists, meshes by name or glob."""

from __future__ import annotations

import glob
import inspect
import os
import tomllib
from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from typing import Any

from meshfair import datasets, denoising, io, noise
from meshfair.checks import check_choice, did_you_mean
from meshfair.experiments.cells import Experiment
from meshfair.experiments.choices import KINDS, PUBLISHED_NOISE, choice
from meshfair.experiments.meshes import MESHES, PAIRS, parts
from meshfair.experiments.original import stopping
from meshfair.experiments.quality import PARAMETERS, score
from meshfair.weights import BY_NAME

EXPERIMENTS: dict[str, Experiment] = {
    "stopping": stopping,
    "quality": score,
    "choices": choice,
}
"""Experiments that a grid can name; any other one is given as ``module:function``."""

PUBLISHED = ("choices", "quality", "table-1")
"""Grids that come with the package."""

CHOICES: dict[str, Callable[[], list[str]]] = {
    "noise": lambda: list(noise.MODELS),
    "weights": lambda: list(BY_NAME),
    "kind": lambda: [*KINDS, PUBLISHED_NOISE],
    "method": lambda: list(dict.fromkeys(["none", "auto", *denoising.methods()])),
    "parameters": lambda: list(PARAMETERS),
}
"""What axes of `EXPERIMENTS` can hold."""

# Of a file: what every part of it has, and the parts.
EXPERIMENT, PARTS = "experiment", "grid"


def read_grids(path: str | os.PathLike[str]) -> list[dict[str, Any]]:
    """Read a grid file.

    Its keys are ``experiment`` and axes: a value, a list, or ``{from = 0, to = 199}`` for whole
    numbers, both ends included. Tables ``[[grid]]`` hold the axes in which parts of it differ.
    An axis ``mesh`` also takes files, and globs of them, as seen from the grid file's folder.

    Parameters
    ----------
    path : path
        Of the file, or a name in `PUBLISHED`.

    Returns
    -------
    list of dict
        Grids for `meshfair.experiments.sweep`.

    Raises
    ------
    ValueError
        One sentence: what is wrong, where, and what would be right.
    """
    path = Path(path)
    if str(path) in PUBLISHED:
        text = files("meshfair").joinpath(f"experiments/{path}.toml").read_text(encoding="utf-8")
    elif path.is_file():
        text = path.read_bytes().decode("utf-8", errors="replace")
    else:
        known = ", ".join(PUBLISHED)
        meant = did_you_mean(str(path), PUBLISHED)
        raise ValueError(f"there is no grid file {path}; give one, or one of {known}{meant}")
    try:
        whole = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{path} is no TOML: {error}") from None
    several = whole.pop(PARTS, [{}])
    if not (isinstance(several, list) and several and all(isinstance(p, dict) for p in several)):
        raise ValueError(f"{path}: {PARTS} is no part of a grid; write [[{PARTS}]] above its axes")
    return [_grid(path, whole | part) for part in several]


def _grid(path: Path, axes: dict[str, Any]) -> dict[str, Any]:
    if EXPERIMENT not in axes:
        meant = next((f" (not {name!r})" for name in axes if did_you_mean(EXPERIMENT, [name])), "")
        raise ValueError(
            f"{path} names no experiment; write {EXPERIMENT}{meant} = and one of "
            f"{', '.join(EXPERIMENTS)}, or 'module:function'"
        )
    name = axes.pop(EXPERIMENT)
    experiment = _experiment(path, name)
    _check_axes(path, name, experiment, axes)
    grid: dict[str, Any] = {EXPERIMENT: experiment}
    for axis, given in axes.items():
        values = _values(f"{path}: {axis}", given)
        if axis == "mesh":
            values = [found for value in values for found in _meshes(path, value)]
        elif name in EXPERIMENTS and axis in CHOICES:
            for value in values:
                check_choice(value, f"{path}: {axis}", CHOICES[axis]())
        grid[axis] = values
    return grid


def _experiment(path: Path, name: Any) -> Experiment:
    if isinstance(name, str) and ":" in name:
        module, _, function = name.partition(":")
        try:
            found = getattr(import_module(module), function, None)
        except ImportError as error:
            raise ValueError(
                f"{path}: experiment {name!r} cannot be imported ({error}); it must be in a "
                "module that Python finds, here and on every worker (see PYTHONPATH)"
            ) from None
        if not callable(found):
            raise ValueError(f"{path}: {module} has no function {function}")
        return found
    check_choice(name, f"{path}: {EXPERIMENT}", EXPERIMENTS)
    return EXPERIMENTS[name]


def _check_axes(path: Path, name: str, experiment: Experiment, axes: Mapping[str, Any]) -> None:
    parameters = inspect.signature(experiment).parameters.values()
    takes = [p.name for p in parameters if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)]
    if not any(p.kind == p.VAR_KEYWORD for p in parameters):
        for axis in axes:
            if axis not in takes:
                raise ValueError(
                    f"{path}: the experiment {name} has no axis {axis!r}; it has "
                    f"{', '.join(takes)}{did_you_mean(axis, takes)}"
                )
    missing = [p.name for p in parameters if p.name in takes and p.default is p.empty]
    if missing := [axis for axis in missing if axis not in axes]:
        raise ValueError(f"{path}: the experiment {name} needs {', '.join(missing)}, too")


def _values(where: str, given: Any) -> list[Any]:
    if isinstance(given, dict):
        return _numbers(where, given)
    values = given if isinstance(given, list) else [given]
    if not values:
        raise ValueError(f"{where} is empty; give it a value")
    for value in values:
        if not isinstance(value, (str, int, float, bool)):
            raise ValueError(f"{where} holds {value!r}; give numbers, text, true or false")
    return values


def _numbers(where: str, given: dict[str, Any]) -> list[int]:
    bounds = {"step": 1, **given}
    whole = all(type(bounds.get(name)) is int for name in ("from", "to", "step"))
    if len(bounds) != 3 or not whole or bounds["step"] < 1 or bounds["from"] > bounds["to"]:
        raise ValueError(f"{where} is {given}; write {{from = 0, to = 199}}, say, or a list")
    return list(range(bounds["from"], bounds["to"] + 1, bounds["step"]))


def _meshes(path: Path, name: Any) -> list[str]:
    """The names of meshes, or the files, that an entry of the axis stands for."""
    where = f"{path}: mesh"
    known = [*MESHES, *datasets.SOURCES, *PAIRS]
    if not isinstance(name, str):
        raise ValueError(f"{where} holds {name!r}; give names or files in quotes")
    if name in known:
        for part in parts(name):
            if part in datasets.SOURCES and datasets.find(part) is None:
                raise ValueError(f"{where} {name!r} is not downloaded; run: make data")
        return [name]
    file = path.parent / name
    if glob.has_magic(name):
        found = [Path(other) for other in glob.glob(str(file), recursive=True)]
        found = sorted(other for other in found if _is_mesh_file(other))
        if not found:
            raise ValueError(
                f"{where} {name!r} matches no mesh file ({', '.join(io.FORMATS)}) in {path.parent}"
            )
        return [other.as_posix() for other in found]
    if file.is_file():
        return [file.as_posix()]
    if file.suffix:
        raise ValueError(f"{where}: there is no file {file}")
    raise ValueError(
        f"{where} {name!r} is none of {', '.join(known)}, and no file{did_you_mean(name, known)}"
    )


def _is_mesh_file(file: Path) -> bool:
    return file.is_file() and Path(file.name.lower().removesuffix(".gz")).suffix in io.FORMATS
