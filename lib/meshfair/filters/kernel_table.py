"""The kernel of the bilateral normal filter as a table, fitted to clean and noisy pairs.

The bilateral normal filter n_i <- sum_j w_ij n_j says by a formula how much a face counts that
is so far away and turned by so much. Here a table says it, and least squares choose its
entries: the smallest case of what `meshfair.filters.learned` does by a network, and of the
cascade of [Wang16]_, whose regressions each learn from what the one before leaves.

References
----------
.. [Wang16] P.-S. Wang, Y. Liu, X. Tong, "Mesh denoising via cascaded normal regression",
   ACM Transactions on Graphics 35(6), 2016.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from meshfair.checks import Floats, Integers, check_count, check_mesh
from meshfair.filters.neighbourhoods import adjacent_faces, entries, face_rings
from meshfair.filters.normal_filtering import mean_distance, move_vertices
from meshfair.mesh import face_normals, face_shapes, normalised
from meshfair.mesh.geometry import incidence

# Nodes of the table: degrees between normals, and mean distances of adjacent centroids.
ANGLES = np.array([0.0, 15, 30, 45, 60, 90, 120, 180])
DISTANCES = np.array([0.0, 1, 2, 3])
RIDGE = 1e-2  # see `fitted`: entries that hardly any pair asks for should not be left to chance


class FacePairs(NamedTuple):
    """Pairs of faces that share a vertex, each face with itself among them.

    Attributes
    ----------
    i, j : ndarrays of integers, shape (k,)
        In the order of i.
    share : ndarray of float64, shape (k,)
        The area of face j, as a part of that of all faces around face i.
    distance : ndarray of float64, shape (k,)
        Between the centroids, in mean distances of adjacent ones.
    """

    i: Integers
    j: Integers
    share: Floats
    distance: Floats


def face_pairs(V: ArrayLike, F: ArrayLike) -> FacePairs:
    """The pairs of faces over which the filter averages.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    FacePairs

    Raises
    ------
    MeshError
        ``V`` and ``F`` are no mesh.
    """
    V, F = check_mesh(V, F)
    rings = face_rings(incidence(F, len(V)))
    _, area, C = face_shapes(V, F)
    i, j = entries(rings)
    total = np.bincount(i, area[j])
    total[total == 0] = 1.0
    distance = np.linalg.norm(C[j] - C[i], axis=1)
    distance /= mean_distance(C, adjacent_faces(rings)) or 1.0
    return FacePairs(i, j, area[j] / total[i], distance)


def hats(x: Floats, nodes: Floats) -> Floats:
    """How much of each node a number has: 1 at the node, 0 from the next one on, linear between.

    Parameters
    ----------
    x : ndarray of float64, shape (k,)
        Numbers past the last node count as that.
    nodes : ndarray of float64, shape (p,)
        Rising.

    Returns
    -------
    ndarray of float64, shape (k, p)
        The rows add up to 1.
    """
    return np.stack([np.interp(x, nodes, one) for one in np.eye(len(nodes))], axis=1)


def partial_sums(N: Floats, pairs: FacePairs) -> Floats:
    """What each entry of the table would contribute to the normal of each face.

    g_i,ab = sum_j share_ij hat_a(angle of n_i and n_j) hat_b(distance_ij) n_j, so that the
    filter with the table K is n_i <- sum_ab K_ab g_i,ab, normalised: linear in K.

    Parameters
    ----------
    N : ndarray of float64, shape (m, 3)
        Unit normals.
    pairs : FacePairs

    Returns
    -------
    ndarray of float64, shape (m, len(ANGLES) * len(DISTANCES), 3)
    """
    i, j, share, distance = pairs
    chord = np.linalg.norm(N[i] - N[j], axis=1)  # near 0 far more accurate than an arccos
    angle = np.degrees(2 * np.arcsin(np.minimum(chord / 2, 1)))
    angles, distances = hats(angle, ANGLES), hats(distance, DISTANCES)
    G = np.empty((len(N), len(ANGLES) * len(DISTANCES), 3))
    for entry, (a, b) in enumerate(np.ndindex(len(ANGLES), len(DISTANCES))):
        w = share * angles[:, a] * distances[:, b]
        G[:, entry] = csr_array((w, (i, j)), shape=(len(N), len(N))) @ N
    return G


def fitted(G: Floats, N_true: Floats) -> Floats:
    """The table whose filter comes closest to the true normals, by least squares.

    It minimises the mean over i of |sum_ab K_ab g_i,ab - n_i|^2, and RIDGE times the mean
    square of the g times |K|^2, so that entries that hardly any pair asks for are near 0.

    Parameters
    ----------
    G : ndarray of float64, shape (m, k, 3)
        See `partial_sums`; several meshes one after the other.
    N_true : ndarray of float64, shape (m, 3)

    Returns
    -------
    ndarray of float64, shape (k,)
    """
    columns = G.transpose(0, 2, 1).reshape(-1, G.shape[1])  # a row for each coordinate
    A, b = columns.T @ columns, columns.T @ N_true.ravel()
    A[np.diag_indices_from(A)] += RIDGE * (np.trace(A) / len(A) or 1.0)
    return np.linalg.solve(A, b).astype(np.float64)


def filtered(G: Floats, table: Floats) -> Floats:
    """n_i <- sum_ab K_ab g_i,ab, normalised.

    Parameters
    ----------
    G : ndarray of float64, shape (m, k, 3)
        See `partial_sums`.
    table : ndarray of float64, shape (k,)

    Returns
    -------
    ndarray of float64, shape (m, 3)
    """
    return normalised(np.einsum("mkx,k->mx", G, table))


def cascade(
    examples: Sequence[tuple[ArrayLike, ArrayLike, ArrayLike]], passes: int
) -> Iterator[Floats]:
    """Tables for pass after pass, as an iterator: each is fitted to what those before leave.

    Parameters
    ----------
    examples : sequence of (V_noisy, V_true, F)
    passes : int

    Yields
    ------
    ndarray of float64, shape (len(ANGLES) * len(DISTANCES),)

    Raises
    ------
    MeshError
        An example is no mesh.
    ValueError
        There are no examples, or a negative number of passes.
    """
    if not examples:
        raise ValueError("there are no examples to learn from; give at least one")
    pairs = [face_pairs(V, F) for V, _, F in examples]
    normals = [face_normals(V, F) for V, _, F in examples]
    N_true = np.concatenate([face_normals(V, F) for _, V, F in examples])
    for _ in range(check_count(passes, "passes")):
        G = [partial_sums(N, p) for N, p in zip(normals, pairs, strict=True)]
        table = fitted(np.concatenate(G), N_true)
        yield table
        normals = [filtered(g, table) for g in G]


def normals_by_tables(V: ArrayLike, F: ArrayLike, tables: Iterable[Floats]) -> list[Floats]:
    """The normals after 0, 1, ... passes.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        Noisy positions.
    F : array_like of integers, shape (m, 3)
    tables : iterable of ndarray of float64
        One for each pass, see `cascade`.

    Returns
    -------
    list of ndarray of float64, each of shape (m, 3)

    Raises
    ------
    MeshError
        ``V`` and ``F`` are no mesh.
    """
    pairs, states = face_pairs(V, F), [face_normals(V, F)]
    for table in tables:
        states.append(filtered(partial_sums(states[-1], pairs), table))
    return states


def fit_vertices(V: ArrayLike, F: ArrayLike, N: Floats, iterations: int = 20) -> Floats:
    """Move the vertices until the faces have these normals, as far as they can.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    N : ndarray of float64, shape (m, 3)
    iterations : int
        Steps of `meshfair.filters.normal_filtering.move_vertices`.

    Returns
    -------
    ndarray of float64, shape (n, 3)

    Raises
    ------
    MeshError
        ``V`` and ``F`` are no mesh.
    ValueError
        A negative number of iterations.
    """
    V, F = check_mesh(V, F)
    B, free = incidence(F, len(V)), np.zeros(len(V), dtype=bool)
    for _ in range(check_count(iterations, "iterations")):
        V = move_vertices(V, F, B, N, free)
    return V
