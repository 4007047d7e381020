"""Find out what a mesh is, and what is wrong with it."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from meshfair.checks import Floats, Integers, check_mesh
from meshfair.mesh.duplicates import duplicate_faces, duplicate_rows
from meshfair.mesh.elements import Edges, Triangles
from meshfair.mesh.findings import KINDS, SLIVER, Finding
from meshfair.mesh.objects import takes_meshes
from meshfair.mesh.report import Inspection
from meshfair.mesh.topology import (
    boundary_loops,
    fans,
    half_edge_pairs,
    interior_manifold_pairs,
    number_components,
    orientation,
    referenced,
    topologically_degenerate,
)

SLIVER_COTANGENT = 1 / np.tan(np.radians(SLIVER))
# Rounding makes weights of +-1e-16 where two angles sum to 180 degrees, as on a grid.
NEGATIVE = -1e-10


@takes_meshes
def inspect(V: ArrayLike, F: ArrayLike) -> Inspection:
    """Find out what a mesh is, and what is wrong with it.

    Nothing is changed; `repair` repairs what can be repaired.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    Inspection
        Shows itself as text (``print``) and in a notebook, with the parts of the
        package that each finding affects, and what helps; ``as_dict()`` is ready
        for JSON. Each of its ``findings`` has all its indices.

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
    used, duplicate = referenced(F, len(V)), duplicate_faces(F)
    triangles = Triangles(V, F)
    where = {
        "unreferenced_vertices": np.flatnonzero(~used),
        "duplicate_vertices": np.flatnonzero(used)[duplicate_rows(V[used])],
        "duplicate_faces": np.flatnonzero(duplicate),
        "degenerate_faces": np.flatnonzero(triangles.degenerate),
        "sliver_faces": np.flatnonzero((triangles.cotangents > SLIVER_COTANGENT).any(axis=0)),
    }
    # The surface: all faces but those that name a vertex twice.
    on_surface = np.flatnonzero(~topologically_degenerate(F))
    T, cotangents = F, triangles.cotangents
    if len(on_surface) < len(F):
        T, cotangents = F[on_surface], cotangents[:, on_surface]
    edges = Edges.of_all(T, len(V))
    lengths = edges.lengths(V)
    topology, found = _topology(V, T, edges)
    where |= found
    where["nonorientable_faces"] = on_surface[where["nonorientable_faces"]]
    # The weights as `weights.cotangent` has them, where a duplicate face counts once.
    negative = edges.sums(np.where(duplicate[on_surface], 0, cotangents)) / 2 < NEGATIVE
    where["negative_weights"] = edges.ends[negative]
    smallest, largest = _extreme_angles(triangles)
    x, y, z = np.ptp(V, axis=0).tolist()
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
        size=(x, y, z),
        findings=tuple(Finding(kind, where[kind]) for kind in KINDS if len(where[kind])),
    )


def _topology(V: Floats, F: Integers, edges: Edges) -> tuple[dict[str, Any], dict[str, Integers]]:
    """What the faces' connections tell: fields of `Inspection`, and indices by kind."""
    faces_of_edge = edges.faces_of_edge
    count, component = number_components(F, len(V))
    pairs = half_edge_pairs(F, edges)
    corner_fans = fans(F, pairs)
    loops = boundary_loops(edges, corner_fans)
    touching = _fans_of_vertices(F, corner_fans, len(V)) > 1
    manifold = not (touching.any() or (faces_of_edge > 2).any())

    pairs = interior_manifold_pairs(pairs, edges)
    against = pairs.edge[~pairs.opposed]
    nonorientable = np.zeros(len(F), dtype=bool)
    if len(against):
        nonorientable = orientation(F, pairs).nonorientable
    orientable = not nonorientable.any()
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
        "nonorientable_faces": np.flatnonzero(nonorientable),
        "inward_components": np.flatnonzero(volumes < 0),
        "boundary_edges": edges.ends[faces_of_edge == 1],
    }


def _fans_of_vertices(F: Integers, corner_fans: NDArray[np.int32], n: int) -> Integers:
    """How many fans of faces each vertex has; shape (n,)."""
    vertex = np.empty(corner_fans.max(initial=-1) + 1, dtype=np.int64)
    vertex[corner_fans] = F.T  # all corners of a fan are at one vertex
    return np.bincount(vertex, minlength=n)


def _cone_volumes(V: Floats, F: Integers) -> Floats:
    """Signed volumes of the cones from the vertices' centre over the faces; shape (m,)."""
    X = V - np.array([x.mean() for x in V.T])
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = (np.take(X, F[:, k], axis=0).T for k in range(3))
    determinant = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    return determinant / 6


def _extreme_angles(triangles: Triangles) -> tuple[float, float] | tuple[None, None]:
    """The smallest and the largest angle in degrees; None where no face has angles."""
    flat, cotangents = triangles.degenerate, triangles.cotangents
    if flat.all():
        return None, None
    if flat.any():
        cotangents = cotangents[:, ~flat]
    smallest, largest = np.degrees(np.arctan2(1, [cotangents.max(), cotangents.min()])).tolist()
    return smallest, largest
