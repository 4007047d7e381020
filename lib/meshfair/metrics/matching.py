"""Which vertices of two meshes are the same."""

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import Floats, Integers, MeshError, check_mesh
from meshfair.mesh import takes_meshes


@takes_meshes
def matched(V: ArrayLike, F: ArrayLike, V_true: ArrayLike, F_true: ArrayLike) -> Floats:
    """The ground truth's vertices in the order of a mesh's own.

    Vertices are the same where the faces say so: all faces of one mesh are, in
    any order, those of the other. Where the vertices are numbered differently, a
    face whose corners are nearest to those of a true face is taken for it, and
    from there the others follow, neighbour by neighbour. That is accepted only
    where it carries all faces over, and most vertices to the nearest one.
    Vertices that no face uses play no part.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        The noisy or denoised mesh.
    F : array_like of integers, shape (m, 3)
    V_true : array_like, shape (n_true, 3)
    F_true : array_like of integers, shape (m_true, 3)

    Returns
    -------
    ndarray of float64, shape (n, 3)
        To compare row by row with ``V``, such as the ground truth of
        `meshfair.denoise`. A vertex that no face uses is where ``V`` has it.

    Raises
    ------
    MeshError
        One of the two is no mesh, or they are not the same mesh; the message says why.
    """
    V, F = check_mesh(V, F)
    V_true, F_true = check_mesh(V_true, F_true)
    used, faces = compact(F)
    used_true, faces_true = compact(F_true)
    found = V.copy()
    found[used] = V_true[used_true[same_vertices(V[used], faces, V_true[used_true], faces_true)]]
    return found


def compact(F: Integers) -> tuple[Integers, Integers]:
    """The vertices that the faces use, in rising order, and the faces numbered by these."""
    used, corners = np.unique(F, return_inverse=True)
    return used, corners.reshape(F.shape)


def same_vertices(V: Floats, F: Integers, V_true: Floats, F_true: Integers) -> Integers:
    """For each vertex of a mesh its row in the ground truth; no mesh has unused vertices.

    Returns
    -------
    ndarray of int64, shape (n,)

    Raises
    ------
    MeshError
        They are not the same mesh; the message says why.
    """
    for name, count, count_true in (
        ("vertices", len(V), len(V_true)), ("faces", len(F), len(F_true)),
    ):  # fmt: skip
        if count != count_true:
            raise MeshError(
                f"the meshes have {count} and {count_true} {name}, and only where their faces are "
                "the same can it be told which vertex is which"
            )
    true = _in_order(F_true)
    rows = np.arange(len(V))
    if np.array_equal(_in_order(F), true):
        return rows
    renumbered = _renumbered(V, F, V_true, F_true)
    if renumbered is not None and np.array_equal(_in_order(renumbered[F]), true):
        return renumbered
    raise MeshError(
        "the meshes have other faces, and only where their faces are the same can it be told "
        "which vertex is which; if it is the numbering alone, number the vertices of both alike"
    )


def _renumbered(V: Floats, F: Integers, V_true: Floats, F_true: Integers) -> Integers | None:
    """The true row of each vertex, where neighbours lead to it; None where they do not."""
    from scipy.spatial import cKDTree

    distance, nearest = cKDTree(V_true).query(V)
    facing, facing_true = _facing(F), _facing(F_true)
    if min(len(facing), len(facing_true)) < 3 * len(F):
        return None  # an edge is run along twice the same way: nobody knows what follows
    rows = np.full(len(V), -1)
    for i, j, k in F[np.argsort(distance[F].sum(axis=1), kind="stable")].tolist():
        seed = nearest[[i, j, k]].tolist()
        if rows[i] >= 0 or facing_true.get((seed[0], seed[1])) != seed[2]:
            continue
        rows[[i, j, k]] = seed
        ahead = [(j, i), (k, j), (i, k)]  # edges of the faces beyond
        while ahead:
            a, b = ahead.pop()
            corner = facing.pop((a, b), None)
            if corner is None:
                continue  # the boundary, or seen already
            place = facing_true.get((int(rows[a]), int(rows[b])))
            if place is None or rows[corner] not in (-1, place):
                return None
            rows[corner] = place
            ahead += [(corner, b), (a, corner)]
    believed = rows.min() >= 0 and np.count_nonzero(rows == nearest) > len(V) / 2
    return rows if believed else None


def _facing(F: Integers) -> dict[tuple[int, int], int]:
    """The corner of a face that faces each directed edge of it."""
    return {
        (face[i], face[(i + 1) % 3]): face[(i + 2) % 3] for face in F.tolist() for i in range(3)
    }


def same_orientation(F: Integers, F_true: Integers) -> bool:
    """Whether two lists of the same faces also have the same orientations."""
    return np.array_equal(_sorted(_rotated(F)), _sorted(_rotated(F_true)))


def _in_order(F: Integers) -> Integers:
    """The faces in an order that depends on neither their rows nor their orientation."""
    return _sorted(np.sort(F, axis=1))


def _rotated(F: Integers) -> Integers:
    """Each face from its least vertex on, which keeps its orientation."""
    turn = (F.argmin(axis=1)[:, None] + np.arange(3)) % 3
    return np.take_along_axis(F, turn, axis=1)


def _sorted(F: Integers) -> Integers:
    return F[np.lexsort(F.T[::-1])]
