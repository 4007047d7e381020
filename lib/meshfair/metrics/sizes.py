"""Change of volume and area."""

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import Floats, Integers, MeshError, check_faces, check_same_vertices
from meshfair.mesh import area, half_edges, join, takes_meshes, volume


@takes_meshes
def volume_change(V: ArrayLike, V_true: ArrayLike, F: ArrayLike) -> float:
    """Relative change of the enclosed volume: -0.02 where two percent are lost.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    V_true : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
        Closed: what does not enclose a volume has none that could change.

    Returns
    -------
    float
        (volume - true volume) / |true volume|.

    Raises
    ------
    MeshError
        Arrays that do not fit together, an open mesh, faces turned against
        each other, or a ground truth of volume 0.
    """
    V, V_true = check_same_vertices(V, V_true, ("V", "V_true"))
    F = check_faces(F, len(V))
    return relative_volume(V, F, V_true, F)


@takes_meshes
def area_change(V: ArrayLike, V_true: ArrayLike, F: ArrayLike) -> float:
    """Relative change of the surface's area: 0.3 where noise has added thirty percent.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    V_true : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    float
        (area - true area) / true area.

    Raises
    ------
    MeshError
        Arrays that do not fit together, or a ground truth without area.
    """
    V, V_true = check_same_vertices(V, V_true, ("V", "V_true"))
    F = check_faces(F, len(V))
    return relative_area(V, F, V_true, F)


def relative_volume(V: Floats, F: Integers, V_true: Floats, F_true: Integers) -> float:
    """Change of volume from one mesh to another, each closed; see `volume_change`."""
    # A seam, where a surface has copies of its vertices, is no boundary.
    check_closed(join(V, F).F, "the mesh")
    check_closed(join(V_true, F_true).F, "the ground truth")
    # A closed surface has the same volume from any centre, but rounding leaves a little.
    true = volume(V_true, F_true)
    extent = np.ptp(V_true[F_true].reshape(-1, 3), axis=0).max()
    if abs(true) <= 1e-12 * extent**3:
        raise MeshError("the ground truth encloses no volume, so there is nothing to compare with")
    return (volume(V, F) - true) / abs(true)


def relative_area(V: Floats, F: Integers, V_true: Floats, F_true: Integers) -> float:
    """Change of area from one mesh to another; see `area_change`."""
    true = area(V_true, F_true)
    if true == 0:
        raise MeshError("the ground truth has no area, so there is nothing to compare with")
    return (area(V, F) - true) / true


def check_closed(F: Integers, name: str) -> None:
    """Refuse faces that enclose no volume.

    They do where each edge is run along as often one way as the other: no
    boundary, and neighbours of the same orientation.

    Parameters
    ----------
    F : ndarray of int64, shape (m, 3)
    name : str
        What the message calls the mesh.

    Raises
    ------
    MeshError
        How many edges are in the way, and which way.
    """
    ends = half_edges(F)
    i, j = ends.min(axis=1), ends.max(axis=1)
    _, edge, faces = np.unique(i * (F.max() + 1) + j, return_inverse=True, return_counts=True)
    # (A face that names a vertex twice has an edge of no length, which is no boundary.)
    turns = np.bincount(edge, np.sign(ends[:, 1] - ends[:, 0]))
    if odd := np.count_nonzero((turns != 0) & (faces % 2 == 1)):
        raise MeshError(f"{name} is open: {odd} edges are on its boundary, so it has no volume")
    if turned := np.count_nonzero(turns):
        raise MeshError(
            f"{name} has faces turned against each other at {turned} edges, so it has no volume; "
            'orient it by mesh.repair(V, F, orient="outward")'
        )
