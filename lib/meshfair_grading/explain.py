"""How one student's mark came about: what was run, and what came back. For appeals."""

import hashlib
import platform
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from scipy.sparse import issparse

from meshfair_grading.answers import Answer, Other, Seeded
from meshfair_grading.assignment import Assignment
from meshfair_grading.gradebook import Mark
from meshfair_grading.isolation import Isolation
from meshfair_grading.marking import mark
from meshfair_grading.printable import printable
from meshfair_grading.students import IsolatedStudent
from meshfair_grading.submissions import Submission

SHOWN = 4  # numbers of an array


@dataclass(frozen=True)
class Call:
    """One call of a student's function."""

    check: str
    """Which check made it."""
    case: str
    """On what."""
    text: str
    """Function, arguments, answer, time."""


def explain(
    submission: Submission, content: bytes, assignment: Assignment, isolation: Isolation, seed: int
) -> str:
    """Mark a submission, and say how.

    Parameters
    ----------
    submission : meshfair_grading.marking.Submission
    content : bytes
        Its file.
    assignment : meshfair_grading.assignment.Assignment
    isolation : meshfair_grading.isolation.Isolation
    seed : int

    Returns
    -------
    str
        The calls by check and case, and the report.
    """
    calls: list[Call] = []
    result = mark(submission, assignment, isolation, seed, _recording(calls))
    lines = [
        f"{assignment.name} of {submission.student}: {submission.path}",
        f"sha256 {hashlib.sha256(content).hexdigest()}",
        f"seed {seed}, {isolation.limits.call:g} s a call, Python {platform.python_version()}, "
        f"NumPy {np.__version__}, SciPy {scipy.__version__}",
        "",
    ]
    lines += [*_by_check(calls), "", *_report(result, assignment)]
    return "\n".join(printable(line) for line in lines)


def _recording(calls: list[Call]) -> type[IsolatedStudent]:
    """A student that writes its calls down."""

    class Recorded(IsolatedStudent):
        def _ask(self, name: str, arguments: tuple[Any, ...]) -> Answer:
            start = time.perf_counter()
            answer = super()._ask(name, arguments)
            seconds = time.perf_counter() - start
            given = ", ".join(map(shown, arguments))
            text = f"{name}({given})\n        gave {_answered(answer)} ({seconds:.3f} s)"
            check = self.check
            if self.replaced:
                check += f" (with a right {' and '.join(self.replaced)} in place of theirs)"
            calls.append(Call(check, self.case, text))
            return answer

    return Recorded


def _by_check(calls: Sequence[Call]) -> list[str]:
    lines: list[str] = []
    before = "", ""
    for call in calls:
        if call.check != before[0]:
            lines += ["", call.check]
        if (call.check, call.case) != before:
            lines.append(f"  on {call.case}")
        lines.append(f"    {call.text}")
        before = call.check, call.case
    return lines[1:]


def _report(result: Mark, assignment: Assignment) -> list[str]:
    return result.report(assignment).text().splitlines()


def _answered(answer: Answer) -> str:
    if answer.failure is not None:
        where = (
            f", line {answer.failure.line}: {answer.failure.code}" if answer.failure.line else ""
        )
        return f"{answer.failure.kind}: {answer.failure.message}{where}"
    changed = f", and changed its arguments {[i + 1 for i in answer.changed]}" * bool(
        answer.changed
    )
    return shown(answer.value) + changed


def shown(value: Any) -> str:
    """A value in a few words: its shape, its first numbers, and a fingerprint of all.

    Parameters
    ----------
    value : object
        An argument or an answer, see `meshfair_grading.answers`.

    Returns
    -------
    str
    """
    if isinstance(value, Seeded):
        return f"default_rng({value.seed})"
    if isinstance(value, Other):
        return f"{value.type} {value.shown}"
    if isinstance(value, list):
        return f"[{', '.join(map(shown, value))}]"
    if issparse(value):
        return f"sparse {_shape(value.shape)} with {value.nnz} entries {_numbers(value.data)}"
    if isinstance(value, np.ndarray) and value.ndim:
        return f"array {_shape(value.shape)} of {value.dtype} {_numbers(value.ravel())}"
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def _shape(shape: Sequence[int]) -> str:
    return " x ".join(map(str, shape))


def _numbers(values: Any) -> str:
    first = " ".join(f"{x:.6g}" for x in values[:SHOWN].tolist())
    digest = hashlib.sha256(np.ascontiguousarray(values).tobytes()).hexdigest()[:8]
    return f"[{first}{' ...' if len(values) > SHOWN else ''}] #{digest}"
