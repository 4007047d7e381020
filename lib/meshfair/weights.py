"""The three edge weights of the original report: combinatorial, distance, cotangent.

Each builder returns the symmetric matrix W of its section 2.1 as a
``scipy.sparse.csr_array`` of shape (n, n): w_ij where (i, j) is an edge, no
entry elsewhere, zeros on the diagonal. All three have the same pattern.

Where vertices move and faces do not, the edges need be found only once:

    edges = mesh.Edges(F, n)
    W = weights.cotangent(V, edges)  # as often as V changes

References
----------
.. [PP93] U. Pinkall, K. Polthier, "Computing discrete minimal surfaces and their
   conjugates", Experimental Mathematics 2(1), 1993.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from meshfair import _fast
from meshfair.checks import Floats, check_choice, check_vertices
from meshfair.mesh.elements import Edges, Triangles, as_edges, warn_of_degenerate_faces
from meshfair.mesh.objects import takes_meshes


def combinatorial(F: ArrayLike | Edges, n: int) -> csr_array:
    """Combinatorial weights: w_ij = 1 on every edge, the adjacency matrix.

    Parameters
    ----------
    F : array_like of integers, shape (m, 3), or Edges
    n : int
        Number of vertices.

    Returns
    -------
    csr_array of float64, shape (n, n)

    Raises
    ------
    MeshError
        No triangles, or an index outside 0 .. n - 1.
    """
    E = as_edges(F, n)
    if _fast.wanted(n):
        return _fast.weights.combinatorial(E.sparsity)
    return E.matrix(np.ones(len(E)))


@takes_meshes
def distance(V: ArrayLike, F: ArrayLike | Edges) -> csr_array:
    """Distance weights: w_ij = |v_i - v_j|.

    As in the original report, so a *far* neighbour pulls more than a near one.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3), or Edges

    Returns
    -------
    csr_array of float64, shape (n, n)
        In the units of ``V``.

    Raises
    ------
    MeshError
        No mesh.
    """
    V = check_vertices(V)
    E = as_edges(F, len(V))
    if _fast.wanted(len(V)):
        return _fast.weights.distance(V, E.sparsity)
    i, j = E.ends.T
    return E.matrix(np.linalg.norm(V[i] - V[j], axis=1))


@takes_meshes
def cotangent(V: ArrayLike, F: ArrayLike | Edges, *, negative: str = "keep") -> csr_array:
    """Cotangent weights: w_ij = (cot alpha_ij + cot beta_ij) / 2 [PP93]_.

    alpha_ij and beta_ij are the angles opposite the edge (i, j) in its two
    triangles, and cot = u . v / |u x v| for the edge vectors u, v at the angle.
    The original report writes the sum without the half; with it, L = D - W is
    the usual discrete Laplace-Beltrami operator, and in the averaging operator
    D^-1 W the factor cancels.

    A weight is negative where the two angles sum to more than 180 degrees.
    A boundary edge has its one angle; where more than two faces meet, all
    are summed; duplicate faces count once.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3), or Edges
    negative : {"keep", "clamp"}
        Keep negative weights, or make them 0. Without them every averaging
        step is stable, but L is no longer the Laplace-Beltrami operator.

    Returns
    -------
    csr_array of float64, shape (n, n)
        Dimensionless: scaling the mesh leaves the weights as they are.

    Raises
    ------
    MeshError, ValueError
        No mesh; ``negative`` neither of the two.

    Warns
    -----
    MeshWarning
        Once, where faces are degenerate. They have no angles and contribute 0.
    """
    check_choice(negative, "negative", ("keep", "clamp"))
    V = check_vertices(V)
    E = as_edges(F, len(V))
    if _fast.wanted(len(V)):
        W, degenerate = _fast.weights.cotangent(V, E.sparsity)
    else:
        T = Triangles(V, E.F)
        W = E.matrix(E.sums(T.cotangents) / 2)  # each edge's sum over the angles opposite it
        degenerate = T.degenerate.any()
    if degenerate:
        warn_of_degenerate_faces(V, E.F, "contribute nothing to the cotangent weights")
    if negative == "clamp":
        W.data = np.maximum(W.data, 0)
    return W


BY_NAME: dict[str, Callable[[Floats, ArrayLike | Edges], csr_array]] = {
    "combinatorial": lambda V, F: combinatorial(F, len(V)),
    "distance": distance,
    "cotangent": cotangent,
}
"""Each builder by its name, as a function of V and F."""
