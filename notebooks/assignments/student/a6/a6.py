"""Assignment 6: a filter that learns.

Fill in the functions; the notebook a6.ipynb explains and checks them.
N: unit normals, shape (m, 3). i, j, share, distance: the pairs of faces, each of shape (p,).
G: what each entry of the table contributes to each face, shape (m, k, 3). table: shape (k,).
"""

import numpy as np
from scipy.sparse import csr_array


def hats(x, nodes):
    """How much of each node each number has.

    Parameters: x of shape (p,), nodes of shape (q,), rising.

    Returns
    -------
    array, shape (p, q)
        The rows add up to 1.
    """
    raise NotImplementedError


def contributions(N, i, j, share, distance, differences, distances):
    """What each entry of the table contributes to the normal of each face.

    Returns
    -------
    array, shape (m, len(differences) * len(distances), 3)
    """
    raise NotImplementedError


def fit(G, N_true, ridge):
    """The table that is best on an example, by (3).

    Returns
    -------
    array, shape (k,)
    """
    raise NotImplementedError


def filtered(G, table):
    """The filtered normals.

    Returns
    -------
    array, shape (m, 3)
    """
    raise NotImplementedError


def held_out(G, N_true, shape, ridge):
    """The error on each shape, of the table learned from all others.

    Returns
    -------
    array, shape (number of shapes,)
        Mean angles, in degrees.
    """
    raise NotImplementedError
