import csv
import subprocess
import sys
from pathlib import Path

from meshfair import denoising

BENCH = Path(__file__).parent / "benchmarks" / "bench.py"


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def test_a_quick_benchmark_agrees_and_writes_its_tables(tmp_path):
    done = subprocess.run(
        [sys.executable, str(BENCH), "--quick", "--results", str(tmp_path)],
        capture_output=True,
        text=True,
    )
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
    methods = [row["method"] for row in rows(tmp_path / "filters.csv")]
    assert methods == denoising.methods()
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
