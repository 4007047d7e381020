"""What the other modules ask of a triangle mesh, and what is wrong with it.

``elements`` holds the one structure of a mesh's edges and the one measure of its
triangles; ``topology``, ``geometry``, ``boundary`` and ``dihedral`` hold the facts,
``ordering`` the numbering of vertices; ``inspection`` says what is wrong, in the words
of ``findings``, and ``report`` shows it with the ``advice`` on it; ``repair`` repairs
it, ``joining`` joins for the time of some work what lies together, and ``clustering``
does damage on purpose. ``objects`` takes the meshes of other libraries.
"""

from meshfair.mesh.boundary import boundary_edges, boundary_vertices
from meshfair.mesh.clustering import cluster
from meshfair.mesh.dihedral import InteriorEdges, dihedral_angles, interior_edges
from meshfair.mesh.duplicates import unique_faces
from meshfair.mesh.elements import Edges, Triangles, half_edges, normalised
from meshfair.mesh.findings import Finding
from meshfair.mesh.geometry import (
    area,
    degenerate_faces,
    edge_lengths,
    face_areas,
    face_normals,
    face_shapes,
    mean_edge_length,
    scatter,
    vertex_normals,
    volume,
)
from meshfair.mesh.inspection import inspect
from meshfair.mesh.joining import Joined, join
from meshfair.mesh.objects import arrays, moved, takes_meshes
from meshfair.mesh.ordering import reorder, restore_order
from meshfair.mesh.repair import Repaired, Step, repair
from meshfair.mesh.report import Inspection
from meshfair.mesh.topology import components, is_closed

__all__ = [
    "Edges",
    "Finding",
    "Inspection",
    "InteriorEdges",
    "Joined",
    "Repaired",
    "Step",
    "Triangles",
    "area",
    "arrays",
    "boundary_edges",
    "boundary_vertices",
    "cluster",
    "components",
    "degenerate_faces",
    "dihedral_angles",
    "edge_lengths",
    "face_areas",
    "face_normals",
    "face_shapes",
    "half_edges",
    "inspect",
    "interior_edges",
    "is_closed",
    "join",
    "mean_edge_length",
    "moved",
    "normalised",
    "reorder",
    "repair",
    "restore_order",
    "scatter",
    "takes_meshes",
    "unique_faces",
    "vertex_normals",
    "volume",
]
