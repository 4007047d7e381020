"""Say what a mesh is, what is wrong with it, and what that does to the package."""

from dataclasses import dataclass, fields
from html import escape
from textwrap import fill

import numpy as np

from meshfair.checks import check_mesh
from meshfair.mesh.duplicates import repeated_faces, repeated_rows
from meshfair.mesh.edges import Edges
from meshfair.mesh.findings import KINDS, SLIVER, Finding
from meshfair.mesh.geometry import Triangles
from meshfair.mesh.topology import (
    across_two_faces,
    boundary_loops,
    collapsed_faces,
    fans,
    neighbours,
    number_components,
    orientation,
    referenced,
)

SLIVER_COTANGENT = 1 / np.tan(np.radians(SLIVER))
# Rounding makes weights of +-1e-16 where two angles sum to 180 degrees, as on a grid.
NEGATIVE = -1e-10


@dataclass(frozen=True, eq=False)
class Inspection:
    """What `inspect` found; print it, or let a notebook show it."""

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
    """Two faces at each edge, counted as they are stored: repeated ones too, here
    and in the findings on edges. Clean them away and look again."""
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
    def ok(self):
        """Whether there is no problem, only things that are good to know."""
        return not any(finding.problem for finding in self.findings)

    @property
    def counts(self):
        """How many there are of each of `KINDS`, as a dictionary."""
        return dict.fromkeys(KINDS, 0) | {found.kind: len(found.where) for found in self.findings}

    def as_dict(self):
        """The inspection as numbers, texts, lists and dictionaries, ready for JSON."""
        facts = {field.name: getattr(self, field.name) for field in fields(self)}
        return facts | {
            "size": list(self.size),
            "ok": self.ok,
            "counts": self.counts,
            "findings": [finding.as_dict() for finding in self.findings],
        }

    def _facts(self):
        """Rows of name and value, for text and HTML."""
        yes = {True: "yes", False: "no"}
        angles = "none, all faces are degenerate"
        if self.smallest_angle is not None:
            angles = f"{self.smallest_angle:.3g} to {self.largest_angle:.4g} degrees"
        return [
            ("vertices", f"{self.vertices:,}"),
            ("faces", f"{self.faces:,}"),
            ("edges", f"{self.edges:,}, mean length {self.mean_edge_length:.4g}"),
            ("size", " x ".join(f"{length:.4g}" for length in self.size)),
            ("area", f"{self.area:.6g}"),
            ("components", f"{self.components:,}"),
            ("closed", yes[self.closed]),
            ("boundary loops", f"{self.boundary_loops:,}"),
            ("manifold", yes[self.manifold]),
            ("orientable", yes[self.orientable]),
            ("genus", "none" if self.genus is None else f"{self.genus:,}"),
            ("Euler characteristic", f"{self.euler_characteristic:,}"),
            ("angles", angles),
            ("negative cotangent weights", f"{100 * self.negative_weights:.3g} % of the edges"),
        ]

    def _verdict(self):
        problems = sum(finding.problem for finding in self.findings)
        return f"{problems or 'no'} problem{'' if problems == 1 else 's'} found"

    def __str__(self):
        width = max(len(name) for name, _ in self._facts())
        lines = [f"{name:<{width}}  {value}" for name, value in self._facts()]
        lines += ["", self._verdict()]
        for finding in self.findings:
            label = "problem" if finding.problem else "note"
            lines += [
                f"{label}: {finding}",
                _wrapped("  affects: ", finding.affects),
                _wrapped("  helps:   ", finding.remedy),
            ]
        return "\n".join(lines)

    def _repr_html_(self):
        """The same for a notebook, in the colours of its theme, light or dark."""
        rule = "border-bottom: 1px solid rgba(128, 128, 128, 0.4)"
        cell = f"text-align: left; vertical-align: top; {rule}"
        facts = "".join(
            f'<tr><th style="{cell}">{name}</th><td style="{cell}">{escape(value)}</td></tr>'
            for name, value in self._facts()
        )
        found = "".join(
            f'<tr><td style="{cell}"><b>{"problem" if finding.problem else "note"}</b></td>'
            f'<td style="{cell}">{escape(str(finding))}</td>'
            f'<td style="{cell}">{escape(finding.affects)}</td>'
            f'<td style="{cell}"><code>{escape(finding.remedy)}</code></td></tr>'
            for finding in self.findings
        )
        heads = "".join(
            f'<th style="{cell}">{name}</th>' for name in ("", "found", "affects", "helps")
        )
        table = '<table style="color: inherit; background: transparent">'
        html = f"{table}<tbody>{facts}</tbody></table><p><b>{self._verdict()}</b></p>"
        if found:
            html += f"{table}<thead><tr>{heads}</tr></thead><tbody>{found}</tbody></table>"
        return f"<div>{html}</div>"


def _wrapped(label, text):
    return fill(text, 88, initial_indent=label, subsequent_indent=" " * len(label))


def inspect(V, F):
    """Say what a mesh is, and what is wrong with it.

    Nothing is changed; `repair` mends what can be mended.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    Inspection
        Shows itself as text (``print``) and in a notebook; ``as_dict()`` is
        ready for JSON. Each of its ``findings`` has all its places, the parts
        of the package that it affects, and what helps.

    Raises
    ------
    MeshError
        No mesh: see `meshfair.checks.check_mesh`.

    Examples
    --------
    >>> V, F = shapes.knot()
    >>> mesh.inspect(V, F).genus
    1
    """
    V, F = check_mesh(V, F)
    used, repeated = referenced(F, len(V)), repeated_faces(F)
    triangles = Triangles(V, F)
    places = {
        "unreferenced_vertices": np.flatnonzero(~used),
        "duplicate_vertices": np.flatnonzero(used)[_repeated(V[used])],
        "duplicate_faces": np.flatnonzero(repeated),
        "degenerate_faces": np.flatnonzero(triangles.degenerate),
        "sliver_faces": np.flatnonzero((triangles.cotangents > SLIVER_COTANGENT).any(axis=0)),
    }
    # The surface, as it is stored, but without faces that name a vertex twice.
    on_surface = np.flatnonzero(~collapsed_faces(F))
    T, cotangents = F, triangles.cotangents
    if len(on_surface) < len(F):
        T, cotangents = F[on_surface], cotangents[:, on_surface]
    edges = Edges.of_all(T, len(V))
    lengths = edges.lengths(V)
    topology, found = _topology(V, T, edges)
    places |= found
    places["one_sided_faces"] = on_surface[places["one_sided_faces"]]
    # The weights as `weights.cotangent` has them, where a duplicate face counts once.
    negative = edges.sums(np.where(repeated[on_surface], 0, cotangents)) / 2 < NEGATIVE
    places["negative_weights"] = edges.ends[negative]
    smallest, largest = _extreme_angles(triangles)
    return Inspection(
        vertices=len(V),
        faces=len(F),
        edges=len(lengths),
        **topology,
        smallest_angle=smallest,
        largest_angle=largest,
        negative_weights=float(negative.mean()) if len(negative) else 0.0,
        mean_edge_length=float(lengths.mean()) if len(lengths) else 0.0,
        area=float(triangles.doubled_area.sum() / 2),
        size=tuple(float(np.ptp(x)) for x in V.T),
        findings=tuple(Finding(kind, places[kind]) for kind in KINDS if len(places[kind])),
    )


def _repeated(rows):
    return repeated_rows(rows) != np.arange(len(rows))


def _topology(V, F, edges):
    """What the faces' connections tell: fields of `Inspection`, and places by kind."""
    faces_of_edge = edges.faces_of_edge
    count, component = number_components(F, len(V))
    pairs = neighbours(F, edges)
    corner_fans = fans(F, pairs)
    loops = boundary_loops(edges, corner_fans)
    touching = _fans_of_vertices(F, corner_fans, len(V)) > 1
    manifold = not (touching.any() or (faces_of_edge > 2).any())

    pairs = across_two_faces(pairs, edges)
    against = pairs.edge[~pairs.opposed]
    one_sided = orientation(F, pairs).one_sided if len(against) else np.zeros(len(F), dtype=bool)
    orientable = not one_sided.any()
    # Euler's formula: vertices - edges + faces = 2 components - 2 genus - loops.
    euler = int(referenced(F, len(V)).sum()) - len(edges.ends) + len(F)
    genus = (2 * count - loops - euler) // 2 if manifold and orientable else None

    leaky = faces_of_edge != 2
    leaky[against] = True
    volumes = np.bincount(component[F[:, 0]], _cone_volumes(V, F), minlength=count)
    volumes[component[edges.ends[leaky, 0]]] = 0
    facts = {
        "components": count,
        "boundary_loops": loops,
        "genus": genus,
        "euler_characteristic": euler,
        "closed": bool(len(F) and (faces_of_edge == 2).all()),
        "manifold": manifold,
        "orientable": orientable,
    }
    return facts, {
        "nonmanifold_edges": edges.ends[faces_of_edge > 2],
        "nonmanifold_vertices": np.flatnonzero(touching),
        "inconsistent_edges": edges.ends[against],
        "one_sided_faces": np.flatnonzero(one_sided),
        "inward_components": np.flatnonzero(volumes < 0),
        "boundary_edges": edges.ends[faces_of_edge == 1],
    }


def _fans_of_vertices(F, corner_fans, n):
    """How many fans of faces each vertex has; shape (n,)."""
    vertex = np.empty(corner_fans.max(initial=-1) + 1, dtype=np.int64)
    vertex[corner_fans] = F.T  # all corners of a fan are at one vertex
    return np.bincount(vertex, minlength=n)


def _cone_volumes(V, F):
    """Signed volumes of the cones from the vertices' centre over the faces; shape (m,)."""
    X = V - np.array([x.mean() for x in V.T])
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (np.take(X, F[:, k], axis=0).T for k in range(3))
    determinant = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return determinant / 6


def _extreme_angles(triangles):
    """The smallest and the largest angle in degrees; None where no face has angles."""
    flat, cotangents = triangles.degenerate, triangles.cotangents
    if flat.all():
        return None, None
    if flat.any():
        cotangents = cotangents[:, ~flat]
    return np.degrees(np.arctan2(1, [cotangents.max(), cotangents.min()])).tolist()
