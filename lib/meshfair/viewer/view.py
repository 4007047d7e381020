"""A live view of one mesh, or of several side by side, in a notebook."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from numpy.typing import ArrayLike

from meshfair.checks import Floats, check_choice, check_number, check_text, check_vertices
from meshfair.viewer.arguments import coloring
from meshfair.viewer.backend import Backend
from meshfair.viewer.camera import Camera
from meshfair.viewer.live import made
from meshfair.viewer.page import described, for_page
from meshfair.viewer.picking import pick
from meshfair.viewer.saved import Bundle, Displayed, Saved, picture
from meshfair.viewer.side_by_side import SideBySide


class View(Displayed, SideBySide):
    """Meshes that can be turned: drag to turn, shift-drag to move, wheel to zoom, R to reset.

    Drawn by polyscope on the machine where Python runs, each frame sent to
    the page; without EGL there (macOS, Windows, a bare server) drawn in the page
    itself, by WebGL. Several meshes stand side by side and share one camera.
    A notebook that is saved keeps a still of what was shown last, for readers without
    its kernel.

    Parameters
    ----------
    V : array_like, shape (n, 3), or a list of them
        One mesh, or one for each panel. A mesh of another library stands for V and F.
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
    backend : {"polyscope", "webgl"}, optional
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
        backend: str | None = None,
    ) -> None:
        super().__init__(
            V,
            F,
            titles=titles,
            values=values,
            label=label,
            limits=limits,
            cmap=cmap,
            smooth=smooth,
            edges=edges,
            direction=direction,
            up=up,
        )
        self.lock: contextlib.AbstractContextManager[bool, None] = threading.RLock()
        # What was changed inside of `together`: how many blocks deep, panels, and the camera.
        self._depth, self._changed, self._moved = 0, set[int](), False
        self._on_pick: Callable[[int, int], object] | None = None
        self._backend: Backend = made(backend, self)
        self._saved = Saved(self.widget, self.state, self.kept)
        self._followers: Sequence[Callable[[], object]] = [self._saved.changed]

    @property
    def widget(self) -> Any:
        """The ipywidget, to put into a layout of one's own."""
        return self._backend.widget

    def _aim(self, camera: Camera) -> None:
        with self.together():
            self._camera, self._moved = camera, True

    def _go_home(self, home: tuple[Floats, Floats] | None = None) -> None:
        with self.together():
            super()._go_home(home)

    def follow(self, function: Callable[[], object]) -> None:
        """Say what is called after each change of what is shown.

        Parameters
        ----------
        function : callable
            Without arguments, and quick: it is called many times a second.
        """
        self._followers = [*self._followers, function]

    def _tell(self) -> None:
        for function in self._followers:
            function()

    def state(self) -> tuple[object, ...]:
        """What is shown, to compare with what was shown before.

        Returns
        -------
        tuple
            Equal to another where both have the same still.
        """
        camera = None if self.camera == self._camera_home() else self.camera
        return (*self.panels, *self.titles, self.label, self.limits, self.cmap, camera)

    def kept(self, note: str = "") -> Bundle:
        """What a notebook keeps: a still.

        Parameters
        ----------
        note : str
            What stands below it.

        Returns
        -------
        dict
            By MIME type.
        """
        return picture(self.still(), described(self.titles, self.label), note)

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
        with self.together():
            old = self.panels[panel]
            title = self.titles[panel] if title is None else check_text(title, "title")
            self.panels[panel] = self._panel(
                old.V if V is None else V, old.F if F is None else F, values
            )
            self.titles[panel] = title
            if self._placement.holds(self.panels):
                self.placed[panel] = self._placement.panel(self.panels[panel])
                self._changed.add(panel)
            else:
                self._place()
                self._changed.update(range(len(self.panels)))
                self._moved = True

    @contextlib.contextmanager
    def together(self) -> Iterator[View]:
        """Changes in this block reach the page as one frame; no frame is drawn meanwhile."""
        outermost, changed, moved = False, set[int](), False
        try:
            with self.lock:
                outermost = self._depth == 0
                self._depth += 1
                try:
                    yield self
                finally:
                    self._depth -= 1
                    if outermost:
                        changed, self._changed = self._changed, set()
                        moved, self._moved = self._moved, False
        finally:
            # Without the lock, for which what draws may wait.
            if moved:
                self._backend.camera_moved(changed)
            elif changed:
                self._backend.refresh(changed)
            if moved or changed:
                self._tell()

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
        with self.together():
            bar = coloring(label, limits, self.cmap if cmap is None else cmap)
            if bar != (self.label, self.limits, self.cmap):
                self.label, self.limits, self.cmap = bar
                self._changed.update(range(len(self.panels)))

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
        V = check_vertices(V).copy()
        with self.together():
            before = self._camera_home()
            self._home = (V, self._home[1])
            after = self._camera_home()
            if after != before:
                untouched = self.camera == before
                self._aim(after if untouched else self.camera.follow(before, after))

    def on_pick(self, function: Callable[[int, int], object] | None) -> None:
        """Say what a click on a mesh does.

        Parameters
        ----------
        function : function(panel, vertex) or None
            Called with the numbers of the panel and of the vertex.
        """
        self._on_pick = function

    def click(self, panel: int, x: float, y: float) -> None:
        """Somebody has clicked on a panel; the page says so.

        Parameters
        ----------
        panel : int
        x, y : float
            From -1 at the panel's left and bottom edge to 1 at its right and top edge.

        Raises
        ------
        ValueError
            No such panel.
        """
        if self._on_pick is None:
            return
        shown = self.panels[check_choice(panel, "panel", range(len(self.panels)))]
        vertex = pick(shown.V, shown.F, self.camera, (x, y), self.aspect)
        if vertex is not None:
            self._on_pick(panel, vertex)

    def fit(self, aspect: float) -> None:
        """Say the panels' shape, width over height; the page does.

        Parameters
        ----------
        aspect : float
            Above 0.

        Raises
        ------
        ValueError
            An ``aspect`` that is no finite number above 0.
        """
        aspect = check_number(aspect, "aspect", 0, open_low=True)
        with self.lock:
            untouched = self.camera == self._camera_home()
            self.aspect = aspect
            if untouched:
                self._camera = self._camera_home()
        self._tell()

    def turn(self, yaw: float, pitch: float, pan: Sequence[float], zoom: float) -> None:
        """A pointer has moved the camera; the page says so, and draws it, or asks for it.

        Parameters
        ----------
        yaw, pitch : float
            In radians, as in `Camera.orbit`.
        pan : two floats
            In heights of the picture, as in `Camera.pan`.
        zoom : float
            Above 0, as in `Camera.zoom`.
        """
        with self.lock:
            self._camera = self.camera.orbit(yaw, pitch, self.up).pan(*pan).zoom(zoom)
        self._tell()

    def _repr_mimebundle_(self, **kwargs: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        """The live view, and a still of it for readers without a kernel; or a part of a page."""
        if for_page():
            return {"text/html": self.to_html()}, {}
        return self._saved.bundle()
