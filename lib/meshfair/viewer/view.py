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
    check_count,
    check_direction,
    check_mesh,
    check_number,
    check_values,
    check_vertices,
    needed_for,
)
from meshfair.viewer.backend import Backend
from meshfair.viewer.camera import Camera
from meshfair.viewer.offscreen import Pixels, has_egl, render
from meshfair.viewer.panel import Panel, Scale

if TYPE_CHECKING:
    from PIL.Image import Image

STILL = (1000, 360)  # pixels of a still picture, all panels together


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
        A number for each vertex or each face, shown as a colour; None in the
        list for a panel without.
    label : str
        What the values are, with their unit; stands at the colour bar.
    limits : (float, float), optional
        The values at both ends of the colour bar; their range by default.
    cmap : str
        A colour map, one of `meshfair.viewer.CMAPS`.
    smooth : bool
        Shade smoothly across the faces.
    edges : bool
        Draw the edges as thin lines.
    direction, up : three floats
        From the meshes towards the camera, and what stays upright; not parallel.
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
        count = _count(V)
        self._smooth, self._edges = smooth, edges
        self.panels = [
            self._panel(*mesh)
            for mesh in zip(
                _each(V, 2, count, "V"),
                _each(F, 2, count, "F"),
                _each(values, 1, count, "values"),
                strict=True,
            )
        ]
        self.titles: list[str] = [title or "" for title in _each(titles, 0, count, "titles")]
        self.label, self.limits, self.cmap = label, limits, cmap
        Scale.of([], limits, cmap)  # refused here, not in the thread that draws
        self.up = check_direction(up, "up")
        self.direction = check_direction(direction, "direction")
        # What the reset button shows, whatever the panels hold by then: set by look_at.
        self._home = np.concatenate([panel.V for panel in self.panels]), self.direction
        self._changed: set[int] | None = None  # panels changed inside `together`
        self._moved = False  # the camera was, there
        self.aspect = STILL[0] / STILL[1] / count
        self.camera = self._camera_home()
        self._backend = _backend(backend, self)

    def _panel(self, V: ArrayLike, F: ArrayLike, values: ArrayLike | None) -> Panel:
        V, F = check_mesh(V, F)
        numbers = None if values is None else check_values(values, len(V), len(F))
        # Positions are copied: the renderers tell by identity whether an array is new.
        return Panel(V.copy(), F, numbers, self._smooth, self._edges)

    @property
    def widget(self) -> Any:
        """The ipywidget, to put into a layout of one's own."""
        return self._backend.widget

    @property
    def scale(self) -> Scale | None:
        """How the panels' values become colours now: a `Scale`, None without values."""
        return Scale.of([panel.values for panel in self.panels], self.limits, self.cmap)

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
            What the colours show; without it the mesh has one colour.
        title : str, optional

        Raises
        ------
        MeshError, ValueError
            No mesh, values that do not fit it, or no such panel.
        """
        old = self.panels[check_choice(panel, "panel", range(len(self.panels)))]
        self.panels[panel] = self._panel(
            old.V if V is None else V, old.F if F is None else F, values
        )
        if title is not None:
            self.titles[panel] = title
        self._refresh([panel])

    @contextlib.contextmanager
    def together(self) -> Iterator[View]:
        """Changes in this block reach the page as one frame."""
        changed: set[int] = set()
        self._changed = changed
        try:
            yield self
        finally:
            self._changed = None
            if self._moved:
                self._moved = False
                self._backend.camera_moved(changed)
            else:
                self._refresh(changed)

    def color_by(
        self, label: str, limits: tuple[float, float] | None = None, cmap: str | None = None
    ) -> None:
        """Say what the values are.

        Parameters
        ----------
        label : str
            What stands at the colour bar.
        limits : (float, float), optional
            The values at its ends; their range by default.
        cmap : str, optional
            Its colour map, one of `meshfair.viewer.CMAPS`; that of before by default.

        Raises
        ------
        ValueError
            ``limits`` that are no range, or an unknown ``cmap``.
        """
        bar = (label, limits, cmap or self.cmap)
        if bar != (self.label, self.limits, self.cmap):
            Scale.of([], limits, bar[2])
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
        self._camera_moved()

    def reset(self) -> None:
        """Go back to the camera of the beginning, or of the last `look_at` or `refit`."""
        self.camera = self._camera_home()
        self._camera_moved()

    def fit(self, aspect: float) -> None:
        """Say the panels' shape, width over height; the page does."""
        untouched = self.camera == self._camera_home()
        self.aspect = check_number(aspect, "aspect", 0, open_low=True)
        if untouched:
            self.camera = self._camera_home()

    def _camera_moved(self) -> None:
        if self._changed is None:
            self._backend.camera_moved()
        else:
            self._moved = True

    def _camera_home(self) -> Camera:
        V, direction = self._home
        return Camera.around(V, direction, self.up, aspect=self.aspect)

    def _refresh(self, panels: Iterable[int]) -> None:
        if self._changed is None:
            self._backend.refresh(panels)
        else:
            self._changed.update(panels)

    def still(self, size: tuple[int, int] = STILL) -> Image:
        """Draw what the view shows now into a picture, with titles and colour bar.

        Parameters
        ----------
        size : (int, int)
            Width and height in pixels, all panels together.

        Returns
        -------
        PIL.Image.Image
            A notebook shows it; ``.save("knot.png")`` writes it.

        Raises
        ------
        ImportError
            matplotlib or Pillow is missing; the message says what to install.
        """
        with needed_for("a still picture"):
            from matplotlib.backends.backend_agg import FigureCanvasAgg
            from matplotlib.cm import ScalarMappable
            from matplotlib.colors import Normalize
            from matplotlib.figure import Figure
            from PIL import Image

        count, scale = len(self.panels), self.scale
        width, height = (check_count(pixels, "size", 1) for pixels in size)
        figure = Figure(figsize=(width / 100, height / 100), dpi=100, layout="constrained")
        axes = figure.subplots(1, count, squeeze=False)[0]
        cell = (max(width // count, 1), max(round(0.9 * height), 1))
        for ax, panel, title in zip(axes, self.panels, self.titles, strict=True):
            ax.imshow(self._pixels(panel, cell, scale), interpolation="antialiased")
            ax.set_title(title, fontsize=10)
            ax.axis("off")
        if scale is not None:
            bar = ScalarMappable(Normalize(scale.low, scale.high), scale.colormap)
            figure.colorbar(bar, ax=list(axes), label=self.label, shrink=0.8)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        return Image.fromarray(np.array(canvas.buffer_rgba())).convert("RGB")

    def _pixels(self, panel: Panel, size: tuple[int, int], scale: Scale | None) -> Pixels:
        return render(
            panel.V,
            panel.F,
            self.camera,
            size=size,
            values=panel.values,
            limits=None if scale is None else (scale.low, scale.high),
            cmap=self.cmap,
            smooth=panel.smooth,
            edges=panel.edges,
        )

    def _repr_mimebundle_(self, **kwargs: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        """The live view, and a still of it for readers without a kernel."""
        return with_still(self.widget, self)


def _is_list(given: Any, ndim: int) -> bool:
    """Whether something is a list with one entry, of ``ndim`` dimensions or None, a panel."""
    return isinstance(given, (list, tuple)) and any(
        entry is not None and np.ndim(entry) == ndim for entry in given
    )


def _count(V: Any) -> int:
    """The number of panels that some positions are for."""
    return len(V) if _is_list(V, 2) else 1


def _each(given: Any, ndim: int, count: int, name: str) -> list[Any]:
    """One entry for each panel: those of a list, or the same for all."""
    entries = list(given) if _is_list(given, ndim) else [given] * count
    if len(entries) != count:
        raise ValueError(f"{name} has {len(entries)} entries; give one for each of {count} panels")
    return entries


def with_still(widget: Any, view: View) -> tuple[dict[str, Any], dict[str, Any]]:
    """A widget's display data with a picture beside it, for a page that runs no widgets."""
    bundle = widget._repr_mimebundle_()
    data, metadata = bundle if isinstance(bundle, tuple) else (bundle, {})
    png = io.BytesIO()
    view.still().save(png, "PNG")
    return data | {"image/png": png.getvalue()}, metadata


def _backend(name: str | None, view: View) -> Backend:
    """What draws a view in the page; its libraries are loaded here."""
    name = name or ("polyscope" if has_egl() else "k3d")
    check_choice(name, "backend", ("polyscope", "k3d"))
    if name == "polyscope":
        with needed_for("a live view"):
            from meshfair.viewer.frames import Frames
        return Frames(view)
    with needed_for("a live view without EGL"):
        from meshfair.viewer.in_page import InPage
    return InPage(view)
