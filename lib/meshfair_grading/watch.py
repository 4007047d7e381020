"""Limits that hold for all processes of a submission together."""

import contextlib
import os
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import psutil

INTERVAL = 0.05  # seconds between two looks


@dataclass(frozen=True)
class Together:
    """What all processes of one submission may use."""

    memory: int
    """Bytes that are held."""
    processes: int
    """Processes and threads."""
    entries: int
    """Files and folders."""


class Watch(threading.Thread):
    """Looks at a process and all below it, and ends them where they use too much.

    Whatever a process behind the walls starts stays below their first process, however it
    leaves its group or its parent.

    Parameters
    ----------
    pid : int
        The first process, from outside.
    limits : Together
    box : Path or None
        The writable folder as the processes see it; None where there are no walls.
    end : callable
        Ends them all.

    Attributes
    ----------
    reason : str
        What was too much; empty while nothing was.
    """

    def __init__(
        self, pid: int, limits: Together, box: Path | None, end: Callable[[], None]
    ) -> None:
        super().__init__(daemon=True)
        self._first, self._limits, self._box, self._end = psutil.Process(pid), limits, box, end
        self._stopped = threading.Event()
        self.reason = ""

    def run(self) -> None:
        """Look until it is stopped."""
        while not self.reason and not self._stopped.wait(INTERVAL):
            with contextlib.suppress(psutil.Error, OSError):
                self.reason = self._too_much()
        if self.reason:
            self._end()

    def stop(self) -> None:
        """Look no more."""
        self._stopped.set()
        self.join()

    def _too_much(self) -> str:
        processes = [self._first, *self._first.children(recursive=True)]
        memory = threads = 0
        for process in processes:
            with contextlib.suppress(psutil.Error):  # it has ended in between
                used = process.memory_info()
                memory += used.rss - getattr(used, "shared", 0)
                threads += process.num_threads()
        limits = self._limits
        if memory > limits.memory:
            return f"used more than {limits.memory / 1e9:g} GB of memory in all its processes"
        if threads > limits.processes:
            return f"started more than {limits.processes} processes or threads"
        if self._box is not None:
            inside = os.statvfs(f"/proc/{processes[-1].pid}/root{self._box}")
            if inside.f_files - inside.f_ffree > limits.entries:
                return f"made more than {limits.entries:,} files"
        return ""
