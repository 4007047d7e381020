"""Cotangent weights that are never negative, on any triangle mesh: intrinsic Delaunay.

A weight (cot alpha + cot beta) / 2 is negative where the two angles sum to
more than 180 degrees. Replacing the edge by the other diagonal of its two
triangles would repair that, but change the surface, if it were done in space.
Done *intrinsically*, it changes nothing: the new edge is the straight line
drawn inside the old, bent surface, of which only the length is needed. Such
flips, repeated until no angle sum is above 180 degrees, end with a
triangulation of the same surface whose weights are all nonnegative [BS07]_.

The flips need a closed surface with two triangles at each edge. Every mesh
gets one through its tufted cover [SC20]_: each triangle is doubled into a
front and a back, and around each edge the front of a triangle is sewn to the
back of the next. At a boundary the front is sewn to the back of the same
triangle. Half of the cover's weights are the mesh's.

References
----------
.. [BS07] A. Bobenko, B. Springborn, "A discrete Laplace-Beltrami operator for
   simplicial surfaces", Discrete & Computational Geometry 38, 2007.
.. [SC20] N. Sharp, K. Crane, "A Laplacian for nonmanifold triangle meshes",
   Computer Graphics Forum (SGP) 39(5), 2020.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import coo_array, csr_array

from meshfair import _fast
from meshfair.checks import (
    Floats,
    Integers,
    MeshError,
    check_mesh,
    check_number,
    warn,
)
from meshfair.mesh import Edges, unique_faces
from meshfair.mesh.objects import takes_meshes
from meshfair.mesh.topology import topologically_degenerate

# Angle sums are compared through their sine, which rounding moves by about 1e-15.
ROUNDING = 1e-13
# Many more flips an edge than any mesh was seen to need; against an endless loop.
MOST_FLIPS = 100


class Triangulation(NamedTuple):
    """An intrinsic triangulation: who is joined to whom, and how far along the surface.

    Half-edge 3 t + k is the side of triangle t that starts at its corner k.
    Two triangles may share two sides, and a side may end where it starts.
    """

    tail: Integers
    """The vertex that each half-edge starts at; int64, shape (3 t,)."""
    twin: Integers
    """The half-edge on the other side of the same edge; int64, shape (3 t,)."""
    length: Floats
    """In mean edge lengths of the mesh; float64, shape (3 t,)."""
    sheets: int
    """How often the surface is covered: once or twice."""


@takes_meshes
def cotangent(V: ArrayLike, F: ArrayLike, *, mollify: float = 1e-6) -> csr_array:
    """Nonnegative cotangent weights, of the intrinsic Delaunay triangulation [BS07]_ [SC20]_.

    On any mesh: with a boundary, non-manifold or non-orientable, too; of
    duplicate faces one counts. ``L = D - W`` is then positive semidefinite with no
    positive entry off its diagonal, and every averaging step with
    0 < tau <= 1 is stable.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    mollify : float
        Triangles are widened, by adding one length to all edges, until each
        two sides together are longer than the third by this fraction of the
        mean edge length [SC20]_. On a mesh of proper triangles nothing is
        added. With 0, degenerate faces are refused.

    Returns
    -------
    csr_array of float64, shape (n, n)
        Symmetric, without unit. Its entries are where the flipped edges are,
        which need not be edges of the mesh.

    Raises
    ------
    MeshError, ValueError
        No mesh, nothing but collapsed faces, ``mollify`` outside [0, 1], or
        degenerate faces with ``mollify`` 0.

    Warns
    -----
    MeshWarning
        Where the flips did not come to an end; the negative weights that are
        left are then set to 0.

    See Also
    --------
    meshfair.weights.cotangent : on the mesh's own edges.
    """
    V, F = check_mesh(V, F)
    D = delaunay(V, F, mollify=mollify)
    w = _half_cotangents(D.length.reshape(-1, 3)).ravel() / D.sheets
    tip = D.tail.reshape(-1, 3)[:, [1, 2, 0]].ravel()
    W = coo_array((w, (D.tail, tip)), shape=(len(V), len(V))).tocsr()
    W = (W + W.T).tocsr()
    W.setdiag(0)  # an edge from a vertex to itself: x_i - x_i is 0 anyway
    W.data = np.maximum(W.data, 0)  # rounding
    W.eliminate_zeros()
    return W


def delaunay(V: ArrayLike, F: ArrayLike, *, mollify: float = 1e-6) -> Triangulation:
    """The intrinsic Delaunay triangulation of a mesh, or of its tufted cover.

    Parameters
    ----------
    V, F, mollify
        As in `cotangent`.

    Returns
    -------
    Triangulation
        Of the mesh itself where it is closed, manifold and consistently
        oriented, and else of its tufted cover, with two sheets.

    Raises
    ------
    MeshError, ValueError
        As `cotangent`.

    Warns
    -----
    MeshWarning
        As `cotangent`.
    """
    V, F = check_mesh(V, F)
    mollify = check_number(mollify, "mollify", 0, 1)
    T = unique_faces(F)
    T = T[~topologically_degenerate(T)]
    if not len(T):
        raise MeshError("every face names a vertex twice, so there is no triangle at all")
    tail, twin = _cover(T)
    tip = tail.reshape(-1, 3)[:, [1, 2, 0]].ravel()
    length = _mollified(np.linalg.norm(V[tail] - V[tip], axis=1), T, mollify)
    sheets = len(tail) // (3 * len(T))
    most = MOST_FLIPS * len(tail)
    if _fast.wanted(len(T), _fast.FILTER_ROWS):
        ended = _fast.intrinsic.flip_until_delaunay(tail, twin, length, most, ROUNDING)
    else:
        flips = _Flips(tail, twin, length)
        ended = flips.until_delaunay(most)
        tail, twin, length = (np.array(x) for x in (flips.tail, flips.twin, flips.length))
    if not ended:
        warn(
            f"the intrinsic flips did not end after {MOST_FLIPS} for each edge; a larger mollify "
            "makes thin triangles wider"
        )
    return Triangulation(tail, twin, length, sheets)


def _cover(F: Integers) -> tuple[Integers, Integers]:
    """Tails and twins of the tufted cover's half-edges, its front only if that is closed."""
    m = len(F)
    front, back = F, F[:, [0, 2, 1]]
    tail = np.concatenate([front, back]).ravel()
    edges = Edges.of_all(F, int(F.max()) + 1)
    # Edges number half-edges by the opposite corner c: from corner c + 1 to c + 2.
    c, f = np.divmod(edges.half_edges, m)
    along = 3 * f + (c + 1) % 3
    against = 3 * (f + m) + np.array([1, 0, 2])[c]  # the same side, seen from the back
    rising = F[f, (c + 1) % 3] < F[f, (c + 2) % 3]
    up, down = np.where(rising, along, against), np.where(rising, against, along)
    # In each edge's group, sew the upward side to the next triangle's downward side.
    following = np.arange(1, len(f) + 1)
    following[edges.start[1:] - 1] = edges.start[:-1]
    twin = np.empty(6 * m, dtype=np.int64)
    twin[up] = down[following]
    twin[down[following]] = up
    if (twin[: 3 * m] < 3 * m).all():
        return tail[: 3 * m].copy(), twin[: 3 * m].copy()
    return tail, twin


def _mollified(length: Floats, F: Integers, mollify: float) -> Floats:
    """Lengths in mean edge lengths, all grown by what the flattest triangle needs."""
    mean = length.mean()
    if mean == 0:
        raise MeshError("all faces have shrunk to points, so there is no triangle at all")
    sides = length.reshape(-1, 3) / mean
    excess = sides.sum(axis=1) - 2 * sides.max(axis=1)
    flattest = excess.argmin()
    if excess[flattest] <= 0 and mollify == 0:
        raise MeshError(
            f"the face with vertices {F[flattest % len(F)].tolist()} is degenerate; "
            "give mollify above 0"
        )
    return (sides + max(0.0, mollify - excess[flattest])).ravel()


def _half_cotangents(sides: Floats) -> Floats:
    """(b^2 + c^2 - a^2) / (8 area): half the cotangent opposite each side, shape (t, 3)."""
    c, b, a = np.sort(sides, axis=1).T
    # As in `_area`, for all triangles at once.
    product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
    area = np.sqrt(np.maximum(product, np.finfo(float).tiny)) / 4
    squares = sides**2
    return (squares.sum(axis=1, keepdims=True) / 2 - squares) / (4 * area[:, None])


class _Flips:
    """A triangulation while its edges are flipped, as plain lists."""

    def __init__(self, tail: Integers, twin: Integers, length: Floats) -> None:
        self.tail, self.twin, self.length = tail.tolist(), twin.tolist(), length.tolist()

    def until_delaunay(self, most: int) -> bool:
        """Flip edges until no two opposite angles sum to more than 180 degrees.

        Returns whether that took no more than ``most`` flips.
        """
        waiting = list(range(len(self.twin)))
        is_waiting = [True] * len(waiting)
        flips = 0
        while waiting:
            h = waiting.pop()
            is_waiting[h] = False
            if self._is_delaunay(h):
                continue
            if flips == most:
                return False
            flips += 1
            for side in self._flip(h):
                if not (is_waiting[side] or is_waiting[self.twin[side]]):
                    is_waiting[side] = True
                    waiting.append(side)
        return True

    def _is_delaunay(self, h: int) -> bool:
        """Whether the two angles opposite this edge sum to at most 180 degrees."""
        if self.twin[h] // 3 == h // 3:  # a triangle sewn to itself is a cone, and Delaunay
            return True
        ab = self.length[h]
        (xc, yc), (xd, yd) = self._tips(h)
        # The sine of the sum of the angles at c and at d, by products of the sides there.
        cos_c, cos_d = xc * (xc - ab) + yc * yc, xd * (xd - ab) + yd * yd
        sides = math.prod(self.length[side] for side in self._diamond(h))
        return ab * (yc * cos_d - cos_c * yd) >= -ROUNDING * sides

    def _diamond(self, h: int) -> tuple[int, int, int, int]:
        """Half-edges bc, ca, ad, db of the triangles (a, b, c) and (b, a, d) at h from a to b."""
        g = self.twin[h]
        return _next(h), _next(_next(h)), _next(g), _next(_next(g))

    def _tips(self, h: int) -> tuple[tuple[float, float], tuple[float, float]]:
        """Where c and d lie if the diamond is laid out with a = (0, 0) and b = (ab, 0)."""
        bc, ca, ad, db = (self.length[side] for side in self._diamond(h))
        xd, yd = _tip(self.length[h], db, ad)
        return _tip(self.length[h], bc, ca), (xd, -yd)

    def _flip(self, h: int) -> list[int]:
        """Replace ab by cd: (d, c, a) takes the half-edges of h, (c, d, b) those of its twin.

        Returns the half-edges of the diamond's four sides.
        """
        g, (bc, ca, ad, db) = self.twin[h], self._diamond(h)
        (xc, yc), (xd, yd) = self._tips(h)
        moved = {ca: bc, ad: ca, db: ad, bc: db}  # each side, and where it is stored from now on
        sides = [(self.tail[side], self.twin[side], self.length[side]) for side in moved]
        self.tail[h], self.tail[g] = self.tail[db], self.tail[ca]
        self.length[h] = self.length[g] = math.hypot(xc - xd, yc - yd)
        for to, (tail, twin, length) in zip(moved.values(), sides, strict=True):
            twin = moved.get(twin, twin)  # the diamond's sides may be sewn to one another
            self.tail[to], self.length[to] = tail, length
            self.twin[to], self.twin[twin] = twin, to
        return list(moved.values())


def _next(h: int) -> int:
    """The half-edge that follows in the same triangle."""
    return h - 2 if h % 3 == 2 else h + 1


def _tip(ab: float, bc: float, ca: float) -> tuple[float, float]:
    """Where c lies above the line from a = (0, 0) to b = (ab, 0)."""
    x = (ab + (ca - bc) * (ca + bc) / ab) / 2
    return x, 2 * _area(ab, bc, ca) / ab


def _area(*sides: float) -> float:
    """Heron's formula as Kahan writes it: accurate for needles too."""
    c, b, a = sorted(sides)
    product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
    return math.sqrt(max(product, 0.0)) / 4
