"""What all explorers have: controls, a view, plots, and work in the background."""

from __future__ import annotations

import contextlib
import html
from collections.abc import Iterator, Sequence
from typing import Any

import ipywidgets as widgets

from meshfair.explorers.controls import said
from meshfair.explorers.curves import CurvePlot
from meshfair.explorers.states import recorded
from meshfair.explorers.worker import Job, LatestWins
from meshfair.viewer import View
from meshfair.viewer.page import OnPage, described, for_page, part
from meshfair.viewer.saved import Bundle, Displayed, Saved

Settings = dict[str, Any]
EIGENMODES = 5e-10  # seconds for all of them, over the third power of the number of vertices


class Explorer(Displayed, OnPage):
    """A view with controls and plots around it.

    A subclass makes ``view``, ``plots`` and ``controls``, and then calls
    `_begin`. What its controls ask for, `_work` does on a thread of its own:
    a new value cancels the work for the old one. A notebook that is saved keeps a
    still of the view and what the controls said.

    Attributes
    ----------
    controls : dict of str to ipywidgets.Widget
        By name; ``explorer.controls["tau"].value = 0.5`` moves a slider.
    view : meshfair.viewer.View
    plots : list of CurvePlot
    widget : ipywidgets.Widget
        All of it, to put into a layout of one's own.
    error : Exception or None
        What the last work failed with.
    main : str
        The control that has the most positions in a page without a kernel, and plays there.
    """

    main = "iteration"
    controls: dict[str, Any]
    view: View
    plots: list[CurvePlot]
    widget: Any

    def __init__(self) -> None:
        self._below: list[Any] = []
        self.error: Exception | None = None
        self._worker = LatestWins(self._work, self._progress, self._failed)
        self._note = widgets.HTML()
        self._bar = widgets.FloatProgress(min=0, max=1, layout={"width": "12em"})
        self._cancel = widgets.Button(
            description="Cancel", icon="times", tooltip="Stop computing; keep what there is"
        )
        self._cancel.on_click(lambda _: self._worker.cancel())
        self._busy = widgets.HBox([self._bar, self._cancel], layout={"visibility": "hidden"})

    def _begin(self, *, along: Sequence[Any] = (), below: Sequence[Any] = ()) -> None:
        """Lay everything out, listen to the controls, and do the first work.

        The look is that of explorer.css.

        Parameters
        ----------
        along : sequence of widgets
            What stands in a row right below the meshes, such as a play button; controls
            that are among them do not stand with the others.
        below : sequence of widgets
            What stands at the end, such as a table.
        """
        for name, control in self.controls.items():
            control.observe(lambda change, name=name: self._changed(name), names="value")
        parts = {
            "view": self.view.widget,
            "along": widgets.HBox(list(along)),
            "controls": widgets.VBox([c for c in self.controls.values() if c not in along]),
            "plots": widgets.HBox(self.plots),
            "status": widgets.HBox([self._note, self._busy]),
            "below": widgets.VBox(list(below)),
        }
        self._below = list(below)
        for name, box in parts.items():
            box.add_class(f"meshfair-{name}-part")
        self.widget = widgets.Box(list(parts.values()))
        self.widget.add_class("meshfair-explorer")
        if len(self.view.panels) == 1:  # which leaves room for the plots beside it
            self.widget.add_class("meshfair-one-panel")
        self._saved = Saved(self.widget, self._state, self._kept)
        self.view.follow(self._saved.changed)
        self._request()

    def settings(self) -> Settings:
        """The controls' values by name.

        Returns
        -------
        dict
        """
        return {name: control.value for name, control in self.controls.items()}

    def wait(self, timeout: float = 60) -> None:
        """Wait until the work for the newest settings is done and shown.

        Parameters
        ----------
        timeout : float
            Seconds.

        Raises
        ------
        TimeoutError
            After ``timeout`` seconds.
        """
        self._worker.wait(timeout)

    def say(self, text: str) -> None:
        """Show a line below the controls, or none.

        Parameters
        ----------
        text : str
            Empty for none.
        """
        self._note.value = html.escape(text)

    def _say_how_long(self, count: int) -> None:
        """Say how long the eigenmodes of so many vertices take, where that is seconds."""
        seconds = EIGENMODES * count**3
        if seconds > 1:
            self.say(f"computing {count:,} eigenmodes, which takes about {seconds:.0f} s …")

    def _changed(self, name: str) -> None:
        """Handle a control's new value; a subclass may have a shorter way than all the work."""
        self._request()

    def _request(self) -> None:
        self.error = None
        self._worker.request(self.settings())

    def _work(self, job: Job, settings: Settings) -> None:
        """Compute and show; in the background. A subclass's own."""
        raise NotImplementedError

    def _progress(self, done: float) -> None:
        self._bar.value = done
        self._busy.layout.visibility = "hidden" if done >= 1 else "visible"

    def _failed(self, error: Exception) -> None:
        self.error = error
        self.say(f"{type(error).__name__}: {error}")

    def seen(self) -> tuple[str, str]:
        """What stands below the controls now.

        Returns
        -------
        note, below : str
            The line, and what stands at the end, such as a table; HTML.
        """
        return self._note.value, "".join(part.value for part in self._below)

    def _part(self) -> str:
        self.wait(600)
        label = described(self.view.titles, self.view.label)
        with self._coming_back():
            still = self.view.still()
            packed = recorded(self).packed()
        return part(packed, still, label)

    @contextlib.contextmanager
    def _coming_back(self) -> Iterator[None]:
        """Settings are gone through in this block; a subclass restores what they change."""
        yield

    def _state(self) -> object:
        return self.view.state(), self.settings()

    def _kept(self) -> Bundle:
        """What a notebook keeps: a still of the view, and what the controls say."""
        shown = [f"{control.description} {said(control)}" for control in self.controls.values()]
        return self.view.kept(" · ".join(shown))

    def _ipython_display_(self, **kwargs: Any) -> None:
        self._wait_a_little()
        super()._ipython_display_()

    def _repr_mimebundle_(self, **kwargs: Any) -> tuple[Bundle, Bundle]:
        """The explorer, and a still of its view for readers without a kernel; or a page's part."""
        if for_page():
            return {"text/html": self.to_html()}, {}
        self._wait_a_little()
        return self._saved.bundle()

    def _wait_a_little(self) -> None:
        with contextlib.suppress(TimeoutError):  # on a large mesh, the first still shows less
            self.wait(5)
