"""What each kind of finding does to the rest of the package, and what helps: text only.

The functions that it names come later in the order of the modules, so nothing
of them is imported here; a test looks each name up.
"""

from typing import NamedTuple


class Advice(NamedTuple):
    """What to know about a kind of finding."""

    affects: str
    """Which parts of the package it affects, and how."""
    remedy: str
    """What helps."""


ADVICE = {
    "unreferenced_vertices": Advice(
        "no flow or filter moves them; noise.gaussian and noise.uniform do, and metrics.snr "
        "counts them",
        "mesh.repair(V, F, unreferenced=True)",
    ),
    "duplicate_vertices": Advice(
        "they are no neighbours, so that weights and the flows made of them tear the surface open "
        "there; denoise, filters and noise move copies along a seam as one",
        "mesh.repair(V, F, weld=0), unless the cut is meant",
    ),
    "duplicate_faces": Advice(
        "the weights count a face once, but mesh.area, mesh.volume, mesh.vertex_normals, "
        "operators.mass and reference (libigl) count each duplicate",
        "mesh.repair(V, F, duplicates=True)",
    ),
    "degenerate_faces": Advice(
        "weights.cotangent leaves them out, with a warning; they have no normal for the normal "
        "filters and for metrics.normal_angle",
        "mesh.repair(V, F, weld=0, degenerate=True), or intrinsic.cotangent",
    ),
    "sliver_faces": Advice(
        "cotangents above 57 outweigh all other neighbours in weights.cotangent, and "
        "operators.diffusion needs tiny steps; face normals there are mostly noise",
        "intrinsic.cotangent, or weights.combinatorial",
    ),
    "nonmanifold_edges": Advice(
        "weights.cotangent sums the angles of all the faces; mesh.vertex_normals and the normal "
        "filters mix the sheets that meet there; mesh.volume means nothing",
        "mesh.repair(V, F, duplicates=True, split=True), or intrinsic.cotangent",
    ),
    "nonmanifold_vertices": Advice(
        "all weights connect surfaces that only touch there, and mesh.vertex_normals mixes them",
        "mesh.repair(V, F, split=True)",
    ),
    "inconsistent_edges": Advice(
        "mesh.vertex_normals cancel there, so noise.along_normals, the vertex and normal filters "
        "and mesh.volume are wrong; the weights do not depend on orientation",
        'mesh.repair(V, F, orient="consistent")',
    ),
    "nonorientable_faces": Advice(
        "normals must flip somewhere, so noise.along_normals, the normal filters and mesh.volume "
        "have no meaning; the weights and flows work",
        "use methods without normals, such as flow.heat",
    ),
    "inward_components": Advice(
        "the volume counts negative there, and normals point inwards: right for a cavity, wrong "
        "for a body",
        'mesh.repair(V, F, orient="outward") if it is a body',
    ),
    "boundary_edges": Advice(
        "flows draw the boundary inwards; weights.cotangent has one angle there; mesh.volume is "
        "that of a cone over the surface",
        "fixed=mesh.boundary_vertices(F) fixes it, operators.boundary_as_curve smooths it as a "
        "curve",
    ),
    "negative_weights": Advice(
        "weights.cotangent: averages leave the neighbours' hull, and flow.heat and flow.average "
        "can be unstable at tau = 1 (tau up to 2/3 is safe)",
        'weights.cotangent(V, F, negative="clamp"), or intrinsic.cotangent',
    ),
}
"""The advice on each of `meshfair.mesh.findings.KINDS`."""
