"""Rows and faces that are stored more than once."""

import numpy as np

from meshfair.checks import check_faces

# Odd numbers with bits all over, which spread rows over 64-bit hashes.
_ODD = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)


def repeated_rows(rows):
    """Which rows of an array are equal to an earlier row, and to which one.

    Parameters
    ----------
    rows : ndarray of int64 or float64, shape (k, 3)

    Returns
    -------
    first : ndarray of int64, shape (k,)
        Index of the first row that is equal; the row's own index if none is.
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


def unique_faces(F):
    """The faces without repetitions, the first of each kept, in their order.

    Two faces are duplicates where they have the same three vertices, whatever
    their orientation.

    Parameters
    ----------
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    ndarray of int64, shape (m', 3)
    """
    F = check_faces(F, np.max(F, initial=0) + 1)
    repeated = repeated_faces(F)
    return F[~repeated] if repeated.any() else F


def repeated_faces(F):
    """Which faces have the three vertices of an earlier face.

    Parameters
    ----------
    F : ndarray of int64, shape (m, 3)

    Returns
    -------
    ndarray of bool, shape (m,)
    """
    return repeated_rows(np.sort(F, axis=1)) != np.arange(len(F))
