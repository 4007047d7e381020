"""Comparisons that say what was expected, what was got, and what may be the reason.

A student's answer arrives here as plain arrays (see ``answers``), so that
nothing in it can take part in its own comparison.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array, issparse

from meshfair_grading.answers import Other

RTOL = 1e-6
# Relative to the largest expected entry: rounding in entries that should be zero.
ATOL = 1e-9
# float32 rounds to 6e-8. What is left of that after the longest formula here, with its differences
# and quotients on meshes away from the origin; relative to the entry, and to the largest one.
SINGLE_RTOL, SINGLE_ATOL = 1e-3, 1e-5
# Right to so much of the largest entry: worth a part of the points where a check says so.
NEARLY = 1e-4
Floats = NDArray[np.float64]
# A hint, and the values that come out of the mistake that it is about; or, where many values can
# come out of it, whether those that were returned are among them.
Values = Any | Callable[[], Any]
Mistakes = Sequence[tuple[str, Values]]
COMMON_FACTORS = (-1, 2, 0.5, -2, -0.5, 3, 1 / 3, 4, 0.25, 6, 1 / 6)


class WrongAnswerError(Exception):
    """A wrong answer: what was expected, what was got, and a hint.

    Parameters
    ----------
    hint : str
    expected, got : str
    share : float
        Of the points that it is still worth.
    explanations : sequence of str, optional
        Hints of all mistakes that explain the values, where the hint is one of
        them or none: it must explain the other cases of the check as well.
    """

    def __init__(
        self,
        hint: str,
        *,
        expected: str = "",
        got: str = "",
        share: float = 0.0,
        explanations: Sequence[str] | None = None,
    ) -> None:
        super().__init__(next(iter(explanations or ()), hint))
        self.hint, self.expected, self.got, self.share = hint, expected, got, share
        self.explanations = explanations


class Recognised:
    """Stands for the values of a mistake of which many values can come.

    Parameters
    ----------
    test : callable
        Gets what was returned, and says whether it is of the kind.
    """

    def __init__(self, test: Callable[[Floats], bool]) -> None:
        self.test = test


def that(condition: Any, hint: str, *, expected: str = "", got: str = "") -> None:
    """Raise `WrongAnswerError` unless a condition holds."""
    if not condition:
        raise WrongAnswerError(hint, expected=expected, got=got)


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


def array(
    value: Any, name: str, shape: tuple[int, ...] | None = None, *, finite: bool = True
) -> Floats:
    """A student's value as a real array, dense, or `WrongAnswerError`.

    Parameters
    ----------
    value : object
        Plain data, see `meshfair_grading.answers.plain`.
    name : str
        What the messages call it.
    shape : tuple of int, optional
        The shape that it must have.
    finite : bool
        Whether all entries must be finite.

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
    if finite and not np.isfinite(value).all():
        raise _not_finite(value, name)
    return value


def _not_finite(value: Floats, name: str) -> WrongAnswerError:
    bad = value[~np.isfinite(value)]
    hint = (
        "nan comes from 0 / 0, or from a root, logarithm or arccos of a number outside its range."
        if np.isnan(bad).all()
        else "inf comes from a division by zero, or from numbers that grow without end."
    )
    return WrongAnswerError(
        f"{name} has entries that are not finite. {hint}",
        expected="finite numbers",
        got=f"{bad[0]} in {bad.size} of {value.size} entries",
    )


def number(value: Any, name: str) -> float:
    """A student's value as a float, or `WrongAnswerError`."""
    return float(array(_scalar(value), name, ()))


def matrix(value: Any, name: str, n: int, *, finite: bool = True) -> csr_array:
    """A student's sparse (n, n) matrix, or `WrongAnswerError`.

    Parameters
    ----------
    value : object
    name : str
    n : int
    finite : bool
        Whether all entries must be finite; `close` says better why they are not.

    Returns
    -------
    csr_array of float64
    """
    if isinstance(value, np.ndarray) and value.size == n and n in value.shape:
        raise WrongAnswerError(
            f"{name} is a vector; a sparse matrix with these numbers on its diagonal is "
            "diags_array(vector).",
            expected=f"a scipy.sparse matrix of shape {(n, n)}",
            got=f"an ndarray of shape {value.shape}",
        )
    if isinstance(value, np.ndarray) and value.shape == (n, n):
        raise WrongAnswerError(
            f"{name} is a dense array. Build it sparse: with 100,000 vertices this one "
            "would take 80 gigabytes.",
            expected="a scipy.sparse matrix",
            got=f"an ndarray of shape {value.shape}",
        )
    array(value, name, (n, n), finite=finite)
    return csr_array(value)


def close(
    got: Any,
    expected: Any,
    name: str,
    *,
    mistakes: Mistakes = (),
    rtol: float = RTOL,
    nearly: float = 0.0,
) -> None:
    """Compare a student's values with the right ones.

    Values that were computed in float32 are right within its precision.

    Parameters
    ----------
    got : object
        Plain data from the student.
    expected : array_like or sparse array
        The right values.
    name : str
        What the messages call it.
    mistakes : sequence of (str, array_like, callable or Recognised)
        Hints, and what comes out of the mistake that each is about; a
        callable is called only when needed.
    rtol : float
        Relative tolerance of each entry.
    nearly : float
        Share of the points for values that are right to four digits.

    Raises
    ------
    WrongAnswerError
        With the hint of the mistake that explains the values, if any does.
    """
    expected = expected.toarray() if issparse(expected) else np.asarray(expected, dtype=float)
    got = _scalar(got) if expected.ndim == 0 else got
    got = array(got, name, expected.shape, finite=False)
    tolerance = _Tolerance(rtol, single(got))
    if alike(got, expected, tolerance):
        return
    explanations = [hint for hint, values in mistakes if _explains(values, got, tolerance)]
    _explain(got, expected, name, explanations, tolerance, nearly)


def _explain(
    got: Floats,
    expected: Floats,
    name: str,
    explanations: list[str],
    tolerance: "_Tolerance",
    nearly: float = 0.0,
) -> NoReturn:
    """Raise for wrong values, with the mistakes that explain them."""
    if not np.isfinite(got).all():
        wrong = _not_finite(got, name)
        raise WrongAnswerError(
            wrong.hint, expected=wrong.expected, got=wrong.got, explanations=explanations or None
        )
    explanations = explanations + [
        hint for hint, values in _general(got, expected, name) if alike(got, values, tolerance)
    ]
    error = np.abs(got - expected)
    worst = np.unravel_index(np.argmax(error), expected.shape)
    where = f"{name}[{', '.join(map(str, worst))}]" if worst else name
    off = ~np.isclose(got, expected, rtol=tolerance.relative, atol=ATOL * _size(expected))
    many = f" ({np.count_nonzero(off)} of {off.size} entries differ)" if worst else ""
    right, wrong_one = differing(float(expected[worst]), float(got[worst]))
    plain = f"The values of {name} are wrong."
    accuracy = float(error[worst]) / (_size(expected) or 1.0)
    if accuracy < NEARLY:
        plain = (
            f"{name} is right to about {-np.log10(accuracy):.0f} digits, and no more: was it "
            "rounded, was a small number added, or does an iteration stop too early (see its "
            "tolerance)?"
        )
    raise WrongAnswerError(
        plain,
        expected=f"{where} = {right}",
        got=f"{wrong_one}{many}",
        share=nearly if accuracy < NEARLY and not explanations else 0.0,
        explanations=explanations,
    )


def _scalar(value: Any) -> Any:
    return value.reshape(()) if isinstance(value, np.ndarray) and value.size == 1 else value


def proportional(got: Any, expected: Any, name: str, *, mistakes: Mistakes = ()) -> None:
    """Compare a student's values with the right ones, up to a common positive factor.

    Parameters and errors are those of `close`; the values of ``mistakes`` are
    compared up to a factor too.
    """
    expected = expected.toarray() if issparse(expected) else np.asarray(expected, dtype=float)
    got = array(got, name, expected.shape, finite=False)
    tolerance, scale = _Tolerance(RTOL, single(got)), np.abs(expected).sum()
    scaled = _scaled(got, scale)
    if alike(scaled, expected, tolerance):
        return
    explanations = [
        hint
        for hint, values in mistakes
        if _explains(values, got, tolerance, lambda values: _scaled(values, scale))
    ]
    _explain(scaled, expected, f"{name} (scaled to the right size)", explanations, tolerance)


def _scaled(values: Floats, scale: float) -> Floats:
    return values * (scale / (np.abs(values[np.isfinite(values)]).sum() or 1.0))


@dataclass(frozen=True)
class _Tolerance:
    """How far values may be off."""

    relative: float = RTOL
    single: bool = False
    """Whether they were computed in float32."""


def alike(got: ArrayLike, expected: ArrayLike, tolerance: _Tolerance | None = None) -> bool:
    """Whether two arrays have one shape and agree up to rounding."""
    got, expected = np.asarray(got, dtype=float), np.asarray(expected, dtype=float)
    if got.shape != expected.shape:
        return False
    tolerance = tolerance or _Tolerance(single=single(got))
    rtol, atol = tolerance.relative, ATOL
    if tolerance.single:
        rtol, atol = max(rtol, SINGLE_RTOL), SINGLE_ATOL
    return np.allclose(got, expected, rtol, atol * _size(expected), equal_nan=True)


def single(values: Any) -> bool:
    """Whether an answer was computed in single precision: float32 holds every entry of it."""
    values = values.data if issparse(values) else np.asarray(values, dtype=float)
    with np.errstate(over="ignore"):
        return bool(np.array_equal(values.astype(np.float32), values, equal_nan=True))


def rounding(values: Any) -> float:
    """What is rounded away from an answer, relative to its entries."""
    return float(np.finfo(np.float32 if single(values) else np.float64).eps)


def _size(expected: Floats) -> float:
    return float(np.abs(expected[np.isfinite(expected)]).max(initial=0))


def _explains(
    values: Values,
    got: Floats,
    tolerance: _Tolerance,
    scaled: Callable[[Floats], Floats] = np.asarray,
) -> bool:
    """Whether the values of a mistake are those that were returned."""
    if isinstance(values, Recognised):
        return bool(values.test(got))
    with np.errstate(all="ignore"):
        values = values() if callable(values) else values
        values = values.toarray() if issparse(values) else np.asarray(values, dtype=float)
        return alike(scaled(got), scaled(values), tolerance)


def _general(got: Floats, expected: Floats, name: str) -> Iterator[tuple[str, Any]]:
    """Mistakes that any values can have."""
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
        if any(right) and not np.allclose(got, expected, rtol=0, atol=NEARLY * _size(expected)):
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
