"""The cotangent weight of one edge, from two triangles whose corners can be dragged."""

from __future__ import annotations

import warnings
from typing import Any

import anywidget
import numpy as np
import traitlets

from meshfair.checks import MeshWarning
from meshfair.mesh.elements import Triangles
from meshfair.viewer.scripts import text
from meshfair.weights import cotangent

F = np.array([[0, 1, 2], [1, 0, 3]])
START = ((0.0, 0.0), (0.0, 2.0), (-1.6, 1.2), (1.5, 0.8))
NAMES = ("v_i", "v_j", "a", "b")


class CotangentExplorer(anywidget.AnyWidget):
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
