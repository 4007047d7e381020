"""The numbering of the vertices: neighbours close to each other in memory.

A step that visits the neighbours of each vertex waits for memory most of the
time where they are far apart, as on a mesh that was subdivided. Numbered
breadth-first, the same step is several times as fast on a million vertices:

    V_near, F_near, order = mesh.reorder(V, F)
    ...
    V = mesh.restore_order(V_near, order)

Long flows on large meshes do so by themselves (see `meshfair.flow`), each time
anew: who runs several, or single steps, reorders the mesh once.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array

from meshfair import _fast
from meshfair.checks import Floats, Integers, MeshError, check_mesh
from meshfair.mesh.elements import Edges


def reorder(V: ArrayLike, F: ArrayLike) -> tuple[Floats, Integers, Integers]:
    """The same mesh with its vertices numbered breadth-first.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    V_near : ndarray of float64, shape (n, 3)
        V[order]; `restore_order` undoes it.
    F_near : ndarray of int64, shape (m, 3)
        The triangles in the same order, with the new numbers.
    order : ndarray of int64, shape (n,)
        order[r] is the old number of the vertex that has the new number r.

    Raises
    ------
    MeshError
        No mesh.
    """
    V, F = check_mesh(V, F)
    edges = Edges(F, len(V))
    if _fast.wanted(len(V)):
        order = _fast.ordering.breadth_first(edges.sparsity).astype(np.int64)
    else:
        order = _breadth_first(edges.matrix(np.ones(len(edges))))
    number = np.empty(len(V), dtype=np.int64)
    number[order] = np.arange(len(V))
    return V[order], number[F], order


def _breadth_first(A: csr_array) -> Integers:
    """The vertices of a graph, component by component from each one's lowest vertex."""
    from scipy.sparse.csgraph import breadth_first_order  # slow to load, and seldom needed

    found, seen = [], np.zeros(A.shape[0], dtype=bool)
    alone = np.diff(A.indptr) == 0
    for start in range(A.shape[0]):
        if alone[start]:
            found.append([start])
        elif not seen[start]:
            component = breadth_first_order(A, start, return_predecessors=False)
            seen[component] = True
            found.append(component)
    return np.concatenate(found).astype(np.int64)


def restore_order(X: ArrayLike, order: ArrayLike) -> NDArray[Any]:
    """Rows that stand in the order of `reorder`, in the order they had before.

    Parameters
    ----------
    X : array_like, shape (n, ...)
        Positions, or any other value of each vertex.
    order : array_like of integers, shape (n,)
        As `reorder` returned it.

    Returns
    -------
    ndarray of the type and shape of ``X``

    Raises
    ------
    MeshError
        ``order`` has another length, or is no permutation of 0 .. n - 1.
    """
    X, order = np.asarray(X), np.asarray(order)
    n = len(X)
    if order.shape != (n,) or order.dtype.kind not in "iu":
        raise MeshError(
            f"order is an array of {order.dtype} of shape {order.shape}, but X has {n} rows; "
            "give the order that reorder returned with them"
        )
    if n and not 0 <= order.min() <= order.max() < n:
        raise MeshError(f"order has an entry outside 0 .. {n - 1}; give one that reorder returned")
    if n and np.bincount(order, minlength=n).max() > 1:
        raise MeshError("order has an entry more than once; give one that reorder returned")
    restored = np.empty_like(X, order="C")
    restored[order] = X
    return restored
