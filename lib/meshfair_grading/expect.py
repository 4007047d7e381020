"""Comparisons that say what was expected, what was got, and what may be the reason.

A student's answer arrives here as plain arrays (see ``answers``), so that
nothing in it can take part in its own comparison.
"""

from collections.abc import Sequence
from typing import Any, NoReturn

import numpy as np
from scipy.sparse import csr_array, issparse

from meshfair_grading.answers import Other
from meshfair_grading.mistakes import Mistakes, Recognised, explains, general
from meshfair_grading.rounding import (
    ATOL,
    NEARLY,
    RTOL,
    Floats,
    Tolerance,
    alike,
    differing,
    rounding,
    single,
    size,
)

__all__ = [
    "Recognised", "WrongAnswerError", "alike", "array", "close", "differing", "matrix", "number",
    "proportional", "rounding", "single", "that",
]  # fmt: skip


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


def that(condition: Any, hint: str, *, expected: str = "", got: str = "") -> None:
    """Raise `WrongAnswerError` unless a condition holds."""
    if not condition:
        raise WrongAnswerError(hint, expected=expected, got=got)


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
    tolerance = Tolerance(rtol, single(got))
    if alike(got, expected, tolerance):
        return
    explanations = [hint for hint, values in mistakes if explains(values, got, tolerance)]
    _explain(got, expected, name, explanations, tolerance, nearly)


def _explain(
    got: Floats,
    expected: Floats,
    name: str,
    explanations: list[str],
    tolerance: Tolerance,
    nearly: float = 0.0,
) -> NoReturn:
    """Raise for wrong values, with the mistakes that explain them."""
    if not np.isfinite(got).all():
        wrong = _not_finite(got, name)
        raise WrongAnswerError(
            wrong.hint, expected=wrong.expected, got=wrong.got, explanations=explanations or None
        )
    explanations = explanations + [
        hint for hint, values in general(got, expected, name) if alike(got, values, tolerance)
    ]
    error = np.abs(got - expected)
    worst = np.unravel_index(np.argmax(error), expected.shape)
    where = f"{name}[{', '.join(map(str, worst))}]" if worst else name
    off = ~np.isclose(got, expected, rtol=tolerance.relative, atol=ATOL * size(expected))
    many = f" ({np.count_nonzero(off)} of {off.size} entries differ)" if worst else ""
    right, wrong_one = differing(float(expected[worst]), float(got[worst]))
    plain = f"The values of {name} are wrong."
    accuracy = float(error[worst]) / (size(expected) or 1.0)
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
    tolerance, scale = Tolerance(RTOL, single(got)), np.abs(expected).sum()
    scaled = _scaled(got, scale)
    if alike(scaled, expected, tolerance):
        return
    explanations = [
        hint
        for hint, values in mistakes
        if explains(values, got, tolerance, lambda values: _scaled(values, scale))
    ]
    _explain(scaled, expected, f"{name} (scaled to the right size)", explanations, tolerance)


def _scaled(values: Floats, scale: float) -> Floats:
    return values * (scale / (np.abs(values[np.isfinite(values)]).sum() or 1.0))
