"""A cold start: a new process in which nothing has been compiled or loaded before."""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import measuring

README = Path(__file__).resolve().parents[2] / "README.md"
PROMISED = 0.3  # seconds, README's first example


def table(rounds):
    """Measure processes in turns; print and return the rows."""
    example = re.search(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.S)[1]
    scripts = {
        "Python": "",
        "NumPy and SciPy imported": "import numpy, scipy.sparse",
        "README's first example": example,
    }
    seconds = {name: [] for name in scripts}
    for _ in range(rounds):
        for name, script in scripts.items():
            with tempfile.TemporaryDirectory() as empty:
                environment = os.environ | {"NUMBA_CACHE_DIR": empty}
                command = [sys.executable, "-c", script]
                seconds[name].append(
                    measuring.timed(
                        lambda c=command, e=environment: subprocess.run(
                            c, env=e, check=True, stdout=subprocess.DEVNULL
                        )
                    )[0]
                )
    rows = [
        {"process": name, "rounds": rounds, "seconds": measuring.median(times)}
        for name, times in seconds.items()
    ]
    print("a new process, seconds")
    for row in rows:
        print(f"  {row['process']:26s} {row['seconds']:8.3f} s")
    kept = "kept" if rows[-1]["seconds"] <= PROMISED else "NOT KEPT"
    print(f"  README's first example: wanted {PROMISED}: {kept}")
    return rows
