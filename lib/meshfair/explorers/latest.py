"""Work in the background of which only the newest request counts."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor


class Obsolete(Exception):  # noqa: N818 (a signal, as StopIteration is, and no error)
    """The work being done is no longer wanted."""


class Job:
    """What the work is given beside its request: where it asks and reports.

    Parameters
    ----------
    wanted : callable
        Tells whether the job is still the newest.
    report : callable
        Called with the part of the work that is done, 0 to 1.
    """

    PATIENCE = 0.3  # seconds before progress is shown: quick work should not flicker
    PACE = 0.1  # seconds between two reports

    def __init__(self, wanted, report):
        self._wanted, self._report = wanted, report
        self._next = time.monotonic() + self.PATIENCE

    def check(self):
        """Raise `Obsolete` where a newer request, or a cancellation, has come."""
        if not self._wanted():
            raise Obsolete

    def progress(self, done):
        """Say which part is done, 0 to 1; also checks."""
        self.check()
        if time.monotonic() > self._next:
            self._next = time.monotonic() + self.PACE
            self._report(done)


class Latest:
    """Runs work on a thread of its own; a new request makes all older ones obsolete.

    Parameters
    ----------
    work : callable
        ``work(job, *request)``. It calls ``job.progress`` every now and then,
        which ends it when it has become obsolete.
    report : callable
        See `Job`. Called with 1.0 when a job has ended, however it did.
    failed : callable
        Called with the exception where the work raises one.
    """

    def __init__(self, work, report, failed):
        self._work, self._report, self._failed = work, report, failed
        self._newest = 0
        self._lock = threading.Lock()
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="explorer")
        self._last = None

    def ask(self, *request):
        """Ask for new work; returns at once."""
        with self._lock:
            self._newest += 1
            self._last = self._thread.submit(self._run, self._newest, request)

    def cancel(self):
        """Drop the work being done, and ask for nothing else."""
        with self._lock:
            self._newest += 1

    def wait(self, timeout=60):
        """Wait until the newest work is done.

        Raises
        ------
        TimeoutError
            It takes longer than ``timeout`` seconds.
        """
        if self._last is not None:
            self._last.result(timeout)

    def _run(self, number, request):
        job = Job(lambda: number == self._newest, self._report)
        try:
            job.check()
            self._work(job, *request)
        except Obsolete:
            return
        except Exception as error:  # it would vanish with this thread: the explorer shows it
            self._failed(error)
        finally:
            self._report(1.0)
