"""The boundary of an open mesh: what to hold in place, or to smooth as a curve."""

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array

from meshfair.checks import MeshError, check_faces
from meshfair.mesh.topology import edges


def boundary_edges(F):
    """The edges with just one face.

    Parameters
    ----------
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    ndarray of int64, shape (k, 2)
        Rows (i, j) with i < j, sorted; none on a closed mesh. A face that is
        stored twice counts once.
    """
    E, faces_of_edge = edges(F)
    return E[faces_of_edge == 1]


def boundary_vertices(F):
    """The vertices on the boundary, to hold them in a flow.

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


def boundary_as_curve(A, F):
    """An averaging operator that smooths the boundary as a curve of its own.

    Without it the vertices of the boundary are drawn inwards, since all their
    other neighbours lie on one side, and holes grow. Here the row of each
    boundary vertex is replaced by the mean of its neighbours *along the
    boundary*, so that the boundary flows like a closed curve in space and
    does not feel the surface; the surface follows it.

    Parameters
    ----------
    A : sparse array, shape (n, n)
        Averaging operator, see `meshfair.operators.averaging`. The identity
        gives an operator that smooths the boundary alone.
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    csr_array of float64, shape (n, n)
        For `meshfair.flow.average` and `meshfair.flow.heat`; rows sum to 1 as
        those of ``A`` do. It has no symmetric form, so an implicit step
        smooths the boundary first and then holds it.

    Raises
    ------
    MeshError
        ``A`` not of shape (n, n), no faces, or an index outside 0 .. n - 1.
    """
    shape = np.shape(A)
    if len(shape) != 2 or shape[0] != shape[1]:
        raise MeshError(f"A has shape {shape}; give an averaging operator of shape (n, n)")
    n = shape[0]
    i, j = boundary_edges(check_faces(F, n)).T
    ones = np.ones(2 * len(i))
    along = coo_array((ones, (np.append(i, j), np.append(j, i))), shape=(n, n)).tocsr()
    count = along.sum(axis=1)
    inside = count == 0
    mean = diags_array(np.divide(1.0, count, out=np.zeros(n), where=~inside)) @ along
    return csr_array(diags_array(inside.astype(float)) @ csr_array(A) + mean)
