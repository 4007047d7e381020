"""A live view of one mesh, or of several side by side, in a notebook."""

import contextlib
import io

import numpy as np

from meshfair.checks import MeshError, check_mesh
from meshfair.viewer.camera import Camera
from meshfair.viewer.offscreen import Panel, Scale, has_egl, render

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
    colours : str
        A colour map that polyscope and matplotlib both have.
    smooth : bool
        Shade smoothly across the faces.
    edges : bool
        Draw the edges as thin lines.
    direction, up : three floats
        From the meshes towards the camera, and what stays upright.
    backend : {"polyscope", "k3d"}, optional
        What draws; by default polyscope where there is EGL.

    Raises
    ------
    MeshError, ValueError
        No meshes, or lists of different lengths.
    ImportError
        A library is missing; the message says what to install.

    Examples
    --------
    >>> from meshfair import shapes
    >>> View(*shapes.knot(), titles="the seed's knot")  # doctest: +SKIP
    """

    def __init__(
        self,
        V,
        F,
        *,
        titles=None,
        values=None,
        label="",
        limits=None,
        colours="viridis",
        smooth=False,
        edges=False,
        direction=(1, -1, 0.6),
        up=(0, 0, 1),
        backend=None,
    ):
        count = len(V) if _is_list(V, 2) else 1
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
        self.titles = [title or "" for title in _each(titles, 0, count, "titles")]
        self.label, self.limits, self.colours = label, limits, colours
        self.up, self._direction = up, direction
        self._home = None  # what the reset button shows: set by look_at
        self._batch = None  # panels changed inside `together`
        self.aspect = STILL[0] / STILL[1] / count
        self.camera = self._camera_home()
        self._page = _page(backend, self)

    def _panel(self, V, F, values):
        V, F = check_mesh(V, F)
        values = None if values is None else np.array(values, dtype=float)
        if values is not None and values.shape not in ((len(V),), (len(F),)):
            raise MeshError(
                f"values have shape {values.shape}; give one for each of the {len(V)} vertices "
                f"or of the {len(F)} faces"
            )
        # Positions are copied: the renderers tell by identity whether an array is new.
        return Panel(V.copy(), F, values, self._smooth, self._edges)

    @property
    def widget(self):
        """The ipywidget, to put into a layout of one's own."""
        return self._page.widget

    @property
    def scale(self):
        """How the panels' values become colours now: a `Scale`, None without values."""
        return Scale.of([panel.values for panel in self.panels], self.limits, self.colours)

    def update(self, V=None, *, panel=0, F=None, values=None, title=None):
        """Show another mesh, or other values, in one panel.

        Parameters
        ----------
        V : array_like, shape (n, 3), optional
            New positions; those of before by default.
        panel : int
            Which panel, from the left.
        F : array_like of integers, optional
            New faces; those of before by default.
        values : array_like, shape (n,) or (m,), optional
            What the colours show; without it the mesh has one colour.
        title : str, optional

        Raises
        ------
        MeshError
            No mesh, or values that do not fit it.
        """
        old = self.panels[panel]
        same_faces = F is None or F is old.F
        new = self._panel(old.V if V is None else V, old.F if same_faces else F, values)
        self.panels[panel] = new
        if title is not None:
            self.titles[panel] = title
        self._refresh([panel])

    @contextlib.contextmanager
    def together(self):
        """Changes in this block reach the page as one frame."""
        self._batch = set()
        try:
            yield self
        finally:
            changed, self._batch = self._batch, None
            self._refresh(changed)

    def colour_by(self, label, limits=None, colours=None):
        """Say what the values are: the colour bar's label, its ends, its colours."""
        bar = (label, limits, colours or self.colours)
        if bar != (self.label, self.limits, self.colours):
            self.label, self.limits, self.colours = bar
            self._refresh(range(len(self.panels)))

    def look_at(self, V, direction=None):
        """Point the camera, and the reset button, at some points.

        Parameters
        ----------
        V : array_like, shape (k, 3)
            What should fill the picture, such as a part's vertices.
        direction : three floats, optional
            From there towards the camera; the view's own by default.
        """
        self._home = (np.array(V), direction or self._direction)
        self.reset()

    def reset(self):
        """Go back to the camera of the beginning, or of the last `look_at`."""
        self.camera = self._camera_home()
        self._page.camera_moved()

    def fit(self, aspect):
        """Tell the view its panels' shape, width over height; the page does."""
        untouched = self.camera == self._camera_home()
        self.aspect = aspect
        if untouched:
            self.camera = self._camera_home()

    def _camera_home(self):
        V, direction = self._home or (
            np.concatenate([panel.V for panel in self.panels]),
            self._direction,
        )
        return Camera.around(V, direction, self.up, aspect=self.aspect)

    def _refresh(self, panels):
        if self._batch is None:
            self._page.refresh(panels)
        else:
            self._batch.update(panels)

    def still(self, size=STILL):
        """Draw what the view shows now into a picture, with titles and colour bar.

        Parameters
        ----------
        size : (int, int)
            Width and height in pixels, all panels together.

        Returns
        -------
        PIL.Image.Image
            A notebook shows it; ``.save("knot.png")`` writes it.
        """
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import Normalize
        from matplotlib.figure import Figure
        from PIL import Image

        count, scale = len(self.panels), self.scale
        figure = Figure(figsize=(size[0] / 100, size[1] / 100), dpi=100, layout="constrained")
        axes = figure.subplots(1, count, squeeze=False)[0]
        cell = (size[0] // count, round(0.9 * size[1]))
        for ax, panel, title in zip(axes, self.panels, self.titles, strict=True):
            ax.imshow(self._pixels(panel, cell, scale), interpolation="antialiased")
            ax.set_title(title, fontsize=10)
            ax.axis("off")
        if scale is not None:
            colours = ScalarMappable(Normalize(scale.low, scale.high), scale.colours)
            figure.colorbar(colours, ax=list(axes), label=self.label, shrink=0.8)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        return Image.fromarray(np.array(canvas.buffer_rgba())).convert("RGB")

    def _pixels(self, panel, size, scale):
        return render(
            panel.V,
            panel.F,
            self.camera,
            size=size,
            values=panel.values,
            limits=scale and (scale.low, scale.high),
            colours=self.colours,
            smooth=panel.smooth,
            edges=panel.edges,
        )

    def _repr_mimebundle_(self, **kwargs):
        """The live view, and a still of it for readers without a kernel."""
        return with_still(self.widget, self)


def _is_list(given, ndim):
    """Whether something is a list with one entry, of ``ndim`` dimensions or None, a panel."""
    return isinstance(given, (list, tuple)) and any(
        entry is not None and np.ndim(entry) == ndim for entry in given
    )


def _each(given, ndim, count, name):
    """One entry for each panel: those of a list, or the same for all."""
    entries = list(given) if _is_list(given, ndim) else [given] * count
    if len(entries) != count:
        raise ValueError(f"{name} has {len(entries)} entries; give one for each of {count} panels")
    return entries


def with_still(widget, view):
    """A widget's display data with a picture beside it, for a page that runs no widgets."""
    bundle = widget._repr_mimebundle_()
    data, metadata = bundle if isinstance(bundle, tuple) else (bundle, {})
    png = io.BytesIO()
    view.still().save(png, "PNG")
    return data | {"image/png": png.getvalue()}, metadata


def _page(backend, view):
    """The view's other end, in the page; its library is loaded here."""
    if backend is None:
        backend = "polyscope" if has_egl() else "k3d"
    if backend == "polyscope":
        from meshfair.viewer.frames import Frames

        return Frames(view)
    if backend == "k3d":
        from meshfair.viewer.in_page import InPage

        return InPage(view)
    raise ValueError(f"backend is {backend!r}; give 'polyscope' or 'k3d'")
