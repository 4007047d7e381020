"""Right functions in place of a student's wrong ones, so that a mistake costs only once."""

import ast
from collections.abc import Sequence
from dataclasses import replace

from meshfair_grading.assignment import Assignment, Corrected
from meshfair_grading.isolation import Isolation
from meshfair_grading.rules import Function, reached, read
from meshfair_grading.students import IsolatedStudent

MAKER = "_right_functions"


def with_right_functions(
    source: bytes, assignment: Assignment, student: IsolatedStudent, isolation: Isolation
) -> Corrected:
    """How to get the student with right functions in place of wrong ones.

    It is a process like the student's own, with what is left of the time, and
    none of the instructor's functions but those that are needed: the student
    has been marked on them before.

    Parameters
    ----------
    source : bytes
        The student's file.
    assignment : meshfair_grading.assignment.Assignment
    student : meshfair_grading.students.IsolatedStudent
        As the file is.
    isolation : meshfair_grading.isolation.Isolation

    Returns
    -------
    callable
        See `Assignment.mark`.
    """

    def corrected(names: Sequence[str]) -> IsolatedStudent:
        limits = replace(isolation.limits, total=round(student.left, 1))
        file = source + b"\n\n\n" + stand_in(assignment, names).encode()
        return type(student)(
            file, assignment.name, assignment.rules, replace(isolation, limits=limits)
        )

    return corrected


def stand_in(assignment: Assignment, names: Sequence[str]) -> str:
    """Code that defines some of the instructor's functions, whatever the file has done before.

    Parameters
    ----------
    assignment : meshfair_grading.assignment.Assignment
    names : sequence of str

    Returns
    -------
    str
        ASCII, to be added to a file in any encoding.
    """
    calls = read(assignment.solution, assignment.rules).calls
    needed = set(names).union(*(reached(calls, name) for name in names))
    inside = [
        statement
        for statement in ast.parse(assignment.solution).body
        if not isinstance(statement, Function) or statement.name in needed
    ]
    targets = ", ".join(names)
    code = ast.parse(f"def {MAKER}():\n    return ({targets},)\n\n\n{targets}, = {MAKER}()")
    maker = code.body[0]
    assert isinstance(maker, Function)
    maker.body[:0] = inside
    return ast.unparse(code).encode("ascii", "backslashreplace").decode()
