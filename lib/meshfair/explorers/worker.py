"""A latest-wins worker: work in the background of which only the newest request counts."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

DELAY = 0.3  # seconds before progress is shown: quick work should not flicker
INTERVAL = 0.1  # seconds between two reports


class Cancelled(Exception):  # noqa: N818 (a signal, as StopIteration is, and no error)
    """The work being done is no longer wanted."""


class Job:
    """What the work gets beside its request: where it asks and reports.

    Parameters
    ----------
    wanted : callable
        Whether the job is still the newest.
    report : callable
        Called with the part of the work that is done, 0 to 1.
    """

    def __init__(self, wanted: Callable[[], bool], report: Callable[[float], object]) -> None:
        self._wanted, self._report = wanted, report
        self._next = time.monotonic() + DELAY

    def check(self) -> None:
        """Raise `Cancelled` where a newer request, or a cancellation, has come."""
        if not self._wanted():
            raise Cancelled

    def progress(self, done: float) -> None:
        """Say which part is done, 0 to 1; also checks."""
        self.check()
        if time.monotonic() > self._next:
            self._next = time.monotonic() + INTERVAL
            self._report(done)


class LatestWins:
    """Runs work on a thread of its own; a new request cancels all older ones.

    Parameters
    ----------
    work : callable
        ``work(job, *request)``. It calls ``job.progress`` every now and then,
        which ends it when it has been cancelled.
    report : callable
        See `Job`. Called with 1.0 when a job has ended, however it did.
    failed : callable
        Called with the exception where the work raises one.
    """

    def __init__(
        self,
        work: Callable[..., object],
        report: Callable[[float], object],
        failed: Callable[[Exception], object],
    ) -> None:
        self._work, self._report, self._failed = work, report, failed
        self._newest = 0
        self._lock = threading.Lock()
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="explorer")
        self._last: Future[None] | None = None

    def request(self, *request: Any) -> None:
        """Ask for new work; returns at once."""
        with self._lock:
            self._newest += 1
            self._last = self._thread.submit(self._run, self._newest, request)

    def cancel(self) -> None:
        """Drop the work being done, and ask for nothing else."""
        with self._lock:
            self._newest += 1

    def wait(self, timeout: float = 60) -> None:
        """Wait until the newest work is done.

        Raises
        ------
        TimeoutError
            It takes longer than ``timeout`` seconds.
        """
        if self._last is not None:
            self._last.result(timeout)

    def _run(self, number: int, request: tuple[Any, ...]) -> None:
        job = Job(lambda: number == self._newest, self._report)
        try:
            job.check()
            self._work(job, *request)
        except Cancelled:
            return
        except Exception as error:  # it would vanish with this thread: the explorer shows it
            self._failed(error)
        finally:
            self._report(1.0)
