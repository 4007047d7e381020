"""Which meshfair a process has: workers of another one would compute something else."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path

import meshfair


class WrongVersionError(RuntimeError):
    """A worker with another version of the package."""


@cache
def version(*packages: str) -> str:
    """Which meshfair this is: its version, and what tells its files from any others.

    Parameters
    ----------
    *packages : str
        Whose files; by default those of meshfair itself.

    Returns
    -------
    str
    """
    content = hashlib.sha256()
    for package in packages or ("meshfair",):
        folder = Path(str(import_module(package).__file__)).parent
        files = sorted(folder.rglob("*.py"), key=lambda path: path.relative_to(folder).as_posix())
        content.update(b"".join(path.read_bytes() for path in files))
    return f"{meshfair.__version__} ({content.hexdigest()[:8]})"


def asked() -> Callable[[Sequence[str]], str]:
    """A question for workers; also for one without this package, since it is sent as a whole.

    Returns
    -------
    function of packages
        That returns `version`, or says why there is none.
    """

    def ask(packages: Sequence[str]) -> str:
        try:
            from meshfair.experiments.versions import version

            return version(*packages)
        except ImportError as error:
            return f"none that is of use ({error})"

    return ask


def refused(worker: str, theirs: str, wanted: str) -> str:
    """Say that a worker has another version.

    Parameters
    ----------
    worker : str
    theirs, wanted : str
        From `version`.

    Returns
    -------
    str
    """
    return (
        f"the worker {worker} has meshfair {theirs}, but this is {wanted}; "
        "install the same there, and start the worker again"
    )
