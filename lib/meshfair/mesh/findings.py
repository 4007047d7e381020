"""The kinds of things that `inspect` can find in a mesh, and one such finding."""

from dataclasses import dataclass
from typing import Any, NamedTuple

from meshfair.checks import Integers

SLIVER = 1.0  # degrees: a smaller angle has a cotangent above 57
SHOWN = 5  # how many of a finding's indices are printed


class Kind(NamedTuple):
    """A kind of finding; `meshfair.mesh.advice` says what it affects, and what helps."""

    problem: bool
    """Whether results are wrong or worse; else it is only good to know."""
    title: str
    element: str
    """What its indices count: vertex, face, edge or component."""


KINDS = {
    "unreferenced_vertices": Kind(False, "unreferenced vertices", "vertex"),
    "duplicate_vertices": Kind(True, "duplicate vertices, in the place of another", "vertex"),
    "duplicate_faces": Kind(True, "duplicate faces, of the same three vertices", "face"),
    "degenerate_faces": Kind(True, "degenerate faces, without area", "face"),
    "sliver_faces": Kind(False, f"slivers, with an angle below {SLIVER:g} degree", "face"),
    "nonmanifold_edges": Kind(True, "non-manifold edges, of more than two faces", "edge"),
    "nonmanifold_vertices": Kind(
        True, "non-manifold vertices, with more than one fan of faces", "vertex"
    ),
    "inconsistent_edges": Kind(True, "edges whose two faces have opposite orientations", "edge"),
    "nonorientable_faces": Kind(
        True, "faces of non-orientable surfaces, which have one side only", "face"
    ),
    "inward_components": Kind(False, "closed components with their faces inwards", "component"),
    "boundary_edges": Kind(False, "boundary edges, of one face", "edge"),
    "negative_weights": Kind(False, "edges with negative cotangent weight", "edge"),
}


@dataclass(frozen=True, eq=False)
class Finding:
    """One thing about a mesh that a user should know."""

    kind: str
    """Its name in `KINDS`, which is also the name of its count in `Inspection`."""
    where: Integers
    """All indices of vertices, faces or components, or edges as rows (i, j)."""

    @property
    def problem(self) -> bool:
        """Whether results are wrong or worse; else it is only good to know."""
        return KINDS[self.kind].problem

    def __str__(self) -> str:
        """One line: what, how many, and the first indices."""
        kind = KINDS[self.kind]
        first = ", ".join(_index(index) for index in self.where[:SHOWN].tolist())
        more = ", ..." if len(self.where) > SHOWN else ""
        return f"{kind.title}: {len(self.where):,} ({kind.element} {first}{more})"


def _index(index: Any) -> str:
    """An index as it is, an edge as (i, j)."""
    return f"({index[0]}, {index[1]})" if isinstance(index, list) else str(index)
