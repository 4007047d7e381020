"""The view without EGL: the page draws the meshes itself, by WebGL."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import anywidget
import numpy as np
import traitlets

from meshfair.viewer.backend import Shown
from meshfair.viewer.camera import Camera
from meshfair.viewer.packing import look, parts, pose
from meshfair.viewer.page import bar
from meshfair.viewer.scripts import text


class InPageWidget(anywidget.AnyWidget):
    """The page's part: canvases, pointer, colour bar. See in_page.js."""

    _esm = text("stage.js", "camera.js", "meshes.js", "in_page.js")
    _css = text("frames.css")
    count = traitlets.Int(1).tag(sync=True)


class InPage:
    """Sends a view's panels to the page when they change.

    Parameters
    ----------
    view : meshfair.viewer.View
    """

    def __init__(self, view: Shown) -> None:
        self._view = view
        self._there = False  # a page that draws
        self.widget = InPageWidget(count=len(view.placed))
        self.widget.on_msg(self._receive)

    def refresh(self, panels: Iterable[int]) -> None:
        """Show some panels' meshes, values and titles of now."""
        self._send(panels, None)

    def camera_moved(self, panels: Iterable[int] = ()) -> None:
        """Point the page's camera as the view's, and show some panels of now."""
        self._send(panels, pose(self._view.placed_camera))

    def _send(self, panels: Iterable[int], camera: list[float] | None) -> None:
        if not self._there:
            return
        view, scale = self._view, self._view.scale
        shown, buffers = [], []
        for k in panels:
            panel = view.placed[k]
            values = parts(panel, scale)
            drawn = look(panel, scale) | {"units": 1.0}
            shown.append({"panel": k, "look": drawn, "title": view.titles[k]})
            buffers += [
                panel.V.astype("<f4").tobytes(),
                panel.F.astype("<u4").tobytes(),
                b"" if values is None else values.tobytes(),
            ]
        message = {
            "kind": "panels",
            "panels": shown,
            "bar": scale and bar(scale, view.label),
            "up": np.asarray(view.up).tolist(),
            "camera": camera,
        }
        self.widget.send(message, buffers)

    def _receive(self, widget: Any, message: dict[str, Any], buffers: Any) -> None:
        """Handle a message from the page."""
        kind, view = message["kind"], self._view
        if kind == "ready":
            self._there = True
            self.camera_moved(range(len(view.placed)))
        elif kind == "layout":
            view.fit(message["width"] / message["height"])
            self.camera_moved()
        elif kind == "reset":
            view.reset()
        elif kind == "click":
            view.click(message["panel"], message["x"], message["y"])
        elif kind == "camera":
            numbers = message["camera"]
            view.placed_camera = Camera(*(tuple(numbers[k : k + 3]) for k in (0, 3, 6)))
