"""The files that a submission's process sees: Python, and the libraries that its assignment allows.

What is not in the view cannot be imported, read or loaded, by whatever trick.
"""

import ast
import functools
import os
import sys
from collections.abc import Iterable, Iterator
from importlib.metadata import PackageNotFoundError, distribution, packages_distributions
from importlib.util import find_spec
from pathlib import Path

from meshfair_grading.rules import MESH_LIBRARIES, within

PYTHON = Path(os.path.realpath(sys._base_executable))  # type: ignore[attr-defined]
GRADER = Path("/grader")
# What runs inside: it holds no answers, and no checks.
CHILD = ("__init__", "answers", "arguments", "child", "loading", "protocol", "rules")
# What Python and its libraries read beside their own files.
SYSTEM = ("/lib", "/lib32", "/lib64", "/usr/lib", "/usr/lib32", "/usr/lib64", "/usr/share/fonts",
          "/usr/share/zoneinfo", "/etc/alternatives", "/etc/fonts", "/etc/ld.so.cache",
          "/etc/localtime")  # fmt: skip
OURS = "meshfair"
# No requirement of another library brings these in.
NEVER = (OURS, "meshfair_grading", *MESH_LIBRARIES)


def system() -> Iterator[str]:
    """Mounts of the system's libraries and Python's own, without what is installed into them.

    Yields
    ------
    str
        The words of bubblewrap's command line.
    """
    for place in map(Path, SYSTEM):
        if place.is_symlink():
            yield from (*_parents(place), "--symlink", os.readlink(place), str(place))
        elif place.exists():
            yield from shown(place)
    for place in _pythons():
        yield from shown(place)
    for folder in _installed():
        yield from ("--tmpfs", str(folder))


def shown(place: Path) -> Iterator[str]:
    """The mount of a file or folder in its place, read-only.

    Parameters
    ----------
    place : Path

    Yields
    ------
    str
    """
    yield from (*_parents(place), "--ro-bind", str(place), str(place))


def grader() -> Iterator[str]:
    """Mounts of the modules that run inside.

    Yields
    ------
    str
    """
    here, there = Path(__file__).parent, GRADER / "meshfair_grading"
    yield from _parents(there / "child.py")
    for name in CHILD:
        yield from ("--ro-bind", str(here / f"{name}.py"), str(there / f"{name}.py"))


def libraries(allowed: Iterable[str], blocked: Iterable[str]) -> Iterator[str]:
    """Mounts of the libraries, each where it lies.

    Parameters
    ----------
    allowed, blocked : iterable of str
        Modules that can be imported, with what these need, and others that cannot.

    Yields
    ------
    str
    """
    entries = _entries(tuple(sorted(allowed)), tuple(sorted(blocked)))
    masked = set(_installed())
    for folder in sorted(set(entries.values())):
        if folder not in masked:
            yield from (*_parents(folder), "--perms", "0755", "--tmpfs", str(folder))
    for entry in sorted(entries):
        yield from shown(entry)
    for folder in sorted(masked | set(entries.values())):
        yield from ("--remount-ro", str(folder))


def folders(allowed: Iterable[str], blocked: Iterable[str]) -> list[Path]:
    """The folders in which the allowed libraries lie: for ``sys.path``.

    Parameters
    ----------
    allowed, blocked : iterable of str
        See `libraries`.

    Returns
    -------
    list of Path
    """
    return sorted(set(_entries(tuple(sorted(allowed)), tuple(sorted(blocked))).values()))


def _pythons() -> Iterator[Path]:
    """Where Python's own files lie, beside those of the system."""
    yield PYTHON
    base = Path(sys.base_prefix)
    if base != Path("/usr"):
        yield from {folder for folder in (base / "lib", base / sys.platlibdir) if folder.is_dir()}


def _installed() -> list[Path]:
    """Where libraries lie within what the system and Python show."""
    roots = {Path(sys.base_prefix), Path("/usr")}
    patterns = ("lib*/python3*/site-packages", "lib*/python3*/dist-packages")
    found = (folder for root in roots for pattern in patterns for folder in root.glob(pattern))
    return sorted({folder.resolve() for folder in found if folder.is_dir()})


def _parents(place: Path) -> list[str]:
    """The folders above, open to everybody: the real ones may be root's."""
    above = [folder for folder in reversed(place.parents) if folder != Path("/")]
    return [word for folder in above for word in ("--perms", "0755", "--dir", str(folder))]


@functools.cache
def _entries(allowed: tuple[str, ...], blocked: tuple[str, ...]) -> dict[Path, Path]:
    """Files and folders of the allowed libraries and of all that they need, with their places."""
    ours = {module for module in allowed if within(module, (OURS,))}
    return {**_others(tuple(sorted({*allowed} - ours))), **_ours(sorted(ours), blocked)}


def _others(allowed: tuple[str, ...]) -> dict[Path, Path]:
    if not allowed:
        return {}
    by_module = packages_distributions()
    never = {name for module in NEVER for name in by_module.get(module, ())}
    tops = {module.partition(".")[0] for module in allowed}.difference(NEVER)
    waiting = [name for module in sorted(tops) for name in by_module.get(module, ())]
    found, seen = set(), set(never)
    for module in tops:  # also where a system's packages come without a list of their files
        spec = find_spec(module)
        if spec and spec.origin:
            origin = Path(spec.origin)
            found.add(origin.parent if spec.submodule_search_locations else origin)
    while waiting:
        name = waiting.pop()
        if name in seen:
            continue
        seen.add(name)
        try:
            package = distribution(name)
        except PackageNotFoundError:  # needed by another library on other systems only
            continue
        waiting += _needed(package.requires or [])
        for file in package.files or ():
            if file.parts[0] not in ("..", "__pycache__") and not file.is_absolute():
                found.add(Path(str(package.locate_file(file.parts[0]))))
    return {entry.absolute(): entry.absolute().parent for entry in found if entry.exists()}


def _needed(requirements: list[str]) -> Iterator[str]:
    """The names of what a library needs here, without extras."""
    from packaging.requirements import Requirement

    for text in requirements:
        requirement = Requirement(text)
        if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
            yield requirement.name


def _ours(allowed: list[str], blocked: Iterable[str]) -> dict[Path, Path]:
    """The files of our own modules and of those that they import: the others hold answers."""
    spec = find_spec(OURS)
    if not allowed or spec is None or not spec.submodule_search_locations:
        return {}
    package = Path(spec.submodule_search_locations[0]).absolute()
    waiting, found = list(allowed), {}
    if OURS in allowed:
        waiting += [_module(file, package) for file in package.rglob("*.py")]
    while waiting:
        module = waiting.pop()
        file = _file(module, package)
        if file is None or module in found or within(module, blocked):
            continue
        found[module] = file
        waiting.append(module.rpartition(".")[0])
        for node in ast.walk(ast.parse(file.read_bytes())):
            if isinstance(node, ast.Import):
                waiting += [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.module:
                waiting += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return {file: package.parent for file in found.values()}


def _module(file: Path, package: Path) -> str:
    parts = file.relative_to(package.parent).with_suffix("").parts
    return ".".join(part for part in parts if part != "__init__")


def _file(module: str, package: Path) -> Path | None:
    """The file of one of our modules; None where there is no such module."""
    if not within(module, (OURS,)):
        return None
    place = package.parent.joinpath(*module.split("."))
    return next(
        (file for file in (place / "__init__.py", place.with_suffix(".py")) if file.is_file()), None
    )
