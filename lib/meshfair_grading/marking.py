"""Mark a class: every submission by itself, in parallel, going on where it stopped."""

import contextlib
import csv
import hashlib
import io
import json
import os
import stat
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from meshfair_grading.answers import Failure
from meshfair_grading.assignment import Assignment
from meshfair_grading.feedback import Report
from meshfair_grading.isolation import Isolation, Limits
from meshfair_grading.outcomes import Outcome
from meshfair_grading.source import Source
from meshfair_grading.standin import with_right_functions
from meshfair_grading.students import IsolatedStudent

LARGEST_FILE = 1_000_000
RECORDS = "records"


@dataclass(frozen=True)
class Submission:
    """What was found for one student."""

    student: str
    path: Path | None
    remark: str = ""


def find(folder: str | Path, assignment: str) -> list[Submission]:
    """Find the submissions in a folder.

    Each student has a folder named by their identity, with ``a2.py`` in it or
    in its subfolder ``a2`` (nbgrader's layout), or else a file of their own
    beside the others, ``IDENTITY.py``.

    Parameters
    ----------
    folder : path
    assignment : str

    Returns
    -------
    list of Submission
        Sorted by student.

    Raises
    ------
    ValueError
        No submission there at all.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise ValueError(f"{folder} is no folder; give the one with the submissions")
    found = []
    for entry in sorted(folder.iterdir()):
        if entry.name.startswith((".", "__")):  # .DS_Store, __MACOSX, __pycache__
            continue
        if entry.is_dir():
            found.append(_in_folder(entry, assignment))
        elif entry.suffix == ".py":
            found.append(Submission(entry.stem, entry))
    if not found:
        raise ValueError(f"{folder} holds neither folders of students nor .py files")
    twice = {one.student for one in found if sum(o.student == one.student for o in found) > 1}
    if twice:
        raise ValueError(f"{folder} has a folder and a file of {', '.join(sorted(twice))}")
    return found


def _in_folder(folder: Path, assignment: str) -> Submission:
    name = f"{assignment}.py"
    for path in (folder / name, folder / assignment / name):
        if path.is_file():
            return Submission(folder.name, path)
    others = sorted(folder.glob("*.py"))
    if len(others) == 1:
        remark = f"The file is called {others[0].name}; call it {name} the next time."
        return Submission(folder.name, others[0], remark)
    return Submission(folder.name, None, f"There is no {name} in the folder.")


@dataclass(frozen=True)
class Mark:
    """One student's result."""

    student: str
    outcomes: list[Outcome]
    status: str
    """graded, or in a few words why not."""
    remarks: list[str]
    printed: str = ""

    def report(self, assignment: Assignment) -> Report:
        """The feedback for the student.

        Returns
        -------
        meshfair_grading.feedback.Report
        """
        heading = f"{assignment.name} · {assignment.title} · {self.student}"
        return Report(heading, self.outcomes, self.remarks, self.printed)

    @property
    def metric(self) -> float | None:
        """The figure for the leaderboard, or None."""
        return next((o.metric for o in self.outcomes if o.metric is not None), None)


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
        source = _read(submission)
    except ValueError as error:
        return Mark(submission.student, _nothing(assignment), str(error), [*remarks, str(error)])
    with kind(source, assignment.name, assignment.rules, isolation) as student:
        corrected = with_right_functions(source, assignment, student, isolation)
        outcomes = assignment.mark(student, seed, corrected=corrected)
    remarks += student.remarks
    broken = student.whole_file
    status = "graded"
    if broken:
        where = f" (line {broken.line}: {broken.code})" if broken.line else ""
        remarks.append(f"The file could not be loaded: {broken.message}{where}")
        status = _status(broken)
    return Mark(submission.student, outcomes, status, remarks, student.printed)


def handed_in(folder: str | Path, assignment: str) -> dict[str, bytes]:
    """The files that can be read, by student.

    Parameters
    ----------
    folder : path
    assignment : str

    Returns
    -------
    dict of str to bytes
    """
    found = {}
    for submission in find(folder, assignment):
        with contextlib.suppress(ValueError):
            found[submission.student] = _read(submission)
    return found


def _status(broken: Failure) -> str:
    """The kind of a failure of the whole file, in our own words: it goes into the CSV."""
    if broken.kind == "not allowed":
        return "forbidden import"
    kinds = {"SyntaxError": "syntax error", "UnicodeDecodeError": "not UTF-8"}
    return kinds.get(broken.message.partition(":")[0], "could not be loaded")


def _read(submission: Submission) -> bytes:
    if submission.path is None:
        raise ValueError("nothing handed in")
    status = os.lstat(submission.path)
    if not stat.S_ISREG(status.st_mode):
        raise ValueError("not a regular file")
    if status.st_size > LARGEST_FILE:
        raise ValueError(f"a file of more than {LARGEST_FILE / 1e6:g} MB")
    return submission.path.read_bytes()


def _nothing(assignment: Assignment) -> list[Outcome]:
    return [Outcome(c.task, c.title, c.points, 0.0, "wrong") for c in assignment.checks]


class Gradebook:
    """The results of a class, on the disk: a record for each student, and the tables.

    Parameters
    ----------
    out : path
        The CSV; feedback and records go into the folder ``<its name>_feedback``.
    assignment : meshfair_grading.assignment.Assignment
    """

    def __init__(self, out: str | Path, assignment: Assignment) -> None:
        self.out = Path(out)
        self.feedback = self.out.with_name(f"{self.out.stem}_feedback")
        self.assignment = assignment
        (self.feedback / RECORDS).mkdir(parents=True, exist_ok=True)

    def known(self, student: str, key: str) -> Mark | None:
        """The mark of an earlier run, or None where something has changed since.

        Parameters
        ----------
        student : str
        key : str
            Fingerprint of all that decides the mark.

        Returns
        -------
        Mark or None
        """
        try:
            record = json.loads(self._record(student).read_text(encoding="utf-8"))
            if record.pop("key") != key:
                return None
            record["outcomes"] = [Outcome(**outcome) for outcome in record["outcomes"]]
            return Mark(**record)
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def add(self, mark: Mark, key: str) -> None:
        """Keep a mark: the feedback first, then the record, which makes it final."""
        report = mark.report(self.assignment)
        write(self.feedback / f"{mark.student}.html", report.page())
        write(self.feedback / f"{mark.student}.md", report.markdown())
        record = json.dumps({**asdict(mark), "key": key}, indent=1)
        write(self._record(mark.student), record)

    def write_tables(self, marks: Sequence[Mark]) -> None:
        """Write the CSV, and the leaderboard where the assignment has one.

        Parameters
        ----------
        marks : sequence of Mark
        """
        tasks = self.assignment.tasks
        metric = any(mark.metric is not None for mark in marks)
        header = ["student", "points", "of", *tasks, "status"] + ["leaderboard"] * metric
        rows = []
        for one in marks:
            row = [one.student, _sum(one.outcomes), f"{sum(tasks.values()):g}"]
            row += [_sum(o for o in one.outcomes if o.task == task) for task in tasks]
            row += [one.status]
            row += ["" if one.metric is None else f"{one.metric:.3f}"] * metric
            rows.append(row)
        text = io.StringIO(newline="")
        csv.writer(text, lineterminator="\n").writerows([header, *rows])
        write(self.out, text.getvalue())
        if metric:
            write(self.feedback / "leaderboard.md", _leaderboard(self.assignment, marks))

    def _record(self, student: str) -> Path:
        return self.feedback / RECORDS / f"{student}.json"


def _sum(outcomes: Iterable[Outcome]) -> str:
    return f"{sum(outcome.earned for outcome in outcomes):g}"


def _leaderboard(assignment: Assignment, marks: Sequence[Mark]) -> str:
    ranked = sorted((-m.metric, m.student) for m in marks if m.metric is not None)
    rows = [
        f"| {rank} | {student} | {-negative:.2f} |"
        for rank, (negative, student) in enumerate(ranked, 1)
    ]
    head = [f"# {assignment.title}: leaderboard", "", "| | student | dB |", "|---|---|---|"]
    return "\n".join([*head, *rows]) + "\n"


def write(path: Path, text: str) -> None:
    """Write a file so that after any error the old one or the new one is whole."""
    with tempfile.NamedTemporaryFile(
        "w", dir=path.parent, prefix=f".{path.name}.", delete=False, encoding="utf-8", newline=""
    ) as file:
        try:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
            os.chmod(file.name, 0o644)
            os.replace(file.name, path)
        except BaseException:
            os.unlink(file.name)
            raise


def grade(
    folder: str | Path,
    source: Source,
    out: str | Path,
    isolation: Isolation,
    *,
    seed: int | None = None,
    jobs: int = 2,
    progress: Callable[..., Iterable[Mark]] | None = None,
) -> list[Mark]:
    """Mark all submissions of a folder; one that has its mark already is not run again.

    Parameters
    ----------
    folder : path
        See `find`.
    source : meshfair_grading.source.Source
    out : path
        The CSV, see `Gradebook`.
    isolation : meshfair_grading.isolation.Isolation
    seed : int, optional
        Of the unseen meshes; the assignment's own by default.
    jobs : int
        How many submissions run at a time.
    progress : callable, optional
        ``progress(marks, total=count)`` gets an iterable and gives it on, as tqdm does.

    Returns
    -------
    list of Mark
        Sorted by student.

    Raises
    ------
    ValueError
        No submissions.
    """
    assignment = source.load()
    seed = assignment.seed if seed is None else seed
    submissions = find(folder, source.name)
    book = Gradebook(out, assignment)
    keys = {s.student: _key(s, source, seed, isolation.limits) for s in submissions}
    marks = {s.student: book.known(s.student, keys[s.student]) for s in submissions}
    waiting = [s for s in submissions if marks[s.student] is None]
    try:
        if waiting:
            with tempfile.TemporaryDirectory(prefix="meshfair-") as cache:
                isolation = replace(isolation, numba_cache=Path(cache))
                dry_run(source, assignment, isolation, seed)
                found = _in_parallel(jobs, waiting, assignment, isolation, seed)
                for one in progress(found, total=len(waiting)) if progress else found:
                    book.add(one, keys[one.student])
                    marks[one.student] = one
    finally:  # after an interruption too: the table of those who have a mark
        marked = [one for one in marks.values() if one is not None]
        book.write_tables(marked)
    return marked


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
        content = _read(submission)
    except ValueError as error:
        content = str(error).encode()
    state = repr((source.digest, seed, limits, submission.remark)).encode()
    return hashlib.sha256(state + content).hexdigest()
