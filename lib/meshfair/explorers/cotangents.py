"""The cotangent weight of one edge, from two triangles whose corners can be dragged."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

import anywidget
import numpy as np
import traitlets

from meshfair.checks import MeshWarning, needed_for
from meshfair.mesh.elements import Triangles
from meshfair.viewer.page import OnPage, for_page, part
from meshfair.viewer.panel import SURFACE
from meshfair.viewer.recording import pack
from meshfair.viewer.saved import Bundle, Displayed, Saved, picture
from meshfair.viewer.scripts import text
from meshfair.viewer.stills import INK
from meshfair.weights import cotangent

if TYPE_CHECKING:
    from PIL.Image import Image

F = np.array([[0, 1, 2], [1, 0, 3]])
START = ((0.0, 0.0), (0.0, 2.0), (-1.6, 1.2), (1.5, 0.8))
NAMES = ("v_i", "v_j", "a", "b")


class CotangentExplorer(Displayed, OnPage, anywidget.AnyWidget):
    """Two triangles at an edge: drag a corner, and see alpha, beta and w_ij.

    Where an angle becomes so obtuse that both sum to more than 180 degrees, the
    weight is negative. The corners can also be moved with the arrow keys, or by code.

    Attributes
    ----------
    points : list of four (float, float)
        The ends v_i and v_j of the edge, and the corners opposite it.
    angles : list of two floats
        alpha and beta, in degrees.
    weight : float or None
        w_ij = (cot alpha + cot beta) / 2; None where a triangle has no area.

    Examples
    --------
    >>> explorer = CotangentExplorer()                    # doctest: +SKIP
    >>> explorer.move("a", (-0.3, 1.0))                   # doctest: +SKIP
    """

    _esm = text("cotangents.js")
    _css = text("cotangents.css")
    points: Any = traitlets.List().tag(sync=True)
    angles: Any = traitlets.List().tag(sync=True)
    cotangents: Any = traitlets.List().tag(sync=True)
    weight = traitlets.Float(allow_none=True, default_value=None).tag(sync=True)

    def __init__(self, **traits: Any) -> None:
        super().__init__(points=[list(point) for point in START], **traits)
        self.observe(lambda _: self._compute(), names="points")
        self._compute()
        self._saved = Saved(self, lambda: self.points, self._kept, drawn="svg")
        self.observe(lambda _: self._saved.changed(), names="points")

    def move(self, name: str, place: tuple[float, float]) -> None:
        """Move a corner.

        Parameters
        ----------
        name : {"v_i", "v_j", "a", "b"}
        place : (float, float)

        Raises
        ------
        ValueError
            No such corner.
        """
        if name not in NAMES:
            raise ValueError(f"there is no corner {name!r}; choose one of {', '.join(NAMES)}")
        points = [list(point) for point in self.points]
        points[NAMES.index(name)] = [float(x) for x in place]
        self.points = points

    def _part(self) -> str:
        return part(pack({"points": self.points}), self._still(), self._said())

    def _said(self) -> str:
        alpha, beta = self.angles
        weight = "none" if self.weight is None else f"{self.weight:.2f}"
        return f"Two triangles at an edge: angles {alpha:.0f}° and {beta:.0f}°, w_ij = {weight}"

    def _still(self) -> Image:
        """The triangles as a picture."""
        with needed_for("a still picture"):
            from matplotlib.backends.backend_agg import FigureCanvasAgg
            from matplotlib.figure import Figure
            from PIL import Image
        figure = Figure(figsize=(5.2, 3.2), facecolor="none")
        canvas = FigureCanvasAgg(figure)
        axes = figure.add_axes((0, 0, 1, 0.9))
        axes.set(xlim=(-2.6, 2.6), ylim=(-0.6, 2.4), aspect="equal")
        axes.set_axis_off()
        places = np.array(self.points)
        for face in F:
            axes.fill(*places[face].T, color=SURFACE, alpha=0.6, lw=0)
        axes.plot(*places[:2].T, color=INK, lw=3)
        for name, place in zip(("v_i", "v_j", r"\alpha", r"\beta"), places, strict=True):
            axes.annotate(f"${name}$", place, color=INK, fontsize=12)
        figure.suptitle(self._said(), fontsize=9, color=INK)
        canvas.draw()
        return Image.fromarray(np.array(canvas.buffer_rgba()))

    def _kept(self) -> Bundle:
        return picture(self._still(), self._said())

    def _repr_mimebundle_(self, **kwargs: Any) -> Any:
        """The explorer, or a part of a page that computes by itself."""
        if for_page():
            return {"text/html": self.to_html()}, {}
        return super()._repr_mimebundle_(**kwargs)

    def _compute(self) -> None:
        """Angles, cotangents and weight of the edge, as the package computes them."""
        V = np.column_stack([np.array(self.points, dtype=float), np.zeros(4)])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MeshWarning)  # the page says it
            W = cotangent(V, F)
        triangles = Triangles(V, F)
        with self.hold_sync():
            # Corner 2 of each face is the one opposite the edge.
            cot = triangles.cotangents[2]
            self.cotangents = cot.tolist()
            self.angles = (np.degrees(np.arctan2(1, cot)) % 180).tolist()
            self.weight = None if triangles.degenerate.any() else float(W[0, 1])
