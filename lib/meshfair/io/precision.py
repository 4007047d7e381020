"""Single precision: what it cannot hold, and what it makes of a mesh."""

import numpy as np

from meshfair.checks import Floats
from meshfair.io.errors import file_error


def check_single(V: Floats) -> None:
    """Refuse positions that are too large for single precision."""
    too_large = np.abs(V).max(axis=1) > np.finfo(np.float32).max
    if too_large.any():
        i = np.argmax(too_large)
        advice = "scale the mesh, or write another format"
        raise file_error(f"vertex {i}", f"position {V[i]}", "STL holds values up to 3.4e38", advice)
