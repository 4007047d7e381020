"""Small meshes that are broken, each in a way known by hand, and random ones that are in any."""

import numpy as np
from hypothesis import strategies as st

TETRAHEDRON = (
    np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]),
)


def bow_tie():
    """Two triangles that share a vertex only: vertex 2 has two fans."""
    V = np.array([[-1.0, -1, 0], [-1, 1, 0], [0, 0, 0], [1, -1, 0], [1, 1, 0]])
    return V, np.array([[0, 2, 1], [2, 3, 4]])


def hourglass():
    """Two tetrahedra that share vertex 0: closed, each edge with two faces, two closed fans."""
    V, F = TETRAHEDRON
    other = np.where(F == 0, 0, F + 3)
    return np.concatenate([V, -V[1:]]), np.concatenate([F, other[:, [0, 2, 1]]])


def moebius_strip(segments=9):
    """A strip with half a twist: one loop, one side, so two neighbours disagree somewhere."""
    t = 2 * np.pi * np.arange(segments) / segments
    rows = []
    for w in (-0.4, 0.4):
        r = 2 + w * np.cos(t / 2)
        rows.append(np.column_stack([r * np.cos(t), r * np.sin(t), w * np.sin(t / 2)]))
    V = np.stack(rows, axis=1).reshape(-1, 3)
    k = np.arange(segments)
    a, b = 2 * k, 2 * k + 1
    c, d = np.roll(a, -1), np.roll(b, -1)
    c[-1], d[-1] = 1, 0  # the twist
    return V, np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)])


@st.composite
def wild_meshes(draw, vertices=8, faces=14):
    """Any faces over few points: duplicate, degenerate in any way, not manifold, in pieces."""
    n = draw(st.integers(3, vertices))
    index = st.integers(0, n - 1)
    F = draw(st.lists(st.tuples(index, index, index), min_size=1, max_size=faces))
    place = st.sampled_from([-1.0, -0.0, 0.0, 0.5, 1.0, 3.0])
    V = draw(st.lists(st.tuples(place, place, place), min_size=n, max_size=n))
    return np.array(V), np.array(F, dtype=np.int64)
