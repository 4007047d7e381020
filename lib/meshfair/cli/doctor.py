"""Check what is installed and what the machine offers, and say what to do.

Exit code 1 where something that meshfair needs is missing.
"""

import os
import re
import sys
from pathlib import Path
from typing import NamedTuple

from meshfair.cli import files, printing


class Check(NamedTuple):
    """One thing that was looked at."""

    name: str
    state: str
    """ok; note, where something optional is missing; or problem."""
    found: str
    advice: str = ""
    """What to do about it."""


def add_arguments(parser):
    """Declare the subcommand's arguments."""
    files.add_json(parser)


def run(options):
    """Look at everything and print it.

    Returns
    -------
    int
        0, or 1 where there is a problem.
    """
    checks = [
        *_packages(),
        _attempt("cores", _cores),
        _attempt("numba cache", _numba_cache),
        _attempt("EGL", _egl),
        _attempt("real meshes", _real_meshes),
    ]
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


def _attempt(name, look):
    """A check; where looking itself fails, that is the problem."""
    try:
        return look(name)
    except Exception as error:
        return Check(name, "problem", f"{type(error).__name__}: {error}", "install meshfair again")


def _packages():
    """Python, meshfair, and each package that its own metadata names."""
    from importlib.metadata import PackageNotFoundError, metadata, requires

    import meshfair

    running = ".".join(str(part) for part in sys.version_info[:3])
    place = Path(meshfair.__file__).parent
    try:
        wanted, requirements = metadata("meshfair")["Requires-Python"], requires("meshfair")
    except PackageNotFoundError:
        found = f"{meshfair.__version__} in {place}, not installed"
        advice = "install it, with pip install -e . in its folder"
        return [Check("python", "ok", running), Check("meshfair", "problem", found, advice)]
    checks = [
        _versions("python", running, wanted.lstrip(">="), None),
        Check("meshfair", "ok", f"{meshfair.__version__} in {place}"),
    ]
    for requirement in requirements:
        package = re.match(r"[\w.-]+", requirement)[0]
        least = re.search(r">=\s*([\w.]+)", requirement)
        extra = re.search(r"extra == ['\"](\w+)", requirement)
        if package != "meshfair":
            checks.append(_installed(package, least and least[1], extra and extra[1]))
    return checks


def _installed(package, least, extra):
    """Whether a package is there, and new enough."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return _versions(package, version(package), least, extra)
    except PackageNotFoundError:
        if extra:
            advice = f'for {extra}: pip install "meshfair[{extra}]"'
            return Check(package, "note", "not installed", advice)
        return Check(package, "problem", "not installed", f"pip install {package}")


def _versions(name, found, least, extra):
    """Compare two versions by their leading numbers, which is as much as is ever asked for."""
    numbers = [
        [int(number) for number in re.findall(r"\d+", text)[:3]] for text in (found, least or "0")
    ]
    if numbers[0] >= numbers[1]:
        return Check(name, "ok", found)
    state = "note" if extra else "problem"
    return Check(name, state, f"{found}, older than {least}", f"get {name} {least} or newer")


def _cores(name):
    from meshfair._fast.kernels import threads

    there, used = os.cpu_count(), threads()
    advice = "" if used > 1 else "kernels and sweeps run on one core; check NUMBA_NUM_THREADS"
    return Check(name, "ok", f"{used} of {there} used", advice)


def _numba_cache(name):
    """Where numba keeps compiled kernels; without it each start compiles anew."""
    import numba

    try:
        # numba takes the first place that it can write to, by itself.
        place = numba.njit(_cores, cache=True).stats.cache_path
    except RuntimeError:
        advice = "set NUMBA_CACHE_DIR to a folder that can be written to"
        return Check(name, "problem", "no folder for compiled kernels", advice)
    return Check(name, "ok", place)


def _egl(name):
    from meshfair.viewer import has_egl
    from meshfair.viewer.offscreen import MISSING_EGL

    if has_egl():
        return Check(name, "ok", "polyscope draws without a screen")
    return Check(name, "note", "missing", MISSING_EGL)


def _real_meshes(name):
    from meshfair import datasets

    present = [source for source in datasets.SOURCES if datasets.find(source)]
    found = f"{len(present)} of {len(datasets.SOURCES)} in {datasets.folder()}"
    mirror = os.environ.get(datasets.MIRROR_VARIABLE)
    if mirror and not Path(mirror).is_dir():
        advice = f"{datasets.MIRROR_VARIABLE} is {mirror!r}, which is no folder; correct it"
        return Check(name, "note", found, advice)
    if len(present) == len(datasets.SOURCES):
        return Check(name, "ok", found)
    return Check(name, "note", found, "make data downloads them")
