"""The messages of the learned filter, face by face: no array has a row for each pair of faces."""

import numpy as np

from meshfair._fast.kernels import compiled, helper, on_all_cores, unsigned

# Faces that a thread takes at a time: each has a dozen messages of some thousand products.
BLOCK = 1024


def mean_lengths(R, C, area, total):
    """As `meshfair.filters.face_network.Rings.mean_length`."""
    length = np.empty(len(C))
    rows = unsigned(R.indptr, R.indices)
    on_all_cores(_mean_lengths, len(C), *rows, C, area, total, length, block=BLOCK)
    return length


def message_sums(w, p, r, v, rings, near, most):
    """As `meshfair.filters.face_network.message_sums`, with its P [...] as p, its Q [...] as r.

    `near` and `most` are that module's constants.
    """
    s, u = np.empty_like(p), np.empty_like(v)
    on_all_cores(
        _message_sums, len(v), *unsigned(rings.R.indptr, rings.R.indices),
        rings.C, rings.smooth, rings.area, rings.total, rings.size,
        near, most, p, r, v, *_transposed(w), s, u, block=BLOCK,
    )  # fmt: skip
    return s, u


def _transposed(w):
    edge, along = (np.ascontiguousarray(w[f"{name}.weight"].T) for name in ("edge", "along"))
    return edge, along, w["along.bias"]


@helper
def _way(C, i, j, size):
    """(c_j - c_i) / size."""
    return (C[j, 0] - C[i, 0]) / size, (C[j, 1] - C[i, 1]) / size, (C[j, 2] - C[i, 2]) / size


@compiled
def _mean_lengths(first, last, start, faces, C, area, total, length):
    for i in range(first, last):
        length[i] = 0.0
        for p in range(start[i], start[i + 1]):
            j = faces[p]
            x, y, z = _way(C, i, j, 1.0)
            length[i] += area[j] / total[i] * np.sqrt(x * x + y * y + z * z)


@compiled(fused=True)
def _message_sums(
    first, last, start, faces, C, smooth, area, total, size, near, most,
    p, r, v, edge, along, bias, s, u,
):  # fmt: skip
    H, K = p.shape[1], v.shape[2]
    x, z, c = np.empty(5 * K + 2), np.empty(H), np.empty(K)
    for i in range(first, last):
        s[i] = 0.0
        u[i] = 0.0
        for e in range(start[i], start[i + 1]):
            j = faces[e]
            share = area[j] / total[i]
            d = _way(C, i, j, size[i])
            t = _way(smooth, i, j, size[i])
            for k in range(K):
                apart = 0.0
                for axis in range(3):
                    apart += (v[i, axis, k] - v[j, axis, k]) ** 2
                x[k] = apart / (apart + near)
                x[K + k] = d[0] * v[i, 0, k] + d[1] * v[i, 1, k] + d[2] * v[i, 2, k]
                x[2 * K + k] = d[0] * v[j, 0, k] + d[1] * v[j, 1, k] + d[2] * v[j, 2, k]
                x[3 * K + k] = t[0] * v[i, 0, k] + t[1] * v[i, 1, k] + t[2] * v[i, 2, k]
                x[4 * K + k] = t[0] * v[j, 0, k] + t[1] * v[j, 1, k] + t[2] * v[j, 2, k]
            x[5 * K] = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
            x[5 * K + 1] = min(max(np.log(area[j] / area[i]), -most), most)
            for h in range(H):
                z[h] = p[i, h] + r[j, h]
            for a in range(len(x)):
                for h in range(H):
                    z[h] += x[a] * edge[a, h]
            for k in range(K):
                c[k] = bias[k]
            for h in range(H):
                z[h] *= min(max(z[h] / 6 + 0.5, 0.0), 1.0)
                s[i, h] += share * z[h]
                for k in range(K):
                    c[k] += z[h] * along[h, k]
            for k in range(K):
                u[i, 0, k] += share * c[k] * v[j, 0, k]
                u[i, 1, k] += share * c[k] * v[j, 1, k]
                u[i, 2, k] += share * c[k] * v[j, 2, k]
