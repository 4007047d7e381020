"""The seed's three edge weights: combinatorial, distance, cotangent.

Each builder returns the symmetric matrix W of the seed's section 2.1 as a
``scipy.sparse.csr_array`` of shape (n, n): w_ij where (i, j) is an edge, no
entry elsewhere, zeros on the diagonal. All three have the same pattern.

Where vertices move and faces do not, the pattern need be found only once:

    pattern = weights.Pattern(F, n)
    W = weights.cotangent(V, pattern)  # as often as V changes
"""

import warnings

import numpy as np

from meshfair.checks import MeshError, MeshWarning, check_vertices
from meshfair.intrinsic import cotangent as intrinsic
from meshfair.kernels import compiled, on_all_cores, unsigned
from meshfair.mesh import DEGENERATE, degenerate_faces, unique_faces
from meshfair.pattern import Pattern

__all__ = ["Pattern", "combinatorial", "cotangent", "distance", "intrinsic"]


def combinatorial(F, n):
    """Combinatorial weights: w_ij = 1 on every edge, the adjacency matrix.

    Parameters
    ----------
    F : array_like of integers, shape (m, 3), or Pattern
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
    pattern = _pattern(F, n)
    return pattern.matrix(np.ones(len(pattern.indices)))


def distance(V, F):
    """Distance weights: w_ij = |v_i - v_j|.

    As in the seed, so a *far* neighbour pulls more than a near one.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3), or Pattern

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
    pattern = _pattern(F, len(V))
    W = np.empty(len(pattern.indices))
    on_all_cores(_fill_distance, len(V), V, *unsigned(pattern.indptr, pattern.indices), W)
    return pattern.matrix(W)


@compiled
def _fill_distance(first, last, V, indptr, indices, W):
    for i in range(first, last):
        for p in range(indptr[i], indptr[i + 1]):
            j = indices[p]
            x, y, z = V[i, 0] - V[j, 0], V[i, 1] - V[j, 1], V[i, 2] - V[j, 2]
            W[p] = np.sqrt(x * x + y * y + z * z)


def cotangent(V, F, *, negative="keep"):
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
    F : array_like of integers, shape (m, 3), or Pattern
    negative : {"keep", "clamp"}
        Keep negative weights, or make them 0. Without them every averaging
        step is stable, but L is no longer the Laplace-Beltrami operator.

    Returns
    -------
    csr_array of float64, shape (n, n)
        Without unit: scaling the mesh leaves the weights as they are.

    Raises
    ------
    MeshError, ValueError
        No mesh; ``negative`` neither of the two.

    Warns
    -----
    MeshWarning
        Once, where faces are degenerate. They have no angles and contribute 0.
    """
    if negative not in ("keep", "clamp"):
        raise ValueError(f"negative is {negative!r}; give 'keep' or 'clamp'")
    V = check_vertices(V)
    P = _pattern(F, len(V))
    least = 0.0 if negative == "clamp" else -np.inf
    W = np.empty(len(P.indices))
    flat = on_all_cores(
        _fill_cotangent, len(V), V,
        *unsigned(P.indptr, P.indices, P.start, P.lower, P.first, P.opposite), least, W,
    )  # fmt: skip
    if P.collapsed or sum(flat):
        _warn_of_degenerate_faces(V, P.F)
    return P.matrix(W)


@compiled
def _fill_cotangent(
    first, last, V, indptr, indices, start, lower, first_opposite, opposite, least, W
):
    """For each edge (i, j) add cot = u . v / |u x v| over the vertices k opposite it."""
    flat = 0
    for i in range(first, last):
        for e in range(start[i], start[i + 1]):
            p = indptr[i + 1] - (start[i + 1] - e)  # the edges are the last entries of row i
            j = indices[p]
            ex, ey, ez = V[j, 0] - V[i, 0], V[j, 1] - V[i, 1], V[j, 2] - V[i, 2]
            cotangents = 0.0
            for s in range(first_opposite[e], first_opposite[e + 1]):
                k = opposite[s]
                ux, uy, uz = V[i, 0] - V[k, 0], V[i, 1] - V[k, 1], V[i, 2] - V[k, 2]
                vx, vy, vz = V[j, 0] - V[k, 0], V[j, 1] - V[k, 1], V[j, 2] - V[k, 2]
                nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
                doubled_area = np.sqrt(nx * nx + ny * ny + nz * nz)
                longest = max(
                    ux * ux + uy * uy + uz * uz,
                    vx * vx + vy * vy + vz * vz,
                    ex * ex + ey * ey + ez * ez,
                )
                if doubled_area <= DEGENERATE * longest:  # see mesh.degenerate_faces
                    flat += 1
                else:
                    cotangents += (ux * vx + uy * vy + uz * vz) / doubled_area
            W[p] = W[lower[e]] = max(least, cotangents / 2)
    return flat


def _pattern(F, n):
    """The pattern of these faces, or the pattern that was given for them."""
    if not isinstance(F, Pattern):
        return Pattern(F, n)
    if F.n != n:
        raise MeshError(f"the pattern has {F.n} vertices, but V has {n}; build it for this mesh")
    return F


def _warn_of_degenerate_faces(V, F):
    F = unique_faces(F)
    flat = degenerate_faces(V, F)
    if flat.any():  # rounding may decide otherwise than at one corner alone
        warnings.warn(
            f"{flat.sum()} of {len(F)} faces are degenerate (the first has vertices "
            f"{F[flat][0].tolist()}); they contribute nothing to the cotangent weights",
            MeshWarning,
            stacklevel=3,
        )
