"""What is drawn: a mesh with its style, and how its values become colours."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from meshfair.checks import Booleans, Floats, Integers, check_choice, check_range, needed_for

SURFACE = (0.55, 0.68, 0.86)  # the colour of a mesh without values
LINES = (0.1, 0.15, 0.25)  # the colour of edges
NONE = (0.6, 0.6, 0.6)  # the usual colour where a value is NaN or infinite

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
    none: tuple[float, float, float] = NONE
    """The colour where a value is NaN or infinite."""

    @property
    def values_on(self) -> str:
        """What the values belong to: "vertices" or "faces"."""
        assert self.values is not None
        return "vertices" if len(self.values) == len(self.V) else "faces"

    @cached_property
    def used(self) -> Booleans:
        """Which vertices a face uses: the others are not drawn; shape (n,)."""
        mask = np.zeros(len(self.V), dtype=bool)
        mask[self.F] = True
        return mask

    @cached_property
    def box(self) -> tuple[Floats, Floats]:
        """The least and the largest coordinates of what is drawn."""
        X = self.V if self.used.all() else self.V[self.used]
        # Column by column: along short rows NumPy is slow.
        return np.array([x.min() for x in X.T]), np.array([x.max() for x in X.T])

    @cached_property
    def known(self) -> Booleans:
        """Which values are finite numbers, of vertices or faces that are drawn."""
        assert self.values is not None
        finite = np.isfinite(self.values)
        return finite & self.used if self.values_on == "vertices" else finite

    @property
    def complete(self) -> bool:
        """Whether all vertices or faces that are drawn have a finite value."""
        return bool(self.known.all() or np.array_equal(self.known, self.used))


@dataclass(frozen=True)
class Scale:
    """How values become colours: the two ends of the scale, and the colour map."""

    low: float
    high: float
    cmap: str = "viridis"
    below: bool = False
    """Whether there are values below the low end, which have its colour."""
    above: bool = False
    """And above the high end."""

    @classmethod
    def of(
        cls,
        panels: Iterable[Panel],
        limits: tuple[float, float] | None = None,
        cmap: str = "viridis",
    ) -> Scale | None:
        """The scale for some panels' values, or None where there is none to be seen.

        Parameters
        ----------
        panels : iterable of Panel
        limits : (float, float), optional
            Both ends of the scale. By default the range of all finite values, from 0
            where that is near for its length; and from 0 to what they are where they are equal.
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
        given = [panel.values[panel.known] for panel in panels if panel.values is not None]
        given = [x for x in given if len(x)]
        if not given:
            return None
        least, most = (float(min(x.min() for x in given)), float(max(x.max() for x in given)))
        low, high = limits or _ends(least, most)
        # A scale of no length divides by zero in every renderer.
        if high <= low:
            high = low + 1e-9 * max(1.0, abs(low))
        spare = 1e-9 * (high / 2 - low / 2)  # what rounding does to the ends
        return cls(low, high, cmap, below=least < low - spare, above=most > high + spare)

    def parts(self, values: Floats) -> Floats:
        """Where values lie on the scale, 0 at its low end and 1 at its high one.

        What is drawn in single precision holds these, not the values, which may
        differ by less than their own seventh digit.
        """
        with np.errstate(invalid="ignore"):  # what is infinite has no place
            # By halves: the difference of two large numbers may be infinite.
            part = (values / 2 - self.low / 2) / (self.high / 2 - self.low / 2)
        return np.nan_to_num(np.clip(part, -1e6, 1e6))

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

    def ends(self) -> tuple[str, str]:
        """What stands at the two ends: "0", "≥ 1.2"."""
        low, high = _written(self.low), _written(self.high)
        return f"≤ {low}" if self.below else low, f"≥ {high}" if self.above else high


def colors(panel: Panel, scale: Scale | None) -> Floats:
    """A colour for each of a panel's values, grey where it is no number; shape (k, 3)."""
    assert panel.values is not None
    if scale is None:
        return np.tile(panel.none, (len(panel.values), 1))
    mapped = scale.colormap(scale.parts(panel.values))[:, :3]
    mapped[~panel.known] = panel.none
    return mapped


def _ends(least: float, most: float) -> tuple[float, float]:
    """The ends of a scale for values between two numbers."""
    if least == most:
        return (min(least, 0.0), max(most, 0.0)) if most else (0.0, 1.0)
    if 0 < least <= 0.1 * most:
        return 0.0, most
    if 0.1 * least <= most < 0:
        return least, 0.0
    return least, most


def _written(number: float) -> str:
    """A number for people: three digits that count."""
    if number and not 1e-3 <= abs(number) < 1e5:
        return f"{number:.1e}"
    return f"{float(f'{number:.3g}'):.12g}"
