"""When two arrays of numbers are the same up to rounding, and how to show that they are not."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import issparse

RTOL = 1e-6
# Relative to the largest expected entry: rounding in entries that should be zero.
ATOL = 1e-9
# float32 rounds to 6e-8. What is left of that after the longest formula here, with its differences
# and quotients on meshes away from the origin; relative to the entry, and to the largest one.
SINGLE_RTOL, SINGLE_ATOL = 1e-3, 1e-5
# Right to so much of the largest entry: worth a part of the points where a check says so.
NEARLY = 1e-4
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Tolerance:
    """How far values may be off."""

    relative: float = RTOL
    single: bool = False
    """Whether they were computed in float32."""


def alike(got: ArrayLike, expected: ArrayLike, tolerance: Tolerance | None = None) -> bool:
    """Whether two arrays have one shape and agree up to rounding."""
    got, expected = np.asarray(got, dtype=float), np.asarray(expected, dtype=float)
    if got.shape != expected.shape:
        return False
    tolerance = tolerance or Tolerance(single=single(got))
    rtol, atol = tolerance.relative, ATOL
    if tolerance.single:
        rtol, atol = max(rtol, SINGLE_RTOL), SINGLE_ATOL
    return np.allclose(got, expected, rtol, atol * size(expected), equal_nan=True)


def single(values: Any) -> bool:
    """Whether an answer was computed in single precision: float32 holds every entry of it."""
    values = values.data if issparse(values) else np.asarray(values, dtype=float)
    with np.errstate(over="ignore"):
        return bool(np.array_equal(values.astype(np.float32), values, equal_nan=True))


def rounding(values: Any) -> float:
    """What is rounded away from an answer, relative to its entries."""
    return float(np.finfo(np.float32 if single(values) else np.float64).eps)


def size(expected: Floats) -> float:
    """The largest finite entry, without its sign."""
    return float(np.abs(expected[np.isfinite(expected)]).max(initial=0))


def differing(expected: float, got: float, digits: int = 6) -> tuple[str, str]:
    """Two different numbers, with digits up to their difference.

    Parameters
    ----------
    expected, got : float
    digits : int
        How many to show where they are enough.

    Returns
    -------
    expected, got : str
    """
    for enough in range(digits, 18):
        shown = f"{expected:.{enough}g}", f"{got:.{enough}g}"
        if float(shown[0]) != float(shown[1]):
            break
    return shown[0].replace("-0", "0") if float(shown[0]) == 0 else shown[0], shown[1]
