"""The one interface between a view and what draws it in the page.

There are two back ends: `meshfair.viewer.frames` streams polyscope's pictures,
`meshfair.viewer.in_page` sends meshes, which the page draws by WebGL. A view knows of
them, and they of a view, what stands here and no more.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager
from typing import Any, Protocol

from meshfair.checks import Floats
from meshfair.viewer.camera import Camera
from meshfair.viewer.panel import Panel, Scale

LOST = 5.0  # seconds after which what was not confirmed is given up: its page is gone


class Backend(Protocol):
    """What draws a view's panels in the page; made with the view that it draws."""

    @property
    def widget(self) -> Any:
        """The ipywidget that stands in the page."""

    def refresh(self, panels: Iterable[int]) -> None:
        """Draw some panels again: their meshes, values, titles, or the colour bar changed."""

    def camera_moved(self, panels: Iterable[int] = ()) -> None:
        """Draw all panels again: the view's camera changed, and in some their meshes."""


class Shown(Protocol):
    """What a back end reads of its view, and what a page asks of it.

    It draws panels that are placed, see `meshfair.viewer.placement`.
    """

    lock: AbstractContextManager[bool, None]  # held while it changes, and while all of it is read
    placed: list[Panel]
    titles: list[str]
    label: str
    up: Floats

    @property
    def placed_camera(self) -> Camera:
        """The camera that sees the placed panels."""

    @property
    def scale(self) -> Scale | None:
        """How the panels' values become colours now."""

    def fit(self, aspect: float) -> None:
        """The page says the shape of the panels, width over height."""

    def turn(self, yaw: float, pitch: float, pan: Sequence[float], zoom: float) -> None:
        """A pointer in the page has moved the camera."""

    def reset(self) -> None:
        """The page asks for the first camera again."""

    def click(self, panel: int, x: float, y: float) -> None:
        """Somebody has clicked on a panel; x and y are from -1 to 1."""


def turned(view: Shown, move: dict[str, Any]) -> None:
    """Move the view's camera as a page says."""
    view.turn(move["yaw"], move["pitch"], move["pan"], move["zoom"])


def asked(view: Shown, widget: Any, message: dict[str, Any]) -> None:
    """Do what a page asks for that every back end does alike."""
    kind = message["kind"]
    if kind == "reset":
        view.reset()
    elif kind == "click":
        view.click(message["panel"], message["x"], message["y"])
    elif kind == "ping":
        widget.send({"kind": "pong"})
