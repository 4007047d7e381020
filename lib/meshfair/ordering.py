"""Vertices in an order in which neighbours are close in memory, and back.

A kernel that visits the neighbours of each vertex waits for memory most of the
time where they are far apart, as on a mesh that was subdivided. Numbered
breadth-first, the same step is several times as fast on a million vertices:

    order, _ = ordering.nearby(weights.combinatorial(F, len(V)))
    V_near, F_near = V[order], ordering.rank(order)[F]
    ...
    V = V_near[ordering.rank(order)]  # back again
"""

import numpy as np
from scipy.sparse import csr_array

from meshfair.kernels import compiled, on_all_cores, unsigned


def nearby(A):
    """A breadth-first order of the vertices: close on the mesh, close in memory.

    Parameters
    ----------
    A : csr_array, shape (n, n)
        Any matrix with entries where two vertices are neighbours.

    Returns
    -------
    order : ndarray of the indices' type, shape (n,)
        order[r] is the vertex that comes at place r.
    A_near : csr_array, shape (n, n)
        A with rows and columns in this order: its entry (r, s) is
        a_order[r],order[s]. Each row keeps its entries in the order they had,
        so that sums over them are the same to the last digit.
    """
    indptr, indices = unsigned(A.indptr, A.indices)
    order = np.empty(len(indptr) - 1, dtype=A.indices.dtype)
    place = np.full_like(order, -1)
    near_indptr = np.zeros_like(indptr)
    _breadth_first(indptr, indices, order, place, near_indptr)
    near_indices, data = np.empty_like(A.indices), np.empty_like(A.data)
    on_all_cores(
        _reorder, len(order), indptr, indices, A.data, *unsigned(order, place, near_indptr),
        near_indices, data,
    )  # fmt: skip
    return order, csr_array((data, near_indices, near_indptr.view(A.indptr.dtype)), shape=A.shape)


def rank(order):
    """The place of each vertex in an order: the inverse permutation."""
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return place


def take(X, order):
    """The rows of an array in this order, copied by all cores.

    Parameters
    ----------
    X : ndarray, shape (n, ...)
    order : ndarray of integers, shape (k,)
        Each in 0 .. n - 1, which is not checked.

    Returns
    -------
    ndarray of the type of ``X``, shape (k, ...)
    """
    rows = np.empty_like(X, shape=(len(order), *X.shape[1:]))
    on_all_cores(_take, len(order), X, order, rows)
    return rows


def _take(first, last, X, order, rows):
    # "clip": straight to where it belongs; NumPy would raise errors from a copy.
    np.take(X, order[first:last], axis=0, out=rows[first:last], mode="clip")


@compiled
def _breadth_first(indptr, indices, order, place, near_indptr):
    """Follow the graph, component by component; write where each vertex' row will begin."""
    head = tail = 0
    for seed in range(len(order)):
        if place[seed] >= 0:
            continue
        order[tail], place[seed] = seed, tail
        tail += 1
        while head < tail:
            i = order[head]
            for p in range(indptr[i], indptr[i + 1]):
                j = indices[p]
                if place[j] < 0:
                    order[tail], place[j] = j, tail
                    tail += 1
            near_indptr[head + 1] = near_indptr[head] + (indptr[i + 1] - indptr[i])
            head += 1


@compiled
def _reorder(first, last, indptr, indices, A, order, place, near_indptr, near_indices, near_A):
    for r in range(first, last):
        start = indptr[order[r]]
        for q in range(near_indptr[r], near_indptr[r + 1]):
            p = start + (q - near_indptr[r])
            near_indices[q], near_A[q] = place[indices[p]], A[p]
