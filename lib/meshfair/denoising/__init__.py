"""One front for all filters: `denoise` by name, or with the method and parameters that suit.

``registry`` holds the filters by name, ``runs`` a method at work on a mesh, and ``front``
what users call. Where something is to be chosen, ``choice`` tries candidates, ``traits``
puts what comes of them into numbers, and ``forecast`` tells from these how good they are.
"""

from meshfair.denoising.front import denoise, estimate_noise, tune
from meshfair.denoising.registry import BUILT_IN, DEFAULT, defaults, methods, register
from meshfair.denoising.runs import Denoised

__all__ = [
    "BUILT_IN",
    "DEFAULT",
    "Denoised",
    "defaults",
    "denoise",
    "estimate_noise",
    "methods",
    "register",
    "tune",
]
