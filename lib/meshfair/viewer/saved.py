"""What a notebook shows of a live widget once the widget's kernel has gone.

A notebook gets two outputs for a widget: first HTML with a still, then the widget. Style rules in
the HTML let a reader see one of both: the still goes where the widget shows something, and the
widget's place, with its "model not found", where it does not. GitHub, and JupyterLab for a notebook
that it does not trust, take the rules out; there the second output has nothing to show. VS Code
shows that nothing, too, where it does not find the widget's model in the kernel.
"""

from __future__ import annotations

import base64
import contextlib
import html
import io
import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from meshfair.viewer.page import for_page

if TYPE_CHECKING:
    from PIL.Image import Image

Bundle = dict[str, Any]
WIDGET = "application/vnd.jupyter.widget-view+json"
REST = 2.0  # seconds without a change until the still is drawn anew
COLORS = 256  # of a still: a third of the bytes of one with all colours
# In a view that shows a frame, or why not. Changes once: the rules are not asked with each frame.
DRAWN = ".drawn"

STYLE = """\
<style>
:root:has({live}) .{saved}, :root:has({live}) {output} {{ display: none; }}
{output} + .jp-OutputArea-child:has({place}):not(:has({live}, {failed})) \
{{ display: block; height: 0; overflow: hidden; }}
</style>
"""
OUTPUT = ".jp-OutputArea-child:has(> .jp-OutputArea-output > .{saved})"
PLACE = "> .lm-Panel, > .jupyter-widgets"  # of a widget, whatever became of it
FAILED = ".jupyter-widgets-error-widget"  # its scripts are missing, say: that is to be seen


class Saved:
    """A widget's two outputs in a notebook: what is saved of it, kept up to date, and itself.

    Parameters
    ----------
    widget : ipywidgets.DOMWidget
    state : callable
        Gives what is shown now, to compare with what was shown before.
    keep : callable
        Gives what is saved of that, by MIME type, as `picture` does.
    drawn : str
        The CSS selector of what is in the widget as soon as it shows something.
    """

    def __init__(
        self,
        widget: Any,
        state: Callable[[], object],
        keep: Callable[[], Bundle],
        drawn: str = DRAWN,
    ) -> None:
        self._widget, self._state, self._keep = widget, state, keep
        name = widget.model_id
        widget.add_class(f"meshfair-live-{name}")
        self._class = saved = f"meshfair-saved-{name}"
        self._style = STYLE.format(
            live=f".meshfair-live-{name} :is({drawn})",
            saved=saved,
            output=OUTPUT.format(saved=saved),
            place=PLACE,
            failed=FAILED,
        )
        self._lock = threading.Lock()
        self._shown = False
        self._published: object = None  # the state of which the still is in the notebook
        self._changed = 0.0  # when, at last
        self._waiting: threading.Thread | None = None  # for the rest after a change

    def show(self) -> None:
        """Publish both outputs."""
        from IPython.display import display

        self._publish(update=False)
        self._shown = True
        data, metadata = self._live()
        display({WIDGET: data[WIDGET], "text/plain": ""}, metadata=metadata, raw=True)

    def bundle(self) -> tuple[Bundle, Bundle]:
        """Data and metadata of one output, for what does not know of two."""
        data, metadata = self._live()
        return data | {"image/png": self._keep()["image/png"]}, metadata

    def _live(self) -> tuple[Bundle, Bundle]:
        bundle = self._widget._repr_mimebundle_()
        return bundle if isinstance(bundle, tuple) else (bundle, {})

    def changed(self) -> None:
        """What is saved is no longer what is shown: draw it anew once nothing changes any more."""
        if not self._shown:
            return
        with self._lock:
            self._changed = time.monotonic()
            if self._waiting is None:
                self._waiting = threading.Thread(
                    target=self._follow, name=f"still of {self._class}", daemon=True
                )
                self._waiting.start()

    def _follow(self) -> None:
        """Wait for the rest, and publish."""
        while True:
            with self._lock:
                left = self._changed + REST - time.monotonic()
                if left <= 0:
                    self._waiting = None
                    break
            time.sleep(left)
        # Where it cannot be drawn, the live widget says why, and what was saved before stays.
        with contextlib.suppress(Exception):
            self._publish(update=True)

    def _publish(self, update: bool) -> None:
        from IPython.display import display

        state = self._state()
        if update and state == self._published:
            return
        kept = self._keep()
        self._published = state
        inner = f'<div class="{self._class}">{kept["text/html"]}</div>\n{self._style}'
        display(kept | {"text/html": inner}, raw=True, display_id=self._class, update=update)


class Displayed:
    """What a notebook shows by a widget, and also without the widget's kernel."""

    _saved: Saved

    def _ipython_display_(self, **kwargs: Any) -> None:
        if for_page():
            raise NotImplementedError  # IPython then asks for one bundle
        self._saved.show()


def picture(still: Image, label: str, note: str = "") -> Bundle:
    """What a notebook keeps of a view: a still, once in HTML and once for readers without that.

    Parameters
    ----------
    still : PIL.Image.Image
    label : str
        What is seen, in words.
    note : str
        What stands below it; plain text.

    Returns
    -------
    dict
        By MIME type, as `IPython.display.display` takes it.
    """
    png = io.BytesIO()
    still.quantize(COLORS).save(png, "PNG", optimize=True)
    data = base64.b64encode(png.getvalue()).decode("ascii")
    # Without a height, so that a page that is less wide shrinks it as it is.
    shown = (
        f'<img src="data:image/png;base64,{data}" width="{still.width}" '
        f'style="max-width: 100%" alt="{html.escape(label)}">'
    )
    below = f"<p>{html.escape(note)}</p>" if note else ""
    return {"text/html": shown + below, "image/png": data, "text/plain": label}
