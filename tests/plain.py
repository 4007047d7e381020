"""The package's fast loops once more, in plain NumPy and SciPy: slow, short, and right.

The specification that tests/test_kernels.py holds the kernels to.
"""

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array, eye_array

from meshfair.mesh import degenerate_faces, edges, face_areas, half_edges, scatter, unique_faces


def symmetric(E, w, n):
    """W with w at (i, j) and at (j, i) for each row (i, j) of E, repeated rows summed."""
    i, j = E.T
    rows, columns = np.concatenate([i, j]), np.concatenate([j, i])
    return coo_array((np.concatenate([w, w]), (rows, columns)), shape=(n, n)).tocsr()


def combinatorial(F, n):
    E, _ = edges(F)
    return symmetric(E, np.ones(len(E)), n)


def distance(V, F):
    E, _ = edges(F)
    i, j = E.T
    return symmetric(E, np.linalg.norm(V[i] - V[j], axis=1), len(V))


def cotangent(V, F):
    F = unique_faces(F)
    flat = degenerate_faces(V, F)
    opposite = half_edges(F)  # the edges across from corners a, then b, then c
    cot = np.concatenate([cot_at(V, F, corner, flat) for corner in range(3)])
    on_edge = opposite[:, 0] != opposite[:, 1]
    return symmetric(opposite[on_edge], cot[on_edge] / 2, len(V))


def cot_at(V, F, corner, flat):
    """Cotangent of each face's angle at a corner: u . v / |u x v|; 0 in flat faces."""
    at, to, fro = (V[F[:, (corner + k) % 3]] for k in range(3))
    u, v = to - at, fro - at
    dot = np.einsum("ij,ij->i", u, v)
    return np.divide(dot, np.linalg.norm(np.cross(u, v), axis=1), out=0 * dot, where=~flat)


def averaging(W):
    d = W.sum(axis=1)
    isolated = d == 0
    inverse = np.divide(1.0, d, out=np.zeros_like(d), where=~isolated)
    return csr_array(diags_array(inverse) @ W + diags_array(isolated.astype(float)))


def mass(V, F):
    return csr_array(diags_array(scatter(face_areas(V, F) / 3, F, len(V))))


def diffusion(W, M):
    L = diags_array(W.sum(axis=1)) - W
    m = M.diagonal()
    inverse = np.divide(1.0, m, out=np.zeros_like(m), where=m > 0)
    return csr_array(eye_array(len(m)) - diags_array(inverse) @ L)


def heat(V, A, tau, steps, fixed=()):
    """The last state of the flow."""
    for _ in range(steps):
        V_next = (1 - tau) * V + tau * (A @ V)
        V_next[list(fixed)] = V[list(fixed)]
        V = V_next
    return V
