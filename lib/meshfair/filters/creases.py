"""Creases: the lines along which a surface is bent, and the faces on either side of them.

References
----------
.. [LLL19] T. Li, W. Liu, H. Liu, J. Wang, L. Liu, "Feature-convinced mesh denoising",
   Graphical Models 101, 2019.
"""

import numpy as np
from scipy.sparse import csr_array

from meshfair import _fast
from meshfair.checks import Booleans, Floats, Integers
from meshfair.filters.neighbourhoods import entries
from meshfair.mesh import InteriorEdges, dihedral_angles, normalised

PATCH = 12  # faces at most in the mean that guides a face
STRAIGHT = 2.5  # radians: consecutive edges of a crease line meet at a wider angle


def crease_edges(
    V: Floats, H: InteriorEdges, cosine: float, *, gap: int, shortest: int
) -> Booleans:
    """Trace the lines of creases [LLL19]_.

    Candidates are the edges whose two normals have a smaller cosine than the
    given one. From each, the most bent first, a line is followed to both
    sides: at each vertex along the most bent edge that goes on nearly
    straight (by more than 2.5 radians), a candidate where there is one. Other
    edges bridge gaps: they belong to the line if a candidate follows at most
    ``gap`` of them, or if one of the next ``gap + 1`` ends on an earlier line.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
        A smooth copy of the mesh.
    H : InteriorEdges, with k edges
    cosine : float
    gap : int
    shortest : int
        Lines of fewer edges are dropped.

    Returns
    -------
    ndarray of bool, shape (k,)
    """
    bend = dihedral_angles(V, H)
    return trace_lines(V, H.ends, bend, np.cos(bend) < cosine, gap, shortest)


def trace_lines(
    V: Floats, ends: Integers, bend: Floats, candidate: Booleans, gap: int, shortest: int
) -> Booleans:
    """Trace lines through these candidates, as `crease_edges` has it.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    ends : ndarray of int64, shape (k, 2)
        The vertices that each edge joins.
    bend : ndarray of float64, shape (k,)
    candidate : ndarray of bool, shape (k,)
    gap, shortest : int

    Returns
    -------
    ndarray of bool, shape (k,)
    """
    seeds = np.flatnonzero(candidate)
    seeds = seeds[np.argsort(-bend[seeds], kind="stable")]
    if _fast.wanted(len(V), _fast.FILTER_ROWS):
        straight = np.cos(STRAIGHT)
        return _fast.creases.trace_lines(seeds, V, ends, bend, candidate, gap, shortest, straight)
    lines = _Lines(ends, *continuations(V, ends, bend, candidate), candidate, gap, shortest)
    for seed in seeds.tolist():
        lines.trace(seed)
    return np.array(lines.crease, dtype=bool)


def continuations(
    V: Floats, ends: Integers, bend: Floats, candidate: Booleans
) -> tuple[Integers, Integers]:
    """By which edges a line may go on nearly straight, the best first.

    An edge e is followed in two directions: half-edge 2 e + s leads to its end ``ends[e, s]``.
    Candidates are better than others, and then what is more bent.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    ends : ndarray of int64, shape (k, 2)
    bend : ndarray of float64, shape (k,)
    candidate : ndarray of bool, shape (k,)

    Returns
    -------
    start : ndarray of int64, shape (2 k + 1,)
    onward : ndarray of int64
        Half-edge h goes on by the half-edges ``onward[start[h] : start[h + 1]]``.
    """
    head, tail = ends.ravel(), ends[:, ::-1].ravel()
    half_edges = np.arange(len(head))
    into = csr_array((np.ones(len(head)), (half_edges, head)), shape=(len(head), len(V)))
    h, g = entries(into @ into.T)  # all pairs of half-edges that lead to the same vertex
    back, on = V[tail[h]] - V[head[h]], V[tail[g]] - V[head[h]]
    lengths = np.sqrt(np.sum(back**2, axis=1) * np.sum(on**2, axis=1))
    straight = np.sum(back * on, axis=1) <= np.cos(STRAIGHT) * lengths
    h, g = h[straight], g[straight]
    order = np.lexsort((g, -bend[g // 2], ~candidate[g // 2], h))
    return np.searchsorted(h[order], np.append(half_edges, len(head))), g[order] ^ 1


class _Lines:
    """The lines of creases while they are traced, one after the other."""

    def __init__(
        self,
        ends: Integers,
        start: Integers,
        onward: Integers,
        candidate: Booleans,
        gap: int,
        shortest: int,
    ) -> None:
        self.head, self.candidate = ends.ravel().tolist(), candidate.tolist()
        self.start, self.onward = start.tolist(), onward.tolist()
        self.gap, self.shortest = gap, shortest
        self.used = [False] * len(ends)  # edges
        self.crease = [False] * len(ends)  # edges
        self.reached: set[int] = set()  # vertices on lines

    def trace(self, seed: int) -> None:
        """Follow a line from a seed to both sides, unless one goes through it already."""
        if self.used[seed]:
            return
        self.used[seed] = True
        line = [seed, *self._follow(2 * seed), *self._follow(2 * seed + 1)]
        if len(line) >= self.shortest:
            for e in line:
                self.crease[e] = True
                self.reached.update(self.head[2 * e : 2 * e + 2])

    def _follow(self, h: int) -> list[int]:
        """The edges by which the line goes on from half-edge h."""
        path: list[int] = []
        sure = 0  # this many edges belong to the line; those after them may bridge a gap
        while self.head[h] not in self.reached and len(path) - sure <= self.gap:
            following = self._next(h)
            if following is None:
                break
            h = following
            path.append(h // 2)
            self.used[h // 2] = True
            if self.candidate[h // 2]:
                sure = len(path)
        if self.head[h] in self.reached:
            sure = len(path)
        for e in path[sure:]:
            self.used[e] = False
        return path[:sure]

    def _next(self, h: int) -> int | None:
        """The best half-edge that goes on from h on an edge of no line; None without one."""
        onward = self.onward[self.start[h] : self.start[h + 1]]
        return next((g for g in onward if not self.used[g // 2]), None)


def crease_guidance(pairs: Integers, N: Floats, area: Floats, C: Floats) -> Floats:
    """The mean normal, by area, of the faces around each face on its side of the creases.

    From each face a patch is grown: again and again by the adjacent face whose
    centroid is nearest, up to `PATCH` faces, never across a crease [LLL19]_.

    Parameters
    ----------
    pairs : ndarray of int64, shape (k, 2)
        Adjacent faces with no crease between them.
    N : ndarray of float64, shape (m, 3)
        Normals.
    area : ndarray of float64, shape (m,)
    C : ndarray of float64, shape (m, 3)
        Centroids.

    Returns
    -------
    ndarray of float64, shape (m, 3)
        Unit vectors; zero where the patch's normals cancel.
    """
    f, g = pairs.T
    ones = np.ones(2 * len(f), dtype=np.int8)
    graph = csr_array((ones, (np.append(f, g), np.append(g, f))), shape=(len(N), len(N)))
    if _fast.wanted(len(N), _fast.FILTER_ROWS):
        return _fast.creases.patch_means(graph, N, area, C, PATCH)
    beside, patch = _padded_rows(graph), np.arange(len(N))[:, None]
    for _ in range(PATCH - 1):  # all patches grow by one face at once
        around = beside[patch].reshape(len(N), -1)
        distance = sum((c[around] - c[:, None]) ** 2 for c in C.T)
        taken = (around[:, :, None] == patch[:, None]).any(axis=2)
        distance[(around < 0) | taken] = np.inf
        nearest = np.take_along_axis(around, distance.argmin(axis=1)[:, None], axis=1)
        patch = np.append(patch, np.where(distance.min(axis=1) < np.inf, nearest.T, -1).T, axis=1)
    w = np.where(patch < 0, 0.0, area[patch])
    return normalised(np.sum(w[:, :, None] * N[patch], axis=1), w.sum(axis=1))


def _padded_rows(graph: csr_array) -> Integers:
    """The columns that each row lists, and -1 up to one width; a last row has -1 only."""
    i, j = entries(graph)
    slot = np.arange(len(j)) - graph.indptr[i]
    rows = np.full((graph.shape[0] + 1, slot.max(initial=0) + 1), -1)
    rows[i, slot] = j
    return rows
