import json
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import numpy as np
import pandas as pd
import pytest

import cells
import meshfair
from meshfair import io, shapes
from meshfair.experiments import meshes, noisy_pair, stopping, sweep
from meshfair.experiments.cells import cells as make_cells
from meshfair.experiments.dispatch import SweepStoppedError
from meshfair.experiments.quality import score
from meshfair.experiments.sweep import _in_order

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
    mesh, journal = tmp_path / "mesh.ply", tmp_path / "rows.jsonl"
    grid = {**GRID, "mesh": str(mesh), "seed": 0}
    results = []
    for subdivisions in (1, 2):
        io.write(mesh, *shapes.icosphere(subdivisions))
        results.append(sweep(grid, path=journal, progress=False))
    assert not results[0]["snr"].equals(results[1]["snr"])


def test_a_failed_cell_is_a_row_and_the_others_go_on(tmp_path):
    path = tmp_path / "rows.jsonl"
    grid = {**GRID, "weights": ["combinatorial", "no such"], "mesh": ["knot", "nor this"]}
    said = r"failed \(mesh knot, .* no such.*so did 12 of 16 cells; see the table's column error"
    with pytest.warns(RuntimeWarning, match=said):
        table = sweep(grid, path=path, progress=False)
    failed = table[table["error"].notna()]
    assert len(table) == 16
    assert len(failed) == 12
    known = failed[failed["mesh"] == "knot"]["error"]
    assert known.str.contains("weights is 'no such'; give one of").all()
    assert failed[failed["mesh"] == "nor this"]["error"].str.contains("no mesh is called").all()
    with pytest.warns(RuntimeWarning, match=said):
        again = sweep(grid, path=path, progress=False)
    pd.testing.assert_frame_equal(again, table)


@pytest.mark.parametrize(
    ("grid", "message"),
    [
        ({"seed": [1]}, "needs a function under 'experiment'"),
        ({**GRID, "seed": [], "noise": []}, "these axes are empty: noise, seed"),
        ([GRID, {**GRID, "seed": []}], "these axes are empty: seed"),
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


def test_several_grids_make_one_table(table):
    halves = [{**GRID, "noise": "uniform"}, {**GRID, "noise": "normals"}]
    pd.testing.assert_frame_equal(sweep(halves, progress=False), table)


def test_results_that_are_meshes_are_files_named_by_their_content(tmp_path):
    axes = {"mesh": "torus", "parameters": "default", "size": 0.2, "keep_mesh": True}
    grid = {"experiment": score, "method": ["none", "taubin"], "seed": [1, 1, 2], **axes}
    table = sweep(grid, path=tmp_path / "rows.jsonl", progress=False)
    files = sorted(tmp_path.glob("rows_meshes/*.ply"))
    assert len(files) == table["denoised"].nunique() == 4
    for _, row in table.iterrows():
        V_noisy, _, F = noisy_pair("torus", 0.2, row["seed"])
        expected = meshfair.denoise(V_noisy, F, "taubin").V if row["method"] != "none" else V_noisy
        found, faces = io.read(tmp_path / row["denoised"])
        np.testing.assert_array_equal(found, expected)
        np.testing.assert_array_equal(faces, F)
    with pytest.warns(RuntimeWarning, match="need a journal, to lie beside it"):
        sweep({**grid, "seed": 1, "method": "none"}, progress=False)


def test_an_executor_that_breaks_stops_the_sweep_and_leaves_its_rows(tmp_path):
    journal, deaths = tmp_path / "rows.jsonl", tmp_path / "deaths"
    deaths.mkdir()
    grid = {"experiment": cells.deadly, "x": list(range(9)), "bad": 5, "folder": str(deaths)}
    with (
        ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool,
        pytest.raises(SweepStoppedError, match="start the sweep again with the same journal"),
    ):
        sweep(grid, pool, path=journal, progress=False)
    table = sweep({**grid, "bad": -1}, path=tmp_path / "other.jsonl", progress=False)
    assert list(table["third"]) == [x / 3 for x in range(9)]
    kept = [json.loads(line) for line in journal.read_text().split("\n") if line]
    assert [row["result"]["third"] for row in kept] == [x / 3 for x in range(5)]


def test_a_pair_of_meshes_is_known_by_the_content_of_both():
    grid = {"experiment": score, "mesh": "fandisk"}
    keys = set()
    for k in range(2):
        for other in range(2):
            V, F = shapes.icosphere(1)
            loaded = {"fandisk-clean": (V + k, F), "fandisk-noisy": (V - other, F)}
            with meshes.given(loaded):
                keys.add(make_cells([grid])[0].key)
    assert len(keys) == 4


def test_cells_run_mesh_by_mesh_after_some_from_all_over():
    grid = {"experiment": stopping, "seed": list(range(30)), "mesh": ["knot", "torus"]}
    ordered = _in_order(make_cells([grid]), 4)
    first = [cell.parameters["seed"] for cell in ordered[:4]]
    assert first == [0, 7, 15, 22]
    names = [cell.parameters["mesh"] for cell in ordered[4:]]
    assert names == sorted(names)
    assert sorted(c.key for c in ordered) == sorted(c.key for c in make_cells([grid]))
