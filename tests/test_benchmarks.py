import csv
import re
import subprocess
import sys
from pathlib import Path

from meshfair import denoising

BENCH = Path(__file__).parent / "benchmarks" / "bench.py"


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def quick(folder, *options):
    return subprocess.run(
        [sys.executable, str(BENCH), "--quick", "--results", str(folder), *options],
        capture_output=True,
        text=True,
    )


def test_a_quick_benchmark_agrees_and_writes_its_tables(tmp_path):
    done = quick(tmp_path)
    assert done.returncode == 0, done.stderr
    measured = rows(tmp_path / "bench.csv")
    steps = {"step", "steps", "step in order", "steps in order"}
    assert {row["task"] for row in measured} == {"weights", *steps, "implicit", "flow"}
    assert all((float(row["times_copy"]) > 0) == (row["task"] in steps) for row in measured)
    assert {"ours", "SciPy product", "libigl"} <= {row["contender"] for row in measured}
    for row in measured:
        assert row["agrees"] in ("True", "not the same"), row
        assert float(row["seconds"]) > 0
        assert row["rounds"] == "1"
    filters = rows(tmp_path / "filters.csv")
    assert [row["method"] for row in filters] == [*denoising.methods(), "auto"]
    assert all(float(row["plain_seconds"]) > 0 for row in filters)
    assert all(float(row["peak_bytes"]) >= 0 for row in filters)
    learned = rows(tmp_path / "learned.csv")
    assert [row["faces"] for row in learned] == ["1200", "4800"]
    assert all(float(row["face_us"]) > 0 for row in learned)
    assert len(rows(tmp_path / "starting.csv")) == 3
    files = rows(tmp_path / "files.csv")
    assert [row["format"] for row in files] == [
        "OBJ",
        "OFF",
        "PLY",
        "PLY, text",
        "STL",
        "STL, text",
    ]
    assert all(float(row["write_like"]) > 0 for row in files)
    assert [row["vertices"] for row in rows(tmp_path / "scaling.csv")] == ["600", "2400"]
    (sweep,) = rows(tmp_path / "sweeping.csv")
    assert (sweep["where"], sweep["cells"], sweep["workers"]) == ("cluster", "200", "2")
    assert float(sweep["written"]) > 0
    assert {"processor", "cores", "numba"} <= {
        row["what"] for row in rows(tmp_path / "machine.csv")
    }

    # One task alone: its rows are new, all others stay, on this machine only.
    done = quick(tmp_path, "--task", "flow")
    assert done.returncode == 0, done.stderr
    again = rows(tmp_path / "bench.csv")
    assert [(row["task"], row["contender"]) for row in again] == [
        (row["task"], row["contender"]) for row in measured
    ]
    assert {row["task"] for row, old in zip(again, measured, strict=True) if row != old} == {"flow"}
    machine = tmp_path / "machine.csv"
    machine.write_text(re.sub(r"(?m)^numba,.*", "numba,0.1", machine.read_text()))
    done = quick(tmp_path, "--task", "flow")
    assert done.returncode != 0
    assert "numba 0.1, and here" in done.stderr
    assert rows(tmp_path / "bench.csv") == again
