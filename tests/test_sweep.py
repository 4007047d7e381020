import json
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import pandas as pd
import pytest

from meshfair.experiments import stopping, sweep

GRID = {
    "experiment": stopping,
    "mesh": "knot",
    "noise": ["uniform", "normals"],
    "weights": ["combinatorial", "cotangent"],
    "seed": [0, 1],
    "decibels": 20.0,
    "time": 1.0,
}


@pytest.fixture(scope="module")
def table():
    return sweep(GRID, progress=False)


def test_rows_come_in_the_order_of_the_grid(table):
    assert list(table["noise"]) == ["uniform"] * 4 + ["normals"] * 4
    assert list(table["seed"]) == [0, 1] * 4
    assert "error" not in table
    assert (table["snr"] >= table["noisy_snr"]).all()


@pytest.mark.parametrize(
    "executor",
    [
        lambda: ThreadPoolExecutor(2),
        lambda: ProcessPoolExecutor(2, mp_context=get_context("spawn")),
    ],
    ids=["threads", "processes"],
)
def test_any_executor_gives_the_same_table(table, executor, tmp_path):
    with executor() as pool:
        other = sweep(GRID, pool, path=tmp_path / "rows.jsonl", progress=False)
    pd.testing.assert_frame_equal(other, table)


def test_finished_rows_are_not_run_again(table, tmp_path):
    path = tmp_path / "rows.jsonl"
    sweep({**GRID, "seed": [0]}, path=path, progress=False)
    kept = path.read_bytes()
    pd.testing.assert_frame_equal(sweep(GRID, path=path, progress=False), table)
    assert path.read_bytes().startswith(kept)
    rows = [json.loads(line) for line in path.read_text().split("\n") if line]
    assert len(rows) == len({row["key"] for row in rows}) == 8


def test_a_line_cut_short_costs_that_row_alone(table, tmp_path):
    path = tmp_path / "rows.jsonl"
    sweep(GRID, path=path, progress=False)
    whole = path.read_bytes()
    for cut in (1, 10, 40):
        path.write_bytes(whole[:-cut])
        pd.testing.assert_frame_equal(sweep(GRID, path=path, progress=False), table)


def test_another_mesh_under_the_same_name_is_run_anew(tmp_path):
    from meshfair import io, shapes
    from meshfair.experiments import load_mesh

    mesh, journal = tmp_path / "mesh.ply", tmp_path / "rows.jsonl"
    grid = {**GRID, "mesh": str(mesh), "seed": 0}
    results = []
    for subdivisions in (1, 2):
        io.write(mesh, *shapes.icosphere(subdivisions))
        load_mesh.cache_clear()
        results.append(sweep(grid, path=journal, progress=False))
    assert not results[0]["snr"].equals(results[1]["snr"])


def test_a_failed_cell_is_a_row_and_the_others_go_on(tmp_path):
    path = tmp_path / "rows.jsonl"
    grid = {**GRID, "weights": ["combinatorial", "no such"], "mesh": ["knot", "nor this"]}
    table = sweep(grid, path=path, progress=False)
    failed = table[table["error"].notna()]
    assert len(table) == 16
    assert len(failed) == 12
    known = failed[failed["mesh"] == "knot"]["error"]
    assert known.str.contains("weights is 'no such'; give one of").all()
    assert failed[failed["mesh"] == "nor this"]["error"].str.contains("no mesh is called").all()
    again = sweep(grid, path=path, progress=False)
    pd.testing.assert_frame_equal(again, table)


@pytest.mark.parametrize(
    ("grid", "message"),
    [
        ({"seed": [1]}, "needs a function under 'experiment'"),
        ({**GRID, "seed": [], "noise": []}, "these axes are empty: noise, seed"),
    ],
)
def test_bad_grids(grid, message):
    with pytest.raises(ValueError, match=message):
        sweep(grid)


def test_killed_and_started_again_it_gives_the_undisturbed_table(tmp_path):
    journal = tmp_path / "rows.jsonl"
    grid = {**GRID, "seed": list(range(30)), "time": 4.0}
    code = (
        "from meshfair.experiments import stopping, sweep\n"
        f"sweep({ {k: v for k, v in grid.items() if k != 'experiment'}!r} | "
        f"{{'experiment': stopping}}, path={str(journal)!r}, progress=False)"
    )
    for rows_before_the_kill in (5, 20, 40):
        child = subprocess.Popen([sys.executable, "-c", code])
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline and child.poll() is None:
            if journal.exists() and journal.read_bytes().count(b'"key"') >= rows_before_the_kill:
                break
            time.sleep(0.002)
        os.kill(child.pid, signal.SIGKILL) if child.poll() is None else None
        child.wait()
        assert child.returncode == -signal.SIGKILL
    kept = sum(b'"key"' in line for line in journal.read_bytes().split(b"\n"))
    assert 40 <= kept < 120
    resumed = sweep(grid, path=journal, progress=False)
    pd.testing.assert_frame_equal(resumed, sweep(grid, progress=False))
