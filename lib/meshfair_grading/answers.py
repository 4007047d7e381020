"""What a student's function returned, as plain data: nothing in it can act or claim to be equal."""

import linecache
import reprlib
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from numbers import Number
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, issparse

# Far more than any task needs; a reply is held in memory on both sides.
LARGEST_ANSWER = 64_000_000
LONGEST_MESSAGE = 500
DEEPEST = 3
# Values of other types travel as one of these four.
PLAIN: dict[str, type[np.generic]] = {
    "b": np.bool_,
    "i": np.int64,
    "u": np.int64,
    "f": np.float64,
    "c": np.complex128,
}


@dataclass(frozen=True)
class Seeded:
    """Stands for ``numpy.random.default_rng(seed)`` among a call's arguments."""

    seed: int


@dataclass(frozen=True)
class Other:
    """Stands for a value that is neither numbers nor a list of them."""

    type: str
    shown: str


@dataclass(frozen=True)
class Failure:
    """Why there is no value."""

    kind: str
    """not done, missing, raised, not allowed, not loaded, time limit, crashed."""
    message: str
    """In words; for "not done" the name of the function that is still the stub."""
    line: int = 0
    """Line of the student's file, 0 where none is known."""
    code: str = ""
    """That line."""


@dataclass(frozen=True)
class Answer:
    """The result of one call."""

    value: Any = None
    """ndarray, csr_array, `Other`, None, or a list of these."""
    changed: tuple[int, ...] = ()
    """Positions of the arguments that the call changed in place."""
    failure: Failure | None = None


def ask(
    function: Callable[..., Any],
    arguments: Sequence[Any],
    file: str,
    lent: Sequence[Any] | None = None,
) -> Answer:
    """Call a student's function on copies, and record what it returns.

    Parameters
    ----------
    function : callable
    arguments : sequence
        Arrays, sparse matrices, numbers and `Seeded` generators.
    file : str
        The student's file, to name the line at which an error arose.
    lent : sequence, optional
        What the function gets in place of copies; equal to the arguments.

    Returns
    -------
    Answer
    """
    given = [_fresh(argument) for argument in arguments] if lent is None else lent
    try:
        value = plain(function(*given))
        changed = tuple(
            index
            for index, (before, after) in enumerate(zip(arguments, given, strict=True))
            if not _same(before, after)
        )
        return Answer(value, changed)
    except BaseException as error:  # sys.exit() in a function is a failure like any other
        stub = _stub(error, file or getattr(getattr(function, "__code__", None), "co_filename", ""))
        return Answer(failure=Failure("not done", stub) if stub else failure(error, file))


def _stub(error: BaseException, file: str) -> str:
    """The function of the student's file that is still the stub, or nothing.

    Libraries raise NotImplementedError as well: the stub's stands in the file itself.
    """
    if not isinstance(error, NotImplementedError):
        return ""
    last = traceback.extract_tb(error.__traceback__)[-1]
    raised = (last.line or "").startswith("raise NotImplementedError")
    return last.name if raised and last.filename == file else ""


def failure(error: BaseException, file: str) -> Failure:
    """An exception as a `Failure`: its type, its message, and the student's line.

    Parameters
    ----------
    error : BaseException
    file : str
        The student's file.

    Returns
    -------
    Failure
    """
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__)
             if frame.filename == file]  # fmt: skip
    line = (lines[-1] if lines else 0) or 0
    if isinstance(error, SyntaxError) and error.filename == file:
        line = error.lineno or 0
    try:
        message = str(error)[:LONGEST_MESSAGE]
    except Exception:  # an exception of the student's own, whose __str__ fails
        message = ""
    if isinstance(error, MemoryError):
        message = f"more memory than there is for a submission. {message}"
    if isinstance(error, SystemExit):
        message = f"exit code {message}; a function returns, it does not end the program"
    name = type(error).__name__
    linecache.checkcache(file)  # in a notebook the file changes while the process lives
    code = linecache.getline(file, line).strip()[:LONGEST_MESSAGE] if line else ""
    return Failure("raised", f"{name}: {message}" if message else name, line, code)


def plain(value: Any, depth: int = 0) -> Any:
    """Numbers and arrays as arrays of four dtypes, sparse matrices as csr_array.

    Parameters
    ----------
    value : object
        What a function returned.
    depth : int
        How many lists it lies in.

    Returns
    -------
    ndarray, csr_array, Other, None, or a list of these

    Raises
    ------
    ValueError
        The value is larger than any right one.
    """
    if value is None:
        return None
    if issparse(value):
        matrix = csr_array(value)
        if matrix.dtype.kind in PLAIN:
            _check_size(matrix)
            return matrix.astype(PLAIN[matrix.dtype.kind])
    try:
        array = _numbers(np.asarray(value))
    except Exception:  # ragged lists, or an object whose conversion fails
        array = np.empty(0, dtype=object)
    if array.dtype.kind in PLAIN:
        _check_size(array)
        return np.array(array, dtype=PLAIN[array.dtype.kind], order="C")
    if isinstance(value, (list, tuple)) and depth < DEEPEST and len(value) <= 100:
        return [plain(item, depth + 1) for item in value]
    return Other(type(value).__name__, _shown(value))


def _numbers(array: NDArray[Any]) -> NDArray[Any]:
    """An array of objects that are all numbers, as an array of numbers."""
    if array.dtype.kind != "O" or array.size > LARGEST_ANSWER // 8:
        return array
    # Fractions and decimals are no numbers to NumPy, but know how to become one.
    if all(isinstance(entry, Number) for entry in array.flat):
        converted = np.array(array.tolist())
        return array.astype(float) if converted.dtype.kind == "O" else converted
    return array


def _check_size(array: Any) -> None:
    data = array.data if issparse(array) else array
    if max([data.nbytes, *array.shape]) > LARGEST_ANSWER:
        raise ValueError(f"the returned array has shape {array.shape}, far larger than asked for")


def _shown(value: object) -> str:
    try:
        return reprlib.repr(value)[:80]
    except Exception:  # a __repr__ of the student's own that fails
        return ""


def _fresh(argument: Any) -> Any:
    """An argument that the student's function may spoil."""
    if isinstance(argument, Seeded):
        return np.random.default_rng(argument.seed)
    return argument.copy() if isinstance(argument, (np.ndarray, csr_array)) else argument


def _same(before: Any, after: Any) -> bool:
    if isinstance(before, np.ndarray):
        return before.shape == after.shape and np.array_equal(before, after, equal_nan=True)
    if isinstance(before, csr_array):
        return before.shape == after.shape and (before != after).nnz == 0
    return True  # numbers cannot be changed, and a generator is meant to be
