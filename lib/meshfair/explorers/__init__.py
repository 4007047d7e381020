"""Sliders beside a mesh: what the notebooks let a student try.

An explorer holds no mathematics: it calls the package with what its controls
say, and shows the result. Its ``controls`` can be set by code, too:

>>> explorer = HeatExplorer(*shapes.knot())        # doctest: +SKIP
>>> explorer.controls["tau"].value = 0.5           # doctest: +SKIP
"""

from meshfair.checks import needed_for

with needed_for("an explorer"):
    from meshfair.explorers.cotangents import CotangentExplorer
    from meshfair.explorers.curves import CurvePlot
    from meshfair.explorers.eigenmodes import EigenmodeExplorer
    from meshfair.explorers.explorer import Explorer
    from meshfair.explorers.filters import FilterExplorer
    from meshfair.explorers.heat import AveragingExplorer, ComparisonExplorer, HeatExplorer
    from meshfair.explorers.iterations import IterationExplorer
    from meshfair.explorers.jet import JetExplorer
    from meshfair.explorers.kernels import KernelExplorer
    from meshfair.explorers.low_pass import LowPassExplorer
    from meshfair.explorers.neighbourhood import NeighbourhoodExplorer
    from meshfair.explorers.noises import NoiseExplorer
    from meshfair.explorers.own_mesh import DenoisingExplorer
    from meshfair.explorers.prediction import Prediction
    from meshfair.explorers.stability import StabilityExplorer

__all__ = [
    "AveragingExplorer",
    "ComparisonExplorer",
    "CotangentExplorer",
    "CurvePlot",
    "DenoisingExplorer",
    "EigenmodeExplorer",
    "Explorer",
    "FilterExplorer",
    "HeatExplorer",
    "IterationExplorer",
    "JetExplorer",
    "KernelExplorer",
    "LowPassExplorer",
    "NeighbourhoodExplorer",
    "NoiseExplorer",
    "Prediction",
    "StabilityExplorer",
]
