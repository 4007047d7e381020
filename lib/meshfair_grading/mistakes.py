"""Known mistakes, by the values that come out of them."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from scipy.sparse import issparse

from meshfair_grading.rounding import NEARLY, Floats, Tolerance, alike, size

# A hint, and the values that come out of the mistake that it is about; or, where many values can
# come out of it, whether those that were returned are among them.
Values = Any | Callable[[], Any]
Mistakes = Sequence[tuple[str, Values]]
COMMON_FACTORS = (-1, 2, 0.5, -2, -0.5, 3, 1 / 3, 4, 0.25, 6, 1 / 6)


class Recognised:
    """Stands for the values of a mistake of which many values can come.

    Parameters
    ----------
    test : callable
        Gets what was returned, and says whether it is of the kind.
    """

    def __init__(self, test: Callable[[Floats], bool]) -> None:
        self.test = test


def explains(
    values: Values,
    got: Floats,
    tolerance: Tolerance,
    scaled: Callable[[Floats], Floats] = np.asarray,
) -> bool:
    """Whether the values of a mistake are those that were returned.

    Parameters
    ----------
    values : array_like, sparse array, callable or Recognised
    got : ndarray
    tolerance : Tolerance
    scaled : callable, optional
        Brings both to one size before they are compared.

    Returns
    -------
    bool
    """
    if isinstance(values, Recognised):
        return bool(values.test(got))
    with np.errstate(all="ignore"):
        values = values() if callable(values) else values
        values = values.toarray() if issparse(values) else np.asarray(values, dtype=float)
        return alike(scaled(got), scaled(values), tolerance)


def general(got: Floats, expected: Floats, name: str) -> Iterator[tuple[str, Any]]:
    """Mistakes that any values can have.

    Parameters
    ----------
    got, expected : ndarray
    name : str
        What the hints call them.

    Yields
    ------
    hint : str
    values : ndarray
        What the mistake gives.
    """
    name = name.partition(" (")[0]  # without what differs from case to case
    for factor in COMMON_FACTORS:
        hint = f"Your {name} is {factor:.3g} times the right one."
        yield (f"The sign of {name} is wrong." if factor == -1 else hint), factor * expected
    yield f"All of {name} is zero.", np.zeros_like(expected)
    if expected.ndim == 2 and expected.shape[0] == expected.shape[1]:
        yield f"This is the transpose of {name}.", expected.T
    if expected.size > 3:
        factor = float((got * expected).sum() / ((expected**2).sum() or 1.0))
        yield f"Your {name} is {factor:.4g} times the right one.", factor * expected
    if expected.ndim == 2 and expected.shape[1] == 3:
        shift = (got - expected).mean(axis=0)
        shown = ", ".join(f"{x:.3g}" for x in shift)
        yield f"{name} is right up to a shift: all rows are off by ({shown}).", expected + shift
        right = [alike(got[:, axis], expected[:, axis]) for axis in range(3)]
        if any(right) and not np.allclose(got, expected, rtol=0, atol=NEARLY * size(expected)):
            one = " and ".join(
                name for name, is_right in zip("xyz", right, strict=True) if is_right
            )
            yield f"Of {name}, {one} is right: do the same with all coordinates.", got
    there = expected != 0
    functions = {"absolute values": np.abs, "squares": np.square, "reciprocals": np.reciprocal,
                 "square roots": np.sqrt}  # fmt: skip
    for kind, function in functions.items():
        values = expected.copy()
        with np.errstate(all="ignore"):
            values[there] = function(expected[there])
        yield f"These are the {kind} of the right numbers.", values
    for digits in range(6):
        hint = f"{name} is rounded to {digits} decimals: return what was computed."
        yield hint, expected.round(digits)
