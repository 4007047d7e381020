"""Mark a class: every submission by itself, in parallel, going on where it stopped."""

import hashlib
import tempfile
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import replace
from pathlib import Path
from typing import Any

from meshfair_grading import walls
from meshfair_grading.answers import Failure
from meshfair_grading.assignment import Assignment
from meshfair_grading.feedback import Report
from meshfair_grading.gradebook import Gradebook, Mark
from meshfair_grading.isolation import Isolation, Limits
from meshfair_grading.outcomes import Outcome
from meshfair_grading.source import Source
from meshfair_grading.standin import with_right_functions
from meshfair_grading.students import IsolatedStudent
from meshfair_grading.submissions import Submission, find, read


def mark(
    submission: Submission,
    assignment: Assignment,
    isolation: Isolation,
    seed: int,
    kind: type[IsolatedStudent] = IsolatedStudent,
) -> Mark:
    """Mark one submission.

    Parameters
    ----------
    submission : Submission
    assignment : meshfair_grading.assignment.Assignment
    isolation : meshfair_grading.isolation.Isolation
    seed : int
    kind : type, optional
        What asks the submission; another one may write down what it asks.

    Returns
    -------
    Mark
        Whatever the submission does, it is reported here and costs nobody else.
    """
    remarks = [submission.remark] if submission.remark else []
    try:
        source = read(submission)
    except ValueError as error:
        return Mark(submission.student, _nothing(assignment), str(error), [*remarks, str(error)])
    try:
        with kind(source, assignment.name, assignment.rules, isolation) as student:
            corrected = with_right_functions(source, assignment, student, isolation)
            outcomes = assignment.mark(student, seed, corrected=corrected)
    except OSError as error:  # of this machine, not of the student
        return not_marked(submission, assignment, str(error))
    remarks += student.remarks
    broken = student.whole_file
    status = "graded"
    if broken:
        where = f" (line {broken.line}: {broken.code})" if broken.line else ""
        remarks.append(f"The file could not be loaded: {broken.message}{where}")
        status = _status(broken)
    return Mark(submission.student, outcomes, status, remarks, student.printed)


def not_marked(submission: Submission, assignment: Assignment, reason: str) -> Mark:
    """What stands for a submission that no machine could mark, until the next run.

    Parameters
    ----------
    submission : Submission
    assignment : meshfair_grading.assignment.Assignment
    reason : str

    Returns
    -------
    Mark
    """
    remarks = [submission.remark] if submission.remark else []
    why = f"This machine could not mark it ({reason}): start the command again."
    nothing = _nothing(assignment)
    return Mark(submission.student, nothing, "not marked", [*remarks, why], final=False)


def _status(broken: Failure) -> str:
    """The kind of a failure of the whole file, in our own words: it goes into the CSV."""
    if broken.kind == "not allowed":
        return "forbidden import"
    kinds = {"SyntaxError": "syntax error", "UnicodeDecodeError": "not UTF-8"}
    return kinds.get(broken.message.partition(":")[0], "could not be loaded")


def _nothing(assignment: Assignment) -> list[Outcome]:
    return [Outcome(c.task, c.title, c.points, 0.0, "wrong") for c in assignment.checks]


def grade(
    folder: str | Path,
    source: Source,
    out: str | Path,
    isolation: Isolation,
    *,
    seed: int | None = None,
    jobs: int = 2,
    force: bool = False,
    progress: Callable[..., Iterable[Mark]] | None = None,
    elsewhere: Callable[[list[Submission], int], Iterator[Mark]] | None = None,
) -> list[Mark]:
    """Mark all submissions of a folder; one that has its mark already is not run again.

    Parameters
    ----------
    folder : path
        See `meshfair_grading.submissions.find`.
    source : meshfair_grading.source.Source
    out : path
        The CSV, see `Gradebook`.
    isolation : meshfair_grading.isolation.Isolation
    seed : int, optional
        Of the unseen meshes; the assignment's own by default.
    jobs : int
        How many submissions run at a time.
    force : bool
        Write over files that are not the grader's own.
    progress : callable, optional
        ``progress(marks, total=count)`` gets an iterable and gives it on, as tqdm does.
    elsewhere : callable, optional
        ``elsewhere(submissions, seed)`` marks them in place of this machine; see
        `meshfair_grading.cluster.marks_on`.

    Returns
    -------
    list of Mark
        Sorted by student.

    Raises
    ------
    ValueError, OSError
        No submissions; results that would lie among them or over somebody's files, see
        `meshfair_grading.gradebook.Gradebook`.
    """
    assignment = source.load()
    seed = assignment.seed if seed is None else seed
    submissions = find(folder, source.name)
    students = [submission.student for submission in submissions]
    book = Gradebook(out, assignment, students, submissions=folder, force=force)
    keys = {s.student: _key(s, source, seed, isolation.limits) for s in submissions}
    marks = {s.student: book.known(s.student, keys[s.student]) for s in submissions}
    waiting = [s for s in submissions if marks[s.student] is None]
    try:
        if waiting:
            if elsewhere is not None:
                found = elsewhere(waiting, seed)
            else:
                found = _here(waiting, source, assignment, isolation, seed, jobs)
            for one in progress(found, total=len(waiting)) if progress else found:
                book.add(one, keys[one.student])
                marks[one.student] = one
    finally:  # after an interruption too: the table of those who have a mark
        marked = [one for one in marks.values() if one is not None]
        book.write_tables(marked)
    return marked


def _here(
    submissions: list[Submission],
    source: Source,
    assignment: Assignment,
    isolation: Isolation,
    seed: int,
    jobs: int,
) -> Iterator[Mark]:
    """The marks of submissions from this machine, as they come."""
    with tempfile.TemporaryDirectory(prefix="meshfair-") as cache:
        walls.give(Path(cache))
        isolation = replace(isolation, numba_cache=Path(cache))
        dry_run(source, assignment, isolation, seed)
        yield from _in_parallel(jobs, submissions, assignment, isolation, seed)


def _in_parallel(jobs: int, submissions: list[Submission], *arguments: Any) -> Iterator[Mark]:
    """The marks of submissions, as they come."""
    pool = ThreadPoolExecutor(jobs)  # threads that wait for processes
    try:
        for future in as_completed([pool.submit(mark, one, *arguments) for one in submissions]):
            yield future.result()
    finally:
        pool.shutdown(cancel_futures=True)


def dry_run(source: Source, assignment: Assignment, isolation: Isolation, seed: int) -> None:
    """Mark the solution, to be sure of the checks before they decide on anybody.

    What numba compiles for it stays in ``isolation.numba_cache``, so that no
    submission pays for that with its time.

    Parameters
    ----------
    source : meshfair_grading.source.Source
    assignment : meshfair_grading.assignment.Assignment
    isolation : meshfair_grading.isolation.Isolation
    seed : int

    Raises
    ------
    ValueError
        The solution does not get all points.
    """
    solution = source.solution().encode()
    # Compiling takes its time on a busy machine, and this code can be trusted.
    limits = isolation.limits
    patient = replace(limits, call=10 * limits.call, total=10 * limits.total)
    isolation = replace(isolation, limits=patient, keep_compiled=True)
    with IsolatedStudent(solution, assignment.name, assignment.rules, isolation) as student:
        report = Report("The solution", assignment.mark(student, seed))
    if report.earned < report.points:
        raise ValueError(
            f"with seed {seed} the solution itself gets only {report.earned:g} of "
            f"{report.points:g} points, so nobody was marked:\n{report.text()}"
        )


def _key(submission: Submission, source: Source, seed: int, limits: Limits) -> str:
    """Fingerprint of all that a mark depends on."""
    try:
        content = read(submission)
    except ValueError as error:
        content = str(error).encode()
    state = repr((source.digest, seed, limits, submission.remark)).encode()
    return hashlib.sha256(state + content).hexdigest()
