"""What the teacher alone gets: an overview of the class, and which submissions look alike."""

import re
import statistics
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from meshfair_grading.assignment import Assignment, Check
from meshfair_grading.feedback import COLORS, templates
from meshfair_grading.gradebook import Mark, write
from meshfair_grading.outcomes import Outcome
from meshfair_grading.similar import COMMON, THRESHOLD, similar

MOST_HINTS = 3
BINS = 10  # of the histogram


@dataclass(frozen=True)
class Line:
    """How the class did on one check."""

    check: Check
    counts: dict[str, int]
    """Students by status: right, partly, wrong, not done."""
    mean: float
    hints: list[tuple[str, int]]
    """The most frequent ones that more than one student got, and how many did."""


@dataclass(frozen=True)
class Overview:
    """A class's results on an assignment."""

    assignment: Assignment
    marks: Sequence[Mark]

    @property
    def points(self) -> list[float]:
        """The points of each student."""
        return [sum(outcome.earned for outcome in mark.outcomes) for mark in self.marks]

    @property
    def of(self) -> float:
        """The points that there are."""
        return sum(self.assignment.tasks.values())

    @property
    def figures(self) -> list[tuple[str, str]]:
        """Names and values of the figures above the tables."""
        points = self.points
        return [
            ("submissions", str(len(points))),
            ("mean", f"{statistics.mean(points):.1f} of {self.of:g}"),
            ("median", f"{statistics.median(points):g}"),
            ("all points", str(sum(one == self.of for one in points))),
        ]

    @property
    def histogram(self) -> list[tuple[str, int]]:
        """Ranges of points, and how many students are in each."""
        width = self.of / BINS
        places = [min(int(one / width), BINS - 1) for one in self.points]
        return [
            (
                f"{place * width:g} to {'below ' if place < BINS - 1 else ''}"
                f"{(place + 1) * width:g}",
                places.count(place),
            )
            for place in range(BINS)
        ]

    @property
    def statuses(self) -> list[tuple[str, int]]:
        """What became of the files that could not be marked in full."""
        counts = Counter(mark.status for mark in self.marks if mark.status != "graded")
        return counts.most_common()

    @property
    def lines(self) -> list[Line]:
        """One for each check, in order."""
        return [
            _line(check, [mark.outcomes[place] for mark in self.marks])
            for place, check in enumerate(self.assignment.checks)
        ]

    def page(self) -> str:
        """The overview as an HTML page.

        Returns
        -------
        str
        """
        template = templates().get_template("overview.html.jinja")
        return template.render(overview=self, colors=COLORS)


def _line(check: Check, outcomes: Sequence[Outcome]) -> Line:
    counts = Counter(outcome.status for outcome in outcomes)
    # The same mistake shows on another mesh, or in other numbers: what is common is its text.
    hints = Counter(
        re.sub(r"^On [^:]*: ", "", outcome.hint)
        for outcome in outcomes
        if outcome.hint and outcome.status in ("wrong", "partly")
    )
    mean = statistics.mean(outcome.earned for outcome in outcomes)
    ordered = {status: counts[status] for status in COLORS}
    frequent = [(hint, count) for hint, count in hints.most_common(MOST_HINTS) if count > 1]
    return Line(check, ordered, mean, frequent)


def write_overview(
    folder: Path,
    assignment: Assignment,
    marks: Sequence[Mark],
    submissions: Mapping[str, bytes],
    stub: str,
) -> None:
    """Write the pages for the teacher.

    Parameters
    ----------
    folder : Path
        Made where it is missing.
    assignment : meshfair_grading.assignment.Assignment
    marks : sequence of Mark
    submissions : dict of str to bytes
        The files that were handed in, by student.
    stub : str
        The file that was handed out.
    """
    folder.mkdir(parents=True, exist_ok=True)
    write(folder / "overview.html", Overview(assignment, marks).page())
    known = {"handed out": stub.encode(), "solution": assignment.solution.encode()}
    page = templates().get_template("similar.html.jinja").render(
        assignment=assignment, pairs=similar(submissions, known), threshold=THRESHOLD, common=COMMON
    )  # fmt: skip
    write(folder / "similar.html", page)
