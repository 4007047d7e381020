"""Denoising triangulated meshes: weights, averaging, heat flow and their experiments.

The modules, in the order in which the data flows:

shapes, io -> mesh -> noise, metrics -> weights -> operators -> flow -> filters
-> sure, denoising -> experiments -> plotting, viewer

with ``checks`` before them all and ``reference`` (libigl) beside them.
"""

from importlib import import_module

from meshfair.checks import MeshError, MeshWarning, StabilityWarning

__version__ = "0.1.0"

_MODULES = (
    "checks", "shapes", "io", "datasets", "mesh", "noise", "metrics", "weights", "intrinsic",
    "operators", "stability", "spectrum", "solve", "flow", "filters", "sure", "denoising",
    "experiments", "plotting", "viewer", "explorers", "reference",
)  # fmt: skip

__all__ = ["MeshError", "MeshWarning", "StabilityWarning", "denoise", *_MODULES]


def __getattr__(name):
    """Load a module when it is first used, so that ``import meshfair`` is quick."""
    if name in _MODULES:
        return import_module(f"meshfair.{name}")
    if name == "denoise":
        return import_module("meshfair.denoising").denoise
    raise AttributeError(f"module 'meshfair' has no attribute {name!r}")


def __dir__():
    return sorted(__all__)
