"""Check what is installed and what the machine offers, and say what to do.

Exit code 1 where something that meshfair needs is missing. What belongs to an
extra is optional: without it, its part of the package does not work, or is slower.
"""

from __future__ import annotations

import argparse
import os
import platform
from collections import defaultdict
from collections.abc import Callable
from functools import partial
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from meshfair.cli import files, printing

if TYPE_CHECKING:
    from packaging.requirements import Requirement


# Other packages bring further looks as entry points of this group: functions that return a
# state, what was found, and advice.
GROUP = "meshfair.doctor"


class Check(NamedTuple):
    """One thing that was looked at."""

    name: str
    state: str
    """ok; note, where something optional is missing; or problem."""
    found: str
    advice: str = ""
    """What to do about it."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the subcommand's arguments."""
    files.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Look at everything and print it.

    Returns
    -------
    int
        0, or 1 where there is a problem.
    """
    looks: dict[str, Callable[[], list[Check]]] = {
        "packages": _packages,
        "compiled loops": _compiled_loops,
        "EGL": _egl,
        "real meshes": _real_meshes,
    }
    looks |= {entry.name: partial(_of_another, entry) for entry in entry_points(group=GROUP)}
    checks = [check for name, look in looks.items() for check in _attempt(name, look)]
    problems = sum(check.state == "problem" for check in checks)
    if options.json:
        printing.print_json({"ok": not problems, "checks": [check._asdict() for check in checks]})
    else:
        width = max(len(check.name) for check in checks)
        for check in checks:
            print(f"{check.state:<8}{check.name:<{width}}  {check.found}")
            if check.advice:
                print(f"{'':<8}{'':<{width}}  -> {check.advice}")
        print(f"{problems or 'no'} problem{'' if problems == 1 else 's'}")
    return 1 if problems else 0


def _of_another(entry: EntryPoint) -> list[Check]:
    """What another package looks at."""
    return [Check(entry.name, *entry.load()())]


def _attempt(name: str, look: Callable[[], list[Check]]) -> list[Check]:
    """The checks of a look; where looking itself fails, that is the problem."""
    try:
        return look()
    except ModuleNotFoundError as error:  # what the core needs is checked by name
        found = f"cannot be checked without {error.name}, which is not installed"
        return [Check(name, "note", found, f"pip install {error.name}, or the extra it is part of")]
    except Exception as error:
        found = f"{type(error).__name__}: {error}"
        return [Check(name, "problem", found, "install meshfair again")]


def _packages() -> list[Check]:
    """Python, meshfair, each package that the core needs, and each extra."""
    from importlib.metadata import PackageNotFoundError, metadata, requires

    from packaging.requirements import Requirement

    import meshfair

    place = Path(meshfair.__file__).parent
    try:
        about = metadata("meshfair")
    except PackageNotFoundError:
        found = f"{meshfair.__version__} in {place}, not installed"
        advice = "install it, with pip install -e . in its folder"
        return [Check("meshfair", "problem", found, advice)]
    wanted = [Requirement(text) for text in requires("meshfair") or []]
    python = Requirement(f"python{about['Requires-Python'] or ''}")
    checks = [
        _core(python, platform.python_version()),
        Check("meshfair", "ok", f"{meshfair.__version__} in {place}"),
    ]
    extras = defaultdict(list)
    for requirement in wanted:
        if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
            checks.append(_core(requirement, _version(requirement.name)))
            continue
        for extra in about.get_all("Provides-Extra") or []:
            # Extras that name other extras of meshfair are those, once more.
            if requirement.marker.evaluate({"extra": extra}) and requirement.name != "meshfair":
                extras[extra].append((requirement, _version(requirement.name)))
    return checks + [_extra(extra, found) for extra, found in extras.items()]


def _version(package: str) -> str | None:
    """The version of a package; None where it is not installed."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(package)
    except PackageNotFoundError:
        return None


def _shortcoming(requirement: Requirement, version: str | None) -> str:
    """What is wrong with the version of a package; nothing where it is as required."""
    if version is None:
        return f"{requirement.name} is not installed"
    if not requirement.specifier.contains(version, prereleases=True):
        return f"{requirement.name} {version} is not {requirement.specifier}"
    return ""


def _core(requirement: Requirement, version: str | None) -> Check:
    """A package without which nothing works."""
    if wrong := _shortcoming(requirement, version):
        advice = f'pip install "{requirement.name}{requirement.specifier}"'
        return Check(requirement.name, "problem", wrong, advice)
    return Check(requirement.name, "ok", str(version))


def _extra(extra: str, packages: list[tuple[Requirement, str | None]]) -> Check:
    """The packages of an extra, of which none has to be there."""
    wrong = [
        text for requirement, version in packages if (text := _shortcoming(requirement, version))
    ]
    if wrong:
        advice = f'optional: pip install "meshfair[{extra}]"'
        return Check(f"extra {extra}", "note", ", ".join(wrong), advice)
    there = ", ".join(f"{requirement.name} {version}" for requirement, version in packages)
    return Check(f"extra {extra}", "ok", there)


def _compiled_loops() -> list[Check]:
    """How large meshes are worked on: the cores, and where compiled loops are kept."""
    from meshfair import _fast

    if not _fast.available():
        found = "none without numba: large meshes take longer"
        return [Check("compiled loops", "note", found, 'pip install "meshfair[fast]"')]
    import numba

    there, used = os.cpu_count(), _fast.kernels.threads()
    advice = "" if used > 1 else "compiled loops and sweeps run on one core; see NUMBA_NUM_THREADS"
    cores = Check("cores", "ok", f"{used} of {there} used", advice)
    try:
        # numba takes the first folder that it can write to, by itself.
        kept = Check("numba cache", "ok", str(numba.njit(_egl, cache=True).stats.cache_path))
    except RuntimeError:
        found = "no folder for compiled loops, so each start compiles anew"
        advice = "set NUMBA_CACHE_DIR to a folder that can be written to"
        kept = Check("numba cache", "problem", found, advice)
    return [cores, kept]


def _egl() -> list[Check]:
    from meshfair.viewer import has_egl
    from meshfair.viewer.offscreen import MISSING_EGL

    if has_egl():
        return [Check("EGL", "ok", "polyscope draws without a screen")]
    return [Check("EGL", "note", "missing", MISSING_EGL)]


def _real_meshes() -> list[Check]:
    from meshfair import datasets

    present = [source for source in datasets.SOURCES if datasets.find(source)]
    found = f"{len(present)} of {len(datasets.SOURCES)} in {datasets.folder()}"
    mirror = os.environ.get(datasets.MIRROR_VARIABLE)
    if mirror and not Path(mirror).is_dir():
        advice = f"{datasets.MIRROR_VARIABLE} is {mirror!r}, which is no folder; correct it"
        return [Check("real meshes", "note", found, advice)]
    if len(present) == len(datasets.SOURCES):
        return [Check("real meshes", "ok", found)]
    return [Check("real meshes", "note", found, "make data downloads them")]
