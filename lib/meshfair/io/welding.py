"""Vertices in the same place, found exactly: 0.0 and -0.0 are the same, and nothing else is."""

import numpy as np

from meshfair.checks import Floats, Integers


def same_rows(rows: Floats) -> tuple[Integers, Integers]:
    """Rows that are equal, by one number for each.

    Parameters
    ----------
    rows : ndarray of float64, shape (n, k)

    Returns
    -------
    first : ndarray of int64, shape (u,)
        The first of each kind of row, in the order of the rows.
    kind : ndarray of int64, shape (n,)
        Which kind each row is: ``rows[first[kind]] == rows``.
    """
    order = np.lexsort(rows.T)
    ordered = rows[order]
    begins = np.append(True, np.any(ordered[1:] != ordered[:-1], axis=1))
    first = np.minimum.reduceat(order, np.flatnonzero(begins))
    rank = np.empty_like(first)
    rank[np.argsort(first)] = np.arange(len(first))
    kind = np.empty_like(order)
    kind[order] = rank[np.cumsum(begins) - 1]
    return np.sort(first), kind
