"""Dihedral angles: the interior edges of a mesh, and how far the surface is bent there."""

from typing import NamedTuple

import numpy as np

from meshfair.checks import Floats, Integers
from meshfair.mesh.elements import Edges


class InteriorEdges(NamedTuple):
    """The edges with two faces; those with one face, or with more than two, are left out."""

    corners: Integers
    """Rows (p1, p2, p3, p4): the edge from p1 to p3, p1 < p3, with the triangles p1 p2 p3
    and p1 p3 p4 on its two sides; int64, shape (k, 4)."""
    faces: Integers
    """The two faces, that of p2 first; int64, shape (k, 2)."""

    @property
    def ends(self) -> Integers:
        """The ends p1 and p3 of each edge; shape (k, 2)."""
        return self.corners[:, [0, 2]]


def interior_edges(F: Integers) -> InteriorEdges:
    """The edges with just two faces, each with its four corners.

    Parameters
    ----------
    F : ndarray of int64, shape (m, 3)

    Returns
    -------
    InteriorEdges
    """
    edges = Edges.of_all(F, int(F.max(initial=0)) + 1)
    two = np.flatnonzero(edges.faces_of_edge == 2)
    # Half-edge r of `half_edges` lies opposite corner r // m of face r % m.
    first = edges.start[two]
    corner, face = np.divmod(edges.half_edges[np.column_stack([first, first + 1])], len(F))
    (p1, p3), (p2, p4) = edges.ends[two].T, F[face, corner].T
    return InteriorEdges(np.column_stack([p1, p2, p3, p4]), face)


def dihedral_angles(V: Floats, H: InteriorEdges) -> Floats:
    """The exterior dihedral angle at each interior edge, in radians: 0 where it is flat.

    Without sign: noise bends edges both ways, and would cancel in a mean of signed angles.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    H : InteriorEdges

    Returns
    -------
    ndarray of float64, shape (k,)
        0 to pi; 0 at a degenerate triangle.
    """
    p1, p2, p3, p4 = (V[corner] for corner in H.corners.T)
    n2, n4 = np.cross(p3 - p1, p2 - p1), np.cross(p4 - p1, p3 - p1)
    sine = np.linalg.norm(np.cross(n2, n4), axis=1)
    return np.arctan2(sine, np.sum(n2 * n4, axis=1))
