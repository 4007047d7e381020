"""Sweeps on dask's cluster: a real scheduler, real workers, and what happens to them."""

import csv
import io as io_module
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from pathlib import Path

import pytest
import yaml

import cells
import meshfair
from meshfair import _fast, io, shapes
from meshfair.cli import main
from meshfair.experiments import cluster as cluster_module
from meshfair.experiments import sweep
from meshfair.experiments.cluster import connect
from meshfair.experiments.dispatch import SweepStoppedError
from meshfair.experiments.versions import version
from submissions import HOSTILE, build

pytest.importorskip("distributed")
# Of sockets and loops that dask leaves to the garbage collector.
pytestmark = [
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]

TESTS = Path(__file__).parent
LIB = Path(meshfair.__file__).parents[1]
PAGE = (Path(__file__).parents[1] / "notebooks" / "SWEEPS.md").read_text(encoding="utf-8")
# The page's own configuration for dask.
CONFIGURATION = re.search(r"in `dask.yaml`.*?```yaml\n(.*?)```", PAGE, re.S)[1]

STOPPING = """
experiment = "stopping"
mesh = ["knot", "*.ply"]
noise = "uniform"
decibels = 20.0
weights = ["combinatorial", "cotangent"]
seed = { from = 0, to = 4 }
time = 1.0
"""
SLOW = 'experiment = "cells:slow"\nx = { from = 0, to = 99 }\n'


def environment(folder, lib=LIB, path=None):
    configuration = write(folder / "dask.yaml", CONFIGURATION)
    modules = f"{lib}{os.pathsep}{TESTS}"
    more = {"PATH": path} if path else {}
    return os.environ | {"PYTHONPATH": modules, "DASK_CONFIG": str(configuration)} | more


def start(folder, *words, lib=LIB, path=None, **options):
    options["env"] = environment(folder, lib, path)
    with open(folder / "log.txt", "ab") as log:
        command = [sys.executable, "-m", *words]
        return subprocess.Popen(command, cwd=folder, stdout=log, stderr=log, **options)


@contextmanager
def a_cluster(folder, workers=2, **options):
    """A scheduler and workers, as their own commands start them; yields the scheduler."""
    file = folder / "scheduler.json"
    on_loopback = ["--host", "127.0.0.1", "--no-dashboard", "--scheduler-file", str(file)]
    scheduler = start(folder, "distributed.cli.dask_scheduler", "--port", "0", *on_loopback)
    processes = [scheduler]
    try:
        wait_until(file.exists)
        one = ["--nthreads", "1", "--nworkers", str(workers), *on_loopback]
        one += ["--local-directory", str(folder)]
        processes.append(start(folder, "distributed.cli.dask_worker", *one, **options))
        yield scheduler, str(file)
    finally:
        for process in reversed(processes):
            process.terminate()
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """The file of a scheduler with two workers."""
    with a_cluster(tmp_path_factory.mktemp("cluster")) as (_, file):
        yield file


def wait_until(what, seconds=60.0):
    deadline = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < deadline, "it does not come to that"
        time.sleep(0.02)


def run(*words):
    return main(["sweep", *(str(word) for word in words)])


def finished(journal):
    return journal.read_bytes().count(b'"key"') if journal.exists() else 0


def write(path, text):
    path.write_text(text)
    return path


@contextmanager
def begun(folder, cells_before, *where):
    """`meshfair sweep` of `SLOW` as a process, once it has finished some cells."""
    grid, out = write(folder / "slow.toml", SLOW), folder / "slow.csv"
    words = ["meshfair", "sweep", str(grid), "--out", str(out), *where]
    process = start(folder, *words, start_new_session=True)
    try:
        wait_until(lambda: finished(folder / "slow.jsonl") >= cells_before)
        yield process
    finally:
        process.kill()
        process.wait()


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """The bytes of the table of `SLOW`, from one process."""
    folder = tmp_path_factory.mktemp("undisturbed")
    assert run(write(folder / "slow.toml", SLOW), "--out", folder / "table.csv") == 0
    return (folder / "table.csv").read_bytes()


def test_the_page_gives_the_configuration_of_workers_here():
    flat = {}

    def flatten(prefix, values):
        for name, value in values.items():
            if isinstance(value, dict):
                flatten(f"{prefix}{name}.", value)
            else:
                flat[prefix + name] = value

    flatten("", yaml.safe_load(CONFIGURATION))
    assert flat == cluster_module.CONFIGURATION


def test_the_table_is_the_same_from_everywhere(cluster, tmp_path, monkeypatch):
    # The files are named as they lie from here; no worker's folder is this one.
    monkeypatch.chdir(tmp_path)
    for k in range(3):
        io.write(f"sphere{k}.ply", *shapes.icosphere(k))
    write(tmp_path / "grid.toml", STOPPING)
    assert run("grid.toml", "--out", "here.csv") == 0
    assert run("grid.toml", "--out", "dask.csv", "--scheduler", cluster) == 0
    table = Path("here.csv").read_text()
    assert table.count("\n") == 1 + 4 * 2 * 5
    assert Path("dask.csv").read_text() == table

    from meshfair.experiments.grids import read_grids

    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        rows = sweep(read_grids("grid.toml"), pool, progress=False)
    assert rows.to_csv(index=False, lineterminator="\n") == table


def test_a_mesh_goes_to_each_worker_once(cluster, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    grid = {"experiment": cells.size, "mesh": ["a.ply", "b.ply"], "x": list(range(300))}
    for name in grid["mesh"]:
        io.write(name, *shapes.torus())
    io.write("b.ply", *shapes.icosphere(3))

    def moved(dask_worker):
        # Log entries have the keys that came from another worker, and their bytes.
        entries = [*dask_worker.transfer_incoming_log]
        return [key for entry in entries for key in entry["keys"]]

    with connect(cluster) as workers:
        scattered = []
        scatter = workers.client.scatter

        def counted(data, **options):
            futures = scatter(data, **options)
            scattered.extend(future.key for future in futures)
            return futures

        workers.client.scatter = counted
        table = sweep(grid, workers, progress=False)
        came = [key for keys in workers.client.run(moved).values() for key in keys]
    assert len(table) == 600
    assert len(scattered) == 2
    assert all(came.count(key) <= 1 for key in scattered)  # to one worker by scatter itself


def test_a_changed_file_is_not_taken_for_the_old_one(cluster, tmp_path):
    grid = {"experiment": cells.size, "mesh": str(tmp_path / "mesh.ply"), "x": 0}
    with connect(cluster) as workers:
        for level in (1, 2):
            io.write(grid["mesh"], *shapes.icosphere(level))
            table = sweep(grid, workers, path=tmp_path / "rows.jsonl", progress=False)
            assert table["faces"][0] == 20 * 4**level


def test_a_worker_killed_in_mid_sweep_costs_nothing_but_time(cluster, tmp_path, undisturbed):
    with connect(cluster) as workers:
        pids = [*workers.client.run(os.getpid).values()]
    with begun(tmp_path, 20, "--scheduler", cluster) as process:
        os.kill(pids[0], signal.SIGKILL)
        assert process.wait(60) == 0
    assert (tmp_path / "slow.csv").read_bytes() == undisturbed
    with connect(cluster) as workers:
        workers.client.wait_for_workers(2, timeout=30)
        assert pids[0] not in workers.client.run(os.getpid).values()


def test_a_cell_that_kills_its_workers_is_given_up_after_three(cluster, tmp_path, capsys):
    deaths = tmp_path / "deaths"
    deaths.mkdir()
    text = f'experiment = "cells:deadly"\nx = {{from=0, to=29}}\nbad = 12\nfolder = "{deaths}"\n'
    out = tmp_path / "deadly.csv"
    assert run(write(tmp_path / "g.toml", text), "--out", out, "--scheduler", cluster) == 1
    assert len(list(deaths.iterdir())) == 3
    lines = out.read_text().splitlines()
    message = "WorkerDiedError: its worker died 3 times: crashed, killed, or out of memory"
    assert lines[13].endswith(f'"{message}"')
    others = [line for k, line in enumerate(lines[1:]) if k != 12]
    assert others == [f"{x},12,{deaths},{x / 3!r}," for x in range(30) if x != 12]
    said = capsys.readouterr()
    assert said.out == (
        f"{out}: 30 cells, 30 run now, 0 from the journal, 1 failed, first in row 13 (x 12, "
        f"bad 12, folder {deaths}): {message}\n"
    )
    assert f"a cell failed (x 12, bad 12, folder {deaths})" in said.err


def test_from_the_journal_it_goes_on_when_the_scheduler_was_killed(tmp_path, undisturbed, capsys):
    with a_cluster(tmp_path, workers=1) as (scheduler, file):
        with begun(tmp_path, 20, "--scheduler", file) as process:
            scheduler.kill()
            assert process.wait(60) == 1
        said = (tmp_path / "log.txt").read_text()
    kept = finished(tmp_path / "slow.jsonl")
    assert 20 <= kept < 100
    assert f"has gone; the results of {kept} of 100 cells are in {tmp_path}" in said
    out = tmp_path / "slow.csv"
    assert not out.exists()
    assert run(tmp_path / "slow.toml", "--out", out, "--workers", "2") == 0
    assert f"100 cells, {100 - kept} run now, {kept} from the journal, 0 failed" in (
        capsys.readouterr().out
    )
    assert out.read_bytes() == undisturbed


@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGKILL], ids=["Ctrl-C", "killed"])
def test_from_the_journal_it_goes_on_when_it_was_ended_itself(
    cluster, tmp_path, end, undisturbed, capsys
):
    where = ["--workers", "1"] if end == signal.SIGINT else ["--scheduler", cluster]
    with begun(tmp_path, 20, *where) as process:
        os.killpg(process.pid, end)  # as a terminal does: its workers, too
        assert process.wait(60) == (130 if end == signal.SIGINT else -end)
    said = (tmp_path / "log.txt").read_text()
    assert "Traceback" not in said
    kept = finished(tmp_path / "slow.jsonl")
    if end == signal.SIGINT:
        assert f"stopped; the results of {kept} of 100 cells are in {tmp_path}" in said
    assert run(tmp_path / "slow.toml", "--out", tmp_path / "slow.csv") == 0
    assert f"{100 - kept} run now, {kept} from the journal" in capsys.readouterr().out
    assert (tmp_path / "slow.csv").read_bytes() == undisturbed


def test_workers_of_another_version_are_refused(tmp_path, capsys):
    other = tmp_path / "lib"
    shutil.copytree(LIB / "meshfair", other / "meshfair")
    with open(other / "meshfair" / "checks.py", "a") as file:
        file.write("# Another line.\n")
    with a_cluster(tmp_path, workers=1, lib=other) as (_, file):
        grid, out = write(tmp_path / "slow.toml", SLOW), tmp_path / "slow.csv"
        assert run(grid, "--out", out, "--scheduler", file) == 1
        said = capsys.readouterr().err
        assert f"has meshfair {meshfair.__version__} (" in said
        assert f"but this is {version()}; install the same there" in said
        # One that came after the start is found out when it gets a batch.
        with connect_unchecked(file) as workers, pytest.raises(SweepStoppedError) as stop:
            sweep({"experiment": cells.slow, "x": 1}, workers, progress=False)
        assert f"but this is {version()}" in str(stop.value)


@contextmanager
def connect_unchecked(file):
    from distributed import Client

    from meshfair.experiments.cluster import Cluster

    with Client(scheduler_file=file, set_as_default=False) as client:
        yield Cluster(client)


def test_a_class_gets_the_same_marks_as_on_one_machine(cluster, tmp_path, capsys):
    submissions = tmp_path / "submissions"
    expected = build(submissions, len(HOSTILE) + 1)
    for name in [*HOSTILE][len(HOSTILE) // 2 :]:  # half of them, for the time that it takes
        shutil.rmtree(submissions / name)
        del expected[name]
    (submissions / "empty").mkdir()
    limits = ["--assignment", "a2", "--seed", "7", "--seconds", "2", "--without-walls"]
    tables = []
    for name, where in (("here", []), ("cluster", ["--scheduler", cluster])):
        out = tmp_path / f"{name}.csv"
        assert main(["grade", str(submissions), "--out", str(out), *limits, *where]) == 0
        tables.append(out.read_text())
    assert tables[1] == tables[0]
    rows = list(csv.DictReader(io_module.StringIO(tables[1])))
    points = {row["student"]: float(row["points"]) for row in rows}
    assert points == {name: of for name, (of, _) in expected.items()} | {"empty": 0.0}
    assert "of 2 workers have walls" in capsys.readouterr().err
    feedback = [tmp_path / f"{name}_feedback" / "good_000.md" for name in ("here", "cluster")]
    assert feedback[0].read_text() == feedback[1].read_text()
    # Those who have their mark are not marked again, and need no cluster to be looked at.
    assert main(["grade", str(submissions), "--out", str(out), *limits]) == 0
    assert out.read_text() == tables[1]


def test_workers_without_walls_are_named_before_anybody_is_marked(tmp_path, capsys):
    submissions = tmp_path / "submissions"
    build(submissions, len(HOSTILE))
    words = ["grade", str(submissions), "--assignment", "a2", "--out", str(tmp_path / "m.csv")]
    with a_cluster(tmp_path, workers=1, lib=LIB, path="/nowhere") as (_, file):
        assert main([*words, "--scheduler", file]) == 1
    error = capsys.readouterr().err
    assert "submissions would run without walls on 1 workers: worker tcp://127.0.0.1:" in error
    assert "bubblewrap is not installed" in error
    assert not (tmp_path / "m_feedback").exists()


def test_no_scheduler_and_no_worker(tmp_path, capsys):
    grid, out = write(tmp_path / "slow.toml", SLOW), tmp_path / "slow.csv"
    for address, said in {
        str(tmp_path / "no.json"): "there is no scheduler file",
        "nothing://here": "no scheduler answers at nothing://here",
        "tls://127.0.0.1:1": "names no certificate and key for TLS",
    }.items():
        assert run(grid, "--out", out, "--scheduler", address) == 1
        assert said in capsys.readouterr().err
    with a_cluster(tmp_path, workers=0) as (_, file):
        assert run(grid, "--out", out, "--scheduler", file, "--wait", "0.5") == 1
        error = capsys.readouterr().err
        assert "no worker has come to the scheduler at tcp://127.0.0.1:" in error
        assert "for 0.5 seconds; start one with dask worker tcp://127.0.0.1:" in error


def test_a_worker_uses_one_core(cluster):
    with connect(cluster) as workers:
        sweep({"experiment": cells.slow, "x": [1, 2, 3, 4]}, workers, progress=False)
        assert all(workers.client.run(_fast.one_core).values())
    assert not _fast.one_core()


def test_first_cells_that_all_fail_alike_stop_the_run(tmp_path, capsys):
    text = 'experiment = "stopping"\nmesh = "knot"\nnoise = "normals"\nweights = "cotangent"\n'
    grid = write(tmp_path / "grid.toml", text + "seed = { from = 0, to = 29 }\n")
    out = tmp_path / "table.csv"
    assert run(grid, "--out", out) == 1
    error = capsys.readouterr().err
    assert "given up, since all of the first 10 cells failed, and failed alike; no cell" in error
    assert error.count("give the noise either a size or its decibels") == 1
    assert not out.exists()
    assert run(grid, "--out", out, "--keep-going", "--json") == 1
    facts = json.loads(capsys.readouterr().out)
    assert facts["failed"] == facts["cells"] == 30
    assert facts["first_failure"]["row"] == 1


def test_one_bad_value_does_not_stop_the_run(tmp_path):
    text = 'experiment = "stopping"\nmesh = "knot"\nnoise = "uniform"\nweights = "cotangent"\n'
    text += "decibels = [-20000.0, 20.0]\nseed = { from = 0, to = 14 }\ntime = 0.2\n"
    out = tmp_path / "table.csv"
    assert run(write(tmp_path / "grid.toml", text), "--out", out) == 1
    with out.open(newline="") as file:
        rows = list(csv.DictReader(file))
    # Nothing has -20000 decibels: the 15 cells of that size fail, and the others do not.
    assert [bool(row["error"]) for row in rows] == 15 * [True] + 15 * [False]
    assert not any(row["gain"] for row in rows[:15])
    assert all(row["gain"] for row in rows[15:])
