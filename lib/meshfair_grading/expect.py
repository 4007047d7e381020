"""Comparisons that say what was expected, what was got, and what may be the reason.

A student's answer arrives here as plain arrays (see ``answers``), so that
nothing in it can take part in its own comparison.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array, issparse

from meshfair_grading.answers import Other

RTOL = 1e-6
# Relative to the largest expected entry: rounding in entries that should be zero.
ATOL = 1e-9
Floats = NDArray[np.float64]
# A hint, and the values that come out of the mistake that it is about.
Mistakes = Sequence[tuple[str, Any | Callable[[], Any]]]
COMMON_FACTORS = (-1, 2, 0.5, -2, -0.5, 3, 1 / 3, 4, 0.25, 6, 1 / 6)


class WrongAnswerError(Exception):
    """A wrong answer: what was expected, what was got, and a hint."""

    def __init__(self, hint: str, *, expected: str = "", got: str = "") -> None:
        super().__init__(hint)
        self.hint, self.expected, self.got = hint, expected, got


def that(condition: Any, hint: str, *, expected: str = "", got: str = "") -> None:
    """Raise `WrongAnswerError` unless a condition holds."""
    if not condition:
        raise WrongAnswerError(hint, expected=expected, got=got)


def array(value: Any, name: str, shape: tuple[int, ...] | None = None) -> Floats:
    """A student's value as a finite real array, dense, or `WrongAnswerError`.

    Parameters
    ----------
    value : object
        Plain data, see `meshfair_grading.answers.plain`.
    name : str
        What the messages call it.
    shape : tuple of int, optional
        The shape that it must have.

    Returns
    -------
    ndarray of float64
    """
    wanted = "an array" if shape is None else f"shape {shape}" if shape else "a single number"
    if isinstance(value, Other):
        raise WrongAnswerError(
            f"{name} is no array of numbers.", expected=wanted, got=f"{value.type} {value.shown}"
        )
    if isinstance(value, list):
        raise WrongAnswerError(
            f"{name} should be one array, but {len(value)} objects came back: see the `return`.",
            expected=wanted,
            got=f"a list of {len(value)}",
        )
    if not issparse(value):
        value = np.asarray(value)
    if shape is not None and value.shape != shape:
        hint = f"The shape of {name} is wrong."
        if len(shape) > 1 and value.shape == shape[::-1]:
            hint += " It is that of the transpose."
        if len(shape) == 1 and value.shape in ((*shape, 1), (1, *shape)):
            hint += " It has an axis of length 1 too many: see `ravel`."
        raise WrongAnswerError(hint, expected=wanted, got=f"shape {value.shape}")
    if issparse(value):
        # A sparse matrix of any shape takes no memory, a dense one does: only the right shape.
        that(shape is not None, f"{name} is a sparse matrix.", expected=wanted, got="a sparse one")
        value = value.toarray()
    if value.dtype.kind == "c":
        if np.abs(value.imag).max(initial=0) > 0:
            raise WrongAnswerError(
                f"{name} has complex entries: take `.real`.", expected="real numbers"
            )
        value = value.real
    value = value.astype(float)
    if not np.isfinite(value).all():
        bad = value[~np.isfinite(value)][0]
        raise WrongAnswerError(
            f"{name} has entries that are not finite: was something divided by zero?",
            expected="finite numbers",
            got=f"{bad} in {np.count_nonzero(~np.isfinite(value))} of {value.size} entries",
        )
    return value


def number(value: Any, name: str) -> float:
    """A student's value as a float, or `WrongAnswerError`."""
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.reshape(())
    return float(array(value, name, ()))


def matrix(value: Any, name: str, n: int) -> csr_array:
    """A student's sparse (n, n) matrix, or `WrongAnswerError`.

    Returns
    -------
    csr_array of float64
    """
    if isinstance(value, np.ndarray):
        raise WrongAnswerError(
            f"{name} is a dense array. Build it sparse: with 100,000 vertices this one "
            "would take 80 gigabytes.",
            expected="a scipy.sparse matrix",
            got=f"an ndarray of shape {value.shape}",
        )
    array(value, name, (n, n))
    return csr_array(value)


def close(
    got: Any, expected: Any, name: str, *, mistakes: Mistakes = (), rtol: float = RTOL
) -> None:
    """Compare a student's values with the right ones.

    Parameters
    ----------
    got : object
        Plain data from the student.
    expected : array_like or sparse array
        The right values.
    name : str
        What the messages call it.
    mistakes : sequence of (str, array_like or callable)
        Hints, and what comes out of the mistake that each is about; a
        callable is called only when needed.
    rtol : float
        Relative tolerance of each entry.

    Raises
    ------
    WrongAnswerError
        With the hint of the mistake that explains the values, if any does.
    """
    expected = expected.toarray() if issparse(expected) else np.asarray(expected, dtype=float)
    got = number(got, name) if expected.ndim == 0 else array(got, name, expected.shape)
    got = np.asarray(got)
    if alike(got, expected, rtol):
        return
    hint = _explained(got, mistakes, rtol) or _factor(got, expected, name, rtol)
    wrong = ~np.isclose(got, expected, rtol=rtol, atol=ATOL * _size(expected))
    worst = np.unravel_index(np.argmax(np.abs(got - expected)), expected.shape)
    where = f"{name}[{', '.join(map(str, worst))}]" if worst else name
    many = f" ({np.count_nonzero(wrong)} of {wrong.size} entries differ)" if worst else ""
    raise WrongAnswerError(
        hint or f"The values of {name} are wrong.",
        expected=f"{where} = {expected[worst]:.6g}",
        got=f"{got[worst]:.6g}{many}",
    )


def proportional(got: Any, expected: Any, name: str, *, mistakes: Mistakes = ()) -> None:
    """Compare a student's values with the right ones, up to a common positive factor.

    Parameters and errors are those of `close`; the values of ``mistakes`` are
    compared up to a factor too.
    """
    scale = _scale(expected)
    got = array(got, name, expected.shape)
    scaled = [
        (hint, lambda values=values: _scaled(values() if callable(values) else values, scale))
        for hint, values in mistakes
    ]
    close(_scaled(got, scale), expected, f"{name} (scaled to the right size)", mistakes=scaled)


def _scale(values: Any) -> float:
    return float(abs(values).sum())


def _scaled(values: Any, scale: float) -> Any:
    return values * (scale / (_scale(values) or 1.0))


def alike(got: ArrayLike, expected: ArrayLike, rtol: float = RTOL) -> bool:
    """Whether two arrays have one shape and agree within the tolerance."""
    got, expected = np.asarray(got, dtype=float), np.asarray(expected, dtype=float)
    try:
        np.testing.assert_allclose(got, expected, rtol=rtol, atol=ATOL * _size(expected))
    except AssertionError:
        return False
    return got.shape == expected.shape


def _size(expected: Floats) -> float:
    return float(np.abs(expected).max(initial=0))


def _explained(got: Floats, mistakes: Mistakes, rtol: float) -> str:
    """The hint of the first mistake whose values are those that were returned."""
    for hint, values in mistakes:
        values = values() if callable(values) else values
        values = values.toarray() if issparse(values) else values
        if alike(got, values, rtol):
            return hint
    return ""


def _factor(got: Floats, expected: Floats, name: str, rtol: float) -> str:
    """A hint where all values are off by one factor."""
    for factor in COMMON_FACTORS:
        if alike(got, factor * expected, rtol):
            if factor == -1:
                return f"The sign of {name} is wrong."
            return f"Your {name} is {factor:.3g} times the right one."
    return ""
