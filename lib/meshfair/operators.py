"""From weights to operators: averaging, Laplacian, mass, diffusion.

References
----------
.. [MD99] M. Desbrun, M. Meyer, P. Schroeder, A. Barr, "Implicit fairing of irregular
   meshes using diffusion and curvature flow", SIGGRAPH 1999.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array, diags_array, eye_array, sparray

from meshfair import _fast
from meshfair.checks import Floats, MeshError, check_faces, check_mesh, check_square
from meshfair.mesh import boundary_edges
from meshfair.mesh.elements import Triangles
from meshfair.mesh.geometry import scatter
from meshfair.mesh.objects import takes_meshes


def degrees(W: sparray) -> Floats:
    """The diagonal of D: d_i = sum_k w_ik over the edges (i, k).

    Parameters
    ----------
    W : sparse array, shape (n, n)
        Edge weights, see `meshfair.weights`.

    Returns
    -------
    ndarray of float64, shape (n,)

    Raises
    ------
    MeshError
        ``W`` not square, or not finite.
    """
    return check_square(W, "W").sum(axis=1)


def averaging(W: sparray) -> csr_array:
    """The averaging operator W~ = D^-1 W (the original report, section 2.1).

    Parameters
    ----------
    W : sparse array, shape (n, n)
        Edge weights, see `meshfair.weights`.

    Returns
    -------
    csr_array of float64, shape (n, n)
        Each row sums to 1. Where d_i = 0 (a vertex without edges) the row is
        that of the identity: the vertex stays where it is.

    Raises
    ------
    MeshError
        ``W`` not square, or not finite.
    """
    W = check_square(W, "W")
    if _fast.wanted(W.shape[0]):
        return _fast.operators.averaging(W)
    d = W.sum(axis=1)
    isolated = d == 0
    return csr_array(diags_array(_inverse(d)) @ W + diags_array(isolated.astype(float)))


def laplacian(W: sparray) -> csr_array:
    """The Laplacian L = D - W, positive semidefinite for nonnegative weights.

    With cotangent weights it is positive semidefinite too, whatever their
    signs: x' L x is the Dirichlet energy of x, a sum of squares over faces.

    Parameters
    ----------
    W : sparse array, shape (n, n)

    Returns
    -------
    csr_array of float64, shape (n, n)
        Rows sum to 0.

    Raises
    ------
    MeshError
        ``W`` not square, or not finite.
    """
    W = check_square(W, "W")
    return csr_array(diags_array(W.sum(axis=1)) - W)


@takes_meshes
def mass(V: ArrayLike, F: ArrayLike) -> csr_array:
    """The lumped mass matrix M: a third of the area of the faces at each vertex.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    csr_array of float64, shape (n, n)
        Diagonal, in squared units of length; it sums to the surface's area. A
        vertex without faces has mass 0.

    Raises
    ------
    MeshError
        No mesh.
    """
    V, F = check_mesh(V, F)
    if _fast.wanted(len(V)):
        return csr_array(diags_array(_fast.operators.mass(V, F)))
    return csr_array(diags_array(scatter(Triangles(V, F).area / 3, F, len(V))))


def diffusion(W: sparray, M: sparray) -> csr_array:
    """The operator A = I - M^-1 L, with which a heat step is one of curvature flow.

    In `meshfair.flow.heat` it makes V+ = V - tau M^-1 L V, forward Euler for
    the mean curvature flow dV/dt = -M^-1 L V [MD99]_; tau is then in squared
    units of length, and the stable step is small (see
    `meshfair.stability.stable_step`).

    Parameters
    ----------
    W : sparse array, shape (n, n)
        Edge weights, cotangent ones for the Laplace-Beltrami operator.
    M : sparse array, shape (n, n)
        Diagonal mass matrix, see `mass`.

    Returns
    -------
    csr_array of float64, shape (n, n)
        A vertex of mass 0 keeps its place.

    Raises
    ------
    MeshError
        A matrix that is not square or not finite, or different sizes.
    """
    L, M = laplacian(W), check_square(M, "M")
    if L.shape != M.shape:
        raise MeshError(f"W has shape {L.shape} but M has {M.shape}; build both from one mesh")
    return csr_array(eye_array(L.shape[0]) - diags_array(_inverse(M.diagonal())) @ L)


def boundary_as_curve(A: sparray, F: ArrayLike) -> csr_array:
    """An averaging operator that smooths the boundary as a curve of its own.

    Without it boundary vertices are drawn inwards, since their other neighbours
    lie on one side, and holes grow. Here each one's row is replaced by the mean of
    its neighbours *along the boundary*: it flows as a curve, the surface follows.

    Parameters
    ----------
    A : sparse array, shape (n, n)
        Averaging operator, see `meshfair.operators.averaging`. The identity
        gives an operator that smooths the boundary alone.
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    csr_array of float64, shape (n, n)
        Rows sum to 1 as those of ``A`` do. It has no symmetric form, so an
        implicit step smooths the boundary first and then fixes it.

    Raises
    ------
    MeshError
        ``A`` not of shape (n, n), no faces, or an index outside 0 .. n - 1.
    """
    A = check_square(A)
    n = A.shape[0]
    i, j = boundary_edges(check_faces(F, n)).T
    along = csr_array((np.ones(2 * len(i)), (np.append(i, j), np.append(j, i))), shape=(n, n))
    count = along.sum(axis=1)
    inside = diags_array((count == 0).astype(float))
    return csr_array(inside @ A + diags_array(_inverse(count)) @ along)


def _inverse(d: Floats) -> Floats:
    """1 / d, and 0 where d is 0."""
    return np.divide(1.0, d, out=np.zeros_like(d), where=d != 0)
