"""The network of the learned filter: faces that pass messages to the faces around them.

Each face has scalars h_i and vectors v_i. Every number that the network sees is an invariant,
such as an inner product of two vectors; every vector is a sum of normals, weighted by what the
network says. So the result turns, mirrors and scales with the mesh, and a plane stays one.

Every function takes weights by the names that they have in training.
"""

from functools import cached_property
from typing import TypeAlias

import numpy as np
from scipy.sparse import csr_array

from meshfair import _fast
from meshfair.checks import Floats
from meshfair.filters.neighbourhoods import entries
from meshfair.filters.normal_bank import COUNT
from meshfair.mesh import normalised

Weights: TypeAlias = dict[str, Floats]

# Normals a face that a stage is given: the bank, and two of the stage before.
BANK = COUNT + 2
SCALARS, CHANNELS, HIDDEN, LAYERS = 32, 8, 32, 3
# Logarithms of ratios of areas and lengths are cut off here; of areas, so are tiny ones.
MOST, LEAST_AREA = 5.0, 1e-6
# Normals nearer than this, half a degree, count as equal; squared distance of vectors that is
# neither near nor far, about that of two normals at 18 degrees.
LEAST_APART, NEAR = 0.01, 0.1
# Faces whose inner products are in memory at the same time.
BLOCK = 16_384


class Rings:
    """The faces around each face, and what the network sees along the way to them.

    Parameters
    ----------
    R : csr_array, shape (m, m)
        See `meshfair.filters.neighbourhoods.face_rings`.
    C, smooth : ndarrays of float64, shape (m, 3)
        Centroids, and those of a smoothed surface.
    area : ndarray of float64, shape (m,)
    """

    def __init__(self, R: csr_array, C: Floats, smooth: Floats, area: Floats) -> None:
        self.R, self.C, self.smooth = R, C, smooth
        self.area = np.maximum(area / (area.mean() or 1.0), LEAST_AREA)
        self.total = R.astype(bool) @ self.area
        length = self.mean_length
        self.size = np.maximum(length, LEAST_AREA * length.mean())
        self.size[self.size == 0] = 1.0

    @cached_property
    def share(self) -> Floats:
        """Of each pair: the area of face j, as a part of the ring of face i."""
        i, j = entries(self.R)
        return self.area[j] / self.total[i]

    @cached_property
    def mean_length(self) -> Floats:
        """The mean distance of each centroid from those of its ring, shape (m,)."""
        if _fast.wanted(len(self.C), _fast.FILTER_ROWS):
            return _fast.learned.mean_lengths(self.R, self.C, self.area, self.total)
        i, j = entries(self.R)
        length = np.linalg.norm(self.C[j] - self.C[i], axis=1)
        return np.add.reduceat(self.share * length, self.R.indptr[:-1])

    @cached_property
    def ways(self) -> tuple[Floats, Floats, Floats]:
        """Of each pair: c_j - c_i in sizes of ring i, the same when smoothed; two numbers."""
        i, j = entries(self.R)
        size = self.size[i][:, None]
        d, t = (self.C[j] - self.C[i]) / size, (self.smooth[j] - self.smooth[i]) / size
        ratio = np.clip(np.log(self.area[j] / self.area[i]), -MOST, MOST)
        return d, t, np.column_stack([np.linalg.norm(d, axis=1), ratio])

    @property
    def scalars(self) -> Floats:
        """Of each face: its area in that of its ring, and the ring's size, both logarithms."""
        mean = self.total / np.diff(self.R.indptr)
        ratios = np.column_stack([self.area / mean, self.size / self.size.mean()])
        return np.clip(np.log(ratios), -MOST, MOST)


def invariants(G: Floats, scalars: Floats) -> Floats:
    """How far each two of the normals that a face has are apart, and its other scalars.

    log(LEAST_APART + |g_a - g_b|) + 2, of size 1: a noise of a degree is as far from
    one of ten as that is from one of a hundred.

    Parameters
    ----------
    G : ndarray of float64, shape (m, BANK, 3)
    scalars : ndarray of float64, shape (m, 2)

    Returns
    -------
    ndarray of float64, shape (m, BANK (BANK - 1) / 2 + 2)
    """
    a, b = np.triu_indices(BANK, 1)
    squared = sum((x[:, a] - x[:, b]) ** 2 for x in np.moveaxis(G, 2, 0))
    return np.concatenate([np.log(LEAST_APART + np.sqrt(squared)) + 2, scalars], axis=1)


def first_features(w: Weights, G: Floats, rings: Rings) -> tuple[Floats, Floats]:
    """What a face has before the first message: scalars, and vectors that mix its normals.

    h_i from the `invariants` of the normals g_ib of the bank, and, through their mean,
    from those of all faces; v_ik = sum_b mix_bk(h_i) g_ib.

    Parameters
    ----------
    w : dict
        The weights of a stage, see `trained`.
    G : ndarray of float64, shape (m, BANK, 3)
    rings : Rings

    Returns
    -------
    h : ndarray of float64, shape (m, SCALARS)
    v : ndarray of float64, shape (m, 3, CHANNELS)
    """
    scalars, m = rings.scalars, len(G)
    h, v = np.empty((m, SCALARS)), np.empty((m, 3, CHANNELS))
    for rows in _blocks(m):
        x = invariants(G[rows], scalars[rows])
        h[rows] = _linear(w, "second", _act(_linear(w, "first", x)))
    h += _linear(w, "all", h.mean(axis=0))
    for rows in _blocks(m):
        mix = _linear(w, "mix", h[rows]).reshape(-1, BANK, CHANNELS)
        v[rows] = G[rows].transpose(0, 2, 1) @ mix
    return h, v


def exchanged(w: Weights, layer: int, h: Floats, v: Floats, rings: Rings) -> tuple[Floats, Floats]:
    """Features after one exchange of messages within the rings.

    With `message_sums` s and u, a network of two layers finds from h, s, |v|^2 and |u|^2 what
    to add to the scalars and how to mix the vectors v and u; both are then normalised.

    Parameters
    ----------
    w : dict
        The weights of a stage, see `trained`.
    layer : int
    h : ndarray of float64, shape (m, SCALARS)
    v : ndarray of float64, shape (m, 3, CHANNELS)
    rings : Rings

    Returns
    -------
    h, v
        As they were given.
    """
    prefix = f"layers.{layer}."
    w = {name.removeprefix(prefix): x for name, x in w.items() if name.startswith(prefix)}
    s, u = message_sums(w, h, v, rings)
    h_new, v_new = np.empty_like(h), np.empty_like(v)
    for rows in _blocks(len(h)):
        q = np.concatenate([h[rows], _squares(v[rows]), s[rows], _squares(u[rows])], axis=1)
        x = _linear(w, "second", _act(_linear(w, "first", q)))
        x_h, mix = x[:, :SCALARS], x[:, SCALARS:].reshape(-1, 2 * CHANNELS, CHANNELS)
        y = v[rows] + u[rows] + 0.1 * (np.concatenate([v[rows], u[rows]], axis=2) @ mix)
        v_new[rows] = y / np.sqrt(0.01 + _squares(y).mean(axis=1))[:, None, None]
        y = h[rows] + x_h
        y = (y - y.mean(axis=1, keepdims=True)) / np.sqrt(y.var(axis=1, keepdims=True) + 1e-5)
        h_new[rows] = y * w["norm.weight"] + w["norm.bias"]
    return h_new, v_new


def message_sums(w: Weights, h: Floats, v: Floats, rings: Rings) -> tuple[Floats, Floats]:
    """The means of the messages that each face gets from its ring.

    With a_ij the share that face j has in the area of ring i, d_ij and t_ij the ways to j's
    centroid,

        z_ij = act(P [h_i, |v_i|^2] + Q [h_j, |v_j|^2] + R x_ij),   s_i = sum_j a_ij z_ij,
        u_i = sum_j a_ij w(z_ij) v_j,

    where x_ij holds |v_i - v_j|^2 / (|v_i - v_j|^2 + NEAR), <d_ij, v_i>, <d_ij, v_j>,
    <t_ij, v_i> and <t_ij, v_j> of each channel, the length of d_ij and the logarithm of the
    ratio of areas.

    Parameters
    ----------
    w : dict
        The weights of a layer.
    h : ndarray of float64, shape (m, SCALARS)
    v : ndarray of float64, shape (m, 3, CHANNELS)
    rings : Rings

    Returns
    -------
    s : ndarray of float64, shape (m, HIDDEN)
    u : ndarray of float64, shape (m, 3, CHANNELS)
    """
    q = np.concatenate([h, _squares(v)], axis=1)
    p, r = _linear(w, "own", q), _linear(w, "other", q)
    if _fast.wanted(len(h), _fast.FILTER_ROWS):
        return _fast.learned.message_sums(w, p, r, v, rings, NEAR, MOST)
    i, j = entries(rings.R)
    d, t, e = rings.ways
    apart = np.sum((v[i] - v[j]) ** 2, axis=1)
    dots = [apart / (apart + NEAR)]
    dots += [np.sum(x[:, :, None] * v[k], axis=1) for x in (d, t) for k in (i, j)]
    z = _act(p[i] + r[j] + _linear(w, "edge", np.concatenate([*dots, e], axis=1)))
    vectors = _linear(w, "along", z)[:, None] * v[j]
    share, start = rings.share, rings.R.indptr[:-1]
    s = np.add.reduceat(share[:, None] * z, start)
    return s, np.add.reduceat(share[:, None, None] * vectors, start)


def normals(w: Weights, h: Floats, v: Floats, G: Floats) -> Floats:
    """n_i = sum_k a_k(h_i) v_ik + sum_b b_b(h_i) g_ib, normalised.

    The b_b are above 0 and add up to 1, so that the network can choose one of the bank.

    Parameters
    ----------
    w : dict
        The weights of a stage, see `trained`.
    h : ndarray of float64, shape (m, SCALARS)
    v : ndarray of float64, shape (m, 3, CHANNELS)
    G : ndarray of float64, shape (m, BANK, 3)

    Returns
    -------
    ndarray of float64, shape (m, 3)
        Unit vectors; zero where all that they are made of is zero.
    """
    N = np.empty((len(h), 3))
    for rows in _blocks(len(h)):
        q = np.concatenate([h[rows], _squares(v[rows])], axis=1)
        x = _linear(w, "out", _act(_linear(w, "third", q)))
        x[:, CHANNELS:] = np.exp(x[:, CHANNELS:] - x[:, CHANNELS:].max(axis=1, keepdims=True))
        x[:, CHANNELS:] /= x[:, CHANNELS:].sum(axis=1, keepdims=True)
        vectors = np.concatenate([v[rows], G[rows].transpose(0, 2, 1)], axis=2)
        N[rows] = (vectors @ x[:, :, None])[:, :, 0]
    return normalised(N)


def _blocks(m: int) -> list[slice]:
    return [slice(first, min(first + BLOCK, m)) for first in range(0, m, BLOCK)]


def _linear(w: Weights, name: str, x: Floats) -> Floats:
    y = x @ w[f"{name}.weight"].T
    return y + w[f"{name}.bias"] if f"{name}.bias" in w else y


def _act(x: Floats) -> Floats:
    """The network's bend: x where x is large, 0 where it is much below 0."""
    return x * np.clip(x / 6 + 0.5, 0, 1)


def _squares(v: Floats) -> Floats:
    """|v_k|^2 of each channel: (m, 3, K) to (m, K)."""
    return np.sum(v * v, axis=1)
