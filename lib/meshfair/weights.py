"""The seed's three edge weights: combinatorial, distance, cotangent.

Each builder returns the symmetric matrix W of the seed's section 2.1 as a
``scipy.sparse.csr_array`` of shape (n, n): w_ij where (i, j) is an edge, no
entry elsewhere, zeros on the diagonal. All three have the same pattern.
"""

import warnings

import numpy as np
from scipy.sparse import coo_array

from meshfair.checks import MeshWarning, check_faces, check_mesh
from meshfair.mesh import degenerate_faces, edges, half_edges, unique_faces


def _symmetric(E, w, n):
    """W with w at (i, j) and at (j, i) for each row (i, j) of E, repeated rows summed."""
    i, j = E.T
    rows, columns = np.concatenate([i, j]), np.concatenate([j, i])
    return coo_array((np.concatenate([w, w]), (rows, columns)), shape=(n, n)).tocsr()


def combinatorial(F, n):
    """Combinatorial weights: w_ij = 1 on every edge, the adjacency matrix.

    Parameters
    ----------
    F : array_like of integers, shape (m, 3)
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
    E, _ = edges(check_faces(F, n))
    return _symmetric(E, np.ones(len(E)), n)


def distance(V, F):
    """Distance weights: w_ij = |v_i - v_j|.

    As in the seed, so a *far* neighbour pulls more than a near one.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    csr_array of float64, shape (n, n)
        In the units of ``V``.

    Raises
    ------
    MeshError
        No mesh.
    """
    V, F = check_mesh(V, F)
    E, _ = edges(F)
    i, j = E.T
    return _symmetric(E, np.linalg.norm(V[i] - V[j], axis=1), len(V))


def cotangent(V, F):
    """Cotangent weights: w_ij = (cot alpha_ij + cot beta_ij) / 2 [PP93].

    alpha_ij and beta_ij are the angles opposite the edge (i, j) in its two
    triangles. The seed writes the sum without the half; with it, L = D - W
    is the usual discrete Laplace-Beltrami operator, and in the averaging
    operator D^-1 W the factor cancels.

    A weight is negative where the two angles sum to more than 180 degrees.
    A boundary edge has its one angle; where more than two faces meet, all
    are summed; a face that is stored twice counts once.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    csr_array of float64, shape (n, n)
        Without unit: scaling the mesh leaves the weights as they are.

    Raises
    ------
    MeshError
        No mesh.

    Warns
    -----
    MeshWarning
        Once, where faces are degenerate. They have no angles and contribute 0.
    """
    V, F = check_mesh(V, F)
    F = unique_faces(F)
    flat = degenerate_faces(V, F)
    if flat.any():
        warnings.warn(
            f"{flat.sum()} of {len(F)} faces are degenerate (the first has vertices "
            f"{F[flat][0].tolist()}); they contribute nothing to the cotangent weights",
            MeshWarning,
            stacklevel=2,
        )
    opposite = half_edges(F)  # the edges across from corners a, then b, then c
    cot = np.concatenate([_cot(V, F, corner, flat) for corner in range(3)])
    on_edge = opposite[:, 0] != opposite[:, 1]
    return _symmetric(opposite[on_edge], cot[on_edge] / 2, len(V))


def _cot(V, F, corner, flat):
    """Cotangent of each face's angle at a corner: u . v / |u x v|; 0 in flat faces."""
    at, to, fro = (V[F[:, (corner + k) % 3]] for k in range(3))
    u, v = to - at, fro - at
    dot = np.einsum("ij,ij->i", u, v)
    return np.divide(dot, np.linalg.norm(np.cross(u, v), axis=1), out=0 * dot, where=~flat)
