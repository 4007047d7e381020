"""Filters: iterators over a mesh that becomes less noisy.

Each takes ``(V, F, *, parameters)`` and yields the part of the work that is
done, and positions; the last ones are the result:

    *_, (_, V_new) = filters.bilateral_normal(V, F)

What all have in common (V, F, ``fixed``, what they yield and raise) is
described once, in `averaging`.
"""

from meshfair.filters.bilateral import bilateral
from meshfair.filters.diffusion import averaging, heat, implicit, regularised, taubin
from meshfair.filters.feature_convinced import feature_convinced
from meshfair.filters.guided_normal import guided_normal
from meshfair.filters.l0 import l0
from meshfair.filters.learned import learned
from meshfair.filters.normal_filtering import bilateral_normal, sun

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
