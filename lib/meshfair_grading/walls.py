"""What a submission's process can see and do: bubblewrap's walls around it.

Inside, there is Python with the libraries that the assignment allows, and nothing
else (see `meshfair_grading.view`). All is read-only but one small folder in memory.
Processes, network, users and messages are its own, and all processes end with the first one.
"""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

from meshfair_grading import kernel, view

BWRAP = "bwrap"
NOBODY = 65534
HOME = Path("/box")
COMPILED = Path("/compiled")
SHARED_MEMORY = 1_000_000  # bytes in /dev/shm
# Not /dev/zero: what is mapped from it is memory that nobody counts.
DEVICES = ("/dev/null", "/dev/random", "/dev/urandom")
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
    if os.geteuid() == 0 and shutil.which("setpriv") is None:
        return "setpriv is not installed (on Debian and Ubuntu: apt install util-linux)"
    filtered = kernel_filter()
    try:
        subprocess.run(
            command([str(view.PYTHON), "-I", "-c", ""], [], box=1_000_000, filtered=filtered),
            check=True, capture_output=True, timeout=PATIENCE, stdin=subprocess.DEVNULL,
            pass_fds=[filtered] if filtered is not None else [],
        )  # fmt: skip
    except subprocess.CalledProcessError as error:
        said = error.stderr.decode(errors="replace").strip() or f"exit code {error.returncode}"
        return f"bubblewrap does not work here ({said.splitlines()[-1]})"
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"bubblewrap does not work here ({error})"
    finally:
        if filtered is not None:
            os.close(filtered)
    return ""


def kernel_filter() -> int | None:
    """The filter of calls to the kernel, ready to be read by bubblewrap.

    Returns
    -------
    int or None
        A file descriptor; None where there is no filter for this processor.
    """
    program = kernel.program()
    if not program:
        return None
    reading, writing = os.pipe()
    os.write(writing, program)
    os.close(writing)
    return reading


def command(
    program: list[str],
    allowed: Iterable[str],
    *,
    box: int,
    blocked: Iterable[str] = (),
    files: Iterable[tuple[int, str]] = (),
    filtered: int | None = None,
    compiled: Path | None = None,
    keep_compiled: bool = False,
    environment: dict[str, str] | None = None,
) -> list[str]:
    """The command that runs a program behind the walls.

    Parameters
    ----------
    program : list of str
    allowed, blocked : iterable of str
        Modules that can be imported, with what these need, and others that cannot.
    box : int
        Bytes that fit into the writable folder.
    files : iterable of (int, str)
        File descriptors whose content is copied into the writable folder, and names there.
    filtered : int, optional
        See `kernel_filter`.
    compiled : Path, optional
        A folder with what numba has compiled, seen as `COMPILED`.
    keep_compiled : bool
        Whether that can be written to: for trusted code only.
    environment : dict of str to str, optional

    Returns
    -------
    list of str
    """
    mounts = [*view.system(), *view.libraries(allowed, blocked), *view.grader()]
    if compiled:
        mounts += ["--bind" if keep_compiled else "--ro-bind", str(compiled), str(COMPILED)]
    variables = [word for item in (environment or {}).items() for word in ("--setenv", *item)]
    copies = [word for fd, name in files for word in ("--file", str(fd), str(HOME / name))]
    calls = [] if filtered is None else ["--seccomp", str(filtered)]

    def walled(mounts: list[str]) -> list[str]:
        return [
            shutil.which(BWRAP) or BWRAP, "--unshare-all", "--unshare-user", "--disable-userns",
            "--die-with-parent", "--new-session", "--hostname", "box", *calls,
            "--clearenv", *variables, *mounts, "--proc", "/proc", "--remount-ro", "/proc",
            *_devices(), "--size", str(box), "--tmpfs", str(HOME), *copies,
            "--chdir", str(HOME), "--remount-ro", "/", *program,
        ]  # fmt: skip

    if os.geteuid() != 0:
        return walled(mounts)
    # For root, devices and the like would be its own. So a first bubblewrap shows the same view,
    # in which `nobody` finds a Python that lies in root's home, and builds the walls as nobody.
    tools = [Path(shutil.which(name) or name) for name in (BWRAP, "setpriv")]
    return [
        str(tools[0]), "--die-with-parent", "--cap-add", "CAP_SETUID", "--cap-add", "CAP_SETGID",
        *mounts, *(word for tool in tools for word in view.shown(tool)),
        "--bind", "/proc", "/proc", "--dev", "/dev", "--dir", "/tmp", "--chdir", "/",
        str(tools[1]), f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups",
        *walled(_seen_again(mounts)),
    ]  # fmt: skip


def give(folder: Path) -> None:
    """Give a folder to the user who works behind the walls, where that is another one.

    Parameters
    ----------
    folder : Path
    """
    if os.geteuid() == 0:
        os.chown(folder, NOBODY, NOBODY)


def _devices() -> list[str]:
    """The few devices that Python needs; their times are not to be changed either."""
    words = ["--perms", "0755", "--tmpfs", "/dev"]
    for device in DEVICES:
        words += ["--dev-bind", device, device, "--remount-ro", device]
    words += ["--symlink", "/proc/self/fd", "/dev/fd"]
    words += ["--size", str(SHARED_MEMORY), "--tmpfs", "/dev/shm", "--remount-ro", "/dev"]
    return words


def _seen_again(mounts: list[str]) -> list[str]:
    """The mounts of a view within itself, where everything lies in its place."""
    mounts = list(mounts)
    for position, word in enumerate(mounts):
        if word in ("--bind", "--ro-bind"):
            mounts[position + 1] = mounts[position + 2]
    return mounts
