"""How far two surfaces are from each other, whatever their vertices are.

References
----------
.. [CRS98] P. Cignoni, C. Rocchini, R. Scopigno, Metro: measuring error on simplified
   surfaces, Computer Graphics Forum 17(2), 1998.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import Floats, Integers, MeshError, check_mesh, check_vertices
from meshfair.mesh import face_areas, mean_edge_length, takes_meshes
from meshfair.metrics.matching import compact
from meshfair.metrics.measure import Measure
from meshfair.metrics.triangles import squared_distances

SAMPLES = 20_000  # points on each surface, of a mean distance
TOLERANCE = 0.01  # of the Hausdorff distance, up to which it is looked for
FINEST = 1e-3  # mean edge lengths up to which it is looked for, however small it is
MOST = 300_000  # points looked at for it, on each surface; a search that ends here says so


@takes_meshes
def vertex_distance(V: ArrayLike, V_true: ArrayLike, F_true: ArrayLike) -> float:
    """Mean distance from the vertices to the true surface, over its mean edge length.

    Does not punish a vertex that slides along the surface, as the SNR does. What
    lies between the vertices does not count; see `surface_distance`.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    V_true : array_like, shape (n_true, 3)
        Need not have the vertices of ``V``.
    F_true : array_like of integers, shape (m, 3)

    Returns
    -------
    float
        In mean edge lengths of the ground truth. The distances are libigl's.

    Raises
    ------
    MeshError
        No vertices, or no ground truth.
    """
    V = check_vertices(V)
    true, X, _ = _in_edges(*check_mesh(V_true, F_true), V)
    return float(true.distances(X).mean())


@takes_meshes
def surface_distance(V: ArrayLike, F: ArrayLike, V_true: ArrayLike, F_true: ArrayLike) -> Measure:
    """Mean distance between two surfaces, over the ground truth's mean edge length.

    Half of the mean distance from the points of the one to the other, and half
    of that back, as Metro [CRS98]_ measures them. Each mean is taken over 20,000
    points, spread evenly over the area by random numbers that are the same in
    every call.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    V_true : array_like, shape (n_true, 3)
    F_true : array_like of integers, shape (m_true, 3)

    Returns
    -------
    Measure
        In mean edge lengths of the ground truth. ``bound`` is two standard errors,
        as if the points were independent: the true mean is that close to
        ``value``, on either side, in at least 19 of 20 cases.

    Raises
    ------
    MeshError
        One of the two is no mesh, or has no area.
    """
    surface, true = _both(V, F, V_true, F_true)
    there = true.distances(surface.sample("the mesh"))
    back = surface.distances(true.sample("the ground truth"))
    error = np.hypot(there.std(), back.std()) / 2 / np.sqrt(SAMPLES)
    return Measure(float(there.mean() + back.mean()) / 2, float(2 * error))


@takes_meshes
def hausdorff(V: ArrayLike, F: ArrayLike, V_true: ArrayLike, F_true: ArrayLike) -> Measure:
    """Hausdorff distance between two surfaces, over the ground truth's mean edge length.

    The largest distance from a point of either surface, not from a vertex only,
    to the other surface. Faces are divided where a larger distance may still
    hide, until the distance is known to a hundredth of it, or to a thousandth
    of the mean edge length.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    V_true : array_like, shape (n_true, 3)
    F_true : array_like of integers, shape (m_true, 3)

    Returns
    -------
    Measure
        In mean edge lengths of the ground truth. ``value`` is the distance of a
        point that was found, and the Hausdorff distance is at least ``value`` and
        at most ``value + bound``: a bound that holds always, and is larger where
        the search, after 300,000 points, has not come as close.

    Raises
    ------
    MeshError
        One of the two is no mesh.
    """
    surface, true = _both(V, F, V_true, F_true)
    low, high = _farthest(surface, true)
    low, high_back = _farthest(true, surface, low)
    return Measure(low, max(high, high_back, low) - low)


@takes_meshes
def distances(X: ArrayLike, V: ArrayLike, F: ArrayLike) -> Floats:
    """Distance of each of some points from a surface, in the units of the mesh.

    Parameters
    ----------
    X : array_like, shape (k, 3)
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    ndarray of float64, shape (k,)

    Raises
    ------
    MeshError
        No points, or no mesh.
    """
    X = check_vertices(X, "X")
    V, F = check_mesh(V, F)
    surface, points, unit = _in_edges(V, F, X)
    return surface.distances(points) * unit


class _Surface:
    """The points of a mesh's faces, and what is nearest to them."""

    def __init__(self, V: Floats, F: Integers) -> None:
        used, self.F = compact(F)
        self.V = np.ascontiguousarray(V[used])
        self._tree: Any = None  # libigl's, when it is first asked for

    def nearest(self, X: Floats) -> tuple[Floats, Integers]:
        """Distance of each point to the surface, and the face that is nearest to it."""
        import igl  # half a second to load, and seldom needed

        if self._tree is None:
            self._tree = igl.AABB()
            self._tree.init(self.V, self.F)
        squared, faces, _ = self._tree.squared_distance(self.V, self.F, X)
        distance = np.sqrt(np.maximum(squared, 0))
        rounding = 8 * np.finfo(np.float64).eps * max(np.abs(self.V).max(), np.abs(X).max())
        return np.where(distance > rounding, distance, 0.0), faces

    def distances(self, X: Floats) -> Floats:
        """Distance of each point to the surface; shape (k,)."""
        return self.nearest(X)[0]

    def sample(self, name: str) -> Floats:
        """Points spread evenly over the area, the same in every call; shape (SAMPLES, 3)."""
        until = np.cumsum(face_areas(self.V, self.F))
        if until[-1] == 0:
            raise MeshError(f"{name} has no area, so no points that could be spread over it")
        rng = np.random.default_rng(0)
        # Equal steps along the sum of the areas: each face gets its share, to one point.
        steps = (np.arange(SAMPLES) + rng.random()) / SAMPLES * until[-1]
        faces = np.minimum(np.searchsorted(until, steps, side="right"), len(self.F) - 1)
        # Uniform in a triangle: the square root undoes that it narrows towards a corner.
        s, t = np.sqrt(rng.random(SAMPLES)), rng.random(SAMPLES)
        weights = np.stack([1 - s, s * (1 - t), s * t], axis=1)
        return np.einsum("ki,kij->kj", weights, self.V[self.F[faces]])


def _in_edges(V_true: Floats, F_true: Integers, X: Floats) -> tuple[_Surface, Floats, float]:
    """A ground truth and some points, around its centre, in its mean edge length; and that.

    So squares neither overflow nor vanish, nor lose digits far from the origin.
    """
    unit = mean_edge_length(V_true, F_true)
    if unit == 0:
        raise MeshError("V_true has all its vertices in one place, so no edge length as a unit")
    centre = V_true[F_true].reshape(-1, 3).mean(axis=0)
    return _Surface((V_true - centre) / unit, F_true), (X - centre) / unit, unit


def _both(
    V: ArrayLike, F: ArrayLike, V_true: ArrayLike, F_true: ArrayLike
) -> tuple[_Surface, _Surface]:
    """A mesh and its ground truth, checked, in mean edge lengths of the latter."""
    V, F = check_mesh(V, F)
    true, X, _ = _in_edges(*check_mesh(V_true, F_true), V)
    return _Surface(X, F), true


class _Pieces(NamedTuple):
    """Triangles that are parts of a surface's faces, and their corners' way to another one."""

    corners: Floats  # (k, 3, 3)
    distance: Floats  # (k, 3): of the corners from the other surface
    nearest: Integers  # (k, 3): the other's faces that are nearest to them

    def most(self, other: _Surface) -> Floats:
        """No point of a piece is farther from the other surface than this; shape (k,)."""
        return np.min([self.bound(other, self.nearest[:, i]) for i in range(3)], axis=0)

    def bound(self, other: _Surface, faces: Integers) -> Floats:
        """The same by one of the other's faces for each piece.

        The distance to a triangle is convex, so it is largest at a corner.
        """
        T = other.V[other.F[faces]]
        squared = [squared_distances(self.corners[:, i], T) for i in range(3)]
        return np.sqrt(np.max(squared, axis=0))

    def of(self, chosen: Integers) -> "_Pieces":
        """Some of the pieces."""
        return _Pieces(self.corners[chosen], self.distance[chosen], self.nearest[chosen])

    def divided(self, other: _Surface) -> "_Pieces":
        """Each piece as four, divided at the middles of its edges."""
        middles = (self.corners + np.roll(self.corners, -1, axis=1)) / 2
        distance, nearest = other.nearest(middles.reshape(-1, 3))
        corners = np.concatenate([self.corners, middles], axis=1)
        distance = np.concatenate([self.distance, distance.reshape(-1, 3)], axis=1)
        nearest = np.concatenate([self.nearest, nearest.reshape(-1, 3)], axis=1)
        parts = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])
        return _Pieces(
            corners[:, parts].reshape(-1, 3, 3),
            distance[:, parts].reshape(-1, 3),
            nearest[:, parts].reshape(-1, 3),
        )


def _farthest(surface: _Surface, other: _Surface, low: float = 0.0) -> tuple[float, float]:
    """Between which bounds the largest distance lies, from one surface to another.

    Branch and bound: ``low`` is the largest distance of any point looked at, and
    what may hold a larger one is divided, the most promising pieces first.
    """
    distance, nearest = other.nearest(surface.V)
    F = surface.F
    pieces = _Pieces(surface.V[F], distance[F], nearest[F])
    inner, below = other.nearest(pieces.corners.mean(axis=1))
    low = max(low, float(distance.max()), float(inner.max()))
    most = np.minimum(pieces.most(other), pieces.bound(other, below))
    left = MOST
    high = low  # what pieces that are not divided any further may hold
    while True:
        enough = max(TOLERANCE * low, FINEST)
        open_ = most > low + enough
        high = max(high, float(most[~open_].max(initial=0.0)))
        if not open_.any():
            return low, max(low, high)
        if left <= 0:
            return low, max(high, float(most.max()))
        chosen = np.flatnonzero(open_)
        if 3 * len(chosen) > left:
            order = chosen[np.argsort(-most[chosen], kind="stable")]
            chosen, rest = order[: left // 3 + 1], order[left // 3 + 1 :]
            high = max(high, float(most[rest].max(initial=0.0)))
        left -= 3 * len(chosen)
        parents = most[chosen]
        pieces = pieces.of(chosen).divided(other)
        low = max(low, float(pieces.distance.max()))
        # A part holds no more than the whole did.
        most = np.minimum(pieces.most(other), np.tile(parents[:, None], 4).ravel())
