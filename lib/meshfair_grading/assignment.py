"""An assignment: its tasks, their points, and the checks that give them."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, TypeVar

from meshfair_grading.expect import WrongAnswerError
from meshfair_grading.feedback import Report
from meshfair_grading.outcomes import Graded, Outcome
from meshfair_grading.rules import Rules, reached
from meshfair_grading.students import NotDoneError, NotebookStudent, Student

# Cases of a check by seed: what is being tried, then the check's arguments after the student.
Cases = Callable[[int], Iterable[tuple[Any, ...]]]
# The student with the functions of these names replaced by right ones.
Corrected = Callable[[list[str]], AbstractContextManager[Student]]

# What right values are worth that cost the caller the input.
SHARE_IN_PLACE = 0.5


Run = TypeVar("Run", bound=Callable[..., Graded | None])


@dataclass(frozen=True)
class Check:
    """A part of a task, with points of its own."""

    task: str
    title: str
    points: float
    cases: Cases
    run: Callable[..., Graded | None]


class Assignment:
    """Tasks and checks, and how to mark a student with them.

    In the student's notebook it is called: ``check("edges")`` shows the report
    of one task, ``check()`` that of all.

    Parameters
    ----------
    name : str
        Such as ``a2``: also the name of the student's module.
    title : str
    rules : Rules
        Which imports and calls are allowed.
    seed : int
        For the meshes that the student sees. Teachers give another one to
        ``meshfair grade``.

    Attributes
    ----------
    module : str
        Name of the module with the student's functions, where they are not
        those of a submission.
    solution : str
        The student's file as the instructor would hand it in; empty where
        only the visible checks are.
    """

    def __init__(self, name: str, title: str, *, rules: Rules | None = None, seed: int = 0) -> None:
        self.name, self.title, self.seed = name, title, seed
        self.rules = rules or Rules()
        self.module = name
        self.solution = ""
        self.checks: list[Check] = []
        self._cases: dict[Cases, Cases] = {}

    def part(self, task: str, points: float, cases: Cases) -> Callable[[Run], Run]:
        """Decorator: a function becomes a check, its docstring the check's title.

        Parameters
        ----------
        task : str
            Name of the student's function.
        points : float
        cases : callable
            ``cases(seed)`` yields tuples: what is being tried, then the
            arguments of the check, which is called with the student before
            them. Points are given when every case passes.

        Returns
        -------
        callable
            The function is left as it is. It raises `WrongAnswerError`, or
            returns None for full points, or a `Graded`.
        """

        def register(run: Run) -> Run:
            title = (run.__doc__ or "").partition("\n")[0].rstrip(".")
            # Checks with the same cases get the same meshes.
            made = self._cases.setdefault(cases, cache(lambda seed: list(cases(seed))))
            self.checks.append(Check(task, title, points, made, run))
            return run

        return register

    @property
    def tasks(self) -> dict[str, float]:
        """Points of each task, in order.

        Returns
        -------
        dict of str to float
        """
        tasks: dict[str, float] = {}
        for check in self.checks:
            tasks[check.task] = tasks.get(check.task, 0) + check.points
        return tasks

    def mark(
        self,
        student: Student,
        seed: int,
        task: str | None = None,
        corrected: Corrected | None = None,
    ) -> list[Outcome]:
        """Run the checks on a student's functions.

        A mistake costs where it was made: a task whose function calls others
        of the file that are wrong is marked with right ones in their place.

        Parameters
        ----------
        student : meshfair_grading.students.Student
        seed : int
        task : str, optional
            Run this task's checks only.
        corrected : callable, optional
            ``corrected(names)`` is a context whose value is the student with
            these functions replaced by right ones. Without it the outcomes
            only say which functions to mend first.

        Returns
        -------
        list of Outcome
            One for each check, in their order.
        """
        outcomes: list[Outcome] = []
        wrong: list[str] = []
        for name in [task] if task else self.tasks:
            checks = [check for check in self.checks if check.task == name]
            found = [_outcome(check, student, seed) for check in checks]
            called = [one for one in wrong if one in reached(student.calls, name)]
            if called and not _full(found):
                found = _once_more(checks, found, called, seed, corrected)
            if not _full(found):
                wrong.append(name)
            outcomes += found
        return outcomes

    def __call__(self, task: str | None = None) -> Report:
        """Check what is in the notebook's module now, and report."""
        if task is not None and task not in self.tasks:
            raise ValueError(f"no task {task!r}; the tasks are {', '.join(self.tasks)}")
        student = NotebookStudent(self.module, self.rules)
        return Report(f"{self.name} · {task or self.title}", self.mark(student, self.seed, task))

    def points(self, task: str) -> float:
        """The points of one task, which nbgrader takes as a cell's partial credit."""
        return self(task).earned


def _full(outcomes: list[Outcome]) -> bool:
    return all(outcome.status == "right" for outcome in outcomes)


def _once_more(
    checks: list[Check],
    found: list[Outcome],
    called: list[str],
    seed: int,
    corrected: Corrected | None,
) -> list[Outcome]:
    """The outcomes of a task that calls wrong functions, with right ones in their place."""
    names = " and ".join(f"`{name}`" for name in called)
    if corrected is None:
        note = f"This calls {names}, not right yet either: mend that first."
        return [one if one.status == "right" else replace(one, note=note) for one in found]
    note = f"Marked with a right {names} in place of yours, so that a mistake costs only once."
    with corrected(called) as student:
        student.replaced = tuple(called)
        again = [replace(_outcome(check, student, seed), note=note) for check in checks]
    return [
        one if one.status == "right" or one.earned > other.earned else other
        for one, other in zip(found, again, strict=True)
    ]


def _outcome(check: Check, student: Student, seed: int) -> Outcome:
    """Run one check on all its cases; the one with the smallest share decides."""
    outcome = Outcome(check.task, check.title, check.points, 0.0, "wrong")
    student.changed, student.check = [], f"{check.task}: {check.title}"
    try:
        graded, tried = _decisive(list(_cases(check, student, seed)))
    except NotDoneError as error:
        return replace(outcome, status="not done", hint=str(error))
    outcome = replace(
        outcome,
        earned=round(2 * check.points * graded.share) / 2,  # half points
        hint=f"On {tried}: {graded.hint}" if graded.hint else "",
        expected=graded.expected,
        got=graded.got,
        metric=graded.metric,
    )
    if student.changed and outcome.earned:
        function, index = student.changed[0]
        outcome = replace(
            outcome,
            earned=SHARE_IN_PLACE * outcome.earned,
            hint=f"The values are right, but `{function}` changed its argument number {index + 1} "
            "in place, and the caller's mesh with it: work on a copy.",
            expected="arguments as they were",
            got="changed arguments",
        )
    full = outcome.earned == outcome.points
    return replace(outcome, status="right" if full else "partly" if outcome.earned else "wrong")


def _cases(
    check: Check, student: Student, seed: int
) -> Iterator[tuple[Graded | WrongAnswerError, str]]:
    """What a check finds on its cases: all of them, or up to the first that settles it."""
    for tried, *arguments in check.cases(seed):
        student.case = tried
        try:
            yield check.run(student, *arguments) or Graded(1.0), tried
        except WrongAnswerError as wrong:
            yield wrong, tried
            if not (wrong.explanations or wrong.share):
                return
        except (NotDoneError, OSError):  # OSError: no process could be started here
            raise
        except Exception as error:  # an answer so odd that the check trips over it
            message = f"{type(error).__name__}: {error}"
            hint = f"the check cannot make sense of your answer ({message})."
            yield Graded(0.0, hint), tried
            return


def _decisive(found: list[tuple[Graded | WrongAnswerError, str]]) -> tuple[Graded, str]:
    """The case that costs most, and the hint that explains all wrong cases."""
    one, tried = min(
        found,
        key=lambda pair: (pair[0].share, getattr(pair[0], "metric", None) or 0.0),
    )
    if isinstance(one, Graded):
        return one, tried
    others = [wrong.explanations for wrong, _ in found if isinstance(wrong, WrongAnswerError)]
    shared = (
        explanation
        for explanation in one.explanations or ()
        if all(explanation in other for other in others if other is not None)
    )
    hint = next(shared, one.hint)
    return Graded(one.share, hint, one.expected, one.got), tried
