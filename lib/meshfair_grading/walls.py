"""What a submission's process can see and do: bubblewrap's walls around it.

Inside, there is Python with the libraries that the assignment allows, and nothing
else: what cannot be seen cannot be imported. All is read-only but one small
folder in memory. Processes, network, users and messages are its own, and all
processes end with the first one.
"""

import functools
import os
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator
from importlib.metadata import PackageNotFoundError, distribution, packages_distributions
from importlib.util import find_spec
from pathlib import Path

from meshfair_grading.rules import MESH_LIBRARIES

BWRAP = "bwrap"
NOBODY = 65534
HOME = Path("/box")
GRADER = Path("/grader")
COMPILED = Path("/compiled")
SHARED_MEMORY = 1_000_000  # bytes in /dev/shm
# What runs inside: it holds no answers, and no checks.
CHILD = ("__init__", "answers", "child", "loading", "protocol", "rules")
# What Python and its libraries read beside their own files.
SYSTEM = ("/usr", "/bin", "/sbin", "/lib", "/lib32", "/lib64", "/etc/alternatives",
          "/etc/ld.so.cache", "/etc/localtime", "/etc/fonts")  # fmt: skip
# The answers are in the first one; the others have their own.
NEVER = ("meshfair", "meshfair_grading", *MESH_LIBRARIES)
PATIENCE = 20.0  # seconds for a trial


def trouble() -> str:
    """Why there are no walls on this system, in a sentence; empty where there are.

    Returns
    -------
    str
    """
    if sys.platform != "linux":
        return "bubblewrap needs Linux (on Windows, the Linux subsystem WSL)"
    if shutil.which(BWRAP) is None:
        return "bubblewrap is not installed (on Debian and Ubuntu: apt install bubblewrap)"
    python = [sys._base_executable, "-I", "-c", ""]  # type: ignore[attr-defined]
    try:
        subprocess.run(
            command(python, [], box=1_000_000),
            check=True, capture_output=True, timeout=PATIENCE, stdin=subprocess.DEVNULL,
        )  # fmt: skip
    except subprocess.CalledProcessError as error:
        said = error.stderr.decode(errors="replace").strip() or f"exit code {error.returncode}"
        return f"bubblewrap does not work here ({said.splitlines()[-1]})"
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"bubblewrap does not work here ({error})"
    return ""


def command(
    program: list[str],
    allowed: Iterable[str],
    *,
    box: int,
    files: Iterable[tuple[int, str]] = (),
    compiled: Path | None = None,
    keep_compiled: bool = False,
    environment: dict[str, str] | None = None,
) -> list[str]:
    """The command that runs a program behind the walls.

    Parameters
    ----------
    program : list of str
    allowed : iterable of str
        Modules of libraries that can be imported, with what these need.
    box : int
        Bytes that fit into the writable folder.
    files : iterable of (int, str)
        File descriptors whose content is copied into the writable folder, and names there.
    compiled : Path, optional
        A folder with what numba has compiled, seen as `COMPILED`.
    keep_compiled : bool
        Whether that can be written to: for trusted code only.
    environment : dict of str to str, optional

    Returns
    -------
    list of str
    """
    view = [*_system(), *_libraries(tuple(sorted(allowed))), *_grader()]
    if compiled:
        view += ["--bind" if keep_compiled else "--ro-bind", str(compiled), str(COMPILED)]
    variables = [word for item in (environment or {}).items() for word in ("--setenv", *item)]
    copies = [word for fd, name in files for word in ("--file", str(fd), str(HOME / name))]

    def walled(view: list[str]) -> list[str]:
        return [
            BWRAP, "--unshare-all", "--unshare-user", "--disable-userns", "--die-with-parent",
            "--new-session", "--hostname", "box", "--clearenv", *variables, *view,
            "--proc", "/proc", "--remount-ro", "/proc", "--dev", "/dev",
            "--size", str(SHARED_MEMORY), "--tmpfs", "/dev/shm", "--remount-ro", "/dev",
            "--size", str(box), "--tmpfs", str(HOME), *copies,
            "--chdir", str(HOME), "--remount-ro", "/", *program,
        ]  # fmt: skip

    if os.geteuid() != 0:
        return walled(view)
    # For root, devices and the like would be its own. So a first bubblewrap shows the same view,
    # in which `nobody` finds a Python that lies in root's home, and builds the walls as nobody.
    return [
        BWRAP, "--die-with-parent", "--cap-add", "CAP_SETUID", "--cap-add", "CAP_SETGID", *view,
        "--bind", "/proc", "/proc", "--dev", "/dev", "--dir", "/tmp", "--chdir", "/",
        "setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups",
        *walled(_seen_again(view)),
    ]  # fmt: skip


def give(folder: Path) -> None:
    """Give a folder to the user who works behind the walls, where that is another one.

    Parameters
    ----------
    folder : Path
    """
    if os.geteuid() == 0:
        os.chown(folder, NOBODY, NOBODY)


def _seen_again(view: list[str]) -> list[str]:
    """The mounts of a view within itself, where everything lies in its place."""
    view = list(view)
    for position, word in enumerate(view):
        if word in ("--bind", "--ro-bind"):
            view[position + 1] = view[position + 2]
    return view


def _system() -> Iterator[str]:
    """The system's libraries and Python's own, without any library installed into them."""
    base = Path(sys.base_prefix)
    for place in map(Path, SYSTEM):
        if place.is_symlink():
            yield from ("--symlink", os.readlink(place), str(place))
        elif place.exists():
            yield from (*_parents(place), "--ro-bind", str(place), str(place))
    if not base.is_relative_to("/usr"):
        yield from (*_parents(base), "--ro-bind", str(base), str(base))
    for folder in _installed(base):
        yield from ("--tmpfs", str(folder))


def _installed(base: Path) -> list[Path]:
    """Where libraries lie within what the system and Python show."""
    roots = {base, Path("/usr"), Path("/usr/local")}
    patterns = ("lib*/python3*/site-packages", "lib*/python3*/dist-packages")
    found = (folder for root in roots for pattern in patterns for folder in root.glob(pattern))
    return sorted({folder.resolve() for folder in found if folder.is_dir()})


def _parents(place: Path) -> list[str]:
    """The folders above, open to everybody: the real ones may be root's."""
    above = [folder for folder in reversed(place.parents) if folder != Path("/")]
    return [word for folder in above for word in ("--perms", "0755", "--dir", str(folder))]


def _grader() -> Iterator[str]:
    """The modules that run inside."""
    here, there = Path(__file__).parent, GRADER / "meshfair_grading"
    yield from _parents(there / "child.py")
    for name in CHILD:
        yield from ("--ro-bind", str(here / f"{name}.py"), str(there / f"{name}.py"))


def _libraries(allowed: tuple[str, ...]) -> Iterator[str]:
    """Mounts of the libraries, each where it lies."""
    folders = library_folders(allowed)
    masked = set(_installed(Path(sys.base_prefix)))
    for folder in folders:
        if folder not in masked:
            yield from (*_parents(folder), "--perms", "0755", "--tmpfs", str(folder))
        for entry in _entries(allowed):
            if entry.parent == folder:
                yield from ("--ro-bind", str(entry), str(entry))
    for folder in sorted(masked | set(folders)):
        yield from ("--remount-ro", str(folder))


def library_folders(allowed: Iterable[str]) -> list[Path]:
    """The folders in which the allowed libraries lie: for ``sys.path``.

    Parameters
    ----------
    allowed : iterable of str

    Returns
    -------
    list of Path
    """
    return sorted({entry.parent for entry in _entries(tuple(sorted(allowed)))})


@functools.cache
def _entries(allowed: tuple[str, ...]) -> tuple[Path, ...]:
    """Files and folders of the allowed libraries and of all that they need."""
    if not allowed:
        return ()
    by_module = packages_distributions()
    waiting = [name for module in allowed for name in by_module.get(module.partition(".")[0], ())]
    found, seen = set(), set()
    for module in allowed:  # also where a system's packages come without a list of their files
        spec = find_spec(module.partition(".")[0])
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
    never = {Path(str(distribution(name).locate_file(""))) / module
             for module in NEVER for name in by_module.get(module, ())}  # fmt: skip
    return tuple(sorted({entry.absolute() for entry in found if entry.exists()} - never))


def _needed(requirements: list[str]) -> Iterator[str]:
    """The names of what a library needs here, without extras."""
    from packaging.requirements import Requirement

    for text in requirements:
        requirement = Requirement(text)
        if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
            yield requirement.name
