"""Assignment 2: three weights.

Fill in the functions; the notebook a2.ipynb explains and checks them.
V: positions, shape (n, 3). F: triangles, shape (m, 3), indices of vertices.
"""

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array


def edges(F):
    """Edges without orientation, each once.

    Returns
    -------
    array of integers, shape (k, 2), rows (i, j) with i < j
    """
    raise NotImplementedError


def combinatorial_weights(F, n):
    """Weight 1 on every edge.

    Returns
    -------
    csr_array, shape (n, n)
    """
    raise NotImplementedError


def distance_weights(V, F):
    """The length of each edge as its weight.

    Returns
    -------
    csr_array, shape (n, n)
    """
    raise NotImplementedError


def cotangent_weights(V, F):
    """Half the sum of the cotangents opposite to each edge.

    Returns
    -------
    csr_array, shape (n, n)
    """
    raise NotImplementedError


def averaging(W):
    """The averaging operator: W with every row divided by its sum.

    Returns
    -------
    csr_array, shape (n, n)
    """
    raise NotImplementedError
