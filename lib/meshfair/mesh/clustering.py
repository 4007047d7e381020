"""Reduce a mesh the quick way, with the damage that this does."""

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import Floats, Integers, MeshError, check_mesh, check_number
from meshfair.mesh.geometry import mean_edge_length
from meshfair.mesh.topology import topologically_degenerate


def cluster(V: ArrayLike, F: ArrayLike, cell: float) -> tuple[Floats, Integers]:
    """Merge all vertices in each cell of a grid into one: vertex clustering [RB93]_.

    Quick and blind to the surface: where two sheets, or two parts of a fold,
    pass through one cell they are fused. The result has non-manifold edges and
    vertices, duplicate faces (with both orientations), and holes too small for
    the grid are closed. This is what the original report's reduction did to its
    meshes, and is here to study the damage: see `inspect` and `repair`.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    cell : float
        Size of the cells, in mean edge lengths of the mesh, above 0. The grid
        starts half a cell below the smallest coordinates.

    Returns
    -------
    V : ndarray of float64, shape (n', 3)
        The mean of the vertices in each cell that has any, unreferenced ones
        counted too.
    F : ndarray of int64, shape (m', 3)
        The faces whose corners lie in three cells, once each. A face and the
        same with the other orientation both stay.

    Raises
    ------
    MeshError, ValueError
        No mesh, ``cell`` not above 0, or so large that no face is left.

    References
    ----------
    .. [RB93] J. Rossignac, P. Borrel, "Multi-resolution 3D approximations for
       rendering complex scenes", Modeling in Computer Graphics, Springer 1993.
    """
    V, F = check_mesh(V, F)
    size = check_number(cell, "cell", 0, open_low=True) * mean_edge_length(V, F)
    index = np.floor((V - V.min(axis=0)) / size + 0.5).astype(np.int64)
    _, number, count = np.unique(index, axis=0, return_inverse=True, return_counts=True)
    X = np.column_stack([np.bincount(number, x) for x in V.T]) / count[:, None]
    T = number[F]
    T = T[~topologically_degenerate(T)]
    if not len(T):
        raise MeshError(f"cell = {cell:g} mean edge lengths leaves no face; give a smaller one")
    # The same face starting at another corner is the same: start each at its lowest.
    turns = (T.argmin(axis=1)[:, None] + np.arange(3)) % 3
    T = np.take_along_axis(T, turns, axis=1)
    _, first = np.unique(T, axis=0, return_index=True)
    return X, T[np.sort(first)]
