"""What all explorers have: controls, a view, plots, and work in the background."""

from __future__ import annotations

import contextlib
import html
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import ipywidgets as widgets

from meshfair.explorers.curves import CurvePlot
from meshfair.explorers.worker import Job, LatestWins
from meshfair.viewer import View, coloring
from meshfair.viewer.view import with_still
from meshfair.weights import BY_NAME

Settings = dict[str, Any]

PLAIN = "none"  # the colouring without values
NAMED = {"description_width": "8.5em"}
WIDE = {"width": "calc(100% - 8px)", "max_width": "34em"}

# How menus write the noise models' names.
NOISES = {
    "normals": "along the normals",
    "gaussian": "Gaussian",
    "uniform": "uniform",
    "impulsive": "impulsive (one in ten)",
}


def slider(
    kind: Any,
    description: str,
    tooltip: str,
    *,
    value: float,
    ends: tuple[float, float],
    step: float,
    **options: Any,
) -> Any:
    """A slider that shows its value while it moves.

    Parameters
    ----------
    kind : type
        ``ipywidgets.FloatSlider`` or ``IntSlider``.
    description, tooltip : str
        A name with its unit, and a sentence.
    value, step : number
        What it shows first, and the least that it moves.
    ends : (number, number)
        The least and the largest value.
    **options
        Others of ``kind``, such as ``readout_format``.

    Returns
    -------
    ipywidgets.Widget
    """
    return kind(
        value=value,
        min=ends[0],
        max=ends[1],
        step=step,
        description=description,
        tooltip=tooltip,
        continuous_update=True,
        style=dict(NAMED),
        layout=dict(WIDE),
        **options,
    )


def choice(
    description: str,
    options: Iterable[str],
    value: str,
    tooltip: str,
    labels: Mapping[str, str] | None = None,
) -> Any:
    """A menu with a name.

    Parameters
    ----------
    description, tooltip : str
        A name, and a sentence.
    options : iterable of str
        What can be chosen.
    value : str
        The first choice.
    labels : dict of str to str, optional
        What the page shows for some of the options.

    Returns
    -------
    ipywidgets.Dropdown
    """
    return widgets.Dropdown(
        options=[((labels or {}).get(name, name), name) for name in options],
        value=value,
        description=description,
        tooltip=tooltip,
        style=dict(NAMED),
        layout=dict(WIDE),
    )


def color_choice() -> Any:
    """The menu of what the meshes are coloured by."""
    return choice(
        "colour by",
        [*coloring.COLORINGS, PLAIN],
        "displacement",
        "What the colours of the noisy meshes show",
    )


def noise_choice(models: Iterable[str], value: str, tooltip: str) -> Any:
    """The menu of noise models."""
    return choice("noise", models, value, tooltip, NOISES)


def size_slider(size: float) -> Any:
    """The slider of the noise's size."""
    return slider(
        widgets.FloatSlider,
        "noise (edges)",
        "Standard deviation of the noise along the normals, in mean edge lengths",
        value=size,
        ends=(0.0, 1.2),
        step=0.01,
    )


def tau_slider(tau: float, ends: tuple[float, float]) -> Any:
    """The slider of the time step."""
    return slider(
        widgets.FloatSlider,
        "time step τ",
        "Each iteration moves a vertex this part of the way to its neighbours' weighted mean",
        value=tau,
        ends=ends,
        step=0.05,
    )


def weights_choice(value: str = "combinatorial") -> Any:
    """The menu of weights."""
    return choice("weights", BY_NAME, value, "How much each neighbour counts")


class Explorer:
    """A view with controls and plots around it.

    A subclass makes ``view``, ``plots`` and ``controls``, and then calls
    `_begin`. What its controls ask for, `_work` does on a thread of its own:
    a new value cancels the work for the old one.

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
    """

    controls: dict[str, Any]
    view: View
    plots: list[CurvePlot]
    widget: Any

    def __init__(self) -> None:
        self.error: Exception | None = None
        self._worker = LatestWins(self._work, self._progress, self._failed)
        self._note = widgets.HTML()
        self._bar = widgets.FloatProgress(min=0, max=1, layout={"width": "12em"})
        self._cancel = widgets.Button(
            description="Cancel", icon="times", tooltip="Stop computing; keep what there is"
        )
        self._cancel.on_click(lambda _: self._worker.cancel())
        self._busy = widgets.HBox([self._bar, self._cancel], layout={"visibility": "hidden"})

    def _begin(self, extra: Sequence[Any] = ()) -> None:
        """Lay everything out, listen to the controls, and do the first work.

        Parameters
        ----------
        extra : sequence of widgets
            What stands below the controls, such as a play button.
        """
        for name, control in self.controls.items():
            control.observe(lambda change, name=name: self._changed(name), names="value")
        # Side by side where a laptop's page has the room, below each other where it has not.
        column = {"flex": "1 1 300px", "min_width": "300px"}
        for plot in self.plots:
            plot.layout = column
        controls = widgets.VBox([*self.controls.values(), *extra], layout=column)
        row = widgets.HBox([controls, *self.plots], layout={"flex_flow": "row wrap"})
        status = widgets.HBox([self._note, self._busy], layout={"flex_flow": "row wrap"})
        self.widget = widgets.VBox([self.view.widget, row, status], layout={"width": "100%"})
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

        Raises
        ------
        TimeoutError
            After ``timeout`` seconds.
        """
        self._worker.wait(timeout)

    def say(self, text: str) -> None:
        """Show a line below the controls, or none."""
        self._note.value = html.escape(text)

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

    def _repr_mimebundle_(self, **kwargs: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        """The explorer, and a still of its view for readers without a kernel."""
        with contextlib.suppress(TimeoutError):  # on a large mesh, the still shows less
            self.wait(5)
        return with_still(self.widget, self.view)
