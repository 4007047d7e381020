"""A view as one picture: its panels side by side, with titles and a colour bar."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from meshfair.checks import check_size, needed_for
from meshfair.viewer.camera import Camera
from meshfair.viewer.offscreen import LARGEST, render
from meshfair.viewer.panel import Panel, Scale

if TYPE_CHECKING:
    from PIL.Image import Image

STILL = (1000, 360)  # pixels of a still picture, all panels together
LEAST = 64  # pixels of its sides
DPI = 100
TITLE = 28  # pixels of the row of titles
BAR = 110  # pixels of the colour bar with its numbers and label, where it stands at the right
BELOW = 64  # and where, in a narrow picture, it lies below
NARROW = 420  # pixels of a picture up to which it does
INK = "#7a7a7a"  # of what is written: can be read on white, and on a dark page
FONT, SMALLEST = 10.0, 7.0  # points


class Shown(Protocol):
    """What a still shows of a view."""

    panels: list[Panel]
    titles: list[str]
    label: str

    @property
    def scale(self) -> Scale | None:
        """How the panels' values become colours."""

    def camera_for(self, aspect: float) -> Camera:
        """The camera for panels of this shape, width over height."""


def still(view: Shown, size: tuple[int, int], background: str | None = None) -> Image:
    """Draw what a view shows into a picture; see `meshfair.viewer.View.still`."""
    with needed_for("a still picture"):
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
        from PIL import Image

    width, height = check_size(size, "size", LEAST, LARGEST)
    count, scale = len(view.panels), view.scale
    below = scale is not None and width <= NARROW
    right = BAR if scale is not None and not below else 0
    top, bottom = TITLE if any(view.titles) else 0, BELOW if below else 0
    cell = ((width - right) // count, height - top - bottom)
    if min(cell) < LEAST // 2:
        raise ValueError(
            f"size is {size!r}, which leaves {cell[0]} x {cell[1]} pixels for each of {count} "
            "panels; give a larger one"
        )
    ink = _ink_on(background)
    figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI, facecolor=background or "none")
    canvas = FigureCanvasAgg(figure)
    camera = view.camera_for(cell[0] / cell[1])
    for k, (panel, title) in enumerate(zip(view.panels, view.titles, strict=True)):
        pixels = render(
            panel.V,
            panel.F,
            camera,
            size=cell,
            values=panel.values,
            limits=None if scale is None else (scale.low, scale.high),
            cmap="viridis" if scale is None else scale.cmap,
            smooth=panel.smooth,
            edges=panel.edges,
            none=panel.none,
        )
        figure.figimage(pixels, k * cell[0], bottom)
        middle = ((k + 0.5) * cell[0] / width, 1 - TITLE / 2 / height)
        text = figure.text(*middle, title, ha="center", va="center", fontsize=FONT, color=ink)
        _shrink(text, canvas, cell[0] - 8)
    if scale is not None:
        place = (width - BAR + 12.0, 0.12 * cell[1], 12.0, 0.76 * cell[1])
        if below:
            place = (0.1 * width, 0.62 * BELOW, 0.8 * width, 12.0)
        label = _draw_bar(figure, place, (width, height), scale, view.label, below, ink)
        _shrink(label, canvas, width - 8 if below else height - 8)
    canvas.draw()
    picture = Image.fromarray(np.array(canvas.buffer_rgba()))
    return picture if background is None else picture.convert("RGB")


def _ink_on(background: str | None) -> str:
    """The colour of what is written on a background, or on nobody knows which."""
    from matplotlib.colors import is_color_like, to_rgb

    if background is None:
        return INK
    if not is_color_like(background):
        raise ValueError(f"background is {background!r}; give a colour such as 'white', or None")
    return "black" if sum(to_rgb(background)) > 1.5 else "white"


def _shrink(text: Any, canvas: Any, room: float) -> None:
    """Make a text small enough for the pixels that it may be long, or cut it."""
    renderer = canvas.get_renderer()

    def length() -> float:
        extent = text.get_window_extent(renderer)
        return max(extent.width, extent.height)  # of one line, however it is turned

    if length() > room:
        text.set_fontsize(max(text.get_fontsize() * room / length(), SMALLEST))
    while length() > room and len(text.get_text()) > 1:
        text.set_text(text.get_text()[:-2] + "…")


def _draw_bar(
    figure: Any,
    place: tuple[float, float, float, float],
    size: tuple[int, int],
    scale: Scale,
    label: str,
    below: bool,
    ink: str,
) -> Any:
    """Draw the colour bar, of which the place is in pixels; its label."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.ticker import MaxNLocator

    x, y, wide, high = place
    axes = figure.add_axes((x / size[0], y / size[1], wide / size[0], high / size[1]))
    bar = figure.colorbar(
        ScalarMappable(Normalize(scale.low, scale.high), scale.colormap),
        cax=axes,
        orientation="horizontal" if below else "vertical",
        label=label,
        ticks=MaxNLocator(max(2, int(max(wide, high) // 50))),
        extend={(True, True): "both", (True, False): "min", (False, True): "max"}.get(
            (scale.below, scale.above), "neither"
        ),
    )
    bar.ax.tick_params(labelsize=8, colors=ink)
    bar.outline.set_edgecolor(ink)
    text = (bar.ax.xaxis if below else bar.ax.yaxis).label
    text.set(fontsize=9, color=ink)
    return text
