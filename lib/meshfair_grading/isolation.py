"""A student's process, started with all the restrictions that this system has.

Each restriction is tried out once (`Isolation.detect`); `Isolation.describe` says
which of them hold. This contains accidents; against code that means
harm, run the grading in a container or a virtual machine that can be thrown away.
"""

import contextlib
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

from meshfair_grading import protocol

NOBODY = 65534
KEPT_OUTPUT = 4000
# No network device but a loopback that is down; processes that die with their first one.
NAMESPACES = ("unshare", "--net", "--ipc", "--pid", "--fork", "--kill-child")
NUMBA = "numba"
# Python without its environment (-I) finds this very package all the same, wherever it lies.
START = (
    "import runpy, sys; sys.path.insert(0, sys.argv.pop(1)); "
    "runpy.run_module('meshfair_grading.child', run_name='__main__')"
)
PACKAGES = Path(__file__).parents[1]
STARTUP = 60.0  # seconds; importing SciPy on a busy machine


@dataclass(frozen=True)
class Limits:
    """What one submission may use."""

    call: float = 10.0
    """Seconds for one call of a function."""
    total: float = 60.0
    """Seconds for the whole submission, and of processor time for each process."""
    memory: int = 2_000_000_000
    """Bytes of address space of each process."""
    file: int = 16_000_000
    """Bytes in one file; what the code prints goes to one."""
    processes: int = 32
    files: int = 64


@dataclass(frozen=True)
class Isolation:
    """How to start a student's process on this system."""

    limits: Limits = field(default_factory=Limits)
    namespaces: bool = False
    """Whether network and processes are the child's own."""
    nobody: bool = False
    """Whether the child gives up the rights of root."""
    confined: bool = False
    """Whether the child sees no files but Python's and its own folder."""
    numba_cache: Path | None = None
    """A folder with what numba has compiled; each child gets a copy."""
    keep_compiled: bool = False
    """Whether what the child compiles goes into that folder: for trusted code only."""

    @classmethod
    def detect(cls, limits: Limits | None = None) -> Self:
        """Try the restrictions out, the strongest first.

        Parameters
        ----------
        limits : Limits, optional

        Returns
        -------
        Isolation

        Raises
        ------
        OSError
            Not even a plain process with limits can be started.
        """
        limits = limits or Limits()
        if os.name != "posix":
            raise OSError("grading needs Linux or macOS (on Windows, the Linux subsystem WSL)")
        root = os.geteuid() == 0
        spaced = shutil.which("unshare") is not None
        attempts = [
            (s, n) for s in (True, False) for n in (True, False) if s <= spaced and n <= root
        ]
        for namespaces, nobody in attempts:
            try:
                process = cls(limits, namespaces, nobody).start(b"", "trial.py")
            except OSError as error:
                reason = error
                continue
            process.stop()
            return cls(limits, namespaces, nobody, process.confined)
        raise reason

    def describe(self) -> list[str]:
        """Say what holds on this system and what does not, a line each.

        Returns
        -------
        list of str
        """
        root = os.geteuid() == 0
        return [
            "network: " + ("none" if self.namespaces else "NOT cut off (no user namespaces here)"),
            "files: "
            + (
                "Python's own and the submission's folder, no others"
                if self.confined
                else "NOT confined (no Landlock here): the code can read what you can read"
            ),
            "user: "
            + ("nobody" if self.nobody else "ROOT, do not grade like this" if root else "yours"),
            "processes: "
            + (
                "all ended with the submission's first one"
                if self.namespaces
                else "the process group is ended; one that leaves its group is NOT"
            ),
            f"limits: {self.limits.call:g} s a call, {self.limits.total:g} s in all, "
            f"{self.limits.memory / 1e9:g} GB, files of {self.limits.file / 1e6:g} MB, "
            f"{self.limits.processes} processes, {self.limits.files} open files",
        ]

    def wrapped(self, command: list[str]) -> list[str]:
        """The command in namespaces of its own, where the system has them."""
        if not self.namespaces:
            return command
        # Who is not root needs a user namespace to make the others; no user is mapped
        # in it, so nothing inside has any privilege.
        mine = () if self.nobody else ("--user",)
        return [*NAMESPACES, *mine, *command]

    def start(self, source: bytes, filename: str) -> "Process":
        """Start a process in a fresh folder with a submission's file in it.

        Parameters
        ----------
        source : bytes
        filename : str

        Returns
        -------
        Process

        Raises
        ------
        OSError
            It did not start; the message holds what it printed.
        """
        return Process(source, filename, self)


class Process:
    """A student's process, its folder and the channel to it."""

    def __init__(self, source: bytes, filename: str, isolation: Isolation) -> None:
        self._isolation = isolation
        self._folder = tempfile.TemporaryDirectory(prefix="meshfair-", ignore_cleanup_errors=True)
        self._output = tempfile.TemporaryFile()  # noqa: SIM115  closed in stop
        self.channel, theirs = socket.socketpair()
        folder = Path(self._folder.name)
        self.file = str(folder / filename)
        Path(self.file).write_bytes(source)
        if isolation.numba_cache:
            shutil.copytree(isolation.numba_cache, folder / NUMBA)
        if isolation.nobody:
            for path in (folder, *folder.rglob("*")):
                os.chown(path, NOBODY, NOBODY)
        self._printed_before = 0
        limits = isolation.limits
        child_limits = {
            "cpu": int(limits.total),
            "memory": limits.memory,
            "file": limits.file,
            "processes": limits.processes,
            "files": limits.files,
        }
        user = NOBODY if isolation.nobody else None
        command = [sys.executable, "-I", "-B", "-c", START, str(PACKAGES)]
        command += [str(theirs.fileno()), json.dumps(child_limits), json.dumps(user)]
        with theirs:
            self._popen = subprocess.Popen(
                isolation.wrapped(command),
                cwd=folder,
                env=_environment(folder),
                stdin=subprocess.DEVNULL,
                stdout=self._output,
                stderr=subprocess.STDOUT,
                pass_fds=[theirs.fileno()],
                start_new_session=True,  # a group of its own, to be killed as one
            )
        try:
            hello = protocol.receive(self.channel, time.monotonic() + STARTUP)
        except (OSError, EOFError) as error:
            _, printed = self.stop(patience=1.0)
            raise OSError(f"the process did not start: {printed[-500:] or error!r}") from error
        self.confined = hello["confined"]
        # What was printed so far is Python's, not the student's.
        self._printed_before = self._output.seek(0, os.SEEK_END)

    def stop(self, patience: float = 0.0) -> tuple[int, str]:
        """Kill the process and all of its group, and remove its folder.

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
        """
        self.channel.close()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._popen.wait(patience)
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self._popen.pid, signal.SIGKILL)
        code = self._popen.wait()
        printed = os.pread(self._output.fileno(), KEPT_OUTPUT, self._printed_before)
        self._output.close()
        compiled, cache = Path(self._folder.name) / NUMBA, self._isolation.numba_cache
        if self._isolation.keep_compiled and cache and compiled.exists():
            shutil.copytree(compiled, cache, dirs_exist_ok=True)
        self._folder.cleanup()
        return code, printed.decode(errors="replace")


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
