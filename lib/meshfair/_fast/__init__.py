"""Compiled loops for large meshes: private, and never the only form of anything.

Each loop computes what a public function says in NumPy, and a test holds the
one to the other (``tests/test_fast_equals_plain.py``). The public function
chooses by the size of the mesh alone:

    if _fast.wanted(len(V)):
        return _fast.flow.average(V, A, iterations, fixed)

so that the same mesh gives the same digits wherever numba is installed. The
loops, and numba with them, are loaded when a large mesh first asks for them.
"""

from functools import cache
from importlib import import_module
from typing import Any

# Rows (vertices or faces) from which on the loops repay the half second that numba and they take
# to load: ten flows of twenty steps on 20,000 vertices save as much, or two runs of guided normal
# filtering or of feature-convinced denoising on 3,000 faces (tests/benchmarks/thresholds.py).
ROWS = 20_000
FILTER_ROWS = 3_000

_MODULES = (
    "cg", "creases", "faces", "filters", "flow", "intrinsic", "kernels", "learned", "multigrid",
    "neighbourhoods", "operators", "ordering", "pattern", "stability", "weights",
)  # fmt: skip


@cache
def available() -> bool:
    """Whether numba, the optional extra ``fast``, can be imported."""
    try:
        import_module("numba")
    except ImportError:
        return False
    return True


def wanted(rows: int, least: int = ROWS) -> bool:
    """Whether a mesh of this many rows is worth the compiled loops, and they are there."""
    return rows >= least and available()


_one_core = False


def use_one_core() -> None:
    """Let loops use one core from now on: other processes like this one use the others."""
    global _one_core
    _one_core = True


def one_core() -> bool:
    """Whether `use_one_core` was called."""
    return _one_core


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return import_module(f"meshfair._fast.{name}")
    raise AttributeError(f"module 'meshfair._fast' has no attribute {name!r}")
