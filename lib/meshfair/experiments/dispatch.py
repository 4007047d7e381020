"""Hand cells out to workers, and collect their rows whatever happens to the workers."""

from __future__ import annotations

import os
import queue
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor
from typing import Any, Protocol

from meshfair.experiments.cells import Cell, Row, failure, run_batch

# A cell whose worker died so often, the last time with no other cell near, is given up.
TRIES = 3
# How often a batch may come back undone for a reason that is not its own.
LOSSES = 20
# A message to a worker and back takes milliseconds of the scheduler. So cells that take less than
# this go several at a time; and more of them, where so many workers would send more messages a
# second than the scheduler bears.
BATCH_SECONDS = 0.25
MESSAGES = 100
# At most this many batches for each worker at a time: one that runs, and one that waits.
AHEAD = 2
PATIENCE = 1.0  # seconds without an answer, after which the workers are looked after

Rows = list[tuple[Cell, Row]]


class SweepStoppedError(OSError):
    """The sweep cannot go on; the message says why. Finished rows are in the journal."""


class WorkerDiedError(RuntimeError):
    """A cell's worker died."""

    def __init__(self, times: int = 1) -> None:
        super().__init__(f"its worker died {times} times: crashed, killed, or out of memory")
        self.times = times


class LostError(RuntimeError):
    """A batch came back undone, through no fault of its cells."""


class Workers(Protocol):
    """What runs batches of cells."""

    def slots(self) -> int:
        """How many batches can run at the same time."""

    def submit(self, batch: Sequence[Cell], limit: float) -> Any:
        """Begin `run_batch`; return a future with ``add_done_callback`` and ``cancel``."""

    def collect(self, future: Any) -> tuple[list[Row], float]:
        """What `run_batch` returned.

        Raises
        ------
        WorkerDiedError, LostError, SweepStoppedError
        """

    def look(self) -> None:
        """Look whether there are workers at all; called while nothing comes back.

        Raises
        ------
        SweepStoppedError
        """


class ExecutorWorkers:
    """The workers of any executor of `concurrent.futures`.

    Parameters
    ----------
    executor : concurrent.futures.Executor
    """

    def __init__(self, executor: Executor) -> None:
        self._executor = executor

    def slots(self) -> int:
        """As many as the executor says, or else one for each core here."""
        return getattr(self._executor, "_max_workers", None) or os.cpu_count() or 1

    def submit(self, batch: Sequence[Cell], limit: float) -> Any:
        """Begin with a batch.

        Raises
        ------
        SweepStoppedError
            The executor takes nothing any more.
        """
        try:
            return self._executor.submit(run_batch, batch, limit)
        except BrokenExecutor as error:
            raise _broken(error) from None

    def collect(self, future: Any) -> tuple[list[Row], float]:
        """What `run_batch` returned.

        Raises
        ------
        SweepStoppedError
            A worker died, and with it such an executor.
        """
        try:
            return future.result()
        except BrokenExecutor as error:
            raise _broken(error) from None

    def look(self) -> None:
        """Nothing to look after: an executor says itself when it breaks."""


def _broken(error: BrokenExecutor) -> SweepStoppedError:
    return SweepStoppedError(
        f"a worker died, and its executor ends with it ({error}); start the sweep again with the "
        "same journal, on meshfair.experiments.cluster if this comes back"
    )


def dispatch(workers: Workers, waiting: Sequence[Cell]) -> Iterator[Rows]:
    """Run cells on workers.

    A worker that dies costs its batches; their cells run again one by one. Which of them
    killed it is certain only of a cell that runs alone, so one is given up only then.

    Parameters
    ----------
    workers : Workers
    waiting : sequence of Cell

    Yields
    ------
    list of (Cell, dict)
        Cells with their rows, as they are finished; each cell once.

    Raises
    ------
    SweepStoppedError
        No workers, or nothing to reach them by.
    """
    todo, suspects = deque(waiting), deque[Cell]()
    pending: dict[Any, list[Cell]] = {}
    deaths: Counter[str] = Counter()
    losses: Counter[str] = Counter()
    done: queue.SimpleQueue[Any] = queue.SimpleQueue()
    seconds_each = BATCH_SECONDS  # so the first batches hold one cell

    def submit(batch: list[Cell]) -> None:
        future = workers.submit(batch, limit)
        pending[future] = batch
        future.add_done_callback(done.put)

    try:
        while todo or suspects or pending:
            slots = workers.slots()
            limit = max(BATCH_SECONDS, slots / MESSAGES)
            while todo and len(pending) < AHEAD * slots:
                fair = len(todo) // (2 * AHEAD * slots)
                submit(_take(todo, min(int(limit / seconds_each), fair), deaths))
            alone = not pending
            if alone:
                submit([suspects.popleft()])
            future = _next(done, workers)
            batch = pending.pop(future)
            try:
                rows, seconds = workers.collect(future)
            except WorkerDiedError as death:
                for cell in batch:
                    deaths[cell.key] += death.times
                    if alone and deaths[cell.key] >= TRIES:
                        yield [(cell, failure(WorkerDiedError(deaths[cell.key])))]
                    elif deaths[cell.key] >= TRIES - 1:
                        suspects.append(cell)
                    else:
                        todo.appendleft(cell)
            except (LostError, CancelledError) as loss:
                losses.update(cell.key for cell in batch)
                if losses[batch[0].key] > LOSSES:
                    raise SweepStoppedError(f"cells come back undone: {loss}") from None
                todo.extendleft(reversed(batch))
            except SweepStoppedError:
                raise
            except Exception as error:  # what cannot be sent there or back
                yield [(cell, failure(error)) for cell in batch]
            else:
                todo.extendleft(reversed(batch[len(rows) :]))
                seconds_each = max((seconds_each + seconds / len(rows)) / 2, 1e-6)
                yield list(zip(batch, rows, strict=False))
    finally:
        for future in pending:
            future.cancel()


def _take(todo: deque[Cell], size: int, deaths: Counter[str]) -> list[Cell]:
    """The next cells; one whose worker died before goes by itself."""
    batch = [todo.popleft()]
    while todo and len(batch) < size and not deaths[batch[0].key] and not deaths[todo[0].key]:
        batch.append(todo.popleft())
    return batch


def _next(done: queue.SimpleQueue[Any], workers: Workers) -> Any:
    while True:
        try:
            return done.get(timeout=PATIENCE)
        except queue.Empty:
            workers.look()
