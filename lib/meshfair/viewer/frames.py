"""The view's frames: drawn by polyscope, shown in the page by an anywidget.

Only one frame at a time is on its way to the page. Whatever changes
meanwhile, the camera or a mesh, is drawn when the page has said that it shows
that frame, so that a slow connection drops frames instead of piling them up.
While something moves, frames are drafts; when it has come to rest, the page
asks for good ones.
"""

from __future__ import annotations

import io
import threading
import time
from collections.abc import Iterable, Sequence
from typing import Any

import anywidget
import traitlets
from PIL import Image

from meshfair.viewer import offscreen
from meshfair.viewer.backend import LOST, Shown, asked, turned
from meshfair.viewer.offscreen import Pixels
from meshfair.viewer.page import bar
from meshfair.viewer.scripts import text

DRAFT, GOOD = 1, 2  # supersampling
LARGEST = 2400  # pixels, of a frame's longer side


class FramesWidget(anywidget.AnyWidget):
    """The page's part: pictures, pointer, colour bar. See frames.js."""

    _esm = text("stage.js", "kernel.js", "frames.js")
    _css = text("frames.css")
    count = traitlets.Int(1).tag(sync=True)


class Frames:
    """Draws a view's panels when they change, and sends them to the page.

    Parameters
    ----------
    view : meshfair.viewer.View
    """

    def __init__(self, view: Shown) -> None:
        self._view = view
        self._lock = threading.Lock()
        self._wanted: dict[int, int] = {}  # panel -> quality: what has changed since it was drawn
        self._rough: set[int] = set()  # panels of which the page shows a draft
        # Time at which the frame on its way was begun.
        self._sent: float | None = None
        # The page's: panel size, pixel ratio, background.
        self._layout: dict[str, Any] | None = None
        self.drawn = 0  # number of frames drawn so far
        self.widget = FramesWidget(count=len(view.placed))
        self.widget.on_msg(self._receive)

    def refresh(self, panels: Iterable[int]) -> None:
        """Draw some panels again, as drafts; the rest of the page stays."""
        with self._lock:
            self._wanted.update(dict.fromkeys(panels, DRAFT))
        self._pump()

    def camera_moved(self, panels: Iterable[int] = ()) -> None:
        """Draw all panels again."""
        self.refresh(range(len(self._view.placed)))

    def _receive(self, widget: Any, message: dict[str, Any], buffers: Any) -> None:
        """Handle a message from the page; on any thread, and quick."""
        kind = message["kind"]
        if kind == "layout":
            self._layout = message
            self._view.fit(message["width"] / message["height"])
            self._sent = None  # a page that was loaded anew knows of no frame
            self.camera_moved()
        elif kind == "shown":
            self._sent = None
            self._pump()
        elif kind == "rest":
            with self._lock:
                self._wanted.update({k: GOOD for k in self._rough if k not in self._wanted})
            self._pump()
        elif kind == "move":
            turned(self._view, message)
            self.camera_moved()
        else:
            asked(self._view, self.widget, message)

    def _pump(self) -> None:
        """Begin the next frame, unless one is on its way, or no page is there."""
        with self._lock:
            on_its_way = self._sent is not None and time.monotonic() - self._sent < LOST
            if not self._wanted or self._layout is None or on_its_way:
                return
            drafts = [k for k, quality in self._wanted.items() if quality == DRAFT]
            # Good frames are slow: one panel at a time, so that a move can come between.
            panels = sorted(drafts) or [min(self._wanted)]
            for k in panels:
                del self._wanted[k]
            self._sent = time.monotonic()
            layout = self._layout
        offscreen.gl_thread().submit(self._draw, panels, layout, DRAFT if drafts else GOOD)

    def _draw(self, panels: Sequence[int], layout: dict[str, Any], quality: int) -> None:
        """Draw and send one frame; on the GL thread."""
        view = self._view
        # A draft has the page's own pixels, a good frame also a fine screen's.
        ratio = 1 if quality == DRAFT else layout["ratio"]
        ratio = min(ratio, LARGEST / max(layout["width"], layout["height"]))
        size = (round(layout["width"] * ratio), round(layout["height"] * ratio))
        try:
            with view.lock:
                scale, camera, label = view.scale, view.placed_camera, view.label
                titles = [view.titles[k] for k in panels]
                placed = [view.placed[k] for k in panels]
            pictures = [
                encode(
                    offscreen.scene().draw(
                        panel,
                        camera,
                        size,
                        slot=k,
                        scale=scale,
                        quality=quality,
                        background=layout["background"],
                    ),
                    quality,
                )
                for k, panel in zip(panels, placed, strict=True)
            ]
        except Exception as error:  # it would vanish with this thread: the page shows it
            self.widget.send({"kind": "error", "text": f"{type(error).__name__}: {error}"})
            self._sent = None
            return
        self.drawn += 1
        self._rough = self._rough | set(panels) if quality == DRAFT else self._rough - set(panels)
        frame = {
            "kind": "frame",
            "number": self.drawn,
            "panels": panels,
            "titles": titles,
            "draft": quality == DRAFT,
            "bar": scale and bar(scale, label),
        }
        self.widget.send(frame, pictures)


def encode(pixels: Pixels, quality: int) -> bytes:
    """JPEG of an image: drafts smaller, good frames without smeared colours."""
    jpeg = io.BytesIO()
    options: dict[str, Any] = (
        {"quality": 80} if quality == DRAFT else {"quality": 92, "subsampling": 0}
    )
    Image.fromarray(pixels[:, :, :3]).save(jpeg, "JPEG", **options)
    return jpeg.getvalue()
