"""A report on a student's work: as text, as Markdown, as HTML."""

from __future__ import annotations

import html
import re
from dataclasses import dataclass, field, replace
from functools import cache
from typing import TYPE_CHECKING, Any

from meshfair_grading.outcomes import Outcome

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup

MARKS = {"right": "✓", "partly": "◐", "wrong": "✗", "not done": "·"}
COLORS = {"right": "#1a7f37", "partly": "#9a6700", "wrong": "#cf222e", "not done": "#6e7781"}


@dataclass(frozen=True)
class Report:
    """The outcomes of checks under a heading.

    Shown by its ``repr`` in a terminal and as HTML in a notebook.
    """

    heading: str
    outcomes: list[Outcome]
    remarks: list[str] = field(default_factory=list)
    """Sentences about the whole submission."""
    printed: str = ""
    """The beginning of what the student's code printed."""

    @property
    def earned(self) -> float:
        """Points earned."""
        return float(sum(outcome.earned for outcome in self.outcomes))

    @property
    def points(self) -> float:
        """Points that there are."""
        return float(sum(outcome.points for outcome in self.outcomes))

    @property
    def score(self) -> str:
        """Both in words."""
        return f"{self.earned:g} of {self.points:g} points"

    def text(self) -> str:
        """The report in plain text, as a terminal shows it.

        Returns
        -------
        str
        """
        lines = [f"{self.heading}: {self.score}", *self.remarks]
        for _, outcomes in self.by_task():
            for o in outcomes:
                lines.append(f" {MARKS[o.status]} {o.earned:g}/{o.points:g}  {o.task}: {o.title}")
                lines += [f"          {name + ':':10}{value}" for name, value in _details(o)]
        if self.printed:
            lines += ["Your code printed:", self.printed]
        return _printable("\n".join(lines))

    def markdown(self) -> str:
        """The report in Markdown.

        Returns
        -------
        str
        """
        lines = [f"# {quoted(self.heading)}", "", f"**{self.score}**", ""]
        lines += [f"{quoted(remark)}\n" for remark in self.remarks]
        for task, outcomes in self.by_task():
            earned = sum(o.earned for o in outcomes)
            lines += [f"## `{task}`: {earned:g} of {sum(o.points for o in outcomes):g}", ""]
            for o in outcomes:
                lines.append(f"- {MARKS[o.status]} **{o.earned:g}/{o.points:g}** {o.title}")
                lines += [f"    - {name}: {quoted(value)}" for name, value in _details(o)]
            lines.append("")
        if self.printed:
            indented = "\n".join(f"    {_printable(line)}" for line in self.printed.split("\n"))
            lines += ["## What the code printed", "", indented, ""]
        return "\n".join(lines)

    def html(self) -> str:
        """The report as a part of an HTML page.

        Returns
        -------
        str
        """
        return templates().get_template("report.html.jinja").render(report=self)

    def page(self) -> str:
        """The report as an HTML page of its own.

        Returns
        -------
        str
        """
        return templates().get_template("page.html.jinja").render(report=self)

    def by_task(self) -> list[tuple[str, list[Outcome]]]:
        """The tasks, each with its outcomes."""
        tasks = dict.fromkeys(outcome.task for outcome in self.outcomes)
        return [(task, _brief([o for o in self.outcomes if o.task == task])) for task in tasks]

    def __repr__(self) -> str:
        return self.text()

    def _repr_html_(self) -> str:
        return self.html()


def _brief(outcomes: list[Outcome]) -> list[Outcome]:
    """A task's outcomes without repetitions: one for all where the task is not done."""
    if {outcome.status for outcome in outcomes} == {"not done"}:
        points = sum(outcome.points for outcome in outcomes)
        return [replace(outcomes[0], title=outcomes[0].hint, points=points, hint="")]
    notes = [outcome.note for outcome in outcomes]
    return [
        replace(outcome, note="" if outcome.note in notes[:place] else outcome.note)
        for place, outcome in enumerate(outcomes)
    ]


def _details(outcome: Outcome) -> list[tuple[str, str]]:
    rows = (
        ("expected", outcome.expected),
        ("got", outcome.got),
        ("hint", outcome.hint),
        ("note", outcome.note),
    )
    return [(name, value) for name, value in rows if value]


@cache
def templates() -> Environment:
    """The pages, and what they need."""
    from jinja2 import Environment, PackageLoader

    environment = Environment(
        loader=PackageLoader("meshfair_grading"), autoescape=True, finalize=_printable,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    environment.filters["with_code"] = _with_code
    environment.globals.update(colors=COLORS, marks=MARKS, details=_details)
    return environment


def _printable(value: Any) -> Any:
    """A text without characters that could change how the rest is shown."""
    if type(value) is not str:  # what is marked as HTML has been through here
        return value
    return "".join(c for c in value if c.isprintable() or c in "\n\t")


def _with_code(text: str) -> Markup:
    """HTML of a text in which names of functions stand between backquotes."""
    from markupsafe import Markup

    return Markup(re.sub("`([^`]*)`", r"<code>\1</code>", html.escape(_printable(text))))


def quoted(text: str) -> str:
    """A line of Markdown of a text with a student's words in it, which cannot be markup.

    Parameters
    ----------
    text : str

    Returns
    -------
    str
        One line, without HTML.
    """
    return (
        html.escape(_printable(" ".join(text.split()))).replace("|", "&#124;").replace("[", "&#91;")
    )
