"""Assignment 4: backward Euler and quadratic regularisation.

Fill in the functions; the notebook a4.ipynb explains and checks them.
V: positions, shape (n, 3). F: triangles, shape (m, 3). M, L: sparse, shape (n, n).
"""

import numpy as np
from scipy.sparse import csc_array, csr_array, diags_array, eye_array
from scipy.sparse.linalg import splu


def mass_matrix(V, F):
    """A third of the area of the triangles around each vertex, on the diagonal.

    Returns
    -------
    csr_array, shape (n, n)
    """
    raise NotImplementedError


def implicit_step(V, M, L, t):
    """One step of backward Euler: V+ with (M + t L) V+ = M V.

    Returns
    -------
    array, shape (n, 3)
    """
    raise NotImplementedError


def regularise(V, L, lam):
    """The X that minimises |X - V|^2 + lam tr(X' L X).

    Returns
    -------
    array, shape (n, 3)
    """
    raise NotImplementedError


def regularise_fixed(V, L, lam, fixed):
    """As regularise, with the vertices of a boolean mask (n,) fixed.

    Returns
    -------
    array, shape (n, 3)
    """
    raise NotImplementedError


def restore_volume(V, F, volume):
    """The mesh scaled about the mean of its vertices to a given volume.

    Returns
    -------
    array, shape (n, 3)
    """
    raise NotImplementedError
