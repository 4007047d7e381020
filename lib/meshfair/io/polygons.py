"""Polygons cut into triangles that have their area, also where they are not convex."""

import numpy as np

from meshfair.checks import Booleans, Floats, Integers, install
from meshfair.io.faces import fan

# Rounding may turn a triangle without area round, by this part of its polygon's area.
ROUNDING = 1e-9


def cut(V: Floats, corners: Integers, counts: Integers) -> tuple[Integers | None, str]:
    """Triangles of each face: a fan from its first corner, or ears clipped off where that folds.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    corners, counts
        As in `meshfair.io.faces.check_corners`.

    Returns
    -------
    triangles : ndarray of int64, shape (m, 3), or None
        Of each corner its number in ``corners``, in the order of the faces; a triangle
        is kept as it is. None where all are.
    told : str
        What was done, in words.
    """
    if np.all(counts == 3):
        return None, ""
    triangles = fan(np.arange(len(corners)), counts)
    face = np.repeat(np.arange(len(counts)), counts - 2)
    polygons = np.flatnonzero(_folded(V[corners[triangles]], face, len(counts)))
    told = (
        f"{np.sum(counts > 3)} of {len(counts)} faces have more than three corners "
        f"(up to {counts.max()}); they are cut, which makes {len(triangles)} triangles"
    )
    if not len(polygons):
        return triangles, told
    try:
        import mapbox_earcut
    except ImportError:
        return triangles, (
            f"{told}, of which some are folded in {len(polygons)} polygons that are not convex; "
            f"to cut these well, run: {install('formats')}"
        )
    begin, crossing = np.cumsum(counts) - counts, 0
    for polygon in polygons:
        k = int(counts[polygon])
        X = _flattened(V[corners[begin[polygon] : begin[polygon] + k]])
        clipped = mapbox_earcut.triangulate_float64(X, np.array([k], np.uint32))
        ears = np.array(_with_all_corners(clipped.reshape(-1, 3).tolist(), k), np.int64)
        if len(ears) == k - 2 and _has_area_of(X[ears], X):
            triangles[face == polygon] = begin[polygon] + ears
        else:
            crossing += 1
    if crossing:
        told += f", of which some are folded in {crossing} polygons that cross themselves"
    return triangles, told


def _folded(corners: Floats, face: Integers, number: int) -> Booleans:
    """Whether any triangle of a polygon looks the other way than the polygon as a whole.

    Parameters
    ----------
    corners : ndarray of float64, shape (m, 3, 3)
        Of the triangles.
    face : ndarray of int64, shape (m,)
        The polygon of each triangle.
    number : int
        Number of polygons.
    """
    A, B, C = np.moveaxis(corners, 1, 0)
    areas = np.cross(B - A, C - A)
    whole = np.column_stack([np.bincount(face, column, number) for column in areas.T])
    along = np.einsum("ij,ij->i", areas, whole[face])
    folds = along < -ROUNDING * np.einsum("ij,ij->i", whole, whole)[face]
    return np.bincount(face, folds, number) > 0


def _flattened(X: Floats) -> Floats:
    """A polygon in the plane that it faces, counter-clockwise; shape (k, 2)."""
    X = X - X[0]
    normal = np.cross(X, np.roll(X, -1, axis=0)).sum(axis=0)
    normal /= np.linalg.norm(normal)
    first = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    first /= np.linalg.norm(first)
    return np.column_stack([X @ first, X @ np.cross(normal, first)])


def _with_all_corners(triangles: list[list[int]], k: int) -> list[tuple[int, ...]]:
    """The triangles, cut at those corners of a polygon that they leave out.

    Ear clipping may leave out a corner between two others on one line; the faces beside the
    polygon have it.
    """
    edges = {(t[i - 1], t[i]) for t in triangles for i in range(3)}
    done, open_ = [], [tuple(t) for t in triangles]
    while open_:
        t = open_.pop()
        for p, q, r in (t, t[1:] + t[:1], t[2:] + t[:2]):
            if (q, p) not in edges and (q - p) % k > 1:
                between = (p + 1) % k
                edges |= {(p, between), (between, q), (between, r), (r, between)}
                open_ += [(p, between, r), (between, q, r)]
                break
        else:
            done.append(t)
    return done


def _has_area_of(triangles: Floats, polygon: Floats) -> bool:
    """Whether triangles in the plane look up and have the area of a polygon."""
    A, B, C = np.moveaxis(triangles, 1, 0)
    area = _cross(polygon, np.roll(polygon, -1, axis=0)).sum()
    return bool(np.isclose(np.abs(_cross(B - A, C - A)).sum(), area, rtol=ROUNDING, atol=0))


def _cross(u: Floats, v: Floats) -> Floats:
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
