"""Knot, torus, sphere and box."""

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import Floats, Integers, check_count, check_number
from meshfair.mesh.elements import Edges

# The tube that reproduces Open3D's KnotMesh (1,440 vertices), fitted to its file.
KNOT_TUBE_RADIUS = 19.54387
KNOT_SCALE = 42.50826
KNOT_CENTRE = np.array([-51.81513, 0.0, -76.56766])
KNOT_TANGENT_STEP = 6.5e-4


def _tube_faces(sections: int, sides: int) -> Integers:
    """Faces of a closed tube whose vertex (section i, side j) has index sides*i + j."""
    i, j = np.divmod(np.arange(sections * sides), sides)
    next_i, next_j = (i + 1) % sections, (j + 1) % sides
    a, b = sides * i + j, sides * next_i + j
    c, d = sides * next_i + next_j, sides * i + next_j
    return np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)


def _knot_curve(t: Floats) -> Floats:
    """Centre line of the knot around its own centre, at parameters t of shape (k, 1)."""
    curve = np.hstack([np.cos(2 * t), np.cos(3 * t), -np.sin(2 * t)])
    return KNOT_SCALE * curve / (1 - 5 / 11 * np.sin(3 * t))


def knot(sections: int = 120, sides: int = 12) -> tuple[Floats, Integers]:
    """Tube around a (2, 3) torus knot: the original report's knot.

    The centre line is the stereographic projection of the torus knot,

        P(t) = o + R (cos 2t, cos 3t, -sin 2t) / (1 - 5/11 sin 3t).

    With the defaults it has the faces of Open3D's KnotMesh and its vertices
    to 0.01 units, on a bounding box of 181.

    Parameters
    ----------
    sections : int
        Number of rings along the knot, at least 30.
    sides : int
        Number of vertices around each ring, at least 3.

    Returns
    -------
    V : ndarray of float64, shape (sections * sides, 3)
        Not centred: the knot lies around (-52, 0, -77).
    F : ndarray of int64, shape (2 * sections * sides, 3)

    Raises
    ------
    ValueError
        Too few sections or sides.
    """
    sections, sides = check_count(sections, "sections", 30), check_count(sides, "sides", 3)
    t = 2 * np.pi * np.arange(sections)[:, None] / sections
    from_centre = _knot_curve(t)
    # The tangent as the file's author seems to have had it, by a forward difference.
    T = _knot_curve(t + KNOT_TANGENT_STEP) - from_centre
    U = np.cross(T, from_centre)
    U /= np.linalg.norm(U, axis=1, keepdims=True)
    W = np.cross(T, U)
    W /= np.linalg.norm(W, axis=1, keepdims=True)

    theta = 2 * np.pi * np.arange(sides)[:, None] / sides
    ring = np.cos(theta) * U[:, None] - np.sin(theta) * W[:, None]
    V = (KNOT_CENTRE + from_centre)[:, None] + KNOT_TUBE_RADIUS * ring
    return V.reshape(-1, 3), _tube_faces(sections, sides)


def torus(
    major: float = 1.0, minor: float = 0.4, sections: int = 60, sides: int = 24
) -> tuple[Floats, Integers]:
    """Torus around the z axis, centred at the origin.

    Parameters
    ----------
    major, minor : float
        Radii of the centre circle and of the tube, 0 < minor < major, in
        units of length.
    sections, sides : int
        Vertices along the centre circle and around the tube, at least 3.

    Returns
    -------
    V : ndarray of float64, shape (sections * sides, 3)
    F : ndarray of int64, shape (2 * sections * sides, 3)

    Raises
    ------
    ValueError
        A radius or a count outside its range.
    """
    sections, sides = check_count(sections, "sections", 3), check_count(sides, "sides", 3)
    major = check_number(major, "major", 0, open_low=True)
    minor = check_number(minor, "minor", 0, major, open_low=True)
    if minor == major:
        raise ValueError(f"minor equals major ({major:g}); the tube would touch itself")
    phi = 2 * np.pi * np.arange(sections)[:, None] / sections
    theta = 2 * np.pi * np.arange(sides)[None, :] / sides
    r = major + minor * np.cos(theta)
    V = np.stack([r * np.cos(phi), r * np.sin(phi), minor * np.sin(theta) + 0 * phi], axis=-1)
    return V.reshape(-1, 3), _tube_faces(sections, sides)


def icosphere(subdivisions: int = 4, radius: float = 1.0) -> tuple[Floats, Integers]:
    """Sphere from an icosahedron whose faces are split in four, again and again.

    Parameters
    ----------
    subdivisions : int
        How often each face is split, 0 to 9.
    radius : float
        In units of length, above 0.

    Returns
    -------
    V : ndarray of float64, shape (10 * 4**subdivisions + 2, 3)
        All at distance ``radius`` from the origin.
    F : ndarray of int64, shape (20 * 4**subdivisions, 3)

    Raises
    ------
    ValueError
        A number outside its range.
    """
    subdivisions = check_count(subdivisions, "subdivisions")
    if subdivisions > 9:
        raise ValueError(f"subdivisions is {subdivisions}; above 9 are over 10 million vertices")
    radius = check_number(radius, "radius", 0, open_low=True)
    g = (1 + np.sqrt(5)) / 2
    V = np.array(
        [[-1, g, 0], [1, g, 0], [-1, -g, 0], [1, -g, 0], [0, -1, g], [0, 1, g]]
        + [[0, -1, -g], [0, 1, -g], [g, 0, -1], [g, 0, 1], [-g, 0, -1], [-g, 0, 1]]
    ) / np.sqrt(1 + g * g)
    F = np.array(
        [[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11]]
        + [[1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8]]
        + [[3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9]]
        + [[4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1]]
    )
    for _ in range(subdivisions):
        edges = Edges.of_all(F, len(V))
        edge = np.empty(3 * len(F), dtype=np.int64)
        edge[edges.half_edges] = edges.of_half_edge
        a, b, c = F.T
        # The midpoints opposite the corners a, b and c.
        x, y, z = len(V) + edge.reshape(3, -1)
        F = np.stack([a, z, y, b, x, z, c, y, x, x, y, z], axis=1).reshape(-1, 3)
        i, j = edges.ends.T
        middle = V[i] + V[j]
        V = np.concatenate([V, middle / np.linalg.norm(middle, axis=1, keepdims=True)])
    return radius * V, F


def box(size: ArrayLike = (1.0, 1.0, 1.0), segments: ArrayLike = 12) -> tuple[Floats, Integers]:
    """Box with sharp edges, centred at the origin, its sides cut into a grid.

    Parameters
    ----------
    size : float or three floats
        Lengths of the box along x, y and z, above 0.
    segments : int or three ints
        Number of grid cells along x, y and z, at least 1.

    Returns
    -------
    V : ndarray of float64, shape (n, 3)
        The grid's points on the surface: n = prod(s + 1) - prod(s - 1).
    F : ndarray of int64, shape (m, 3)
        Two triangles a cell, m = 4 (sx sy + sy sz + sz sx).

    Raises
    ------
    ValueError
        A number outside its range.
    """
    sides = [check_number(x, "size", 0, open_low=True) for x in np.broadcast_to(size, 3).tolist()]
    s = np.array([check_count(x, "segments", 1) for x in np.broadcast_to(segments, 3).tolist()])
    index = np.full(s + 1, -1)
    grid = np.argwhere(np.pad(np.zeros(np.maximum(s - 1, 0), bool), 1, constant_values=True))
    index[tuple(grid.T)] = np.arange(len(grid))
    faces = []
    for axis in range(3):
        # Seen along the axis, the other two axes turn counter-clockwise.
        across = np.moveaxis(index, [axis, (axis + 1) % 3, (axis + 2) % 3], [0, 1, 2])
        for side, turn in ((0, slice(None, None, -1)), (-1, slice(None))):
            q = across[side]
            a, b, c, d = (x.ravel() for x in (q[:-1, :-1], q[1:, :-1], q[1:, 1:], q[:-1, 1:]))
            quads = np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)
            faces.append(quads[:, turn])
    return (grid / s - 0.5) * sides, np.concatenate(faces)
