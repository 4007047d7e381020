"""Limits that hold for all processes of a submission together."""

import contextlib
import os
import threading
from collections.abc import Callable, Iterator
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
        processes = list(_with_all_below(self._first))
        resident = threads = 0
        for process in processes:
            with contextlib.suppress(psutil.Error):  # it has ended in between
                resident += process.memory_info().rss
                threads += process.num_threads()
        limits = self._limits
        # What several share counts in each of them, so this is more than they hold.
        if resident > limits.memory and sum(map(_held, processes)) > limits.memory:
            return f"used more than {limits.memory / 1e9:g} GB of memory in all its processes"
        if threads > limits.processes:
            return f"started more than {limits.processes} processes or threads"
        if self._box is not None and _entries(processes, self._box) > limits.entries:
            return f"made more than {limits.entries:,} files"
        return ""


def _with_all_below(first: psutil.Process) -> Iterator[psutil.Process]:
    """A process and those below it."""
    if not Path(f"/proc/{first.pid}/task/{first.pid}/children").exists():
        yield from (first, *first.children(recursive=True))  # looks at all of the system's
        return
    waiting = [first.pid]
    while waiting:
        pid = waiting.pop()
        with contextlib.suppress(psutil.Error, OSError):
            yield psutil.Process(pid)
            for task in Path(f"/proc/{pid}/task").iterdir():
                waiting += map(int, (task / "children").read_text().split())


def _held(process: psutil.Process) -> int:
    """Bytes that a process holds, of what is shared its part."""
    try:
        try:
            full = process.memory_full_info()
            return int(full.pss + full.swap)
        except (psutil.AccessDenied, AttributeError):
            return int(process.memory_info().rss)
    except psutil.Error:  # it has ended in between
        return 0


def _entries(processes: list[psutil.Process], box: Path) -> int:
    """How many files and folders there are in the writable folder."""
    for process in reversed(processes):  # the last ones are those within the walls
        with contextlib.suppress(OSError):
            inside = os.statvfs(f"/proc/{process.pid}/root{box}")
            return inside.f_files - inside.f_ffree
    return 0
