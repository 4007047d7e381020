"""What lies around what: neighbourhoods of vertices and of faces, as sparse matrices.

Row i lists what is near i.
"""

import numpy as np
from scipy.sparse import csr_array, eye_array

from meshfair import _fast
from meshfair.checks import MOST_PAIRS, Floats, Integers

# In edges or so: no mesh that fits into memory is wider.
LARGEST_RADIUS = 1e6


def entries(A: csr_array) -> tuple[Integers, Integers]:
    """The row and the column of each stored entry of a matrix.

    Parameters
    ----------
    A : csr_array, shape (k, l)

    Returns
    -------
    i, j : ndarrays of integers, shape (A.nnz,)
        In the order in which ``A.data`` stores the entries, row after row.
    """
    return np.repeat(np.arange(A.shape[0]), np.diff(A.indptr)), A.indices


def squared_distances(P: Floats, i: Integers, j: Integers) -> Floats:
    """|p_i - p_j|^2 for pairs of rows of ``P``, shape (k, 3).

    Parameters
    ----------
    P : ndarray of float64, shape (k, 3)
    i, j : ndarrays of integers, shape (l,)

    Returns
    -------
    ndarray of float64, shape (l,)
    """
    return sum((x[i] - x[j]) ** 2 for x in P.T)


def face_rings(B: csr_array) -> csr_array:
    """Which faces share a vertex with each face.

    Parameters
    ----------
    B : csr_array, shape (n, m)
        See `meshfair.mesh.geometry.incidence`.

    Returns
    -------
    R : csr_array of int8, shape (m, m)
        R = B' B, the number of vertices that two faces share: 1, or 2 where
        they share an edge, or 3 for a face with itself (and its duplicates).
    """
    R = (B.T @ B).T  # symmetric; the transpose of SciPy's product is stored by rows
    R.sort_indices()  # so that two faces with the same ring sum over it in the same order
    return R


def adjacent_faces(R: csr_array) -> tuple[Integers, Integers]:
    """The pairs of faces that share an edge.

    Parameters
    ----------
    R : csr_array, shape (m, m)
        See `face_rings`.

    Returns
    -------
    f, g : ndarrays of int32, shape (k,)
        Each pair once, f < g.
    """
    f, g = (R == 2).nonzero()
    return f[f < g], g[f < g]


def check_pairs(P: Floats, radius: Floats, given: float) -> None:
    """Refuse a radius with which neighbourhoods do not fit into memory.

    Parameters
    ----------
    P : ndarray of float64, shape (k, 3)
    radius : ndarray of float64, shape (k,)
        As `within` takes it.
    given : float
        The filter's parameter, for the message.

    Raises
    ------
    ValueError
        More than `meshfair.checks.MOST_PAIRS` neighbours, as counted around some of the points.
    """
    if len(P) ** 2 <= MOST_PAIRS:
        return
    some = np.linspace(0, len(P) - 1, 12).astype(int)
    apart = [np.sum([(x[i] - x) ** 2 for x in P.T], axis=0) for i in some]
    mean = np.mean([np.sum(d < radius[i] ** 2) for d, i in zip(apart, some, strict=True)])
    if mean * len(P) > MOST_PAIRS:
        raise ValueError(
            f"radius is {given:g}, within which {mean:,.0f} of {len(P):,} are near each other, "
            f"more than memory holds; give a smaller one"
        )


def within(P: Floats, graph: csr_array, radius: Floats) -> csr_array:
    """The points near each point, as far as they are reached through near points.

    Region growing: from each point along the graph's edges, never past a point
    that is as far away as the radius, so that the other side of a thin sheet
    is not reached.

    Parameters
    ----------
    P : ndarray of float64, shape (k, 3)
        Vertices, or centroids of faces.
    graph : csr_array, shape (k, k)
        Which points are connected.
    radius : ndarray of float64, shape (k,)
        In the units of ``P``.

    Returns
    -------
    csr_array of bool, shape (k, k)
        Row i lists point i and the points nearer to it than its radius.
    """
    if _fast.wanted(len(P), _fast.FILTER_ROWS):
        return _fast.neighbourhoods.within(P, graph, radius)
    ones = np.ones(graph.nnz, dtype=bool)  # an edge of length 0 connects, too
    connected = csr_array((ones, graph.indices, graph.indptr), shape=graph.shape)
    near = frontier = eye_array(len(P), dtype=bool, format="csr")
    while frontier.nnz:  # all regions grow by one step at once
        i, j = entries((frontier @ connected) > near)
        close = squared_distances(P, i, j) < radius[i] ** 2
        frontier = csr_array((close[close], (i[close], j[close])), shape=graph.shape)
        near = near + frontier
    return near
