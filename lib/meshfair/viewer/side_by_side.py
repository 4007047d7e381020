"""Meshes side by side, each with its values and title, seen by one camera."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import (
    Floats,
    check_direction,
    check_flag,
    check_mesh,
    check_number,
    check_values,
    check_vertices,
)
from meshfair.viewer.arguments import coloring, each, each_mesh, each_title
from meshfair.viewer.camera import Camera, check_camera
from meshfair.viewer.page import OnPage, described, part
from meshfair.viewer.panel import NONE, Panel, Scale
from meshfair.viewer.placement import Placement
from meshfair.viewer.recording import Recording
from meshfair.viewer.stills import STILL, still

if TYPE_CHECKING:
    from PIL.Image import Image


class SideBySide(OnPage):
    """Meshes side by side, for a picture or a page on file.

    Parameters
    ----------
    V, F, titles, values, label, limits, cmap, smooth, edges, direction, up
        As in `View`, which also shows them live.

    Raises
    ------
    MeshError, ValueError
        No meshes, values that do not fit them, lists of different lengths, or
        an option that is none.

    Examples
    --------
    >>> from meshfair import shapes
    >>> both = SideBySide(*shapes.knot(), titles="the knot")
    >>> both.still().save("knot.png")  # doctest: +SKIP
    """

    none: tuple[float, float, float] = NONE
    """The colour where a value is NaN or infinite, of the meshes that are shown from now on."""

    def __init__(
        self,
        V: Any,
        F: Any = None,
        *,
        titles: str | Sequence[str | None] | None = None,
        values: ArrayLike | Sequence[ArrayLike | None] | None = None,
        label: str = "",
        limits: tuple[float, float] | None = None,
        cmap: str = "viridis",
        smooth: bool = False,
        edges: bool = False,
        direction: ArrayLike = (1, -1, 0.6),
        up: ArrayLike = (0, 0, 1),
    ) -> None:
        meshes = each_mesh(V, F)
        count = len(meshes)
        self._smooth, self._edges = check_flag(smooth, "smooth"), check_flag(edges, "edges")
        self.panels = [
            self._panel(*mesh, numbers)
            for mesh, numbers in zip(meshes, each(values, 1, count, "values"), strict=True)
        ]
        self.titles = each_title(titles, count)
        self.label, self.limits, self.cmap = coloring(label, limits, cmap)
        self.up = check_direction(up, "up")
        self.direction = check_direction(direction, "direction")
        # What the reset button shows, whatever the panels hold by then: set by look_at.
        drawn = [panel.V[panel.used] for panel in self.panels]
        self._home = np.concatenate(drawn), self.direction
        self._place()
        self.aspect = STILL[0] / STILL[1] / count  # of each panel, width over height
        self._camera = self._camera_home()

    def _panel(self, V: ArrayLike, F: ArrayLike, values: ArrayLike | None) -> Panel:
        V, F = check_mesh(V, F)
        numbers = None if values is None else check_values(values, len(V), len(F), finite=False)
        # A copy, to which nobody else writes.
        return Panel(V.copy(), F, numbers, self._smooth, self._edges, self.none)

    def _place(self) -> None:
        """Place all panels anew, for what draws them."""
        self._placement = Placement.of(self.panels)
        self.placed = [self._placement.panel(panel) for panel in self.panels]

    @property
    def camera(self) -> Camera:
        """The camera that sees all panels."""
        return self._camera

    @camera.setter
    def camera(self, camera: Camera) -> None:
        self._aim(check_camera(camera))

    def _aim(self, camera: Camera) -> None:
        self._camera = camera

    @property
    def placed_camera(self) -> Camera:
        """The camera that sees the placed panels."""
        return self._placement.camera(self.camera)

    @property
    def scale(self) -> Scale | None:
        """How the panels' values become colours now: a `Scale`, None without values."""
        return Scale.of(self.panels, self.limits, self.cmap)

    def look_at(self, V: ArrayLike, direction: ArrayLike | None = None) -> None:
        """Point the camera, and the reset button, at some points.

        Parameters
        ----------
        V : array_like, shape (k, 3)
            What should fill the picture, such as a part's vertices.
        direction : three floats, optional
            From there towards the camera; the view's own by default.

        Raises
        ------
        MeshError, ValueError
            No points, or no direction.
        """
        towards = self.direction if direction is None else check_direction(direction, "direction")
        self._go_home((check_vertices(V).copy(), towards))

    def reset(self) -> None:
        """Go back to the camera of the beginning, or to what it was last pointed at."""
        self._go_home()

    def _go_home(self, home: tuple[Floats, Floats] | None = None) -> None:
        """Go to what the reset button shows, and before make that these points from there."""
        self._home = self._home if home is None else home
        self._aim(self._camera_home())

    def _camera_home(self, aspect: float | None = None) -> Camera:
        V, direction = self._home
        return Camera.around(V, direction, self.up, aspect=aspect or self.aspect)

    def camera_for(self, aspect: float) -> Camera:
        """The camera for a picture of another shape, in which nothing is cut.

        Parameters
        ----------
        aspect : float
            Width over height of the picture of one panel.

        Returns
        -------
        Camera
            From nobody's hand: the one that fits the shape. Else the view's own, moved
            back as far as a narrower picture needs.

        Raises
        ------
        ValueError
            An ``aspect`` that is no finite number above 0.
        """
        aspect = check_number(aspect, "aspect", 0, open_low=True)
        if self.camera == self._camera_home():
            return self._camera_home(aspect)
        return self.camera.zoom(max(1.0, self.aspect / aspect))

    def still(self, size: tuple[int, int] = STILL, *, background: str | None = None) -> Image:
        """Draw what is shown now into a picture, with titles and colour bar.

        Where the camera has not been moved, the meshes fill a picture of any shape;
        else it shows at least what the page does.

        Parameters
        ----------
        size : (int, int)
            Width and height in pixels, all panels together; 64 to 8192 each.
        background : str, optional
            A colour, as matplotlib names it; without it the picture is transparent, and
            its letters can be read on light and on dark pages.

        Returns
        -------
        PIL.Image.Image
            A notebook shows it; ``.save("knot.png")`` writes it. For JPEG, which knows no
            transparency, it needs a background.

        Raises
        ------
        ValueError
            A size that is none, or too small for so many panels; no colour.
        ImportError
            matplotlib or Pillow is missing; the message says what to install.
        """
        return still(self, size, background)

    def _part(self) -> str:
        recording = Recording(self)
        recording.add(self)
        return part(recording.packed(), self.still(), described(self.titles, self.label))
