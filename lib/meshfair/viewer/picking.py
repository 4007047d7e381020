"""Which vertex a click means: the nearest one of the face that it hits first."""

from __future__ import annotations

import numpy as np

from meshfair.checks import Floats, Integers
from meshfair.viewer.camera import FIELD_OF_VIEW, Camera


def pick(
    V: Floats, F: Integers, camera: Camera, at: tuple[float, float], aspect: float
) -> int | None:
    """The vertex at a place in the picture, of those that can be seen.

    A ray from the camera through that place is cut with all faces, by the signs of the
    volumes that it spans with their edges; no renderer is asked.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    camera : Camera
    at : (float, float)
        From the picture's left and bottom edge, -1, to its right and top edge, 1.
    aspect : float
        Width over height of the picture.

    Returns
    -------
    int or None
        None where no face is hit.
    """
    right, up, back = camera.axes
    half = np.tan(np.radians(FIELD_OF_VIEW) / 2)
    ray = half * (aspect * at[0] * right + at[1] * up) - back
    corners = V[F] - camera.position
    # side[:, k] is on which side of the edge opposite corner k the ray passes.
    edges = np.cross(corners[:, [1, 2, 0]], corners[:, [2, 0, 1]])
    side = edges @ ray
    total = side.sum(axis=1)
    hit = ((side >= 0).all(axis=1) | (side <= 0).all(axis=1)) & (total != 0)
    if not hit.any():
        return None
    parts = side[hit] / total[hit, None]
    points = np.einsum("kc,kcx->kx", parts, corners[hit])
    depth = points @ ray
    depth[depth <= 0] = np.inf  # behind the camera
    first = int(depth.argmin())
    if not np.isfinite(depth[first]):
        return None
    corner = np.linalg.norm(corners[hit][first] - points[first], axis=1).argmin()
    return int(F[hit][first][corner])
