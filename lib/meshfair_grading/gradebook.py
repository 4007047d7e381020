"""The results of a class on the disk: a record for each student, feedback, and the tables.

Nothing that is not the grader's own is written over: it knows its files by what it
wrote into them.
"""

import contextlib
import csv
import hashlib
import io
import json
import os
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

from meshfair_grading.assignment import Assignment
from meshfair_grading.feedback import Report, quoted
from meshfair_grading.outcomes import Outcome
from meshfair_grading.printable import cell, file_names, printable

RECORDS = "records"
ABOUT = "about.json"
OURS = "meshfair grade"


@dataclass(frozen=True)
class Mark:
    """One student's result."""

    student: str
    outcomes: list[Outcome]
    status: str
    """graded, or in a few words why not."""
    remarks: list[str]
    printed: str = ""
    final: bool = True
    """False where this machine could not mark it: it is tried again in the next run."""

    @classmethod
    def from_record(cls, record: dict[str, Any]) -> Self:
        """A mark as `dataclasses.asdict` has taken it apart, by way of JSON or not.

        Parameters
        ----------
        record : dict

        Returns
        -------
        Mark
        """
        return cls(**{**record, "outcomes": [Outcome(**one) for one in record["outcomes"]]})

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


def teachers_folder(out: Path) -> Path:
    """Where the pages lie that are for the teacher alone: beside the CSV."""
    return out.with_name(f"{out.stem}_teacher")


class Gradebook:
    """The results of a class.

    Parameters
    ----------
    out : path
        The CSV; feedback and records go into the folder ``<its name>_feedback``.
    assignment : meshfair_grading.assignment.Assignment
    students : iterable of str
    submissions : path, optional
        The folder with the submissions, in which no result may lie.
    force : bool
        Write over files that are not the grader's own.

    Raises
    ------
    ValueError, OSError
        Results would lie among the submissions, or over somebody's files; they cannot be written.
    """

    def __init__(
        self,
        out: str | Path,
        assignment: Assignment,
        students: Iterable[str],
        *,
        submissions: str | Path | None = None,
        force: bool = False,
    ) -> None:
        self.out = Path(out)
        self.feedback = self.out.with_name(f"{self.out.stem}_feedback")
        self.teacher = teachers_folder(self.out)
        self.assignment = assignment
        self._names = file_names(students)
        if submissions is not None:
            self._keep_out_of(Path(submissions))
        if not force:
            self._check_own()
        (self.feedback / RECORDS).mkdir(parents=True, exist_ok=True)
        self._tell(self._about().get("csv"))

    def _keep_out_of(self, submissions: Path) -> None:
        inside = submissions.resolve()
        for place in (self.out, self.feedback, self.teacher):
            if place.resolve().is_relative_to(inside):
                raise ValueError(
                    f"{printable(str(self.out))} lies among the submissions, where results would "
                    "be taken for a student's; give --out a place beside them"
                )

    def _check_own(self) -> None:
        about, out = self._about(), printable(str(self.out))
        if self.out.is_dir():
            raise ValueError(f"{out} is a folder; give --out the name of a CSV file in it")
        if about and about.get("assignment") != self.assignment.name:
            raise ValueError(
                f"{out} holds the results of {about.get('assignment')}; give --out another name, "
                "or replace them with --force"
            )
        if self.out.exists() and about.get("csv") != _digest(self.out):
            raise FileExistsError(
                f"{out} is there already, and was not written by this command or has been changed "
                "since; give --out another name, or replace it with --force"
            )
        for folder in (self.feedback, self.teacher):
            if not about and folder.exists() and any(folder.iterdir()):
                raise FileExistsError(
                    f"{printable(str(folder))} is there already, and is not from this command; "
                    "give --out another name, or write into it with --force"
                )

    def _about(self) -> dict[str, Any]:
        """What an earlier run has written about itself, or nothing."""
        with contextlib.suppress(OSError, ValueError):
            about = json.loads((self.feedback / RECORDS / ABOUT).read_text(encoding="utf-8"))
            if isinstance(about, dict) and about.get("by") == OURS:
                return about
        return {}

    def _tell(self, csv_digest: str | None) -> None:
        about = {"by": OURS, "assignment": self.assignment.name, "csv": csv_digest}
        write(self.feedback / RECORDS / ABOUT, json.dumps(about))

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
            return Mark.from_record(record)
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def add(self, mark: Mark, key: str) -> None:
        """Keep a mark: the feedback first, then the record, which makes it final."""
        report, name = mark.report(self.assignment), self._names[mark.student]
        write(self.feedback / f"{name}.html", report.page())
        write(self.feedback / f"{name}.md", report.markdown())
        if mark.final:
            write(self._record(mark.student), json.dumps({**asdict(mark), "key": key}, indent=1))

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
            row = [cell(one.student), _sum(one.outcomes), f"{sum(tasks.values()):g}"]
            row += [_sum(o for o in one.outcomes if o.task == task) for task in tasks]
            row += [cell(one.status)]
            row += ["" if one.metric is None else f"{one.metric:.3f}"] * metric
            rows.append(row)
        text = io.StringIO(newline="")
        csv.writer(text, lineterminator="\n").writerows([header, *rows])
        write(self.out, text.getvalue())
        self._tell(_digest(self.out))
        if metric:
            write(self.feedback / "leaderboard.md", _leaderboard(self.assignment, marks))

    def _record(self, student: str) -> Path:
        return self.feedback / RECORDS / f"{self._names[student]}.json"


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _sum(outcomes: Iterable[Outcome]) -> str:
    return f"{sum(outcome.earned for outcome in outcomes):g}"


def _leaderboard(assignment: Assignment, marks: Sequence[Mark]) -> str:
    ranked = sorted((-m.metric, m.student) for m in marks if m.metric is not None)
    rows = [
        f"| {rank} | {quoted(student)} | {-negative:.2f} |"
        for rank, (negative, student) in enumerate(ranked, 1)
    ]
    head = [f"# {quoted(assignment.title)}: leaderboard", "", "| | student | dB |", "|---|---|---|"]
    return "\n".join([*head, *rows]) + "\n"


def write(path: Path, text: str) -> None:
    """Write a file so that after any error the old one or the new one is whole.

    Parameters
    ----------
    path : Path
    text : str

    Raises
    ------
    OSError
        It cannot be written; the message names it.
    """
    try:
        with tempfile.NamedTemporaryFile(
            "w", dir=path.parent, prefix=".meshfair-", delete=False, encoding="utf-8",
            errors="backslashreplace", newline="",
        ) as file:  # fmt: skip
            try:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
                os.chmod(file.name, 0o644)
                os.replace(file.name, path)
            except BaseException:
                os.unlink(file.name)
                raise
    except OSError as error:
        where = printable(str(path))
        raise OSError(f"{where} cannot be written ({error.strerror}); is the disk full?") from None
