"""Small meshes with answers that can be worked out by hand, and random ones."""

import numpy as np
from hypothesis import strategies as st

from meshfair import io, shapes

# One right isosceles triangle: angles 90 (at vertex 0), 45 and 45 degrees.
RIGHT_TRIANGLE = (np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))


def fan(faces):
    """Equilateral triangles around one common edge (0, 1): not manifold above two."""
    turn = 2 * np.pi * np.arange(faces) / faces
    height = np.sqrt(3) / 2
    tips = np.column_stack([np.full(faces, 0.5), height * np.cos(turn), height * np.sin(turn)])
    V = np.concatenate([[[0.0, 0, 0], [1, 0, 0]], tips])
    return V, np.array([[0, 1, 2 + k] for k in range(faces)])


def grid(cells=6, irregular=None):
    """A flat open square at z = 0; ``irregular`` moves its inner vertices in the plane."""
    x, y = np.meshgrid(np.arange(cells + 1.0), np.arange(cells + 1.0), indexing="ij")
    V = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    k = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    a, b, c, d = (q.ravel() for q in (k[:-1, :-1], k[1:, :-1], k[1:, 1:], k[:-1, 1:]))
    F = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    if irregular is not None:
        inside = np.all((V[:, :2] > 0) & (V[:, :2] < cells), axis=1)
        V[inside, :2] += irregular.uniform(-0.25, 0.25, (inside.sum(), 2))
    return V, F


CLOSED = {
    "knot": shapes.knot,
    "sphere": lambda: shapes.icosphere(2),
    "torus": lambda: shapes.torus(sections=20, sides=10),
    "box": lambda: shapes.box(segments=(2, 3, 4)),
}


@st.composite
def soups(draw, vertices=12, faces=20):
    """Any triangles over random points: open, not manifold, duplicate, unreferenced, in pieces."""
    n = draw(st.integers(3, vertices))
    m = draw(st.integers(1, faces))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    F = np.array([rng.choice(n, 3, replace=False) for _ in range(m)])
    return rng.standard_normal((n, 3)), F


@st.composite
def rigid_motions(draw):
    """A rotation matrix and a translation."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    Q, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    return Q * np.sign(np.linalg.det(Q)), rng.standard_normal(3)


def pair(mirror, name):
    """A public pair of GuidedDenoising: noisy and noise-free positions, faces."""
    V_noisy, F = io.read(mirror / f"GuidedDenoising-{name}-Noisy.obj")
    V, _ = io.read(mirror / f"GuidedDenoising-{name}-Original.obj")
    return V_noisy, V, F
