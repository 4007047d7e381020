"""Clocks, memory, and the machine: how a figure is taken."""

import csv
import ctypes
import importlib.metadata
import os
import platform
import statistics
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

STATUS, CLEAR = Path("/proc/self/status"), Path("/proc/self/clear_refs")


def timed(run):
    """Run once; return the seconds it took and what it returned."""
    start = time.perf_counter()
    result = run()
    return time.perf_counter() - start, result


def peak_memory(run):
    """Run once; return the most bytes held at any time, beyond those before, and what it returned.

    NaN where the system does not tell (all but Linux).
    """
    try:
        ctypes.CDLL(None).malloc_trim(0)  # what was freed before is given back to the system
        CLEAR.write_text("5")  # and the peak starts anew
        before = _status("VmRSS")
    except (OSError, AttributeError):
        return float("nan"), run()
    result = run()
    return _status("VmHWM") - before, result


def _status(field):
    line = next(line for line in STATUS.read_text().splitlines() if line.startswith(field))
    return 1024 * int(line.split()[1])


def copy_bandwidth(size=2**25, repeats=3):
    """Bytes a second that are read and written when all cores copy a large array (median)."""
    source, target = np.ones(size), np.ones(size)
    cores = os.cpu_count()
    parts = [slice(k * size // cores, (k + 1) * size // cores) for k in range(cores)]

    def copy(part):
        target[part] = source[part]

    with ThreadPoolExecutor(cores) as pool:
        seconds = [timed(lambda: list(pool.map(copy, parts)))[0] for _ in range(repeats)]
    return 2 * source.nbytes / median(seconds)


def write(path, rows):
    """Write rows with the same names as CSV, figures with six digits."""
    with open(path, "w", newline="") as file:
        table = csv.DictWriter(file, rows[0], lineterminator="\n")
        table.writeheader()
        for row in rows:
            table.writerow(
                {key: f"{x:.6g}" if isinstance(x, float) else x for key, x in row.items()}
            )


def read(path):
    """The rows of a CSV file, all text; none where there is no file."""
    if not path.exists():
        return []
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def machine():
    """What was measured on, as rows of name and value."""
    yield "processor", _processor()
    yield "cores", str(len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else "")
    yield "system", f"{platform.system()} {platform.machine()}"
    yield "python", platform.python_version()
    for package in ("numpy", "scipy", "numba"):
        yield package, importlib.metadata.version(package)


def _processor():
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor()


median = statistics.median
