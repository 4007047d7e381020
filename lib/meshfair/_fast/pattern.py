"""Which entries a mesh's weight matrix has: found once, then only values change."""

import numpy as np
from scipy.sparse import csr_array

from meshfair._fast.kernels import compiled, on_all_cores, threads
from meshfair.checks import MeshError

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
    itself is left out. Duplicate faces count once.

    Parameters
    ----------
    F : ndarray of int64, shape (m, 3)
        Checked; not to be changed while the pattern is in use.
    n : int
        Number of vertices.

    Attributes
    ----------
    n : int
        Number of vertices.
    indptr, indices : ndarray, shapes (n + 1,) and (2k,)
        The pattern of W as `scipy.sparse.csr_array` stores it, for k edges.
    at_ij, at_ji : ndarray, shape (k,)
        Places of (i, j) and of (j, i) among the entries: for edge e,
        j = indices[at_ij[e]] and i = indices[at_ji[e]].
    edge_ptr : ndarray, shape (n + 1,)
        Edges edge_ptr[i] .. edge_ptr[i + 1] - 1 have the lower end i; they are the
        last entries of row i.
    opposite_ptr, opposite : ndarray, shapes (k + 1,) and (h,)
        opposite[opposite_ptr[e] : opposite_ptr[e + 1]] are the vertices opposite
        edge e, one for each of its faces.
    collapsed : bool
        Whether a face has the same vertex at two corners.

    Raises
    ------
    MeshError
        More vertices than fit.

    Notes
    -----
    All index arrays are int32 where the largest index fits, else int64.
    """

    def __init__(self, F, n):
        self.n = n
        if n > LARGEST_VERTEX_COUNT:
            raise MeshError(f"the mesh has {n} vertices; at most {LARGEST_VERTEX_COUNT} fit")
        integer = index_type(6 * len(F), n)

        # Each face has an edge opposite each corner: file it under its lower end.
        places = np.zeros((min(threads(), PARTS), n), dtype=integer)
        faces = _cuts(len(F), len(places))
        self.collapsed = sum(_in_parts(_count, places, faces, F)) > 0
        bounds = np.empty(n + 1, dtype=integer)
        _assign_places(places, np.zeros(n, dtype=integer), bounds)
        keys = np.empty(bounds[n], dtype=np.int64)
        _in_parts(_file, places, faces, F, keys)

        # Sorting brings equal edges together, and duplicate faces are equal keys. Parts have as
        # many keys, not as many vertices: the first vertices are the lower ends of more edges.
        self.edge_ptr, opposites = np.zeros((2, n + 1), dtype=integer)
        vertices = np.searchsorted(bounds, _cuts(len(keys), len(places)))
        places[:] = 0
        _in_parts(_sort, places, vertices, bounds, keys, self.edge_ptr, opposites)

        # Row j holds its lower ends i < j, then the higher ends of its own edges.
        self.indptr = np.empty(n + 1, dtype=integer)
        _assign_places(places, self.edge_ptr[1:], self.indptr)
        np.cumsum(self.edge_ptr, out=self.edge_ptr)
        np.cumsum(opposites, out=opposites)
        k = self.edge_ptr[n]
        self.indices = np.empty(2 * k, dtype=integer)
        self.at_ij, self.at_ji = np.empty((2, k), dtype=integer)
        self.opposite_ptr = np.empty(k + 1, dtype=integer)
        self.opposite_ptr[k] = opposites[n]
        self.opposite = np.empty(opposites[n], dtype=integer)
        _in_parts(
            _list, places, vertices, bounds, keys, self.edge_ptr, opposites, self.indptr,
            self.indices, self.at_ij, self.at_ji, self.opposite_ptr, self.opposite,
        )  # fmt: skip

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


def _cuts(count, parts):
    """Where range(count) is cut into parts of the same length."""
    return np.arange(parts + 1) * count // parts


def _in_parts(kernel, places, cuts, *arguments):
    """Run a kernel that counts or files, each part of its rows with places of its own."""
    return on_all_cores(kernel, len(places), places, cuts, *arguments, block=1)


@compiled
def _assign_places(counts, more, bounds):
    """Turn counts of each part and vertex into each part's first place for each vertex.

    Vertex by vertex, and for a vertex part by part, then ``more`` places;
    ``bounds`` is where those of each vertex begin.
    """
    place = 0
    for i in range(len(more)):
        bounds[i] = place
        for part in range(len(counts)):
            count = counts[part, i]
            counts[part, i] = place
            place += count
        place += more[i]
    bounds[len(more)] = place


@compiled
def _count(first, last, count, cuts, F):
    """Count the half-edges under their lower ends; return the number of collapsed faces."""
    collapsed = 0
    for part in range(first, last):
        for f in range(cuts[part], cuts[part + 1]):
            low = min(F[f, 0], F[f, 1], F[f, 2])
            high = max(F[f, 0], F[f, 1], F[f, 2])
            middle = F[f, 0] + F[f, 1] + F[f, 2] - low - high
            count[part, low] += (low != middle) + (low != high)
            count[part, middle] += middle != high
            collapsed += low == middle or middle == high
    return collapsed


@compiled
def _file(first, last, place, cuts, F, keys):
    """Write the key (higher end, opposite vertex) of each half-edge under its lower end."""
    for part in range(first, last):
        for f in range(cuts[part], cuts[part + 1]):
            low = min(F[f, 0], F[f, 1], F[f, 2])
            high = max(F[f, 0], F[f, 1], F[f, 2])
            middle = F[f, 0] + F[f, 1] + F[f, 2] - low - high
            p = place[part, low]
            if low != middle:
                keys[p] = middle << 32 | high
                p += 1
            if low != high:
                keys[p] = high << 32 | middle
                p += 1
            place[part, low] = p
            if middle != high:
                keys[place[part, middle]] = high << 32 | low
                place[part, middle] += 1


@compiled
def _sort(first, last, count, cuts, bounds, keys, edge_count, opposite_count):
    """Sort each vertex's keys (shell sort); count its edges, at either end, and different keys."""
    for part in range(first, last):
        for i in range(cuts[part], cuts[part + 1]):
            start, stop = bounds[i], bounds[i + 1]
            gap = 1
            while 16 * gap < stop - start:  # few keys need no larger gap than 1
                gap = 3 * gap + 1
            while gap > 0:
                for p in range(start + gap, stop):
                    key, q = keys[p], p
                    while q >= start + gap and keys[q - gap] > key:
                        keys[q] = keys[q - gap]
                        q -= gap
                    keys[q] = key
                gap //= 3
            edges, opposites, previous = 0, 0, -1
            for p in range(start, stop):
                key = keys[p]
                if key >> 32 != previous >> 32:
                    edges += 1
                    count[part, key >> 32] += 1
                opposites += key != previous
                previous = key
            edge_count[i + 1], opposite_count[i + 1] = edges, opposites


@compiled
def _list(
    first, last, below, cuts, bounds, keys, edge, slot, indptr,
    indices, at_ij, at_ji, opposite_ptr, opposite,
):  # fmt: skip
    """Write each edge (i, j) to its two entries, and the vertices opposite it to their list.

    below[part, j] is the next free entry in row j.
    """
    for part in range(first, last):
        for i in range(cuts[part], cuts[part + 1]):
            e, s = edge[i], slot[i]
            p = indptr[i + 1] - (edge[i + 1] - e)
            previous = -1
            for at in range(bounds[i], bounds[i + 1]):
                key = keys[at]
                j = key >> 32
                if j != previous >> 32:
                    q = below[part, j]
                    below[part, j] = q + 1
                    indices[p], indices[q] = j, i
                    at_ij[e], at_ji[e] = p, q
                    opposite_ptr[e] = s
                    p += 1
                    e += 1
                if key != previous:
                    opposite[s] = key & 0xFFFFFFFF
                    s += 1
                previous = key
