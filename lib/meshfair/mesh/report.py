"""What `inspect` found, and how it is reported: as text, in a notebook, as JSON."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from html import escape
from textwrap import fill
from typing import Any

from meshfair.mesh.advice import ADVICE
from meshfair.mesh.findings import KINDS, SHOWN, Finding


@dataclass(frozen=True, eq=False)
class Inspection:
    """What `inspect` found; print it, or let a notebook show it.

    Each finding is shown with the `meshfair.mesh.advice` on its kind: what it
    affects, and what helps.
    """

    vertices: int
    faces: int
    edges: int
    """Faces that name a vertex twice have none, here and in all that follows."""
    components: int
    boundary_loops: int
    genus: int | None
    """Number of handles, over all components; None where the surface is not an
    orientable manifold, so that it has no such number."""
    euler_characteristic: int
    """Vertices with faces, minus edges, plus faces."""
    closed: bool
    """Two faces at each edge. Duplicate faces count each, here and in the findings
    on edges: drop them and inspect again."""
    manifold: bool
    """At most two faces at each edge, and one fan of faces at each vertex."""
    orientable: bool
    smallest_angle: float | None
    """In degrees, over the faces that are not degenerate; None if all are."""
    largest_angle: float | None
    negative_weights: float
    """Share of the edges whose cotangent weight is negative, 0 to 1."""
    mean_edge_length: float
    """In the units of the vertices; the package's unit of noise."""
    area: float
    """Of all faces, in the squared units of the vertices."""
    size: tuple[float, float, float]
    """Of the bounding box, in the units of the vertices."""
    findings: tuple[Finding, ...]
    """What there is to know, see `KINDS`; nothing that was not found."""

    @property
    def ok(self) -> bool:
        """Whether there is no problem, only things that are good to know."""
        return not any(finding.problem for finding in self.findings)

    @property
    def counts(self) -> dict[str, int]:
        """How many there are of each of `KINDS`."""
        return dict.fromkeys(KINDS, 0) | {found.kind: len(found.where) for found in self.findings}

    def as_dict(self) -> dict[str, Any]:
        """The inspection as numbers, texts, lists and dictionaries, ready for JSON.

        Returns
        -------
        dict
        """
        facts = {field.name: getattr(self, field.name) for field in fields(self)}
        return facts | {
            "size": list(self.size),
            "ok": self.ok,
            "counts": self.counts,
            "findings": [_finding_as_dict(finding) for finding in self.findings],
        }

    def as_text(self, words: Callable[[str], str] = str, width: int = 88) -> str:
        """The facts in two columns, then each finding with its advice.

        Parameters
        ----------
        words : function, optional
            From the advice as the package gives it, in Python, to other words.
        width : int
            Of the lines of findings and advice.

        Returns
        -------
        str
        """
        return _text(self, words, width)

    def __str__(self) -> str:
        return self.as_text()

    def _repr_html_(self) -> str:
        return _html(self)


def _finding_as_dict(finding: Finding) -> dict[str, Any]:
    """What JSON can hold of a finding: everything, but only the first few indices."""
    return {
        "kind": finding.kind,
        "problem": finding.problem,
        "count": len(finding.where),
        "first": finding.where[:SHOWN].tolist(),
        **ADVICE[finding.kind]._asdict(),
    }


def _facts(inspection: Inspection) -> list[tuple[str, str]]:
    """Rows of name and value, for text and HTML."""
    yes = {True: "yes", False: "no"}
    angles = "none, all faces are degenerate"
    if inspection.smallest_angle is not None:
        angles = f"{inspection.smallest_angle:.3g} to {inspection.largest_angle:.4g} degrees"
    edges = f"{inspection.edges:,}, mean length {inspection.mean_edge_length:.4g}"
    negative = f"{100 * inspection.negative_weights:.3g} % of the edges"
    return [
        ("vertices", f"{inspection.vertices:,}"),
        ("faces", f"{inspection.faces:,}"),
        ("edges", edges),
        ("size", " x ".join(f"{length:.4g}" for length in inspection.size)),
        ("area", f"{inspection.area:.6g}"),
        ("components", f"{inspection.components:,}"),
        ("closed", yes[inspection.closed]),
        ("boundary loops", f"{inspection.boundary_loops:,}"),
        ("manifold", yes[inspection.manifold]),
        ("orientable", yes[inspection.orientable]),
        ("genus", "none" if inspection.genus is None else f"{inspection.genus:,}"),
        ("Euler characteristic", f"{inspection.euler_characteristic:,}"),
        ("angles", angles),
        ("negative cotangent weights", negative),
    ]


def _verdict(inspection: Inspection) -> str:
    problems = sum(finding.problem for finding in inspection.findings)
    return f"{problems or 'no'} problem{'' if problems == 1 else 's'} found"


def _label(finding: Finding) -> str:
    return "problem" if finding.problem else "note"


def _text(inspection: Inspection, words: Callable[[str], str], width: int) -> str:
    facts = _facts(inspection)
    column = max(len(name) for name, _ in facts)
    lines = [f"{name:<{column}}  {value}" for name, value in facts]
    lines += ["", _verdict(inspection)]
    for finding in inspection.findings:
        affects, remedy = ADVICE[finding.kind]
        lines += [
            _wrapped(f"{_label(finding)}: ", str(finding), width),
            _wrapped("  affects: ", words(affects), width),
            _wrapped("  helps:   ", words(remedy), width),
        ]
    return "\n".join(lines)


def _wrapped(label: str, text: str, width: int) -> str:
    """Lines of this width; what is to be typed, such as --fix-boundary, stays whole."""
    return fill(
        text,
        width,
        initial_indent=label,
        subsequent_indent=" " * len(label),
        break_long_words=False,
        break_on_hyphens=False,
    )


def _html(inspection: Inspection) -> str:
    """The same for a notebook, in the colours of its theme, light or dark."""
    rule = "border-bottom: 1px solid rgba(128, 128, 128, 0.4)"
    style = f'style="text-align: left; vertical-align: top; {rule}"'
    table = '<table style="color: inherit; background: transparent">'

    def row(*cells: str) -> str:
        return f"<tr>{''.join(f'<td {style}>{cell}</td>' for cell in cells)}</tr>"

    facts = "".join(
        f"<tr><th {style}>{name}</th><td {style}>{escape(value)}</td></tr>"
        for name, value in _facts(inspection)
    )
    html = f"{table}<tbody>{facts}</tbody></table><p><b>{_verdict(inspection)}</b></p>"
    if inspection.findings:
        heads = "".join(f"<th {style}>{name}</th>" for name in ("", "found", "affects", "helps"))
        found = "".join(
            row(
                f"<b>{_label(finding)}</b>",
                escape(str(finding)),
                escape(ADVICE[finding.kind].affects),
                f"<code>{escape(ADVICE[finding.kind].remedy)}</code>",
            )
            for finding in inspection.findings
        )
        html += f"{table}<thead><tr>{heads}</tr></thead><tbody>{found}</tbody></table>"
    return f"<div>{html}</div>"
