"""Filters: iterators over a mesh that becomes less noisy.

Each takes ``(V, F, *, parameters)`` and yields the part of the work that is
done, and positions; the last ones are the result::

    *_, (_, V_new) = filters.bilateral_normal(V, F)

What all have in common (V, F, ``fixed``, what they yield and raise) is
described once, in `averaging`. The modules hold the filters as their papers have them;
here they take any mesh: see `meshfair.filters.preparation`.
"""

from meshfair.filters import diffusion, normal_filtering
from meshfair.filters.bilateral import bilateral as _bilateral
from meshfair.filters.feature_convinced import feature_convinced as _feature_convinced
from meshfair.filters.guided_normal import guided_normal as _guided_normal
from meshfair.filters.l0 import l0 as _l0
from meshfair.filters.learned import learned as _learned
from meshfair.filters.preparation import prepared

averaging = prepared(diffusion.averaging)
heat = prepared(diffusion.heat)
implicit = prepared(diffusion.implicit)
regularised = prepared(diffusion.regularised)
taubin = prepared(diffusion.taubin)
l0 = prepared(_l0)
bilateral = prepared(_bilateral, normals=True)
sun = prepared(normal_filtering.sun, normals=True)
bilateral_normal = prepared(normal_filtering.bilateral_normal, normals=True)
guided_normal = prepared(_guided_normal, normals=True)
feature_convinced = prepared(_feature_convinced, normals=True)
learned = prepared(_learned, normals=True)

__all__ = [
    "averaging",
    "bilateral",
    "bilateral_normal",
    "feature_convinced",
    "guided_normal",
    "heat",
    "implicit",
    "l0",
    "learned",
    "regularised",
    "sun",
    "taubin",
]
