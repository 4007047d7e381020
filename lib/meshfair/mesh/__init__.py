"""What the other modules ask of a triangle mesh, and what is wrong with it.

``topology`` and ``geometry`` hold the facts, ``boundary`` what to do with an
open mesh's edge; ``inspection`` says what is wrong, in the words of
``findings``, ``cleaning`` mends it, and ``clustering`` does damage on purpose.
"""

from meshfair.mesh.boundary import boundary_as_curve, boundary_edges, boundary_vertices
from meshfair.mesh.cleaning import Cleaned, Step, clean
from meshfair.mesh.clustering import cluster
from meshfair.mesh.findings import Finding
from meshfair.mesh.geometry import (
    DEGENERATE,
    area,
    area_vectors,
    degenerate_faces,
    edge_lengths,
    face_areas,
    face_normals,
    mean_edge_length,
    scatter,
    vertex_normals,
    volume,
)
from meshfair.mesh.inspection import Inspection, inspect
from meshfair.mesh.topology import components, edges, half_edges, is_closed, unique_faces

__all__ = [
    "DEGENERATE",
    "Cleaned",
    "Finding",
    "Inspection",
    "Step",
    "area",
    "area_vectors",
    "boundary_as_curve",
    "boundary_edges",
    "boundary_vertices",
    "clean",
    "cluster",
    "components",
    "degenerate_faces",
    "edge_lengths",
    "edges",
    "face_areas",
    "face_normals",
    "half_edges",
    "inspect",
    "is_closed",
    "mean_edge_length",
    "scatter",
    "unique_faces",
    "vertex_normals",
    "volume",
]
