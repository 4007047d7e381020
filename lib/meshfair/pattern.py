"""Which entries a mesh's weight matrix has: found once, then only values change."""

import numpy as np
from scipy.sparse import csr_array

from meshfair.checks import MeshError, check_faces
from meshfair.kernels import compiled, on_all_cores, threads

# Two vertex indices share one 64-bit key while they are built.
LARGEST_VERTEX_COUNT = 2**31 - 1
# Filing is done in this many parts at most: each needs memory for every vertex.
PARTS = 4


class Pattern:
    """The edges of a mesh and where they stand in a csr_array of shape (n, n).

    A matrix W of weights has one value for each edge {i, j}, at (i, j) and at
    (j, i). The value comes from the vertices at the edge and from those
    opposite it. All this depends on the faces only, not on where the vertices
    are: a flow that moves them builds one pattern and fills it again and again.

    Edge e joins i < j; edges are sorted by i, then j. An edge from a vertex to
    itself is left out. A face that is stored twice counts once.

    Parameters
    ----------
    F : array_like of integers, shape (m, 3)
        Not to be changed while the pattern is in use.
    n : int
        Number of vertices.

    Attributes
    ----------
    n : int
        Number of vertices.
    F : ndarray of int64, shape (m, 3)
        The faces as given.
    indptr, indices : ndarray, shapes (n + 1,) and (2k,)
        The pattern of W as `scipy.sparse.csr_array` stores it, for k edges.
    upper, lower : ndarray, shape (k,)
        Places of (i, j) and of (j, i) among the entries: for edge e,
        j = indices[upper[e]] and i = indices[lower[e]].
    first, opposite : ndarray, shapes (k + 1,) and (h,)
        opposite[first[e] : first[e + 1]] are the vertices opposite edge e,
        one for each of its faces.
    collapsed : bool
        Whether a face has the same vertex at two corners.

    Raises
    ------
    MeshError
        No triangles, or an index outside 0 .. n - 1.

    Notes
    -----
    All index arrays are int32 where the largest index fits, else int64.
    """

    def __init__(self, F, n):
        self.n, self.F = n, check_faces(F, n)
        if n > LARGEST_VERTEX_COUNT:
            raise MeshError(f"the mesh has {n} vertices; at most {LARGEST_VERTEX_COUNT} fit")
        integer = index_type(6 * len(self.F), n)

        # Each face has an edge opposite each corner: file it under its lower end.
        places = np.zeros((min(threads(), PARTS), n), dtype=integer)
        self.collapsed = sum(_in_parts(_count, places, self.F)) > 0
        bounds = _free_places(places)
        keys = np.empty(bounds[n], dtype=np.int64)
        _in_parts(_file, places, self.F, keys)

        # Sorting brings equal edges together, and repeated faces are equal keys.
        edges, opposites = np.zeros((2, n + 1), dtype=integer)
        on_all_cores(_sort, n, bounds, keys, edges, opposites)
        upper_count = edges[1:].copy()
        np.cumsum(edges, out=edges)
        np.cumsum(opposites, out=opposites)
        k = edges[n]
        higher = np.empty(k, dtype=integer)
        self.first = np.empty(k + 1, dtype=integer)
        self.first[k] = opposites[n]
        self.opposite = np.empty(opposites[n], dtype=integer)
        on_all_cores(
            _list, n, bounds, keys, edges, opposites, higher, self.first, self.opposite
        )  # fmt: skip

        # Row j holds its lower ends i < j, then the higher ends of its own edges.
        places[:] = 0
        _in_parts(_count_ends, places, edges, higher)
        self.indptr = _free_places(places, upper_count)
        self.indices = np.empty(2 * k, dtype=integer)
        self.upper, self.lower = np.empty((2, k), dtype=integer)
        _in_parts(_place, places, edges, higher, self.indptr, self.indices, self.upper, self.lower)

    def matrix(self, data):
        """The csr_array with these values in the order of its entries.

        It shares nothing with the pattern but ``data``.
        """
        W = csr_array((data, self.indices.copy(), self.indptr.copy()), shape=(self.n, self.n))
        W.has_canonical_format = True  # spares SciPy the search
        return W


def index_type(*largest):
    """int32 where these counts fit into it, else int64."""
    return np.int32 if max(largest) <= np.iinfo(np.int32).max else np.int64


def _in_parts(kernel, places, *arguments):
    """Run a kernel that counts or files, each part of its rows with places of its own."""
    return on_all_cores(kernel, len(places), places, *arguments, block=1)


def _free_places(counts, more=0):
    """Turn counts of each part and vertex into each part's first place for each vertex.

    Vertex by vertex, and for a vertex part by part, then ``more`` empty places.
    Returns where the places of each vertex begin, shape (n + 1,).
    """
    before = np.cumsum(counts, axis=0, dtype=counts.dtype)
    bounds = np.zeros(counts.shape[1] + 1, dtype=counts.dtype)
    np.cumsum(before[-1] + more, out=bounds[1:])
    np.subtract(bounds[:-1] + before, counts, out=counts)
    return bounds


@compiled
def _count(first, last, count, F):
    """Count the half-edges under their lower ends; return the number of collapsed faces."""
    collapsed = 0
    for part in range(first, last):
        for f in range(part * len(F) // len(count), (part + 1) * len(F) // len(count)):
            a, b, c = F[f, 0], F[f, 1], F[f, 2]
            collapsed += a == b or b == c or c == a
            for i, j in ((b, c), (c, a), (a, b)):
                if i != j:
                    count[part, min(i, j)] += 1
    return collapsed


@compiled
def _file(first, last, place, F, keys):
    """Write the key (higher end, opposite vertex) of each half-edge under its lower end."""
    for part in range(first, last):
        for f in range(part * len(F) // len(place), (part + 1) * len(F) // len(place)):
            a, b, c = F[f, 0], F[f, 1], F[f, 2]
            for i, j, k in ((b, c, a), (c, a, b), (a, b, c)):
                if i != j:
                    low = min(i, j)
                    keys[place[part, low]] = max(i, j) << 32 | k
                    place[part, low] += 1


@compiled
def _sort(first, last, bounds, keys, edge_count, opposite_count):
    """Sort each vertex's keys (shell sort), and count its edges and its different keys."""
    for i in range(first, last):
        start, stop = bounds[i], bounds[i + 1]
        gap = 1
        while 3 * gap + 1 < stop - start:
            gap = 3 * gap + 1
        while gap > 0:
            for p in range(start + gap, stop):
                key, q = keys[p], p
                while q >= start + gap and keys[q - gap] > key:
                    keys[q] = keys[q - gap]
                    q -= gap
                keys[q] = key
            gap //= 3
        previous = -1
        for p in range(start, stop):
            edge_count[i + 1] += keys[p] >> 32 != previous >> 32
            opposite_count[i + 1] += keys[p] != previous
            previous = keys[p]


@compiled
def _list(first, last, bounds, keys, edge, slot, higher, first_opposite, opposite):
    """Write each edge's higher end, and the vertices opposite it, to the lists' places."""
    for i in range(first, last):
        e, s = edge[i], slot[i]
        previous = -1
        for p in range(bounds[i], bounds[i + 1]):
            key = keys[p]
            if key >> 32 != previous >> 32:
                higher[e] = key >> 32
                first_opposite[e] = s
                e += 1
            if key != previous:
                opposite[s] = key & 0xFFFFFFFF
                s += 1
            previous = key


@compiled
def _count_ends(first, last, count, edges, higher):
    """Count for each vertex the edges of which it is the higher end."""
    n = len(edges) - 1
    for part in range(first, last):
        for e in range(edges[part * n // len(count)], edges[(part + 1) * n // len(count)]):
            count[part, higher[e]] += 1


@compiled
def _place(first, last, below, edges, higher, indptr, indices, upper, lower):
    """Write each edge (i, j) to its two entries; below[j] is the next free one in row j."""
    n = len(edges) - 1
    for part in range(first, last):
        for i in range(part * n // len(below), (part + 1) * n // len(below)):
            p = indptr[i + 1] - (edges[i + 1] - edges[i])
            for e in range(edges[i], edges[i + 1]):
                j = higher[e]
                q = below[part, j]
                below[part, j] += 1
                indices[p], indices[q] = j, i
                upper[e], lower[e] = p, q
                p += 1
