"""The view without EGL: Python sends meshes, and the page draws them by WebGL.

The page turns them by itself and tells how, so that Python's camera is the page's. Only what has
changed is sent, in one message at a time: what changes meanwhile goes with the next.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterable
from typing import Any

import anywidget
import numpy as np
import traitlets

from meshfair.viewer.backend import LOST, Shown, asked, turned
from meshfair.viewer.packing import look, parts
from meshfair.viewer.page import bar
from meshfair.viewer.scripts import LIVE, text


class MeshesWidget(anywidget.AnyWidget):
    """The page's part: meshes, pointer, colour bar. See in_page.js."""

    _esm = text(*LIVE)
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
        self._lock = threading.Lock()
        self._wanted: set[int] = set()  # panels that have changed since they were sent
        self._aimed = False  # the camera has, too
        self._fresh = False  # a page has nothing yet
        self._there = False  # there is a page
        self._sent: float | None = None  # when the message on its way was sent
        self._known: list[dict[str, bytes | None]] = [{} for _ in view.placed]
        self.widget = MeshesWidget(count=len(view.placed))
        self.widget.on_msg(self._receive)

    def refresh(self, panels: Iterable[int]) -> None:
        """Show some panels' meshes, values and titles of now."""
        with self._lock:
            self._wanted.update(panels)
        self._pump()

    def camera_moved(self, panels: Iterable[int] = ()) -> None:
        """Point the page's camera as the view's, and show some panels of now."""
        self._aimed = True
        self.refresh(panels)

    def _receive(self, widget: Any, message: dict[str, Any], buffers: Any) -> None:
        """Handle a message from the page; on any thread, and quick."""
        kind = message["kind"]
        if kind == "layout":
            self._view.fit(message["width"] / message["height"])
            self._there = True
            if message["fresh"]:
                self._fresh, self._sent = True, None
                self._wanted.update(range(len(self._view.placed)))
            self.camera_moved()
        elif kind == "shown":
            self._sent = None
            self._pump()
        elif kind == "move":
            turned(self._view, message)
            # To the page that moved it, an answer; to others with the same view, the news.
            self.widget.send({"kind": "moved", "by": message["by"], **self._camera()})
        else:
            asked(self._view, self.widget, message)

    def _pump(self) -> None:
        """Send what has changed, unless something is on its way, or no page is there."""
        with self._lock:
            on_its_way = self._sent is not None and time.monotonic() - self._sent < LOST
            if on_its_way or not self._there or not (self._wanted or self._aimed):
                return
            if self._fresh:
                self._known = [{} for _ in self._known]
            buffers: list[bytes] = []
            with self._view.lock:
                scale = self._view.scale
                message = {
                    "kind": "show",
                    "whole": self._fresh,
                    "panels": [self._panel(k, buffers) for k in sorted(self._wanted)],
                    "bar": scale and bar(scale, self._view.label),
                    **(self._camera() if self._aimed else {}),
                }
            self._wanted, self._aimed, self._fresh = set(), False, False
            self._sent = time.monotonic()
        self.widget.send(message, buffers)

    def _panel(self, k: int, buffers: list[bytes]) -> dict[str, Any]:
        """What the page needs to know of a panel; arrays that it lacks go to the buffers."""
        panel, scale = self._view.placed[k], self._view.scale
        places = parts(panel, scale)
        given = {
            "V": panel.V.astype("<f4").tobytes(),
            "F": panel.F.astype("<u4").tobytes(),
            "parts": None if places is None else places.tobytes(),
        }
        arrays: dict[str, int | None] = {}  # which of the buffers; None where there is none
        for name, data in given.items():
            if name in self._known[k] and self._known[k][name] == data:
                continue
            arrays[name] = None if data is None else len(buffers)
            if data is not None:
                buffers.append(data)
        self._known[k] = given
        return {
            "panel": k,
            "title": self._view.titles[k],
            "look": look(panel, scale),
            "arrays": arrays,
        }

    def _camera(self) -> dict[str, list[float]]:
        camera = self._view.placed_camera
        place = [*camera.position, *camera.target, *camera.up]
        return {"camera": place, "up": np.asarray(self._view.up).tolist()}
