"""A report on a student's work: as text, as Markdown, as HTML."""

import html
import re
import string
from dataclasses import dataclass, field, replace

MARKS = {"right": "✓", "partly": "◐", "wrong": "✗", "not done": "·"}
COLOURS = {"right": "#1a7f37", "partly": "#9a6700", "wrong": "#cf222e", "not done": "#6e7781"}

PAGE = string.Template("""<!doctype html>
<html lang="en"><meta charset="utf-8"><title>$title</title>
<style>body { font: 16px/1.5 system-ui, sans-serif; max-width: 48em; margin: 2em auto; }</style>
$body
</html>
""")


@dataclass(frozen=True)
class Report:
    """The outcomes of checks under a heading.

    Shown by its ``repr`` in a terminal and as HTML in a notebook.
    """

    heading: str
    outcomes: list
    remarks: list = field(default_factory=list)
    """Sentences about the whole submission."""
    printed: str = ""
    """The beginning of what the student's code printed."""

    @property
    def earned(self):
        """Points earned."""
        return float(sum(outcome.earned for outcome in self.outcomes))

    @property
    def points(self):
        """Points that there are."""
        return float(sum(outcome.points for outcome in self.outcomes))

    @property
    def _score(self):
        return f"{self.earned:g} of {self.points:g} points"

    def text(self):
        """The report in plain text, as a terminal shows it.

        Returns
        -------
        str
        """
        lines = [f"{self.heading}: {self._score}", *self.remarks]
        for _, outcomes in self._by_task():
            for o in outcomes:
                lines.append(f" {MARKS[o.status]} {o.earned:g}/{o.points:g}  {o.task}: {o.title}")
                lines += [f"          {name + ':':10}{value}" for name, value in _details(o)]
        if self.printed:
            lines += ["Your code printed:", self.printed]
        return "\n".join(lines)

    def markdown(self):
        """The report in Markdown.

        Returns
        -------
        str
        """
        lines = [f"# {self.heading}", "", f"**{self._score}**", ""]
        lines += [f"{_quoted(remark)}\n" for remark in self.remarks]
        for task, outcomes in self._by_task():
            earned = sum(o.earned for o in outcomes)
            lines += [f"## `{task}`: {earned:g} of {sum(o.points for o in outcomes):g}", ""]
            for o in outcomes:
                lines.append(f"- {MARKS[o.status]} **{o.earned:g}/{o.points:g}** {o.title}")
                lines += [f"    - {name}: {_quoted(value)}" for name, value in _details(o)]
            lines.append("")
        if self.printed:
            indented = "\n".join(f"    {line}" for line in self.printed.splitlines())
            lines += ["## What the code printed", "", indented, ""]
        return "\n".join(lines)

    def html(self):
        """The report as a part of an HTML page.

        Returns
        -------
        str
        """
        parts = [f"<h3>{_escaped(self.heading)}: {self._score}</h3>"]
        parts += [f"<p>{_escaped(remark)}</p>" for remark in self.remarks]
        for task, outcomes in self._by_task():
            parts.append(f"<p style='margin:.8em 0 .2em'><code>{_escaped(task)}</code></p>")
            parts += [_html_of(outcome) for outcome in outcomes]
        if self.printed:
            parts.append(f"<h4>What the code printed</h4><pre>{_escaped(self.printed)}</pre>")
        return "\n".join(parts)

    def page(self):
        """The report as an HTML page of its own.

        Returns
        -------
        str
        """
        return PAGE.substitute(title=_escaped(self.heading), body=self.html())

    def _by_task(self):
        tasks = dict.fromkeys(outcome.task for outcome in self.outcomes)
        return [(task, _told([o for o in self.outcomes if o.task == task])) for task in tasks]

    def __repr__(self):
        return self.text()

    def _repr_html_(self):
        return self.html()


def _told(outcomes):
    """A task's outcomes; one for all where the task is not done."""
    if {outcome.status for outcome in outcomes} != {"not done"}:
        return outcomes
    points = sum(outcome.points for outcome in outcomes)
    return [replace(outcomes[0], title=outcomes[0].hint, points=points, hint="")]


def _details(outcome):
    rows = ("expected", outcome.expected), ("got", outcome.came), ("hint", outcome.hint)
    return [(name, value) for name, value in rows if value]


def _html_of(outcome):
    colour = COLOURS[outcome.status]
    rows = "".join(
        f"<tr><td style='text-align:left'>{name}</td>"
        f"<td style='text-align:left'>{_with_code(value)}</td></tr>"
        for name, value in _details(outcome)
    )
    score = f"{MARKS[outcome.status]} {outcome.earned:g}/{outcome.points:g}"
    return (
        f"<div style='border-left:4px solid {colour};padding-left:.7em;margin:.3em 0'>"
        f"<b style='color:{colour}'>{score}</b> "
        f"{_with_code(outcome.title)}{f'<table>{rows}</table>' if rows else ''}</div>"
    )


def _escaped(text):
    return html.escape("".join(c for c in text if c.isprintable() or c in "\n\t"))


def _with_code(text):
    """HTML of a text in which names of functions stand between backquotes."""
    return re.sub("`([^`]*)`", r"<code>\1</code>", _escaped(text))


def _quoted(text):
    """Text with a student's words in it, so that it cannot be markup: one line, no HTML."""
    return _escaped(" ".join(text.split())).replace("|", "&#124;").replace("[", "&#91;")
