"""A student's process: started behind walls, watched, ended, and what it printed.

`Isolation.describe` says which restrictions hold on this system. Without the walls
(see `meshfair_grading.walls`) accidents are contained and no malice.
"""

import contextlib
import json
import os
import platform
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from meshfair_grading import protocol, view, walls
from meshfair_grading.watch import Together, Watch

KEPT_OUTPUT = 4000
NUMBA = "numba"
# Python without its environment (-I), whose libraries lie in folders that are given.
START = (
    "import json, runpy, sys; words = json.loads(sys.argv[1]); "
    "sys.path[:] = words['before'] + sys.path + words['after']; "
    "runpy.run_module('meshfair_grading.child', run_name='__main__')"
)
PACKAGES = Path(__file__).parents[1]
# That can be imported, and that cannot.
Modules = tuple[Sequence[str], Sequence[str]]
STARTUP = 60.0  # seconds; importing SciPy on a busy machine
# From here on Linux counts a user's processes within the walls alone.
COUNTS_WITHIN = (5, 14)


class NoWallsError(OSError):
    """There are no walls on this system; the message says why, and what to do."""


@dataclass(frozen=True)
class Limits:
    """What one submission may use."""

    call: float = 10.0
    """Seconds for one call of a function."""
    total: float = 60.0
    """Seconds for the whole submission, and of processor time for each process."""
    memory: int = 2_000_000_000
    """Bytes of address space of each process, and of memory of all of them together."""
    file: int = 16_000_000
    """Bytes in one file, and in all of its folder; what the code prints goes to a file, too."""
    processes: int = 32
    """Processes and threads at a time."""
    files: int = 64
    """Open files."""
    entries: int = 2_000
    """Files and folders that there may be."""


@dataclass(frozen=True)
class Isolation:
    """How to start a student's process on this system."""

    limits: Limits = field(default_factory=Limits)
    walls: bool = True
    """Whether bubblewrap's walls are around it."""
    numba_cache: Path | None = None
    """A folder with what numba has compiled; each child gets a copy."""
    keep_compiled: bool = False
    """Whether what the child compiles goes into that folder: for trusted code only."""

    @classmethod
    def detect(cls, limits: Limits | None = None, *, without_walls: bool = False) -> Self:
        """Try the walls out.

        Parameters
        ----------
        limits : Limits, optional
        without_walls : bool
            Do without them where this system has none.

        Returns
        -------
        Isolation

        Raises
        ------
        NoWallsError
            There are none, and they are wanted.
        OSError
            Not even a plain process with limits can be started.
        """
        limits = limits or Limits()
        if os.name != "posix":
            raise OSError("grading needs Linux or macOS (on Windows, the Linux subsystem WSL)")
        trouble = walls.trouble()
        if trouble and not without_walls:
            raise NoWallsError(
                f"submissions would run without walls: {trouble}; install it, or give "
                "--without-walls in a machine that you can throw away"
            )
        isolation = cls(limits, walls=not trouble)
        isolation.start(b"", "trial.py").stop()
        return isolation

    def describe(self) -> list[str]:
        """Say what holds on this system and what does not, a line each.

        Returns
        -------
        list of str
        """
        limits = self.limits
        lines = [
            f"limits: {limits.call:g} s a call, {limits.total:g} s in all, "
            f"{limits.memory / 1e9:g} GB, files of {limits.file / 1e6:g} MB, "
            f"{limits.processes} processes, {limits.files} open files"
        ]
        if self.walls:
            return [
                "walls: no network, no files but Python's and the submission's own, which end with "
                "it; no user but nobody, no process that stays",
                *lines,
            ]
        who = "ROOT" if os.geteuid() == 0 else "you"
        return [
            f"walls: NONE. The code can reach the network and do what {who} can do with your "
            "files, import what holds the answers, and leave processes behind",
            *lines,
        ]

    def start(
        self,
        source: bytes,
        filename: str,
        allowed: Sequence[str] = (),
        blocked: Sequence[str] = (),
    ) -> "Process":
        """Start a process with a submission's file in its folder.

        Parameters
        ----------
        source : bytes
        filename : str
        allowed, blocked : sequence of str
            Modules of libraries that it can import, beside NumPy and SciPy, and others of
            the same libraries that it cannot.

        Returns
        -------
        Process

        Raises
        ------
        OSError
            It did not start; the message holds what it printed.
        """
        modules = ("numpy", "scipy", *allowed), blocked
        return Process(source, filename, modules, self)


class Process:
    """A student's process, its folder and the channel to it."""

    def __init__(
        self,
        source: bytes,
        filename: str,
        modules: Modules,
        isolation: Isolation,
    ) -> None:
        self._isolation = isolation
        self._output = tempfile.TemporaryFile()  # noqa: SIM115  closed in stop
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self.channel, theirs = socket.socketpair()
        self._printed_before = 0
        with theirs, tempfile.TemporaryFile() as file:
            file.write(source)
            file.seek(0)
            start = self._behind_walls if isolation.walls else self._in_the_open
            self.file, self._popen = start(file.fileno(), filename, source, modules, theirs)
        self._watch = Watch(
            self._popen.pid,
            Together(isolation.limits.memory, isolation.limits.processes, isolation.limits.entries),
            walls.HOME if isolation.walls else None,
            self._kill,
        )
        try:
            protocol.receive(self.channel, time.monotonic() + STARTUP)
        except (OSError, EOFError) as error:
            _, printed = self._ended(patience=1.0)
            raise OSError(f"the process did not start: {printed[-500:] or error!r}") from error
        # What was printed so far is Python's, not the student's.
        self._printed_before = self._output.seek(0, os.SEEK_END)
        self._watch.start()

    def _behind_walls(
        self, fd: int, filename: str, source: bytes, modules: Modules, theirs: socket.socket
    ) -> tuple[str, subprocess.Popen[bytes]]:
        isolation = self._isolation
        allowed, blocked = modules
        path = [view.GRADER, *view.folders(allowed, blocked)]
        cache = isolation.numba_cache
        filtered = walls.kernel_filter()
        command = walls.command(
            self._python(str(view.PYTHON), theirs, after=path, compiled=cache is not None),
            allowed,
            blocked=blocked,
            box=isolation.limits.file,
            files=[(fd, filename)],
            filtered=filtered,
            compiled=cache,
            keep_compiled=isolation.keep_compiled,
            environment=_environment(walls.HOME),
        )
        fds = [fd, theirs.fileno(), *([] if filtered is None else [filtered])]
        try:
            return str(walls.HOME / filename), self._popen_of(command, fds)
        finally:
            if filtered is not None:
                os.close(filtered)

    def _in_the_open(
        self, fd: int, filename: str, source: bytes, modules: Modules, theirs: socket.socket
    ) -> tuple[str, subprocess.Popen[bytes]]:
        self._folder = tempfile.TemporaryDirectory(prefix="meshfair-", ignore_cleanup_errors=True)
        folder = Path(self._folder.name)
        (folder / filename).write_bytes(source)
        cache = self._isolation.numba_cache
        if cache:
            shutil.copytree(cache, folder / NUMBA)
        command = self._python(sys.executable, theirs, before=[PACKAGES])
        popen = self._popen_of(command, [theirs.fileno()], cwd=folder, env=_environment(folder))
        return str(folder / filename), popen

    def _python(
        self,
        python: str,
        theirs: socket.socket,
        before: Sequence[Path] = (),
        after: Sequence[Path] = (),
        compiled: bool = False,
    ) -> list[str]:
        """The command of the child, with folders before and after Python's own ones."""
        limits = self._isolation.limits
        words: dict[str, Any] = {
            "before": [str(folder) for folder in before],
            "after": [str(folder) for folder in after],
            "channel": theirs.fileno(),
            "limits": {
                "cpu": int(limits.total) + 1,
                "memory": limits.memory,
                "file": limits.file,
                "files": limits.files,
            },
            "compiled": str(walls.COMPILED) if compiled else None,
            "keep_compiled": self._isolation.keep_compiled,
        }
        if self._isolation.walls and _release() >= COUNTS_WITHIN:
            words["limits"]["processes"] = limits.processes
        # Unbuffered, so that what was printed is there however the process ends.
        return [python, "-I", "-B", "-u", "-c", START, json.dumps(words)]

    def _popen_of(
        self, command: list[str], fds: list[int], **options: Any
    ) -> subprocess.Popen[bytes]:
        nothing, writing = os.pipe()  # not a device of this system's, whose times can be changed
        os.close(writing)
        try:
            return subprocess.Popen(
                command,
                stdin=nothing,
                stdout=self._output,
                stderr=subprocess.STDOUT,
                pass_fds=fds,
                start_new_session=True,  # a group of its own, to be killed as one
                **options,
            )
        finally:
            os.close(nothing)

    def _kill(self) -> None:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self._popen.pid, signal.SIGKILL)

    def stop(self, patience: float = 0.0) -> tuple[int, str, str]:
        """End the process with all that it has started, and remove its folder.

        Parameters
        ----------
        patience : float
            Seconds to wait for it to end by itself.

        Returns
        -------
        code : int
            Its exit code, negative for a signal.
        printed : str
            The beginning of what it printed.
        excess : str
            What all of its processes together used too much of, or nothing.
        """
        code, printed = self._ended(patience)
        self._watch.stop()
        return code, printed, self._watch.reason

    def _ended(self, patience: float) -> tuple[int, str]:
        self.channel.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._popen.wait(patience)
        self._kill()
        code = self._popen.wait()
        if self._isolation.walls and code > 128:  # as bubblewrap reports a signal
            code = 128 - code
        printed = os.pread(self._output.fileno(), KEPT_OUTPUT, self._printed_before)
        self._output.close()
        if self._folder is not None:
            compiled, cache = Path(self._folder.name) / NUMBA, self._isolation.numba_cache
            if self._isolation.keep_compiled and cache and compiled.exists():
                shutil.copytree(compiled, cache, dirs_exist_ok=True)
            self._folder.cleanup()
        return code, printed.decode(errors="replace")


def _release() -> tuple[int, int]:
    """The version of the system's kernel."""
    numbers = re.match(r"(\d+)\.(\d+)", platform.release())
    return (int(numbers[1]), int(numbers[2])) if numbers else (0, 0)


def _environment(folder: Path) -> dict[str, str]:
    """An environment without anything of the teacher's; one thread for each library."""
    threads = ("OMP", "OPENBLAS", "MKL", "NUMBA")
    # Some installations of Python find their own libraries only by this.
    kept = {name: os.environ[name] for name in ("LD_LIBRARY_PATH",) if name in os.environ}
    return {
        **kept,
        "PATH": "/usr/bin:/bin",
        "HOME": str(folder),
        "TMPDIR": str(folder),
        "LANG": "C.UTF-8",
        "NUMBA_CACHE_DIR": str(folder / NUMBA),
        **{f"{library}_NUM_THREADS": "1" for library in threads},
    }
