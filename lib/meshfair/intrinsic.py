"""Cotangent weights that are never negative, on any triangle mesh: intrinsic Delaunay.

A weight (cot alpha + cot beta) / 2 is negative where the two angles sum to
more than 180 degrees. Replacing the edge by the other diagonal of its two
triangles would mend that, but change the surface, if it were done in space.
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

import warnings
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array

from meshfair._fast.kernels import compiled
from meshfair.checks import MeshError, MeshWarning, check_mesh, check_number
from meshfair.mesh import Edges, unique_faces
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

    tail: np.ndarray
    """The vertex that each half-edge starts at; int64, shape (3 t,)."""
    twin: np.ndarray
    """The half-edge on the other side of the same edge; int64, shape (3 t,)."""
    length: np.ndarray
    """In mean edge lengths of the mesh; float64, shape (3 t,)."""
    sheets: int
    """How often the surface is covered: once or twice."""


def cotangent(V, F, *, mollify=1e-6):
    """Nonnegative cotangent weights, of the intrinsic Delaunay triangulation [BS07]_ [SC20]_.

    On any mesh: with a boundary, non-manifold or one-sided, too; of repeated
    faces one counts. ``L = D - W`` is then positive semidefinite with no
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


def delaunay(V, F, *, mollify=1e-6):
    """The intrinsic Delaunay triangulation of a mesh, or of its tufted cover.

    Parameters, errors and warnings are those of `cotangent`.

    Returns
    -------
    Triangulation
        Of the mesh itself where it is closed, manifold and consistently
        oriented, and else of its tufted cover, with two sheets.
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
    if not _flip_to_delaunay(tail, twin, length, MOST_FLIPS * len(tail)):
        warnings.warn(
            f"the intrinsic flips did not end after {MOST_FLIPS} for each edge; a larger mollify "
            "makes thin triangles wider",
            MeshWarning,
            stacklevel=3,
        )
    return Triangulation(tail, twin, length, sheets)


def _cover(F):
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


def _mollified(length, F, mollify):
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


def _half_cotangents(sides):
    """(b^2 + c^2 - a^2) / (8 area): half the cotangent opposite each side, shape (t, 3)."""
    c, b, a = np.sort(sides, axis=1).T
    # Heron's formula as Kahan writes it: accurate for needles too.
    product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
    area = np.sqrt(np.maximum(product, np.finfo(float).tiny)) / 4
    squares = sides**2
    return (squares.sum(axis=1, keepdims=True) / 2 - squares) / (4 * area[:, None])


@compiled
def _flip_to_delaunay(tail, twin, length, most):
    """Flip edges, in place, until no two opposite angles sum to more than 180 degrees.

    Returns whether that took no more than ``most`` flips.
    """

    def apex(ab, bc, ca):
        """Place c above the line from a = (0, 0) to b = (ab, 0)."""
        x = (ab + (ca - bc) * (ca + bc) / ab) / 2
        long, short = max(ab, bc, ca), min(ab, bc, ca)
        middle = max(min(ab, bc), min(max(ab, bc), ca))
        product = (long + (middle + short)) * (short - (long - middle))
        product *= (short + (long - middle)) * (long + (middle - short))
        return x, np.sqrt(max(product, 0.0)) / (2 * ab)

    waiting = np.arange(len(tail))
    is_waiting = np.ones(len(tail), dtype=np.bool_)
    count, flips = len(waiting), 0
    while count:
        count -= 1
        h = waiting[count]
        is_waiting[h] = False
        g = twin[h]
        if g // 3 == h // 3:  # a triangle sewn to itself is a cone, and Delaunay
            continue
        # The diamond around the edge from a to b: triangles (a, b, c) and (b, a, d).
        bc, ca = h - h % 3 + (h + 1) % 3, h - h % 3 + (h + 2) % 3
        ad, db = g - g % 3 + (g + 1) % 3, g - g % 3 + (g + 2) % 3
        ab = length[h]
        xc, yc = apex(ab, length[bc], length[ca])
        xd, yd = apex(ab, length[db], length[ad])
        # The sine of the sum of the angles at c and at d, by products of the sides there.
        cos_c, cos_d = xc * (xc - ab) + yc * yc, xd * (xd - ab) + yd * yd
        size = length[bc] * length[ca] * length[ad] * length[db]
        if ab * (yc * cos_d + cos_c * yd) >= -ROUNDING * size:
            continue
        if flips == most:
            return False
        flips += 1

        # The triangles become (d, c, a) on h's sides and (c, d, b) on g's.
        cd = np.hypot(xc - xd, yc + yd)
        at_c, at_d = tail[ca], tail[db]
        side_ca, side_ad, side_db, side_bc = length[ca], length[ad], length[db], length[bc]
        twin_ca, twin_ad, twin_db, twin_bc = twin[ca], twin[ad], twin[db], twin[bc]
        at_a, at_b = tail[h], tail[g]
        new_ca, new_ad, new_db, new_bc = bc, ca, ad, db
        tail[h], tail[new_ca], tail[new_ad] = at_d, at_c, at_a
        tail[g], tail[new_db], tail[new_bc] = at_c, at_d, at_b
        length[h] = length[g] = cd
        length[new_ca], length[new_ad] = side_ca, side_ad
        length[new_db], length[new_bc] = side_db, side_bc
        for new, other in (
            (new_ca, twin_ca), (new_ad, twin_ad), (new_db, twin_db), (new_bc, twin_bc),
        ):  # fmt: skip
            # The diamond's sides may be sewn to one another; then both have moved.
            if other == ca:
                other = new_ca
            elif other == ad:
                other = new_ad
            elif other == db:
                other = new_db
            elif other == bc:
                other = new_bc
            twin[new], twin[other] = other, new
        for side in (new_ca, new_ad, new_db, new_bc):
            if not (is_waiting[side] or is_waiting[twin[side]]):
                is_waiting[side] = True
                waiting[count] = side
                count += 1
    return True
