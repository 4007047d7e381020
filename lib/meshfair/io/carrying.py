"""What a file keeps of another one in another format, or of one with other faces."""

from dataclasses import replace

import numpy as np

from meshfair.checks import Floats, Integers
from meshfair.io.attributes import Attributes
from meshfair.io.extras import Extras
from meshfair.io.formats import FORMATS

NAMED = 6  # of all that is left out, at most so many


def carried(like: Attributes, V: Floats, F: Integers, ending: str) -> tuple[Extras | None, str]:
    """What a file keeps of another one, and a sentence on what it does not keep.

    Parameters
    ----------
    like : Attributes
        The other file.
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    ending : str
        The format of the new file.

    Returns
    -------
    more : Extras or None
        None where there is nothing to keep.
    message : str
        Empty where everything is kept.
    """
    more: Extras = FORMATS[like.format].extras(like)
    if like.vertex is not None:
        more = replace(more, corners=like.vertex[more.corners])
    there = more.kinds()
    if len(V) != len(like.V):
        kept, reason = None, f"the mesh has {len(V)} vertices and {like.name} has {len(like.V)}"
    elif not np.array_equal(F, like.F):
        kept, reason = more.without_faces(F), f"the faces are others than those of {like.name}"
    else:
        kept, reason = more, f"a {ending} file cannot hold them"
    holds = FORMATS[ending].HOLDS
    left = [kind for kind in there if kept is None or kind not in holds & set(kept.kinds())]
    if kept is not None and not holds.intersection(kept.kinds()):
        kept = None
    if not left:
        return kept, ""
    names = ", ".join(left[:NAMED]) + (f" and {len(left) - NAMED} more" if left[NAMED:] else "")
    return kept, f"left out, because {reason}: {names}"
