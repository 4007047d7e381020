"""Experiments for tests of sweeps: cells that are slow, and cells that kill."""

import os
import signal
import time
from pathlib import Path

from meshfair.experiments import load_mesh


def slow(x: int, seconds: float = 0.02) -> dict[str, float]:
    """Take some time."""
    time.sleep(seconds)
    return {"third": x / 3}


def deadly(x: int, bad: int, folder: str) -> dict[str, float]:
    """Kill the process at one value, and note in the folder that it came to that."""
    if x == bad:
        (Path(folder) / str(os.getpid())).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return {"third": x / 3}


def size(mesh: str, x: int) -> dict[str, float]:
    """Look at a mesh."""
    V, F = load_mesh(mesh)
    return {"volume": float(V.sum()) + x, "faces": len(F)}
