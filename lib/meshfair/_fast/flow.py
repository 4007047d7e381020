"""Steps of the flow: the sums over neighbours, the mixing and the SNR in one pass.

On a large mesh a step waits for memory. So plain averaging checks what it reads
on its way, block by block, instead of in passes of their own, and long flows
first number the vertices so that neighbours are near in memory.
"""

import numpy as np

from meshfair._fast import ordering
from meshfair._fast.kernels import compiled, helper, on_all_cores, unsigned
from meshfair.checks import LARGEST_COORDINATE, check_square, check_vertices

# From so many iterations on, on a mesh whose positions outgrow the caches, ordering
# the vertices for locality first is repaid.
ITERATIONS_WORTH_ORDERING = 8
VERTICES_WORTH_ORDERING = 100_000
NONE = np.empty((0, 3))  # where no mesh is given to compare with


def average(V, A, iterations, fixed):
    """As `meshfair.flow.average`; what V and A hold need not have been checked."""
    if fixed.any() or not iterations:
        V, A = check_vertices(V), check_square(A)
    order, A = _order_for(A, iterations)
    X, moving = _in_order(order, V if iterations else V.copy(), ~fixed)
    rows = (*unsigned(A.indptr, A.indices), A.data)
    Y = np.empty_like(V)
    for iteration in range(iterations):
        if not moving.all():
            _step(A, X, 1.0, ~moving, Y)
        elif not all(on_all_cores(_average, len(X), *rows, X, Y, iteration == 0)):
            check_vertices(V)  # one of these two says what is wrong
            check_square(A)
        X, Y = Y, np.empty_like(V) if X is V else X  # V itself is not ours to write to
    return X if order is None else ordering.put_back(X, order, Y)


def step(V, A, tau, fixed):
    """As a step of `meshfair.flow.heat`."""
    V_next = np.empty_like(V)
    _step(A, V, tau, fixed, V_next)
    return V_next


def distances(V, V_true, A, tau, iterations, fixed):
    """Yield sum_i |v_i - v_true_i| before the flow, and after each step."""
    order, A = _order_for(A, iterations)
    X, V_true, fixed = _in_order(order, V.copy(), V_true, fixed)
    Y = np.empty_like(X)
    yield _step(A, X, tau, np.ones_like(fixed), Y, V_true)  # all fixed: nothing moves
    for _ in range(iterations):
        yield _step(A, X, tau, fixed, Y, V_true)
        X, Y = Y, X


def _order_for(A, iterations):
    """An order and the operator in it; None and the operator as it is where that is quicker."""
    few = iterations < ITERATIONS_WORTH_ORDERING or A.shape[0] < VERTICES_WORTH_ORDERING
    if few or ordering.is_near(A):
        return None, A
    return ordering.nearby(check_square(A))


def _in_order(order, *of_vertices):
    if order is None:
        return of_vertices
    return tuple(ordering.take(X, order) for X in of_vertices)


def _step(A, V, tau, fixed, V_next, V_true=NONE):
    """Write one step to V_next; return sum_i |v_i - v_true_i|, 0 without V_true."""
    rows = (*unsigned(A.indptr, A.indices), A.data)
    return sum(on_all_cores(_flow, len(V), *rows, V, tau, fixed, V_next, V_true))


@helper
def columns_exist(start, stop, indices, columns):
    """Whether these entries stand in columns that there are; they are read soon after."""
    largest = indices.dtype.type(0)
    for p in range(start, stop):
        largest = max(largest, indices[p])
    return largest < columns


@helper
def row_product(p, stop, indices, A, V):
    """sum_j a_ij v_j over the entries of a row from p on, and where the next row begins."""
    x = y = z = 0.0
    one = indices.dtype.type(1)  # of the type of p: numba adds two types as floats
    while p < stop:
        a, j = A[p], indices[p]
        x += a * V[j, 0]
        y += a * V[j, 1]
        z += a * V[j, 2]
        p += one
    return x, y, z, p


@compiled(fused=True)
def _average(first, last, indptr, indices, A, V, V_next, check):
    """v+_i = sum_j a_ij v_j: `_flow` for tau = 1 and nothing fixed, with less to do per row.

    Returns False where ``check`` is asked for and finds a column that does not exist, or
    numbers that are none or too large: a sum over the block shows them all.
    """
    p = indptr[first]
    if not check:
        for i in range(first, last):
            x, y, z, p = row_product(p, indptr[i + 1], indices, A, V)
            V_next[i, 0], V_next[i, 1], V_next[i, 2] = x, y, z
        return True
    size = 0.0
    if not columns_exist(p, indptr[last], indices, len(V)):
        return False
    for i in range(first, last):
        x, y, z, p = row_product(p, indptr[i + 1], indices, A, V)
        V_next[i, 0], V_next[i, 1], V_next[i, 2] = x, y, z
        size += abs(x) + abs(y) + abs(z) + abs(V[i, 0]) + abs(V[i, 1]) + abs(V[i, 2])
    return size < LARGEST_COORDINATE


@compiled(fused=True)
def _flow(first, last, indptr, indices, A, V, tau, fixed, V_next, V_true):
    """v+_i = (1 - tau) v_i + tau sum_j a_ij v_j, but v+_i = v_i where fixed."""
    distance = 0.0
    p = indptr[first]
    for i in range(first, last):
        x, y, z, p = row_product(p, indptr[i + 1], indices, A, V)
        if fixed[i]:
            x, y, z = V[i, 0], V[i, 1], V[i, 2]
        else:
            x = (1 - tau) * V[i, 0] + tau * x
            y = (1 - tau) * V[i, 1] + tau * y
            z = (1 - tau) * V[i, 2] + tau * z
        V_next[i, 0], V_next[i, 1], V_next[i, 2] = x, y, z
        if len(V_true):
            dx, dy, dz = x - V_true[i, 0], y - V_true[i, 1], z - V_true[i, 2]
            distance += np.sqrt(dx * dx + dy * dy + dz * dz)
    return distance
