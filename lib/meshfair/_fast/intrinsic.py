"""Intrinsic flips, in place on the arrays of a triangulation."""

import numpy as np

from meshfair._fast.kernels import compiled


@compiled
def flip_until_delaunay(tail, twin, length, most, rounding):
    """Flip edges, in place, until no two opposite angles sum to more than 180 degrees.

    Returns whether that took no more than ``most`` flips.
    """
    waiting = np.arange(len(tail))
    is_waiting = np.ones(len(tail), dtype=np.bool_)
    count, flips = len(waiting), 0
    while count:
        count -= 1
        h = waiting[count]
        is_waiting[h] = False
        if twin[h] // 3 == h // 3:  # a triangle sewn to itself is a cone, and Delaunay
            continue
        delaunay, new_length = _measure(h, twin, length, rounding)
        if delaunay:
            continue
        if flips == most:
            return False
        flips += 1
        for side in _flip(h, tail, twin, length, new_length):
            if not (is_waiting[side] or is_waiting[twin[side]]):
                is_waiting[side] = True
                waiting[count] = side
                count += 1
    return True


@compiled
def _diamond(h, g):
    """Half-edges bc, ca, ad, db of the triangles (a, b, c) and (b, a, d) at h, with twin g."""
    return _following(h, 1), _following(h, 2), _following(g, 1), _following(g, 2)


@compiled
def _following(h, k):
    return h - h % 3 + (h + k) % 3


@compiled
def _tip(ab, bc, ca):
    """Place c above the line from a = (0, 0) to b = (ab, 0)."""
    x = (ab + (ca - bc) * (ca + bc) / ab) / 2
    long, short = max(ab, bc, ca), min(ab, bc, ca)
    middle = max(min(ab, bc), min(max(ab, bc), ca))
    product = (long + (middle + short)) * (short - (long - middle))
    product *= (short + (long - middle)) * (long + (middle - short))
    return x, np.sqrt(max(product, 0.0)) / (2 * ab)


@compiled
def _measure(h, twin, length, rounding):
    """Whether the angles opposite ab sum to at most 180 degrees, and the length of cd."""
    bc, ca, ad, db = _diamond(h, twin[h])
    ab = length[h]
    xc, yc = _tip(ab, length[bc], length[ca])
    xd, yd = _tip(ab, length[db], length[ad])
    # The sine of the sum of the angles at c and at d, by products of the sides there.
    cos_c, cos_d = xc * (xc - ab) + yc * yc, xd * (xd - ab) + yd * yd
    size = length[bc] * length[ca] * length[ad] * length[db]
    return ab * (yc * cos_d + cos_c * yd) >= -rounding * size, np.hypot(xc - xd, yc + yd)


@compiled
def _flip(h, tail, twin, length, new_length):
    """The triangles become (d, c, a) on h's half-edges and (c, d, b) on its twin's."""
    g = twin[h]
    bc, ca, ad, db = _diamond(h, g)
    old, new = (ca, ad, db, bc), (bc, ca, ad, db)
    tails = (tail[ca], tail[ad], tail[db], tail[bc])
    twins = (twin[ca], twin[ad], twin[db], twin[bc])
    lengths = (length[ca], length[ad], length[db], length[bc])
    tail[h], tail[g] = tail[db], tail[ca]
    length[h] = length[g] = new_length
    for k in range(4):
        # The diamond's sides may be sewn to one another; then both have moved.
        other = twins[k]
        for side in range(4):
            if twins[k] == old[side]:
                other = new[side]
        tail[new[k]], length[new[k]] = tails[k], lengths[k]
        twin[new[k]], twin[other] = other, new[k]
    return new
