"""L0 minimisation: as few creases as possible, all other edges flat.

References
----------
.. [HS13] L. He, S. Schaefer, "Mesh denoising via L0 minimization", ACM Transactions on
   Graphics 32(4), 2013.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array, eye_array

from meshfair import solve
from meshfair.checks import DEGENERATE, Floats, check_fixed, check_mesh, check_number
from meshfair.mesh import InteriorEdges, dihedral_angles, interior_edges, mean_edge_length

# The residual that a solve may leave, relative to the mesh around its centre.
TOLERANCE = 1e-6


def l0(
    V: ArrayLike,
    F: ArrayLike,
    *,
    lam: float = 0.2,
    regularity: float = 0.1,
    regularity_factor: float = 0.5,
    beta: float = 1e-3,
    beta_factor: float = 1.414,
    beta_max: float = 1e3,
    fixed: ArrayLike | None = None,
) -> Iterator[tuple[float, Floats]]:
    """L0 minimisation [HS13]_, as an iterator: as few edges as possible are not flat.

    Seeks positions p near the noisy ones p* with few edges that are not flat,

        min |p - p*|^2 + lambda |D p|_0 + alpha |R p|^2,

    where D p is a vector at each edge that vanishes where the edge's two
    triangles lie in a plane (see `edge_operator`), |.|_0 counts the edges at
    which it does not, and R p = p_1 - p_2 + p_3 - p_4 keeps triangles in
    shape. An auxiliary d stands for D p: with beta growing, in turn

        d_e = (D p)_e where |(D p)_e|^2 > lambda / beta, else 0,
        p = argmin |p - p*|^2 + beta |D p - d|^2 + alpha |R p|^2.

    Parameters
    ----------
    V, F, fixed
        As in `meshfair.filters.averaging`.
    lam : float
        lambda, in squared mean edge lengths times the mean dihedral angle
        (the mean absolute angle, in radians, by which edges are bent).
    regularity : float
        The first alpha, in mean dihedral angles.
    regularity_factor : float
        What alpha is multiplied by after each iteration.
    beta, beta_factor, beta_max : float
        The first beta, what it is multiplied by after each iteration, and the
        bound from which on it ends. Stopping early leaves smooth parts smooth.

    Yields
    ------
    progress, V
        As `meshfair.filters.averaging`.

    Raises
    ------
    MeshError, ValueError
        As `meshfair.filters.averaging`.
    SolveError
        A linear system could not be solved.
    """
    V, F = check_mesh(V, F)
    lam = check_number(lam, "lam", 0)
    alpha = check_number(regularity, "regularity", 0)
    regularity_factor = check_number(regularity_factor, "regularity_factor", 0, 1)
    beta = check_number(beta, "beta", 0, open_low=True)
    beta_factor = check_number(beta_factor, "beta_factor", 1, open_low=True)
    beta_max = check_number(beta_max, "beta_max", 0, open_low=True)
    fixed = check_fixed(fixed, len(V))

    n = len(V)
    centre = V.mean(axis=0)  # the tolerance must not depend on where the mesh lies
    P_noisy = P = V - centre
    H = interior_edges(F)
    bend = float(np.mean(dihedral_angles(P, H))) if len(H.corners) else 0.0
    lam *= mean_edge_length(V, F) ** 2 * bend
    alpha *= bend
    R = edge_matrix(np.tile([1.0, -1.0, 1.0, -1.0], (len(H.corners), 1)), H, n)
    steps = max(0, int(np.ceil((np.log(beta_max) - np.log(beta)) / np.log(beta_factor))))
    for step in range(1, steps + 1):
        D = edge_matrix(edge_operator(P, H), H, n)
        d = D @ P
        d[np.sum(d**2, axis=1) <= lam / beta] = 0
        A = eye_array(n) + beta * (D.T @ D) + alpha * (R.T @ R)
        b = P_noisy + beta * (D.T @ d)
        P = solve.spd(A, b, guess=P, fixed=fixed, tolerance=TOLERANCE)
        beta *= beta_factor
        alpha *= regularity_factor
        yield step / steps, np.where(fixed[:, None], V, P + centre)


def edge_operator(V: Floats, H: InteriorEdges) -> Floats:
    """The area-based edge operator ([HS13]_, section 3.2): its coefficients at each edge.

    With h_2 and h_4 the vectors from the edge's line to p2 and to p4, at
    right angles to it, and A_2, A_4 the areas of the two triangles,

        D p = (A_4 h_2 + A_2 h_4) / (A_2 + A_4),

    which is 0 where the triangles lie in a plane, since A is |h| times half
    the edge.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    H : InteriorEdges

    Returns
    -------
    ndarray of float64, shape (k, 4)
        D p = c1 p1 + c2 p2 + c3 p3 + c4 p4; the c sum to 0. All are 0 where
        the edge or both triangles are degenerate.
    """
    p1, p2, p3, p4 = (V[corner] for corner in H.corners.T)
    edge = p3 - p1
    squared = np.sum(edge**2, axis=1)
    area_2 = np.linalg.norm(np.cross(p2 - p1, edge), axis=1)
    area_4 = np.linalg.norm(np.cross(p4 - p1, edge), axis=1)
    sound = area_2 + area_4 > DEGENERATE * squared
    area, squared = np.where(sound, [area_2 + area_4, squared], 1.0)
    c2, c4 = area_4 / area, area_2 / area
    # The feet of the two heights divide the edge at t2 and at t4.
    t2 = np.sum((p2 - p1) * edge, axis=1) / squared
    t4 = np.sum((p4 - p1) * edge, axis=1) / squared
    c3 = -c2 * t2 - c4 * t4
    return np.where(sound, [-(c2 + c3 + c4), c2, c3, c4], 0.0).T


def edge_matrix(coefficients: Floats, H: InteriorEdges, n: int) -> csr_array:
    """The matrix of shape (k, n) with row e of ``coefficients`` at the corners of edge e."""
    k = len(H.corners)
    starts = np.arange(0, 4 * k + 1, 4)
    return csr_array((coefficients.ravel(), H.corners.ravel(), starts), shape=(k, n))
