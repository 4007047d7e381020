"""A live view of one mesh, or of several side by side, in a notebook."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import (
    check_choice,
    check_direction,
    check_flag,
    check_mesh,
    check_number,
    check_range,
    check_text,
    check_values,
    check_vertices,
)
from meshfair.viewer.arguments import count_panels, each, each_title
from meshfair.viewer.backend import Backend, made
from meshfair.viewer.camera import Camera
from meshfair.viewer.panel import CMAPS, Panel, Scale
from meshfair.viewer.placement import Placement
from meshfair.viewer.stills import STILL, still

if TYPE_CHECKING:
    from PIL.Image import Image


class View:
    """Meshes that can be turned: drag to turn, shift-drag to move, wheel to zoom, R to reset.

    Drawn by polyscope on the machine where Python runs, each frame sent to
    the page; without EGL there (macOS, Windows, a bare server) drawn by k3d in
    the page itself. Several meshes stand side by side and share one camera.

    Parameters
    ----------
    V : array_like, shape (n, 3), or a list of them
        One mesh, or one for each panel.
    F : array_like of integers, shape (m, 3), or a list of them
        One for all panels, or one for each.
    titles : str or list of str, optional
        What stands above each panel.
    values : array_like, shape (n,) or (m,), or a list of them, optional
        A number for each vertex or each face, shown as a colour; grey where it
        is NaN or infinite. None in the list for a panel without.
    label : str
        What the values are, with their unit; stands at the colour bar.
    limits : (float, float), optional
        The values at both ends of the colour bar; by default the range of those
        that are finite.
    cmap : str
        A colour map, one of `meshfair.viewer.CMAPS`.
    smooth : bool
        Shade smoothly across the faces.
    edges : bool
        Draw the edges as thin lines.
    direction, up : three floats
        From the meshes towards the camera, and what stays upright. Looking straight
        along ``up``, an axis across stands up in its place.
    backend : {"polyscope", "k3d"}, optional
        What draws; by default polyscope where there is EGL.

    Raises
    ------
    MeshError, ValueError
        No meshes, values that do not fit them, lists of different lengths, or
        an option that is none.
    ImportError
        A library is missing; the message says what to install.

    Examples
    --------
    >>> from meshfair import shapes
    >>> View(*shapes.knot(), titles="the knot")  # doctest: +SKIP
    """

    def __init__(
        self,
        V: ArrayLike,
        F: ArrayLike,
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
        backend: str | None = None,
    ) -> None:
        count = count_panels(V)
        self._smooth, self._edges = check_flag(smooth, "smooth"), check_flag(edges, "edges")
        self.panels = [
            self._panel(*mesh)
            for mesh in zip(
                each(V, 2, count, "V"),
                each(F, 2, count, "F"),
                each(values, 1, count, "values"),
                strict=True,
            )
        ]
        self.titles = each_title(titles, count)
        self.label, self.limits, self.cmap = _coloring(label, limits, cmap)
        self.up = check_direction(up, "up")
        self.direction = check_direction(direction, "direction")
        # What the reset button shows, whatever the panels hold by then: set by look_at.
        drawn = [panel.V[panel.used] for panel in self.panels]
        self._home = np.concatenate(drawn), self.direction
        self._place()
        self._changed: set[int] | None = None  # panels changed inside `together`
        self._moved = False  # the camera was, there
        self.aspect = STILL[0] / STILL[1] / count
        self.camera = self._camera_home()
        self._backend: Backend = made(backend, self)

    def _panel(self, V: ArrayLike, F: ArrayLike, values: ArrayLike | None) -> Panel:
        V, F = check_mesh(V, F)
        numbers = None if values is None else check_values(values, len(V), len(F), finite=False)
        # A copy, to which nobody else writes.
        return Panel(V.copy(), F, numbers, self._smooth, self._edges)

    def _place(self) -> None:
        """Place all panels anew, for what draws them."""
        self._placement = Placement.of(self.panels)
        self.placed = [self._placement.panel(panel) for panel in self.panels]

    @property
    def placed_camera(self) -> Camera:
        """The camera that sees the placed panels."""
        return self._placement.camera(self.camera)

    @property
    def widget(self) -> Any:
        """The ipywidget, to put into a layout of one's own."""
        return self._backend.widget

    @property
    def scale(self) -> Scale | None:
        """How the panels' values become colours now: a `Scale`, None without values."""
        return Scale.of(self.panels, self.limits, self.cmap)

    def update(
        self,
        V: ArrayLike | None = None,
        *,
        panel: int = 0,
        F: ArrayLike | None = None,
        values: ArrayLike | None = None,
        title: str | None = None,
    ) -> None:
        """Show another mesh, or other values, in one panel.

        Parameters
        ----------
        V : array_like, shape (n, 3), optional
            New positions; those of before by default.
        panel : int
            Which panel, from the left, from 0.
        F : array_like of integers, optional
            New faces; those of before by default.
        values : array_like, shape (n,) or (m,), optional
            What the colours show, grey where it is NaN or infinite; without it the
            mesh has one colour.
        title : str, optional

        Raises
        ------
        MeshError, ValueError
            No mesh, values that do not fit it, or no such panel.
        """
        panel = check_choice(panel, "panel", range(len(self.panels)))
        old = self.panels[panel]
        title = self.titles[panel] if title is None else check_text(title, "title")
        self.panels[panel] = self._panel(
            old.V if V is None else V, old.F if F is None else F, values
        )
        self.titles[panel] = title
        if self._placement.holds(self.panels):
            self.placed[panel] = self._placement.panel(self.panels[panel])
            self._refresh([panel])
        else:
            self._place()
            self._refresh(range(len(self.panels)), moved=True)

    @contextlib.contextmanager
    def together(self) -> Iterator[View]:
        """Changes in this block reach the page as one frame."""
        changed: set[int] = set()
        self._changed = changed
        try:
            yield self
        finally:
            moved, self._moved = self._moved, False
            self._changed = None
            self._refresh(changed, moved=moved)

    def color_by(
        self, label: str, limits: tuple[float, float] | None = None, cmap: str | None = None
    ) -> None:
        """Say what the values are.

        Parameters
        ----------
        label : str
            What stands at the colour bar.
        limits : (float, float), optional
            The values at its ends; by default the range of those that are finite.
        cmap : str, optional
            Its colour map, one of `meshfair.viewer.CMAPS`; that of before by default.

        Raises
        ------
        ValueError
            A label that is no text, ``limits`` that are no range, or an unknown ``cmap``.
        """
        bar = _coloring(label, limits, self.cmap if cmap is None else cmap)
        if bar != (self.label, self.limits, self.cmap):
            self.label, self.limits, self.cmap = bar
            self._refresh(range(len(self.panels)))

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
        self._home = (check_vertices(V).copy(), towards)
        self.reset()

    def refit(self, V: ArrayLike) -> None:
        """Point the reset button at other points, and the camera with it.

        A camera that was turned, moved or brought closer stays so, and goes as far away as
        the points' new size asks for.

        Parameters
        ----------
        V : array_like, shape (k, 3)
            What should fill the picture, such as a mesh that has grown.

        Raises
        ------
        MeshError
            No points.
        """
        before = self._camera_home()
        self._home = (check_vertices(V).copy(), self._home[1])
        after = self._camera_home()
        if after == before:
            return
        self.camera = after if self.camera == before else self.camera.follow(before, after)
        self._refresh([], moved=True)

    def reset(self) -> None:
        """Go back to the camera of the beginning, or of the last `look_at` or `refit`."""
        self.camera = self._camera_home()
        self._refresh([], moved=True)

    def fit(self, aspect: float) -> None:
        """Say the panels' shape, width over height; the page does."""
        untouched = self.camera == self._camera_home()
        self.aspect = check_number(aspect, "aspect", 0, open_low=True)
        if untouched:
            self.camera = self._camera_home()

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
        """
        aspect = check_number(aspect, "aspect", 0, open_low=True)
        if self.camera == self._camera_home():
            return self._camera_home(aspect)
        return self.camera.zoom(max(1.0, self.aspect / aspect))

    def _refresh(self, panels: Iterable[int], moved: bool = False) -> None:
        """Draw some panels again, and all of them where the camera has moved."""
        if self._changed is None:
            draw = self._backend.camera_moved if moved else self._backend.refresh
            draw(panels)
        else:
            self._changed.update(panels)
            self._moved = self._moved or moved

    def still(self, size: tuple[int, int] = STILL, *, background: str | None = None) -> Image:
        """Draw what the view shows now into a picture, with titles and colour bar.

        Where the camera has not been moved, the meshes fill a picture of any shape;
        else it shows at least what the view does.

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

    def _repr_mimebundle_(self, **kwargs: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        """The live view, and a still of it for readers without a kernel."""
        return with_still(self.widget, self)


def with_still(widget: Any, view: View) -> tuple[dict[str, Any], dict[str, Any]]:
    """A widget's display data with a picture beside it, for a page that runs no widgets."""
    bundle = widget._repr_mimebundle_()
    data, metadata = bundle if isinstance(bundle, tuple) else (bundle, {})
    png = io.BytesIO()
    view.still().save(png, "PNG")
    return data | {"image/png": png.getvalue()}, metadata


def _coloring(label: Any, limits: Any, cmap: Any) -> tuple[str, tuple[float, float] | None, str]:
    """What the colours show, checked: refused here, not in the thread that draws."""
    limits = None if limits is None else check_range(limits, "limits")
    return check_text(label, "label"), limits, check_choice(cmap, "cmap", CMAPS)
