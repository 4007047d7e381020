"""The shapes that the network learns from: made here, each from its number."""

from typing import Any

import numpy as np
import pymeshlab as ml
from arrays import Mesh, compact
from grids import grid
from reliefs import with_any_relief
from solids import solid, thin
from surfaces import blobs, rounded, sheets
from tessellations import WAYS, cut, isotropic, near, subdivided, with_detail, with_roughness

from meshfair import mesh
from meshfair.checks import Floats, Integers

# Generators, how often each is taken, and how often its shapes get fine detail.
SHARP = {solid: (0.3, 0.12), thin: (0.1, 0.1)}
SMOOTH = {rounded: (0.18, 0.4), blobs: (0.25, 0.8), sheets: (0.06, 0.5)}
REGULAR = {grid: (0.11, 0.15)}
DETAILS = {with_detail: 0.4, with_any_relief: 0.35, with_roughness: 0.25}
RAW = 0.15  # share of the smooth shapes that are as marching cubes leaves them
PART = 0.3  # share of the others that are a part of a shape with more faces, as of a scan

FACES = 2_000, 4_500  # the least and the most that are asked for, where there are edges
COARSE = 600  # the least where it is smooth
FEWEST, MOST = 400, 9_000  # what may come of it


def shape(number: int) -> Mesh:
    """A training shape: vertices and faces."""
    for attempt in range(50):
        try:
            V, F = _attempt(np.random.default_rng([number, attempt]))
        except ml.PyMeshLabException:  # such as a solid that is not manifold after all
            continue
        if FEWEST <= len(F) <= MOST and not mesh.degenerate_faces(V, F).any():
            return V, F
    raise RuntimeError(f"training shape {number} has not come about in 50 attempts")


def _attempt(rng: np.random.Generator) -> Mesh:
    makers = SHARP | SMOOTH | REGULAR
    make = _drawn({maker: share for maker, (share, _) in makers.items()}, rng)
    way = _drawn(WAYS, rng)
    least, most = FACES if make in SHARP else (COARSE, FACES[1])
    faces = int(np.exp(rng.uniform(np.log(least), np.log(most))))
    if make in SMOOTH:
        V, F = _smooth(make, way, faces, rng)
    else:
        V, F = make(rng)
        if make in SHARP and len(F):
            V, F = way(V, F, faces, rng)
    if not len(F):
        return V, F
    if rng.random() < makers[make][1]:
        V = _drawn(DETAILS, rng)(V, F, rng)
    if rng.random() < 0.15:
        V, F = cut(V, F, rng)
    return V, F


def _smooth(make: Any, way: Any, faces: int, rng: np.random.Generator) -> Mesh:
    raw, part = rng.random() < RAW, rng.random() < PART
    cells = (20, 30) if raw else (80, 110) if part else (44, 60)
    V, F = make(rng, int(rng.integers(*cells)))
    if not len(F):
        return V, F
    V, F = _largest_part(V, F)
    if raw:
        return V, F
    if part:
        faces = max(faces, FACES[0])
        V, F = isotropic(V, F, int(faces * rng.uniform(3, 8)), rng)
        return _largest_part(*near(V, F, faces, rng)) if len(F) else (V, F)
    return (isotropic if way is subdivided else way)(V, F, faces, rng)


def _drawn(shares: dict, rng: np.random.Generator):  # type: ignore[no-untyped-def]
    return list(shares)[rng.choice(len(shares), p=np.array(list(shares.values())))]


def _largest_part(V: Floats, F: Integers) -> Mesh:
    _, part = mesh.components(F, len(V))
    of_face = part[F[:, 0]]
    return compact(V, F[of_face == np.bincount(of_face).argmax()])
