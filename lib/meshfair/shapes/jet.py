"""A fighter aircraft in the manner of the F-16, with missiles thin enough for a filter to eat.

All parts come from one construction, `loft`: a closed surface through a row of
cross-sections, with triangles of one size. `body` and `wing` turn tables of
stations into the cross-sections of round and of flat parts.

Axes: x forward, y to the left, z up, in metres. The aircraft is 15 long, the
origin in the middle of its fuselage.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import Floats, Integers, check_number

Mesh: TypeAlias = tuple[Floats, Integers]
Point: TypeAlias = tuple[float, float, float]
Rows: TypeAlias = Sequence[tuple[float, float, float, float]]

EDGE = 0.2  # length of the edges at detail 1; a missile is less than two of them across
SMALLEST_RING = 6  # vertices around the thinnest sections, so that a tube stays a tube

# Bodies: x, half the width, z of the bottom, z of the top; from the nose to the tail.
FUSELAGE = [
    (7.4, 0.00, -0.14, -0.14),
    (6.9, 0.19, -0.33, 0.05),
    (6.1, 0.38, -0.50, 0.25),
    (5.0, 0.54, -0.62, 0.44),
    (4.0, 0.63, -0.66, 0.58),
    (2.8, 0.74, -0.68, 0.72),
    (1.4, 0.90, -0.75, 0.84),
    (0.0, 1.04, -0.86, 0.86),
    (-2.0, 1.08, -0.92, 0.80),
    (-4.0, 0.98, -0.86, 0.72),
    (-5.5, 0.78, -0.72, 0.66),
    (-6.5, 0.62, -0.60, 0.60),
    (-6.5, 0.00, 0.00, 0.00),
]
CANOPY = [
    (4.95, 0.00, 0.44, 0.44),
    (4.55, 0.26, 0.22, 0.80),
    (3.80, 0.43, 0.14, 1.18),
    (2.90, 0.48, 0.16, 1.32),
    (1.90, 0.41, 0.34, 1.20),
    (0.80, 0.21, 0.58, 0.96),
    (0.20, 0.00, 0.78, 0.78),
]
INTAKE = [  # from the end of the duct forward to the lip, and outside back to the belly
    (1.5, 0.00, -1.02, -1.02),
    (1.5, 0.44, -1.34, -0.72),
    (2.75, 0.54, -1.44, -0.74),
    (2.75, 0.66, -1.56, -0.62),
    (1.4, 0.78, -1.52, -0.46),
    (-0.5, 0.84, -1.40, -0.46),
    (-2.5, 0.72, -1.18, -0.52),
    (-4.4, 0.40, -0.88, -0.52),
    (-5.0, 0.00, -0.60, -0.60),
]
NOZZLE = [  # from inside the fuselage back to the rim, and inside forward to the turbine
    (-6.0, 0.00, 0.00, 0.00),
    (-6.0, 0.56, -0.56, 0.56),
    (-6.6, 0.58, -0.58, 0.58),
    (-7.4, 0.47, -0.47, 0.47),
    (-7.4, 0.38, -0.38, 0.38),
    (-6.7, 0.34, -0.34, 0.34),
    (-6.7, 0.00, 0.00, 0.00),
]
STRAKE = [  # from the cockpit back to the wing, and on as the shelf that carries the tailplane
    (4.6, 0.00, 0.00, 0.00),
    (3.6, 0.19, -0.05, 0.07),
    (2.6, 0.26, -0.08, 0.10),
    (1.6, 0.32, -0.11, 0.13),
    (0.8, 0.37, -0.14, 0.16),
    (0.1, 0.40, -0.17, 0.19),
    (-3.4, 0.37, -0.20, 0.20),
    (-6.9, 0.37, -0.12, 0.12),
]
STRAKE_Y = [0.54, 0.59, 0.70, 0.82, 0.93, 1.02, 0.99, 0.82]
MISSILE = [  # its nose at the origin
    (0.0, 0.00, 0.00, 0.00),
    (-0.35, 0.12, -0.12, 0.12),
    (-0.85, 0.18, -0.18, 0.18),
    (-3.6, 0.18, -0.18, 0.18),
    (-3.6, 0.00, 0.00, 0.00),
]
RAIL = [(-1.7, 0.03, -0.03, 0.03), (-1.95, 0.08, -0.08, 0.08), (-3.7, 0.08, -0.08, 0.08)]

# Wings: distance from the root, x of the leading edge, x of the trailing edge, thickness.
WING = [(1.2, 0.58, -3.40, 0.26), (4.65, -2.30, -3.40, 0.12)]
TAILPLANE = [(0.8, -4.60, -7.00, 0.18), (2.95, -6.20, -7.05, 0.10)]
FIN = [(0.5, -2.60, -6.20, 0.24), (1.0, -3.50, -6.30, 0.22), (3.3, -5.65, -6.95, 0.12)]
VENTRAL_FIN = [(0.0, -3.90, -5.70, 0.14), (1.0, -4.60, -5.60, 0.10)]
PYLON = [(0.0, -1.30, -2.90, 0.12), (0.42, -1.30, -2.80, 0.12)]  # behind the missile's nose
MISSILE_FINS = [
    [(0.1, -1.30, -2.00, 0.08), (0.46, -1.75, -2.00, 0.06)],
    [(0.1, -2.90, -3.55, 0.08), (0.50, -3.15, -3.55, 0.06)],
]

# Noses of the missiles on the left: x, y, z.
TIP, OUTER, INNER = (-0.8, 4.92, 0.0), (-0.3, 3.75, -0.56), (0.8, 2.5, -0.59)


def superellipse(exponent: float) -> Floats:
    """Points (a, b) with |a|^p + |b|^p = 1 for the exponent p: shape (512, 2), from (1, 0)."""
    angle = 2 * np.pi * np.arange(512) / 512
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    return np.sign(circle) * np.abs(circle) ** (2 / exponent)


def airfoil() -> Floats:
    """Points of a symmetric NACA section that fills [-1, 1]^2: shape (512, 2).

    From the leading edge (1, 0) to the trailing edge (-1, 0) and back.
    """
    angle = 2 * np.pi * np.arange(512) / 512
    s = (1 - np.cos(angle)) / 2  # way along the chord, sampled densely at both edges
    half = 0.2969 * np.sqrt(s) - 0.1260 * s - 0.3516 * s**2 + 0.2843 * s**3 - 0.1036 * s**4
    return np.column_stack([1 - 2 * s, np.sign(np.sin(angle)) * half / half.max()])


def loft(stations: ArrayLike, curve: Floats, edge: float) -> Mesh:
    """Closed surface through a row of cross-sections, with triangles of one size.

    Parameters
    ----------
    stations : array_like, shape (k, 3, 3)
        Of each section its centre c and its half-axes u and v: a point (a, b)
        of the curve goes to c + a u + b v. The row goes in the direction of
        u x v. With u = v = 0 the section is a point, for a pointed end or the
        middle of a disc; any other end gets a flat cap.
    curve : ndarray, shape (p, 2)
        Closed curve, p much denser than the edges, counter-clockwise from (1, 0), symmetric
        to the first axis.
    edge : float
        Wanted length of the edges, in the units of the stations.

    Returns
    -------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
        A closed surface of genus 0, outward.
    """
    stations = np.asarray(stations, dtype=np.float64)
    rings = [_ring(curve @ axes + centre, edge) for centre, *axes in _rows(stations, edge)]
    ends = np.cumsum([len(ring) for ring in rings])
    indices = np.split(np.arange(ends[-1]), ends[:-1])
    caps = _cap(indices[0], stations[0])[:, ::-1], _cap(indices[-1], stations[-1])
    return np.concatenate(rings), np.concatenate([*caps, *(_strip(*p) for p in pairwise(indices))])


def _rows(stations: Floats, edge: float) -> Floats:
    """Sections about one edge apart, on a smooth curve through the stations."""
    # In these coordinates the distance of two ellipses is the rms distance of their points.
    weights = np.sqrt([[1.0], [0.5], [0.5]])
    X = (stations * weights).reshape(-1, 9)
    gap = np.linalg.norm(np.diff(X, axis=0), axis=1)[:, None]

    # A cubic between any two stations. Its slope at a station is the harmonic mean of the chords'
    # on both sides, zero where their signs differ: nothing overshoots and rims stay sharp.
    chord = np.diff(X, axis=0) / gap
    product = np.maximum(chord[1:] * chord[:-1], 0)
    mean = np.divide(2 * product, chord[1:] + chord[:-1], out=0 * product, where=product > 0)
    tangent = np.concatenate([chord[:1], mean, chord[-1:]])
    t = np.linspace(0, 1, 65)[:, None]
    rows = [
        _resample(
            (1 - t) ** 2 * ((1 + 2 * t) * X[i] + t * gap[i] * tangent[i])
            + t**2 * ((3 - 2 * t) * X[i + 1] - (1 - t) * gap[i] * tangent[i + 1]),
            edge,
        )
        for i in range(len(gap))
    ]
    return np.concatenate([*rows, X[-1:]]).reshape(-1, 3, 3) / weights


def _ring(points: Floats, edge: float) -> Floats:
    """Vertices at equal distances on a closed curve, or one vertex where it is a point."""
    if not np.ptp(points, axis=0).any():
        return points[:1]
    # A multiple of four keeps the four extremes of a symmetric section, so edges stay straight.
    return _resample(np.concatenate([points, points[:1]]), edge, multiple=4, least=SMALLEST_RING)


def _resample(points: Floats, spacing: float, multiple: int = 1, least: int = 1) -> Floats:
    """Split a polyline into equal pieces, about ``spacing`` long, and return where they start."""
    travelled = np.append(0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    count = max(least, multiple * round(travelled[-1] / (multiple * spacing)))
    at = np.arange(count) / count * travelled[-1]
    return np.column_stack([np.interp(at, travelled, column) for column in points.T])


def _strip(a: Integers, b: Integers) -> Integers:
    """Triangles between two neighbouring rings, whose numbers of vertices may differ.

    Each edge of either ring has a triangle, with its apex on the other ring. On
    the way around, the edges come in the order of their middles, and the apex
    is the vertex that the other ring has got to.
    """
    na, nb = len(a), len(b)
    # The way around is 2 na nb long: in integers, middles at the same place are exactly equal.
    middle_a = (2 * np.arange(na if na > 1 else 0) + 1) * nb
    middle_b = (2 * np.arange(nb if nb > 1 else 0) + 1) * na
    middle = np.append(middle_a, middle_b)
    of_b = np.arange(len(middle)) >= len(middle_a)
    # Equals: a's edge first on the first half, b's on the second, for a symmetric result.
    order = np.lexsort((of_b ^ (middle > na * nb), middle))
    of_b = of_b[order]
    j: Integers = np.cumsum(of_b) - of_b  # how many of b's edges come before
    i = np.arange(len(of_b)) - j
    third = np.where(of_b, b[(j + 1) % nb], a[(i + 1) % na])
    return np.column_stack([a[i % na], third, b[j % nb]])


def _cap(ring: Integers, station: Floats) -> Integers:
    """Triangles across a ring: a ladder whose rungs go along the section's shorter axis."""
    n = len(ring)
    _, u, v = np.linalg.norm(station, axis=1)
    if u < v:
        ring = np.roll(ring, n // 4)
    zigzag = np.zeros(n, dtype=int)
    zigzag[1::2] = np.arange(1, n // 2 + 1)
    zigzag[2::2] = n - np.arange(1, (n + 1) // 2)
    faces = np.column_stack([zigzag[:-2], zigzag[1:-1], zigzag[2:]])
    faces[1::2] = faces[1::2, ::-1]
    return ring[faces]


def body(rows: Rows, edge: float, y: ArrayLike = 0.0, exponent: float = 2.0) -> Mesh:
    """Round part along the x axis: a loft through superellipses.

    Parameters
    ----------
    rows : sequence of (x, half the width, z of the bottom, z of the top)
        From the nose to the tail; a hollow end turns around at its rim.
    edge : float
        Wanted length of the edges.
    y : float or sequence of float
        Of the sections' centres.
    exponent : float
        2 is an ellipse, less is closer to a rhombus, more to a rectangle.

    Returns
    -------
    V, F : ndarrays
        As `loft`.
    """
    x, half_width, bottom, top = np.transpose(rows)
    zero = np.zeros_like(x)
    centre = np.column_stack([x, zero + y, (bottom + top) / 2])
    up = np.column_stack([zero, zero, (top - bottom) / 2])
    left = np.column_stack([zero, half_width, zero])
    return loft(np.stack([centre, up, left], axis=1), superellipse(exponent), edge)


def wing(rows: Rows, edge: float, angle: float = 0.0, at: Point = (0.0, 0.0, 0.0)) -> Mesh:
    """Flat part that sticks out from the x axis: a loft through airfoils.

    Parameters
    ----------
    rows : sequence of (distance, x of the leading edge, x of the trailing edge, thickness)
        From the root to the tip.
    edge : float
        Wanted length of the edges.
    angle : float
        Where it points, in degrees: 0 to the left, 90 up.
    at : sequence of three floats
        Where the distance is counted from.

    Returns
    -------
    V, F : ndarrays
        As `loft`.
    """
    distance, leading, trailing, thickness = np.transpose(rows)[..., None]
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    forward, out, across = np.array([[1, 0, 0], [0, c, s], [0, s, -c]])
    centre = at + (leading + trailing) / 2 * forward + distance * out
    axes = (leading - trailing) / 2 * forward, thickness / 2 * across
    return loft(np.stack([centre, *axes], axis=1), airfoil(), edge)


def _missile(edge: float, nose: Point) -> Mesh:
    """Tube with a pointed nose, and two crosses of fins."""
    fins = [wing(rows, edge, angle) for rows in MISSILE_FINS for angle in (45, 135, 225, 315)]
    V, F = _join([body(MISSILE, edge), *fins])
    return V + nose, F


def _join(parts: Sequence[Mesh]) -> Mesh:
    """One mesh of several, in their order."""
    starts = np.cumsum([0, *(len(V) for V, _ in parts)])
    faces = [F + start for (_, F), start in zip(parts, starts[:-1], strict=True)]
    return np.concatenate([V for V, _ in parts]), np.concatenate(faces)


def jet_parts(missiles: bool = True, detail: float = 1.0) -> dict[str, Mesh]:
    """The parts of `jet` by name, each of one or more closed surfaces.

    Parameters
    ----------
    missiles : bool
        With or without the missiles, and the rails and pylons that hold them.
    detail : float
        From 0.5 to 8. The edges are 0.2 / detail long, so the number of
        vertices grows about as the square.

    Returns
    -------
    dict of str to (V, F)
        In fixed order, missiles and what holds them last. ``V`` float64 of
        shape (n, 3) in metres, x forward, y to the left, z up; ``F`` int64 of
        shape (m, 3), outward. Surfaces may pass through each other.

    Raises
    ------
    ValueError
        ``detail`` is no number from 0.5 to 8.
    """
    edge = EDGE / check_number(detail, "detail", 0.5, 8)
    parts = {
        "fuselage": body(FUSELAGE, edge, exponent=1.8),  # its sides slope towards the strakes
        "canopy": body(CANOPY, edge),
        "intake": body(INTAKE, edge, exponent=2.3),
        "nozzle": body(NOZZLE, edge),
        "fin": wing(FIN, edge, angle=90),
    }
    left = {
        "strake": body(STRAKE, edge, STRAKE_Y),
        "wing": wing(WING, edge),
        "tailplane": wing(TAILPLANE, edge, angle=-8),
        "ventral fin": wing(VENTRAL_FIN, edge, angle=-75, at=(0, 0.5, -0.45)),
    }
    if missiles:
        left |= {
            "tip rail": body(RAIL, edge, y=4.7),
            "tip missile": _missile(edge, TIP),
            "outer pylon": wing(PYLON, edge, angle=-90, at=(OUTER[0], OUTER[1], 0)),
            "outer missile": _missile(edge, OUTER),
            "inner pylon": wing(PYLON, edge, angle=-90, at=(INNER[0], INNER[1], 0)),
            "inner missile": _missile(edge, INNER),
        }
    for name, (V, F) in left.items():
        parts[f"{name} left"] = V, F
        parts[f"{name} right"] = V * [1, -1, 1], F[:, ::-1]  # mirrored, and outward again
    return parts


def jet(missiles: bool = True, detail: float = 1.0) -> Mesh:
    """A fighter aircraft, with or without missiles: the parts of `jet_parts` as one mesh.

    Parameters
    ----------
    missiles, detail
        As `jet_parts`.

    Returns
    -------
    V : ndarray of float64, shape (n, 3)
        In metres; x forward, y to the left, z up.
    F : ndarray of int64, shape (m, 3)
        Each component is closed, of genus 0, and outward.

    Raises
    ------
    ValueError
        As `jet_parts`.
    """
    return _join(list(jet_parts(missiles, detail).values()))


def jet_labels(missiles: bool = True, detail: float = 1.0) -> tuple[Integers, list[str]]:
    """Of which part each vertex of `jet` is.

    Parameters
    ----------
    missiles, detail
        As `jet_parts`.

    Returns
    -------
    labels : ndarray of int64, shape (n,)
        Indices into ``names``.
    names : list of str
        The keys of `jet_parts`, in its order.

    Raises
    ------
    ValueError
        As `jet_parts`.
    """
    parts = jet_parts(missiles, detail)
    sizes = [len(V) for V, _ in parts.values()]
    return np.repeat(np.arange(len(parts)), sizes), list(parts)
