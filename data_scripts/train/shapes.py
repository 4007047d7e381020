"""The shapes that the network learns from: made here, each from its number."""

import numpy as np
from arrays import Mesh, compact
from grids import grid
from reliefs import RELIEFS, with_relief
from solids import solid, thin
from surfaces import blobs, rounded, sheets
from tessellations import WAYS, cut, isotropic, subdivided, with_detail

from meshfair import mesh
from meshfair.checks import Floats, Integers

# Generators, how often each is taken, and how often its shapes get fine detail.
SHARP = {solid: (0.33, 0.12), thin: (0.1, 0.1)}
SMOOTH = {rounded: (0.18, 0.35), blobs: (0.21, 0.75), sheets: (0.06, 0.4)}
REGULAR = {grid: (0.12, 0.15)}
RELIEF = 0.45  # share of the details that are a relief, and no waves

FACES = 2_000, 4_500  # the least and the most that are asked for, where there are edges
COARSE = 600  # the least where it is smooth
FEWEST, MOST = 400, 9_000  # what may come of it


def shape(number: int) -> Mesh:
    """A training shape: vertices and faces."""
    for attempt in range(50):
        V, F = _attempt(np.random.default_rng([number, attempt]))
        if FEWEST <= len(F) <= MOST and not mesh.degenerate_faces(V, F).any():
            return V, F
    raise RuntimeError(f"training shape {number} has not come about in 50 attempts")


def _attempt(rng: np.random.Generator) -> Mesh:
    makers = SHARP | SMOOTH | REGULAR
    make = _drawn({maker: share for maker, (share, _) in makers.items()}, rng)
    way = _drawn(WAYS, rng)
    least, most = FACES if make in SHARP else (COARSE, FACES[1])
    faces = int(np.exp(rng.uniform(np.log(least), np.log(most))))
    raw = make in SMOOTH and rng.random() < 0.15  # as marching cubes leaves it
    if make in SHARP or make in REGULAR:
        V, F = make(rng)
    else:
        V, F = make(rng, int(rng.integers(20, 30) if raw else rng.integers(44, 60)))
    if not len(F):
        return V, F
    if make in SMOOTH:
        V, F = _largest_part(V, F)
    if not raw and make not in REGULAR:
        V, F = (isotropic if make in SMOOTH and way is subdivided else way)(V, F, faces, rng)
    if rng.random() < makers[make][1]:
        if rng.random() < RELIEF:
            V = with_relief(RELIEFS[rng.integers(len(RELIEFS))], V, F, rng)
        else:
            V = with_detail(V, F, rng)
    if rng.random() < 0.15:
        V, F = cut(V, F, rng)
    return V, F


def _drawn(shares: dict, rng: np.random.Generator):  # type: ignore[no-untyped-def]
    return list(shares)[rng.choice(len(shares), p=np.array(list(shares.values())))]


def _largest_part(V: Floats, F: Integers) -> Mesh:
    _, part = mesh.components(F, len(V))
    of_face = part[F[:, 0]]
    return compact(V, F[of_face == np.bincount(of_face).argmax()])
