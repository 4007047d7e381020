"""Rows and faces that an array holds more than once."""

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import Booleans, Floats, Integers, check_faces

# Odd numbers with bits all over, which spread rows over 64-bit hashes.
_ODD = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)


def first_equal(rows: Integers | Floats) -> Integers:
    """For each row of an array, the first row that is equal to it.

    Parameters
    ----------
    rows : ndarray of int64 or float64, shape (k, 3)

    Returns
    -------
    ndarray of int64, shape (k,)
        Index of the first row that is equal: the row's own where no earlier one is.
    """
    first = np.arange(len(rows))
    # Equal rows have equal hashes, and numbers are sorted quickly; only the rows
    # whose hash is not alone are then compared themselves.
    bits = (rows + 0).view(np.uint64) * _ODD[0]  # adding 0 turns -0.0 into 0.0
    bits ^= bits >> np.uint64(32)
    hashes = bits @ _ODD
    ordered = np.sort(hashes)
    shared = ordered[1:][ordered[1:] == ordered[:-1]]
    if len(shared):
        suspects = np.flatnonzero(np.isin(hashes, shared))
        order = suspects[np.lexsort(rows[suspects].T)]  # stable: a run's first has its lowest index
        new = np.append(True, np.any(rows[order[1:]] != rows[order[:-1]], axis=1))
        first[order] = order[new][np.cumsum(new) - 1]
    return first


def duplicate_rows(rows: Integers | Floats) -> Booleans:
    """Which rows of an array are equal to an earlier row.

    Parameters
    ----------
    rows : ndarray of int64 or float64, shape (k, 3)

    Returns
    -------
    ndarray of bool, shape (k,)
    """
    return first_equal(rows) != np.arange(len(rows))


def duplicate_faces(F: Integers) -> Booleans:
    """Which faces have the three vertices of an earlier face, whatever their orientation.

    Parameters
    ----------
    F : ndarray of int64, shape (m, 3)

    Returns
    -------
    ndarray of bool, shape (m,)
    """
    return duplicate_rows(np.sort(F, axis=1))


def unique_faces(F: ArrayLike) -> Integers:
    """The faces without duplicates: the first of each is kept, in their order.

    Two faces are duplicates if they have the same three vertices, whatever
    their orientation.

    Parameters
    ----------
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    ndarray of int64, shape (m', 3)

    Raises
    ------
    MeshError
        Not of shape (m, 3), not integers, no faces, or a negative index.
    """
    F = check_faces(F, np.max(F, initial=0) + 1)
    duplicate = duplicate_faces(F)
    return F[~duplicate] if duplicate.any() else F
