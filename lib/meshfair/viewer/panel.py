"""What is drawn: a mesh with its style, and how its values become colours."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from meshfair.checks import Floats, Integers, check_choice, check_range, needed_for

SURFACE = (0.55, 0.68, 0.86)  # the colour of a mesh without values
LINES = (0.1, 0.15, 0.25)  # the colour of edges

# The colour maps that polyscope and matplotlib both have, and matplotlib's names for them.
CMAPS = {
    **{
        name: name
        for name in (
            "viridis", "magma", "inferno", "plasma", "gray", "coolwarm", "rainbow", "jet", "turbo",
        )
    },
    "blues": "Blues",
    "reds": "Reds",
    "spectral": "Spectral",
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Panel:
    """A mesh as it is drawn. Compared by identity: a changed mesh is a new panel."""

    V: Floats
    F: Integers
    values: Floats | None = None
    smooth: bool = False
    edges: bool = False

    @property
    def values_on(self) -> str:
        """What the values belong to: "vertices" or "faces"."""
        assert self.values is not None
        return "vertices" if len(self.values) == len(self.V) else "faces"


@dataclass(frozen=True)
class Scale:
    """How values become colours: the two ends of the scale, and the colour map."""

    low: float
    high: float
    cmap: str = "viridis"

    @classmethod
    def of(
        cls,
        values: Iterable[Floats | None],
        limits: tuple[float, float] | None = None,
        cmap: str = "viridis",
    ) -> Scale | None:
        """The scale for some arrays of values, or None where none of them is given.

        Parameters
        ----------
        values : iterable of ndarray or None
        limits : (float, float), optional
            Both ends of the scale; the range of all values by default.
        cmap : str
            One of `CMAPS`.

        Returns
        -------
        Scale or None

        Raises
        ------
        ValueError
            ``limits`` that are no range, or an unknown ``cmap``.
        """
        check_choice(cmap, "cmap", CMAPS)
        if limits is not None:
            limits = check_range(limits, "limits")
        given = [x for x in values if x is not None]
        if not given:
            return None
        low, high = limits or (min(x.min() for x in given), max(x.max() for x in given))
        # A scale of no length divides by zero in every renderer.
        return cls(float(low), float(high) if high > low else float(low) + 1e-9, cmap)

    @property
    def colormap(self) -> Any:
        """Matplotlib's colour map: a function of numbers from 0 to 1."""
        with needed_for("a colour map"):
            from matplotlib import colormaps
        return colormaps[CMAPS[self.cmap]]

    def stops(self) -> list[str]:
        """Seventeen colours, as CSS has them, from the low end to the high one."""
        with needed_for("a colour bar"):
            from matplotlib.colors import to_hex
        return [to_hex(self.colormap(k / 16)) for k in range(17)]
