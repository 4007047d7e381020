"""The sums over edges of the network, what comes of it, and their derivatives, for torch.

torch gathers and adds rows by index slowly on a CPU; these loops do it in one
pass each. An edge goes from face i to a face j of its ring, row after row of a
CSR matrix; a face's vectors are a row of 3 x K numbers.
"""

from typing import Any

import moves
import numba
import numpy as np
import torch
from scipy.sparse import csr_array
from torch.autograd.function import once_differentiable

from meshfair.checks import Floats, Integers
from meshfair.filters.face_network import NEAR as NEAR_SQUARED
from meshfair.mesh import face_normals

NEAR = np.float32(NEAR_SQUARED)

loop = numba.njit(fastmath=True, nogil=True, cache=True, error_model="numpy")


class Edges:
    """What does not change along the way: the edges, and vectors and weights along them."""

    def __init__(self, start: Any, end: Any, d: Any, t: Any, e: Any, share: Any) -> None:
        self.arrays = (start, end, d, t, e, share)


class Invariants(torch.autograd.Function):
    """Of each edge: how far v_i is from v_j, d . v_i, d . v_j, t . v_i, t . v_j in channels; e."""

    @staticmethod
    def forward(ctx: Any, v: torch.Tensor, edges: Edges) -> torch.Tensor:
        """Shape (E, 5 K + 2)."""
        ctx.v, ctx.edges = v.detach().numpy(), edges
        return torch.from_numpy(_invariants(ctx.v, *edges.arrays[:5]))

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, g: torch.Tensor) -> Any:
        """By the vectors."""
        return torch.from_numpy(
            _invariants_back(ctx.v, *ctx.edges.arrays[:4], g.contiguous().numpy())
        ), None


class Messages(torch.autograd.Function):
    """z = act(p_i + r_j + y) of each edge."""

    @staticmethod
    def forward(ctx: Any, p: torch.Tensor, r: torch.Tensor, y: torch.Tensor, edges: Edges) -> Any:
        """Shape (E, H)."""
        start, end = edges.arrays[:2]
        z, ctx.slope = _messages(
            start, end, p.detach().numpy(), r.detach().numpy(), y.detach().numpy()
        )
        ctx.edges = edges
        return torch.from_numpy(z)

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, g: torch.Tensor) -> Any:
        """By p, r and y."""
        start, end = ctx.edges.arrays[:2]
        back = _messages_back(start, end, ctx.slope, g.contiguous().numpy())
        return *map(torch.from_numpy, back), None


class Sums(torch.autograd.Function):
    """Of each face: the means of z, and of c v_j for each channel, over its ring."""

    @staticmethod
    def forward(ctx: Any, z: torch.Tensor, c: torch.Tensor, v: torch.Tensor, edges: Edges) -> Any:
        """Shapes (m, H) and (m, 3 K)."""
        ctx.data = z.detach().numpy(), c.detach().numpy(), v.detach().numpy()
        ctx.edges = edges
        return tuple(map(torch.from_numpy, _sums(*ctx.data, *_ends_and_share(edges))))

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, gs: torch.Tensor, gu: torch.Tensor) -> Any:
        """By z, c and v."""
        back = _sums_back(
            *ctx.data, *_ends_and_share(ctx.edges), gs.contiguous().numpy(), gu.contiguous().numpy()
        )
        return *map(torch.from_numpy, back), None


class Mixed(torch.autograd.Function):
    """x @ w for each face: (m, 3, B) and (m, B, K) to (m, 3, K)."""

    @staticmethod
    def forward(ctx: Any, x: torch.Tensor, w: torch.Tensor) -> torch.Tensor:
        """Shape (m, 3, K)."""
        ctx.data = x.detach().contiguous().numpy(), w.detach().contiguous().numpy()
        return torch.from_numpy(_mixed(*ctx.data))

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, g: torch.Tensor) -> Any:
        """By x and w."""
        return tuple(map(torch.from_numpy, _mixed_back(*ctx.data, g.contiguous().numpy())))


class Moved(torch.autograd.Function):
    """The unit normals of the faces, shape (m, 3), after the vertices have moved to fit."""

    @staticmethod
    def forward(ctx: Any, N: torch.Tensor, V: Floats, F: Integers, B: csr_array) -> torch.Tensor:
        """From the normals that the faces should have, the vertices, and who has which face."""
        wanted = N.detach().numpy().astype(float)
        places = moves.places(V, wanted, F, B)
        ctx.data = places, wanted, F, B.indptr, B.indices
        return torch.from_numpy(face_normals(places[-1], F).astype(np.float32))

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, g: torch.Tensor) -> Any:
        """By the normals that the faces should have."""
        back = moves.slopes(*ctx.data, g.contiguous().numpy().astype(float))
        return torch.from_numpy(back.astype(np.float32)), None, None, None


def _ends_and_share(edges: Edges) -> tuple[Any, ...]:
    start, end, *_, share = edges.arrays
    return start, end, share


@loop
def _invariants(v, start, end, d, t, e):
    K = v.shape[1] // 3
    X = np.zeros((len(end), 5 * K + 2), dtype=np.float32)
    for i in range(len(v)):
        for p in range(start[i], start[i + 1]):
            j = end[p]
            x = X[p]
            for axis in range(3):
                a, b, dx, tx = v[i, axis * K :], v[j, axis * K :], d[p, axis], t[p, axis]
                for k in range(K):
                    x[k] += (a[k] - b[k]) ** 2
                    x[K + k] += dx * a[k]
                    x[2 * K + k] += dx * b[k]
                    x[3 * K + k] += tx * a[k]
                    x[4 * K + k] += tx * b[k]
            for k in range(K):
                x[k] /= x[k] + NEAR
            x[5 * K], x[5 * K + 1] = e[p, 0], e[p, 1]
    return X


@loop
def _invariants_back(v, start, end, d, t, g):
    K = v.shape[1] // 3
    back, apart = np.zeros_like(v), np.empty(K, np.float32)
    for i in range(len(v)):
        for p in range(start[i], start[i + 1]):
            j = end[p]
            x = g[p]
            apart[:] = 0
            for axis in range(3):
                a, b = v[i, axis * K :], v[j, axis * K :]
                for k in range(K):
                    apart[k] += (a[k] - b[k]) ** 2
            for k in range(K):
                apart[k] = 2 * x[k] * NEAR / (apart[k] + NEAR) ** 2
            for axis in range(3):
                a, b, dx, tx = v[i, axis * K :], v[j, axis * K :], d[p, axis], t[p, axis]
                ga, gb = back[i, axis * K :], back[j, axis * K :]
                for k in range(K):
                    ga[k] += apart[k] * (a[k] - b[k]) + dx * x[K + k] + tx * x[3 * K + k]
                    gb[k] += apart[k] * (b[k] - a[k]) + dx * x[2 * K + k] + tx * x[4 * K + k]
    return back


@loop
def _messages(start, end, p, r, y):
    z, slope = np.empty_like(y), np.empty_like(y)
    for i in range(len(p)):
        for e in range(start[i], start[i + 1]):
            j = end[e]
            for k in range(y.shape[1]):
                x = p[i, k] + r[j, k] + y[e, k]
                gate = min(max(x / 6 + np.float32(0.5), np.float32(0)), np.float32(1))
                inside = np.float32(1 / 6) if -3 < x < 3 else np.float32(0)
                z[e, k] = x * gate
                slope[e, k] = gate + x * inside
    return z, slope


@loop
def _messages_back(start, end, slope, g):
    m = len(start) - 1
    gp, gr = np.zeros((m, g.shape[1]), np.float32), np.zeros((m, g.shape[1]), np.float32)
    gy = np.empty_like(g)
    for i in range(m):
        for e in range(start[i], start[i + 1]):
            j = end[e]
            for k in range(g.shape[1]):
                x = g[e, k] * slope[e, k]
                gy[e, k] = x
                gp[i, k] += x
                gr[j, k] += x
    return gp, gr, gy


@loop
def _sums(z, c, v, start, end, share):
    m, K, H = len(v), v.shape[1] // 3, z.shape[1]
    s, u = np.zeros((m, H), np.float32), np.zeros_like(v)
    for i in range(m):
        for e in range(start[i], start[i + 1]):
            j, w = end[e], share[e]
            for k in range(H):
                s[i, k] += w * z[e, k]
            for axis in range(3):
                out, b = u[i, axis * K :], v[j, axis * K :]
                for k in range(K):
                    out[k] += w * c[e, k] * b[k]
    return s, u


@loop
def _sums_back(z, c, v, start, end, share, gs, gu):
    m, K, H = len(v), v.shape[1] // 3, z.shape[1]
    gz, gc, gv = np.empty_like(z), np.zeros_like(c), np.zeros_like(v)
    for i in range(m):
        for e in range(start[i], start[i + 1]):
            j, w = end[e], share[e]
            for k in range(H):
                gz[e, k] = w * gs[i, k]
            x = gc[e]
            for axis in range(3):
                g, b, gb = gu[i, axis * K :], v[j, axis * K :], gv[j, axis * K :]
                for k in range(K):
                    x[k] += w * g[k] * b[k]
                    gb[k] += w * g[k] * c[e, k]
    return gz, gc, gv


@loop
def _mixed(x, w):
    m, B, K = w.shape
    y = np.zeros((m, 3, K), np.float32)
    for i in range(m):
        for axis in range(3):
            for b in range(B):
                for k in range(K):
                    y[i, axis, k] += x[i, axis, b] * w[i, b, k]
    return y


@loop
def _mixed_back(x, w, g):
    m, B, K = w.shape
    gx, gw = np.zeros_like(x), np.zeros_like(w)
    for i in range(m):
        for axis in range(3):
            for b in range(B):
                total = np.float32(0)
                for k in range(K):
                    total += g[i, axis, k] * w[i, b, k]
                    gw[i, b, k] += g[i, axis, k] * x[i, axis, b]
                gx[i, axis, b] = total
    return gx, gw
