"""What there is to find in a mesh, which parts of the package it affects, and what helps."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

SLIVER = 1.0  # degrees: a smaller angle has a cotangent above 57
SHOWN = 5  # how many of the places of a finding are printed


class Kind(NamedTuple):
    """A kind of finding: what the package's parts make of it, and what helps."""

    problem: bool
    """Whether results are wrong or worse; else it is only good to know."""
    title: str
    places: str
    """What the indices of its places are: vertex, face, edge or component."""
    affects: str
    remedy: str


KINDS = {
    "unreferenced_vertices": Kind(
        False,
        "unreferenced vertices",
        "vertex",
        "no flow or filter moves them; noise.gaussian and noise.uniform do, and metrics.snr "
        "counts them",
        "mesh.repair(V, F, unreferenced=True)",
    ),
    "duplicate_vertices": Kind(
        True,
        "vertices in the place of another",
        "vertex",
        "they are no neighbours, so the surface is cut there: noise and every flow tear it open",
        "mesh.repair(V, F, weld=0), unless the cut is meant",
    ),
    "duplicate_faces": Kind(
        True,
        "faces stored again",
        "face",
        "the weights count a face once, but mesh.area, mesh.volume, mesh.vertex_normals, "
        "operators.mass and reference (libigl) as often as it is stored",
        "mesh.repair(V, F, duplicates=True)",
    ),
    "degenerate_faces": Kind(
        True,
        "degenerate faces, without area",
        "face",
        "weights.cotangent leaves them out, with a warning; they have no normal for the normal "
        "filters and for metrics.normal_angle",
        "mesh.repair(V, F, weld=0, degenerate=True), or intrinsic.cotangent",
    ),
    "sliver_faces": Kind(
        False,
        f"slivers, with an angle below {SLIVER:g} degree",
        "face",
        "cotangents above 57 outweigh all other neighbours in weights.cotangent, and "
        "operators.diffusion needs tiny steps; face normals there are mostly noise",
        "intrinsic.cotangent, or weights.combinatorial",
    ),
    "nonmanifold_edges": Kind(
        True,
        "non-manifold edges, of more than two faces",
        "edge",
        "weights.cotangent sums the angles of all the faces; mesh.vertex_normals and the normal "
        "filters mix the sheets that meet there; mesh.volume means nothing",
        "mesh.repair(V, F, duplicates=True, split=True), or intrinsic.cotangent",
    ),
    "nonmanifold_vertices": Kind(
        True,
        "non-manifold vertices, with more than one fan of faces",
        "vertex",
        "all weights join surfaces that only touch there, and mesh.vertex_normals mixes them",
        "mesh.repair(V, F, split=True)",
    ),
    "inconsistent_edges": Kind(
        True,
        "edges whose two faces are turned against each other",
        "edge",
        "mesh.vertex_normals cancel there, so noise.along_normals, the vertex and normal filters "
        "and mesh.volume are wrong; the weights do not depend on orientation",
        'mesh.repair(V, F, orient="consistent")',
    ),
    "one_sided_faces": Kind(
        True,
        "faces of one-sided surfaces, which have no orientation",
        "face",
        "normals must flip somewhere, so noise.along_normals, the normal filters and mesh.volume "
        "have no meaning; the weights and flows work",
        "use methods without normals, such as flow.heat",
    ),
    "inward_components": Kind(
        False,
        "closed components with their faces inwards",
        "component",
        "the volume counts negative there, and normals point inwards: right for a cavity, wrong "
        "for a body",
        'mesh.repair(V, F, orient="outward") if it is a body',
    ),
    "boundary_edges": Kind(
        False,
        "boundary edges, of one face",
        "edge",
        "flows draw the boundary inwards; weights.cotangent has one angle there; mesh.volume is "
        "that of a cone over the surface",
        "fixed=mesh.boundary_vertices(F) fixes it, operators.boundary_as_curve smooths it as a "
        "curve",
    ),
    "negative_weights": Kind(
        False,
        "edges with negative cotangent weight",
        "edge",
        "weights.cotangent: averages leave the neighbours' hull, and flow.heat and flow.average "
        "can be unstable at tau = 1 (tau up to 2/3 is safe)",
        'weights.cotangent(V, F, negative="clamp"), or intrinsic.cotangent',
    ),
}


@dataclass(frozen=True, eq=False)
class Finding:
    """One thing about a mesh that a user should know."""

    kind: str
    """Its name in `KINDS`, which is also the name of its count in `Inspection`."""
    where: np.ndarray
    """All places: indices of vertices, faces or components, or edges as rows (i, j)."""

    @property
    def problem(self):
        """Whether results are wrong or worse; else it is only good to know."""
        return KINDS[self.kind].problem

    @property
    def affects(self):
        """Which parts of the package it affects, and how."""
        return KINDS[self.kind].affects

    @property
    def remedy(self):
        """What helps."""
        return KINDS[self.kind].remedy

    def __str__(self):
        """One line: what, how many, and the first places."""
        kind = KINDS[self.kind]
        first = ", ".join(_place(place) for place in self.where[:SHOWN].tolist())
        more = ", ..." if len(self.where) > SHOWN else ""
        return f"{kind.title}: {len(self.where):,} ({kind.places} {first}{more})"

    def as_dict(self):
        """What JSON can hold of it: everything, but only the first few places."""
        return {
            "kind": self.kind,
            "problem": self.problem,
            "count": len(self.where),
            "first": self.where[:SHOWN].tolist(),
            "affects": self.affects,
            "remedy": self.remedy,
        }


def _place(place):
    """An index as it is, an edge as (i, j)."""
    return f"({place[0]}, {place[1]})" if isinstance(place, list) else str(place)
