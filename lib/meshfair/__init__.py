"""Denoising triangulated meshes: weights, averaging, heat flow and their experiments.

``_ORDER`` names the modules in the order in which the data flows: each imports only from
those before it.
"""

from importlib import import_module
from typing import Any

from meshfair.checks import MeshError, MeshWarning, StabilityWarning

__version__ = "0.2.0"

_ORDER = (
    "checks", "_fast", "mesh", "shapes", "io", "datasets", "noise", "metrics", "weights",
    "intrinsic", "operators", "reference", "stability", "spectrum", "solve", "flow", "filters",
    "sure", "denoising", "experiments", "plotting", "viewer", "explorers", "cli",
)  # fmt: skip
_PUBLIC = [name for name in _ORDER if not name.startswith("_")]

__all__ = ["MeshError", "MeshWarning", "StabilityWarning", "denoise", *_PUBLIC]


def __getattr__(name: str) -> Any:
    """Load a module when it is first used, so that ``import meshfair`` is quick."""
    if name in _PUBLIC:
        return import_module(f"meshfair.{name}")
    if name == "denoise":
        return import_module("meshfair.denoising").denoise
    raise AttributeError(f"module 'meshfair' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
