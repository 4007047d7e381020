"""A measured number with its error, or the reason why there is none."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Measure:
    """What a metric gives of two meshes.

    Attributes
    ----------
    value : float or None
        None where the metric does not fit the two meshes.
    bound : float
        How far the true number can be from ``value``; 0 where it is exact up to
        rounding. The metric says on which side, and how surely.
    reason : str
        Why there is no value; empty where there is one.
    """

    value: float | None
    bound: float = 0.0
    reason: str = ""
