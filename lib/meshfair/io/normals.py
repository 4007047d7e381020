"""Normals that a file holds, computed anew for vertices that have moved."""

import numpy as np

from meshfair.checks import Booleans, Floats, Integers
from meshfair.io.welding import same_rows
from meshfair.mesh import Triangles, normalised


def renewed(
    V_old: Floats, V_new: Floats, F: Integers, row: Integers, old: Floats
) -> tuple[Floats, Booleans]:
    """The normals of a file after its vertices have moved.

    A normal that stands at one place only is a vertex's: the mean of the faces
    around, by area, as of `mesh.vertex_normals`. The faces are those that have this
    very normal there: both sides of a seam have, the two sides of a sharp edge have
    not. A normal that stands at several places is the mean of the faces that name
    it: a flat face's is the face's own.

    Parameters
    ----------
    V_old, V_new : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    row : ndarray of int64, shape (m, 3)
        Which normal each corner names, or -1.
    old : ndarray of float64, shape (k, 3)

    Returns
    -------
    normals : ndarray of float64, shape (k, 3)
        Of length 1; zero where the faces have no area.
    changed : ndarray of bool, shape (k,)
        Which of them are others than they were. One that no face names is not.
    """
    before, after = (Triangles(V, F).area_vectors for V in (V_old, V_new))
    named = row >= 0
    normal, face = row[named], np.nonzero(named)[0]
    _, place = same_rows(V_old)
    place = place[F][named]
    lowest, highest = np.full(len(old), len(V_old)), np.full(len(old), -1)
    np.minimum.at(lowest, normal, place)
    np.maximum.at(highest, normal, place)
    own = np.where(lowest == highest, -1, np.arange(len(old)))
    _, group = same_rows(np.column_stack([lowest, own, np.where(own[:, None] < 0, old, 0)]))
    sums = [_sums(group[normal], vectors[face], len(old)) for vectors in (before, after)]
    moved = np.any(sums[0] != sums[1], axis=1)[group]
    return normalised(sums[1])[group], moved & (highest >= 0)


def _sums(group: Integers, vectors: Floats, number: int) -> Floats:
    columns = [np.bincount(group, column, number) for column in vectors.T]
    return np.column_stack(columns).astype(np.float64)  # of no faces, they are integers
