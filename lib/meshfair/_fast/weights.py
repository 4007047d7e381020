"""Distance and cotangent weights, filled into a known sparsity pattern."""

import numpy as np

from meshfair._fast.kernels import compiled, helper, on_all_cores, unsigned
from meshfair.checks import DEGENERATE, ROUNDED


def combinatorial(pattern):
    """As `meshfair.weights.combinatorial`."""
    return pattern.matrix(np.ones(len(pattern.indices)))


def distance(V, pattern):
    """As `meshfair.weights.distance`."""
    W = np.empty(len(pattern.indices))
    on_all_cores(_distance, len(V), V, *unsigned(pattern.indptr, pattern.indices), W)
    return pattern.matrix(W)


def cotangent(V, pattern):
    """As `meshfair.weights.cotangent`, and whether a face is degenerate."""
    P = pattern
    W = np.empty(len(P.indices))
    degenerate = on_all_cores(
        _cotangent, len(V), V,
        *unsigned(P.indptr, P.indices, P.edge_ptr, P.at_ji, P.opposite_ptr, P.opposite), W,
    )  # fmt: skip
    return P.matrix(W), bool(P.collapsed or sum(degenerate))


@helper
def _difference(V, i, j):
    return V[i, 0] - V[j, 0], V[i, 1] - V[j, 1], V[i, 2] - V[j, 2]


@helper
def _dot(u, v):
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


@helper
def _cross(u, v):
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


@helper
def _largest(V, i):
    return max(abs(V[i, 0]), abs(V[i, 1]), abs(V[i, 2]))


@compiled
def _distance(first, last, V, indptr, indices, W):
    for i in range(first, last):
        for p in range(indptr[i], indptr[i + 1]):
            e = _difference(V, i, indices[p])
            W[p] = np.sqrt(_dot(e, e))


@compiled
def _cotangent(first, last, V, indptr, indices, edge_ptr, at_ji, opposite_ptr, opposite, W):
    """For each edge (i, j) add cot = u . v / |u x v| over the vertices k opposite it."""
    degenerate = 0
    for i in range(first, last):
        for e in range(edge_ptr[i], edge_ptr[i + 1]):
            p = indptr[i + 1] - (edge_ptr[i + 1] - e)  # the edges are the last entries of row i
            j = indices[p]
            edge = _difference(V, i, j)
            largest = max(_largest(V, i), _largest(V, j))
            cotangents = 0.0
            for s in range(opposite_ptr[e], opposite_ptr[e + 1]):
                u, v = _difference(V, i, opposite[s]), _difference(V, j, opposite[s])
                normal = _cross(u, v)
                doubled_area = np.sqrt(_dot(normal, normal))
                longest = max(_dot(u, u), _dot(v, v), _dot(edge, edge))
                rounded = ROUNDED * max(largest, _largest(V, opposite[s])) * np.sqrt(longest)
                if doubled_area <= max(DEGENERATE * longest, rounded):
                    degenerate += 1
                else:
                    cotangents += _dot(u, v) / doubled_area
            W[p] = W[at_ji[e]] = cotangents / 2
    return degenerate
