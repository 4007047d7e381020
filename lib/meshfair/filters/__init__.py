"""Filters: iterators over a mesh that becomes less noisy.

Each takes ``(V, F, *, parameters)`` and yields the part of the work that is
done, and positions; the last ones are the result:

    *_, (_, V_new) = filters.bilateral_normal(V, F)
"""

from meshfair.filters.diffusion import averaging, heat, implicit, regularised, taubin
from meshfair.filters.features import feature_convinced
from meshfair.filters.guided import guided_normal
from meshfair.filters.minimisation import l0
from meshfair.filters.normals import bilateral_normal, sun
from meshfair.filters.vertices import bilateral

__all__ = [
    "averaging",
    "bilateral",
    "bilateral_normal",
    "feature_convinced",
    "guided_normal",
    "heat",
    "implicit",
    "l0",
    "regularised",
    "sun",
    "taubin",
]
