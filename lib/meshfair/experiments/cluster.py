"""Sweeps on dask's cluster: many processes here, or on any number of machines."""

from __future__ import annotations

import logging
import platform
import time
from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from meshfair import _fast
from meshfair.checks import check_count, needed_for
from meshfair.experiments.cells import Cell, Row, run_batch
from meshfair.experiments.dispatch import LostError, SweepStoppedError, WorkerDiedError
from meshfair.experiments.meshes import Mesh, digest, load_mesh
from meshfair.experiments.versions import WrongVersionError, asked, refused, version

if TYPE_CHECKING:
    from distributed import Client, Future

WAIT = 60.0  # seconds for a first worker to come, and for another when none is left
MESHES = 16  # that the cluster keeps beyond those in use
# notebooks/SWEEPS.md has the same for clusters of one's own.
CONFIGURATION = {
    # `dispatch` counts a worker's deaths, not the scheduler.
    "distributed.scheduler.allowed-failures": 0,
    # Copies of meshes stay where they are.
    "distributed.scheduler.active-memory-manager.start": False,
    # Workers keep the memory of arrays that are freed: dask gives all but 64 kB back at once, and
    # to get it again for the next array costs filters half as much time as all else.
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": 134217728,
    "distributed.nanny.pre-spawn-environ.MALLOC_MMAP_THRESHOLD_": 33554432,
}
# Ctrl-C reaches every process of a terminal; workers leave it to the one that started them.
DEAF = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)"
REFRESH = 2.0  # seconds after which workers are counted again


@contextmanager
def connect(
    scheduler: str | None = None,
    *,
    workers: int | None = None,
    wait: float = WAIT,
    packages: Sequence[str] = ("meshfair",),
) -> Iterator[Cluster]:
    """A dask cluster to run sweeps on, for the time of this block.

    Parameters
    ----------
    scheduler : str, optional
        The address of a scheduler that runs already, such as ``tcp://192.168.0.7:8786``, or
        the path of the file that ``dask scheduler --scheduler-file`` has written.
    workers : int, optional
        Without a scheduler: how many processes to start here.
    wait : float
        Seconds to wait for a worker where there is none.
    packages : sequence of str
        What must be the same on each worker.

    Yields
    ------
    Cluster

    Raises
    ------
    SweepStoppedError
        No scheduler or no worker there, or one with another version of the package.
    NotInstalledError
        dask is missing.
    """
    with needed_for("a cluster"):
        import dask
        import distributed

    with ExitStack() as stack:
        stack.enter_context(_quiet())
        if scheduler is None:
            workers = check_count(workers, "workers", 1)
            stack.enter_context(dask.config.set(CONFIGURATION))
            local = stack.enter_context(
                distributed.LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    dashboard_address=None,
                    silence_logs=logging.CRITICAL,
                    preload=[DEAF],
                )
            )
            client = stack.enter_context(distributed.Client(local))
        else:
            client = stack.enter_context(_client(scheduler))
        cluster = Cluster(client, wait, packages)
        cluster.check_versions()
        yield cluster


def _client(scheduler: str) -> Client:
    """A client of a scheduler that runs already."""
    from distributed import Client
    from distributed.comm import parse_address
    from distributed.comm.registry import get_backend
    from distributed.security import Security

    is_file = scheduler.endswith(".json")
    if is_file and not Path(scheduler).is_file():
        raise SweepStoppedError(f"there is no scheduler file {scheduler}")
    where = {"scheduler_file": scheduler} if is_file else {"address": scheduler}
    try:
        scheme, _ = parse_address(scheduler)
        get_backend(scheme)
        if scheme == "tls" and not Security().get_connection_args("client").get("ssl_context"):
            raise ValueError("dask's configuration here names no certificate and key for TLS")
        return Client(**where, timeout=10, set_as_default=False)
    except (OSError, ValueError) as error:
        raise SweepStoppedError(
            f"no scheduler answers at {scheduler} ({error}); start one with dask scheduler"
        ) from None


@contextmanager
def _quiet() -> Iterator[None]:
    """Silence dask's loggers: of what they say, the package's own messages say what matters."""
    names = [name for name in logging.root.manager.loggerDict if name.startswith("distributed")]
    levels = {name: logging.getLogger(name).level for name in names}
    for name in names:
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for name, level in levels.items():
            logging.getLogger(name).setLevel(level)


class Cluster:
    """The workers of a dask cluster, as `meshfair.experiments.sweep` takes them.

    Parameters
    ----------
    client : distributed.Client
    wait, packages
        As in `connect`.
    """

    def __init__(
        self, client: Client, wait: float = WAIT, packages: Sequence[str] = ("meshfair",)
    ) -> None:
        self.client = client
        self.address = client.scheduler.address
        self._wait = wait
        self._packages = tuple(packages)
        self._meshes: OrderedDict[str, Future] = OrderedDict()
        self._slots, self._counted = 1, 0.0
        self._seen = time.monotonic()

    def check_versions(self) -> None:
        """Wait for workers, and refuse those with another version of the package.

        Raises
        ------
        SweepStoppedError
        """
        try:
            self.client.wait_for_workers(1, timeout=self._wait)
        except TimeoutError:
            raise SweepStoppedError(self._no_worker()) from None
        wanted = version(*self._packages)
        for worker, theirs in self.client.run(asked(), self._packages).items():
            if theirs != wanted:
                raise SweepStoppedError(refused(worker, theirs, wanted))

    def on_each_worker(self, function: Callable[..., Any], *arguments: Any) -> dict[str, Any]:
        """Call a function once on each worker that there is now.

        Parameters
        ----------
        function : callable
            Of an importable module.
        *arguments

        Returns
        -------
        dict of str to object
            What it returned, by the workers' addresses; what it raised is raised.
        """
        futures = {
            worker: self.client.submit(function, *arguments, workers=[worker], pure=False)
            for worker in self.client.nthreads()
        }
        return {worker: future.result() for worker, future in futures.items()}

    def slots(self) -> int:
        """How many threads the workers have together."""
        if time.monotonic() - self._counted > REFRESH and self.client.status == "running":
            self._slots = max(sum(self.client.nthreads().values()), 1)
            self._counted = time.monotonic()
        return self._slots

    def submit(self, batch: Sequence[Cell], limit: float) -> Future:
        """Begin with a batch; a mesh goes to the cluster, and to each worker, once."""
        if self.client.status != "running":
            raise SweepStoppedError(self._no_scheduler())
        meshes = self._scattered(batch)
        return self.client.submit(
            _run,
            (self._packages, version(*self._packages)),
            list(batch),
            limit,
            list(meshes),
            *meshes.values(),
            pure=False,
        )

    def _scattered(self, batch: Sequence[Cell]) -> dict[str, Future]:
        found = {}
        for name in dict.fromkeys(name for cell in batch for name in cell.meshes):
            try:
                mesh = load_mesh(name)
            except Exception:
                continue  # the cell itself will say what is wrong with it
            content = digest(mesh)
            future = self._meshes.pop(content, None)
            if future is None or future.cancelled():
                future = self.client.scatter([mesh], hash=False)[0]
            self._meshes[content] = found[name] = future
            if len(self._meshes) > MESHES:
                self._meshes.popitem(last=False)
        return found

    def collect(self, future: Future) -> tuple[list[Row], float]:
        """What `run_batch` returned.

        Raises
        ------
        WorkerDiedError, LostError, SweepStoppedError
        """
        from distributed import KilledWorker

        try:
            return future.result()
        except KilledWorker as error:
            raise WorkerDiedError(error.allowed_failures + 1) from None
        except CancelledError as error:
            if self.client.status != "running":
                raise SweepStoppedError(self._no_scheduler()) from None
            raise LostError(str(error)) from None
        except WrongVersionError as error:
            raise SweepStoppedError(str(error)) from None

    def look(self) -> None:
        """See whether there is a scheduler with workers.

        Raises
        ------
        SweepStoppedError
        """
        if self.client.status != "running":
            raise SweepStoppedError(self._no_scheduler())
        if self.client.nthreads():
            self._seen = time.monotonic()
        elif time.monotonic() - self._seen > self._wait:
            raise SweepStoppedError(self._no_worker())

    def _no_scheduler(self) -> str:
        return f"the scheduler at {self.address} has gone"

    def _no_worker(self) -> str:
        return (
            f"no worker has come to the scheduler at {self.address} for {self._wait:g} seconds; "
            f"start one with dask worker {self.address} --nthreads 1"
        )


def _run(
    needed: tuple[Sequence[str], str],
    batch: Sequence[Cell],
    limit: float,
    names: Sequence[str],
    *meshes: Mesh,
) -> tuple[list[Row], float]:
    """On a worker: `run_batch` of the same version, on one core."""
    packages, wanted = needed
    if wanted != version(*packages):  # a worker that came later
        raise WrongVersionError(refused(f"on {platform.node()}", version(*packages), wanted))
    _fast.use_one_core()
    return run_batch(batch, limit, dict(zip(names, meshes, strict=True)))
