"""The boundary of an open mesh."""

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import Integers
from meshfair.mesh.elements import Edges


def boundary_edges(F: ArrayLike) -> Integers:
    """The edges with just one face.

    Parameters
    ----------
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    ndarray of int64, shape (k, 2)
        Rows (i, j) with i < j, sorted; none on a closed mesh. Duplicate faces
        count once.
    """
    edges = Edges(F)
    return edges.ends[edges.faces_of_edge == 1]


def boundary_vertices(F: ArrayLike) -> Integers:
    """The vertices on the boundary, to fix them in a flow.

    As in ``flow.heat(V, A, tau, time, fixed=mesh.boundary_vertices(F))``.

    Parameters
    ----------
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    ndarray of int64, shape (k,)
        Vertex indices in rising order; none on a closed mesh.
    """
    return np.unique(boundary_edges(F))
