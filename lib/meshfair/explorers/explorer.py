"""What all explorers have: controls, a view, charts, and work in the background."""

import contextlib
import html

from meshfair.experiments.cases import WEIGHTS
from meshfair.explorers.latest import Latest
from meshfair.viewer import colouring, libraries
from meshfair.viewer.view import with_still

widgets = libraries.load("ipywidgets", "an explorer")

PLAIN = "none"  # the colouring without values
NAMED = {"description_width": "8.5em"}
WIDE = {"width": "calc(100% - 8px)", "max_width": "34em"}


def slider(kind, description, value, low, high, step, tooltip, **options):
    """A slider that tells its value while it moves.

    Parameters
    ----------
    kind : type
        ``ipywidgets.FloatSlider`` or ``IntSlider``.
    description, tooltip : str
        A name with its unit, and a sentence.
    value, low, high, step : number
    **options
        Others of ``kind``, such as ``readout_format``.
    """
    return kind(
        value=value,
        min=low,
        max=high,
        step=step,
        description=description,
        tooltip=tooltip,
        continuous_update=True,
        style=dict(NAMED),
        layout=dict(WIDE),
        **options,
    )


def choice(description, options, value, tooltip):
    """A menu with a name."""
    return widgets.Dropdown(
        options=list(options),
        value=value,
        description=description,
        tooltip=tooltip,
        style=dict(NAMED),
        layout=dict(WIDE),
    )


def colour_choice():
    """The menu of what the meshes are coloured by."""
    return choice(
        "colour by",
        [*colouring.COLOURINGS, PLAIN],
        "displacement",
        "What the colours of the noisy meshes show",
    )


def size_slider(size):
    """The slider of the noise's size."""
    return slider(
        widgets.FloatSlider, "noise (edges)", size, 0.0, 1.2, 0.01,
        "Standard deviation of the noise along the normals, in mean edge lengths",
    )  # fmt: skip


def tau_slider(tau, ends):
    """The slider of the time step."""
    return slider(
        widgets.FloatSlider, "time step τ", tau, *ends, 0.05,
        "Each step moves a vertex this part of the way to its neighbours' weighted mean",
    )  # fmt: skip


def weights_choice(value="combinatorial"):
    """The menu of weights."""
    return choice("weights", WEIGHTS, value, "How much each neighbour counts")


class Explorer:
    """A view with controls and charts around it.

    A subclass makes ``view``, ``charts`` and ``controls``, and then calls
    `_begin`. What its controls ask for, `_work` does on a thread of its own:
    a new value makes the work for the old one obsolete.

    Attributes
    ----------
    controls : dict of str to ipywidgets.Widget
        By name; ``explorer.controls["tau"].value = 0.5`` moves a slider.
    view : meshfair.viewer.View
    charts : list of Chart
    error : Exception or None
        What the last work failed with.
    """

    def __init__(self):
        self.error = None
        self._latest = Latest(self._work, self._progress, self._failed)
        self._note = widgets.HTML()
        self._bar = widgets.FloatProgress(min=0, max=1, layout={"width": "12em"})
        self._cancel = widgets.Button(
            description="Cancel", icon="times", tooltip="Stop computing; keep what there is"
        )
        self._cancel.on_click(lambda _: self._latest.cancel())
        self._busy = widgets.HBox([self._bar, self._cancel], layout={"visibility": "hidden"})

    def _begin(self, extra=()):
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
        for chart in self.charts:
            chart.layout = column
        controls = widgets.VBox([*self.controls.values(), *extra], layout=column)
        row = widgets.HBox([controls, *self.charts], layout={"flex_flow": "row wrap"})
        status = widgets.HBox([self._note, self._busy], layout={"flex_flow": "row wrap"})
        self.widget = widgets.VBox([self.view.widget, row, status], layout={"width": "100%"})
        self._ask()

    def settings(self):
        """The controls' values by name.

        Returns
        -------
        dict
        """
        return {name: control.value for name, control in self.controls.items()}

    def wait(self, timeout=60):
        """Wait until the work for the newest settings is done and shown.

        Raises
        ------
        TimeoutError
            After ``timeout`` seconds.
        """
        self._latest.wait(timeout)

    def say(self, text):
        """Show a line below the controls, or none."""
        self._note.value = html.escape(text)

    def _changed(self, name):
        """Handle a control's new value; a subclass may have a shorter way than all the work."""
        self._ask()

    def _ask(self):
        self.error = None
        self._latest.ask(self.settings())

    def _work(self, job, settings):
        """Compute and show; in the background. A subclass's own."""
        raise NotImplementedError

    def _progress(self, done):
        self._bar.value = done
        self._busy.layout.visibility = "hidden" if done >= 1 else "visible"

    def _failed(self, error):
        self.error = error
        self.say(f"{type(error).__name__}: {error}")

    def _repr_mimebundle_(self, **kwargs):
        """The explorer, and a still of its view for readers without a kernel."""
        with contextlib.suppress(TimeoutError):  # on a large mesh, the still shows less
            self.wait(5)
        return with_still(self.widget, self.view)
