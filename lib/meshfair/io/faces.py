"""Faces of any number of corners: their check, and their cutting into triangles."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from meshfair.checks import Integers
from meshfair.io.errors import file_error


def spans(starts: Integers, counts: Integers) -> Integers:
    """The positions start, start + 1, ... of runs of given lengths, one run after another."""
    before = np.cumsum(counts) - counts
    return np.repeat(starts - before, counts) + np.arange(counts.sum())


def check_corners(corners: NDArray[Any], counts: Integers, n: int) -> None:
    """Raise an error unless there are faces, of three corners or more, and all are vertices.

    Parameters
    ----------
    corners : ndarray of numbers, shape (sum of counts,)
        Vertex indices, from 0, of all faces one after another.
    counts : ndarray of int64, shape (m,)
        Number of corners of each face.
    n : int
        Number of vertices.
    """
    if not len(counts):
        raise file_error(
            "faces", "there are none", "a mesh has at least one", "export a surface mesh"
        )
    if counts.min() < 3:
        face = np.argmax(counts < 3)
        raise file_error(f"face {face}", f"{counts[face]} corners", "a face has three or more")
    fits = (corners >= 0) & (corners < n)
    if corners.dtype.kind == "f":
        fits &= corners == np.floor(corners)
    if not fits.all():
        corner = np.argmin(fits)
        face = np.searchsorted(np.cumsum(counts), corner, side="right")
        found = f"vertex index {corners[corner]}"
        raise file_error(f"face {face}", found, f"the file has {n} vertices (0 to {n - 1})")


def fan(corners: Integers, counts: Integers) -> Integers:
    """Triangles of each face: its first corner with each edge that does not touch it.

    Parameters
    ----------
    corners, counts
        As in `check_corners`.

    Returns
    -------
    ndarray, shape (m, 3)
        The triangles in the order of the faces; a triangle is kept as it is.
    """
    if np.all(counts == 3):
        return corners.reshape(-1, 3)
    first = np.repeat(np.cumsum(counts) - counts, counts - 2)
    second = spans(np.cumsum(counts) - counts + 1, counts - 2)
    return np.column_stack([corners[first], corners[second], corners[second + 1]])
