"""Breadth-first orders: a matrix and the rows of arrays in them, and back, on all cores."""

import numpy as np
from scipy.sparse import csr_array

from meshfair._fast.kernels import compiled, on_all_cores, unsigned

# Breadth-first, neighbours are about 3 sqrt(n) places apart on closed surfaces; in
# another order that is nearly as good, nine in ten are within so many times sqrt(n).
NEAR = 8
NEARLY_ALL = 0.9
SAMPLE = 4096


def breadth_first(pattern):
    """The breadth-first order of a pattern's vertices; see `nearby`."""
    indptr, indices = unsigned(pattern.indptr, pattern.indices)
    order = np.empty(pattern.n, dtype=pattern.indices.dtype)
    _breadth_first(
        indptr, indices, order, np.full_like(order, -1), np.empty_like(pattern.indptr),
        np.empty_like(pattern.indices),
    )  # fmt: skip
    return order


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
    near_indptr, near_indices, data = (np.empty_like(x) for x in (A.indptr, A.indices, A.data))
    _breadth_first(indptr, indices, order, place, near_indptr, near_indices)
    rows = (indptr, A.data, *unsigned(order, near_indptr), data)
    on_all_cores(_take_rows, len(order), *rows)
    return order, csr_array((data, near_indices, near_indptr), shape=A.shape)


def is_near(A):
    """Whether the vertices are in an order in which neighbours are close in memory.

    Parameters
    ----------
    A : csr_array, shape (n, n)
        Any matrix with entries where two vertices are neighbours.

    Returns
    -------
    bool
        Judged by the first and the last entry of some thousand rows.
    """
    n = A.shape[0]
    rows = np.arange(0, n, n // SAMPLE + 1)
    rows = rows[A.indptr[rows] < A.indptr[rows + 1]]  # those with entries
    ends = A.indptr[rows], A.indptr[rows + 1] - 1
    apart = np.abs(A.indices[np.stack(ends)] - rows)
    return bool(np.mean(apart <= NEAR * np.sqrt(n)) >= NEARLY_ALL) if rows.size else True


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


def put_back(X, order, out):
    """Write the rows of an array in this order where they were before `take`.

    Parameters
    ----------
    X : C-contiguous ndarray, shape (n, k)
    order : ndarray of integers, shape (n,)
    out : C-contiguous ndarray of the type and shape of ``X``

    Returns
    -------
    ndarray
        ``out``.
    """
    on_all_cores(_put_back, len(X), X, *unsigned(order), out)
    return out


@compiled
def _put_back(first, last, X, order, out):
    for r in range(first, last):
        for c in range(X.shape[1]):
            out[order[r], c] = X[r, c]


@compiled
def _breadth_first(indptr, indices, order, place, near_indptr, near_indices):
    """Follow the graph, component by component; write the rows of the matrix in that order."""
    head = tail = q = 0
    near_indptr[0] = 0
    for start in range(len(order)):
        if place[start] >= 0:
            continue
        order[tail], place[start] = start, tail
        tail += 1
        while head < tail:
            i = order[head]
            for p in range(indptr[i], indptr[i + 1]):
                j = indices[p]
                if place[j] < 0:
                    order[tail], place[j] = j, tail
                    tail += 1
                near_indices[q] = place[j]
                q += 1
            head += 1
            near_indptr[head] = q


@compiled
def _take_rows(first, last, indptr, A, order, near_indptr, near_A):
    """The values of the rows in this order."""
    for r in range(first, last):
        start = indptr[order[r]]
        for q in range(near_indptr[r], near_indptr[r + 1]):
            near_A[q] = A[start + (q - near_indptr[r])]
