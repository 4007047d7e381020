"""Curves with a moving marker, drawn in the page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import anywidget
import numpy as np
import traitlets
from numpy.typing import ArrayLike

from meshfair.viewer.scripts import text


class CurvePlot(anywidget.AnyWidget):
    """A small plot of curves or points; see curves.js.

    Drawn by the page from the numbers, so that a marker moves without a
    picture being sent, and the plot has the notebook's theme and width.

    Parameters
    ----------
    title, x_label, y_label : str
        What is shown, with units.
    **traits
        Of `anywidget.AnyWidget`, such as a layout.
    """

    _esm = text("curves.js")
    # Every explorer has a plot, so the look of all of it comes with the plot's.
    _css = text("curves.css", "explorer.css")
    title = traitlets.Unicode().tag(sync=True)
    x_label = traitlets.Unicode().tag(sync=True)
    y_label = traitlets.Unicode().tag(sync=True)
    series: Any = traitlets.List().tag(sync=True)
    x_range: Any = traitlets.List(allow_none=True, default_value=None).tag(sync=True)
    y_range: Any = traitlets.List(allow_none=True, default_value=None).tag(sync=True)
    threshold = traitlets.Float(allow_none=True, default_value=None).tag(sync=True)
    marker = traitlets.Float(allow_none=True, default_value=None).tag(sync=True)
    picked = traitlets.Float(allow_none=True, default_value=None).tag(sync=True)
    """Where on the x axis the reader last clicked."""

    def draw(
        self,
        curves: Mapping[str, tuple[ArrayLike, ArrayLike]],
        *,
        points: bool = False,
        colors: Mapping[str, str] | None = None,
        marks: Mapping[str, str] | None = None,
        best: Mapping[str, int] | None = None,
        legend: Mapping[str, str] | None = None,
        threshold: float | None = None,
        x_range: tuple[float, float] | None = None,
        y_range: tuple[float, float] | None = None,
    ) -> None:
        """Show some curves in place of those before.

        Parameters
        ----------
        curves : dict of str to (x, y)
            Name -> coordinates; values that are not finite are left out.
        points : bool
            Points, not joined by lines.
        colors : dict of str to str, optional
            A CSS colour for each name.
        marks : dict of str to str, optional
            A mark for each name, as matplotlib calls it: "o", "s" or "^".
        best : dict of str to int, optional
            Which point of a curve is the best; it gets the curve's mark.
        legend : dict of str to str, optional
            What the legend says behind the name.
        threshold : float, optional
            Draw a line across at this y, and make what lies above it stand out.
        x_range : (float, float), optional
            Ends of the x axis; those of the curves by default.
        y_range : (float, float), optional
            Ends of the y axis, likewise.
        """
        marks, best, legend = marks or {}, best or {}, legend or {}
        series = []
        for name, (x, y) in curves.items():
            x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
            shown = np.isfinite(x) & np.isfinite(y)
            k = best.get(name)
            series.append(
                {
                    "name": name,
                    "x": x[shown].tolist(),
                    "y": y[shown].tolist(),
                    "points": points,
                    "color": (colors or {}).get(name, ""),
                    "mark": marks.get(name, "o"),
                    "best": None if k is None or not shown[k] else [float(x[k]), float(y[k])],
                    "legend": legend.get(name, ""),
                }
            )
        # One message for all of it, so that the page never shows a mixture.
        with self.hold_sync():
            self.series, self.threshold = series, threshold
            self.x_range = None if x_range is None else [float(x) for x in x_range]
            self.y_range = None if y_range is None else [float(y) for y in y_range]
