"""Single precision: what it cannot hold, and what it makes of a mesh."""

import numpy as np

from meshfair.checks import Floats, Integers
from meshfair.io.errors import file_error
from meshfair.io.welding import same_rows
from meshfair.mesh import Triangles

# Rounding that moves vertices by this part of the mean edge length is visible noise.
VISIBLE = 0.01


def check_single(V: Floats) -> None:
    """Refuse positions that are too large for single precision."""
    too_large = np.abs(V).max(axis=1) > np.finfo(np.float32).max
    if too_large.any():
        i = np.argmax(too_large)
        advice = "scale the mesh, or write another format"
        raise file_error(f"vertex {i}", f"position {V[i]}", "STL holds values up to 3.4e38", advice)


def loss(V: Floats, F: Integers, stored: Floats) -> str:
    """What rounding does to a mesh, in a sentence; nothing where it does no harm.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    stored : ndarray of float64, shape (n, 3)
        The positions as they will be read again.
    """
    moved = 0.0 if stored is V else float(np.abs(stored - V).max())
    if moved == 0:
        return ""
    some = F[:: len(F) // 1000 + 1]
    edge = float(np.linalg.norm(V[some[:, 1]] - V[some[:, 0]], axis=1).mean())
    flat = np.flatnonzero(~np.any(Triangles(stored, F).cross, axis=0))  # exact: they are rounded
    if len(flat):
        flat = flat[~Triangles(V, F[flat]).degenerate]
    if not len(flat) and moved <= VISIBLE * edge:
        return ""
    joined = len(same_rows(V)[0]) - len(same_rows(stored)[0])
    return (
        f"rounded to the file's precision, vertices move by up to {moved:.2g} (edges are about "
        f"{edge:.2g} long), {joined} fall together and {len(flat)} faces lose their area; move "
        f"the mesh to the origin first, or write it as OBJ or OFF, which keep all digits"
    )
