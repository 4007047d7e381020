"""Heat flow and averaging: a mesh at every step, and the curve of its SNR."""

import threading
import time
import warnings

import numpy as np

from meshfair import flow
from meshfair.checks import StabilityWarning
from meshfair.experiments.cases import NOISE, WEIGHTS, add_noise, operator
from meshfair.explorers.chart import Chart
from meshfair.explorers.explorer import (
    PLAIN,
    Explorer,
    choice,
    colour_choice,
    size_slider,
    slider,
    tau_slider,
    weights_choice,
    widgets,
)
from meshfair.metrics import snr, volume_change
from meshfair.plotting import WEIGHT_COLOURS
from meshfair.shapes import jet, jet_labels
from meshfair.viewer import View, colouring

GROWTH = 0.3  # seconds between two pictures of a curve that is still being computed


class Start:
    """Where flows begin: a noisy mesh, and its operators, each built when first wanted.

    Parameters
    ----------
    V_true, V_noisy : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    """

    def __init__(self, V_true, V_noisy, F):
        self.V_true, self.V_noisy, self.F = V_true, V_noisy, F
        self._operators = {}

    def operator(self, name):
        """The averaging operator with weights by name, see `experiments.cases.operator`."""
        if name not in self._operators:
            self._operators[name] = operator(self.V_noisy, self.F, name)
        return self._operators[name]


class Run:
    """Flows from one start, each with its own weights, as far as they are computed.

    Parameters
    ----------
    start : Start
    names : sequence of str
        The weights.
    tau : float
    """

    def __init__(self, start, names, tau):
        self.start, self.tau = start, tau
        self.states = {name: [] for name in names}  # the mesh after each step
        self.curves = {name: [] for name in names}  # what is measured of it
        self.shown = False
        self._colours = {}

    @property
    def steps(self):
        """How many steps all flows have made; -1 before the first mesh is there."""
        return min(map(len, self.curves.values())) - 1

    def colours(self, name):
        """A function from positions to values, and the ends of their colour bar."""
        if name not in self._colours:
            start = self.start
            values = colouring.COLOURINGS[name].of(start.V_true, start.F)
            # The noisy mesh sets the limits, so that the colours fade as the noise goes.
            self._colours[name] = values, colouring.limits(values(start.V_noisy))
        return self._colours[name]


class FlowExplorer(Explorer):
    """What the explorers of flows share: all steps are computed once, then shown at will.

    A control that changes the flow starts it anew in the background. Those
    in ``quick`` choose what is shown of it, and do so at once.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        The clean mesh.
    F : array_like of integers, shape (m, 3)
    size : float
        First size of the noise along the normals, in mean edge lengths.
    seed : int
        Of the noise.
    tau : float
        First time step.
    steps : int
        Number of steps that are computed.
    """

    measure = "SNR"
    unit = "dB"
    clock = "time t"
    quick = ("step", "colour")
    tau_range = (0.05, 1.0)

    def __init__(self, V, F, *, size=0.2, seed=1, tau=0.2, steps=40):
        super().__init__()
        self._mesh, self._seed, self._steps = (V, F), seed, steps
        self._run = None
        self._started = (None, None)  # settings, and the Start that they gave
        self._showing = threading.RLock()  # a slider and the background work both show
        step = slider(
            widgets.IntSlider, "step", 0, 0, steps, 1, "How many steps of the flow are shown"
        )
        self.charts = [
            Chart(
                title=f"{self.measure} along the flow",
                x_label=self.clock,
                y_label=f"{self.measure} ({self.unit})",
            )
        ]
        self.charts[0].observe(self._picked, names="picked")
        self.controls = {
            **self._flow_controls(size, tau),
            "colour": colour_choice(),
            "step": step,
        }
        self.view = self._make_view()
        play = widgets.Play(min=0, max=steps, interval=150, show_repeat=True)
        widgets.jslink((play, "value"), (step, "value"))
        self._begin(extra=[play])

    def _flow_controls(self, size, tau):
        """The controls that start the flow anew."""
        raise NotImplementedError

    def _make_view(self):
        """The view with its panels, on the clean mesh."""
        raise NotImplementedError

    def _names(self, settings):
        """The weights whose flows are wanted."""
        return (settings["weights"],)

    def _start(self, settings):
        """The noisy mesh that the settings ask for."""
        V, F = self._mesh
        return Start(V, add_noise(V, F, "normals", self._seed, size=settings["size"]), F)

    def _measured(self, V, start):
        """One number about a state, for the curve."""
        return snr(start.V_true, V)

    def _panel(self, name):
        """The panel in which the flow with some weights is seen."""
        return len(self.view.panels) - 1

    def _show_start(self, run, values):
        """Show what all steps have in common, once for each run."""

    # The work, in the background.

    def _work(self, job, settings):
        run = self._make_run(settings)
        self._run = run
        wanted = settings["step"]
        growth = time.monotonic() + GROWTH
        for k, states in enumerate(self._flows(run)):
            for name, V in states.items():
                run.states[name].append(V)
                run.curves[name].append(self._measured(V, run.start))
                job.progress(k / self._steps)
            if k == wanted:
                self._show()
            if time.monotonic() > growth:
                growth = time.monotonic() + GROWTH
                self._draw_curves(run)
        self._show()
        self._draw_curves(run)

    def _make_run(self, settings):
        # The start is kept while only the time step or the weights change.
        key = {k: v for k, v in settings.items() if k not in (*self.quick, "tau", "weights")}
        if self._started[0] != key:
            self._started = (key, self._start(settings))
        return Run(self._started[1], self._names(settings), settings.get("tau", 1.0))

    def _flows(self, run):
        """Yield the meshes after 0, 1, ... steps, by weights; say what is said of stability."""
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", StabilityWarning)
            flows = {
                name: flow.heat(
                    run.start.V_noisy,
                    run.start.operator(name),
                    run.tau,
                    run.tau * self._steps,
                )
                for name in run.states
            }
        self.say("; ".join(str(warning.message) for warning in caught))
        for states in zip(*flows.values(), strict=True):
            yield {name: V for name, (_, V) in zip(flows, states, strict=True)}

    def _draw_curves(self, run):
        curves = {
            name: (run.tau * np.arange(len(curve)), curve) for name, curve in run.curves.items()
        }
        ends = (0, run.tau * self._steps)
        self.charts[0].draw(curves, colours=WEIGHT_COLOURS, x_range=ends)

    # What is shown of it, at once.

    def _changed(self, name):
        if name in self.quick and self._run is not None:
            self._show(anew=name != "step")
        else:
            self._ask()

    def _picked(self, change):
        """Go to the step at which the reader clicked in the chart."""
        if self._run is not None:
            step = round(change["new"] / self._run.tau)
            self.controls["step"].value = min(max(step, 0), self._steps)

    def _show(self, anew=False):
        """Show the wanted step, or the last one that there is."""
        with self._showing, self.view.together():
            run, settings = self._run, self.settings()
            step = min(settings["step"], run.steps)
            if step < 0:
                return
            values = _no_values
            if settings["colour"] != PLAIN:
                values, limits = run.colours(settings["colour"])
                self.view.colour_by(colouring.COLOURINGS[settings["colour"]].label, limits)
            if anew or not run.shown:
                self._show_start(run, values)
                run.shown = True
            for name, states in run.states.items():
                V = states[step]
                self.view.update(
                    V,
                    panel=self._panel(name),
                    F=run.start.F,
                    values=values(V),
                    title=self._title(name, step, run),
                )
            self.charts[0].marker = step * run.tau

    def _title(self, name, step, run):
        return (
            f"{name}, {self._time(step, run)}, "
            f"{self.measure} {run.curves[name][step]:.2f} {self.unit}"
        )

    def _time(self, step, run):
        return f"t = {step * run.tau:.2f}"


def _no_values(V):
    return None


class HeatExplorer(FlowExplorer):
    """The heat equation on one mesh: clean, noisy and denoised; step, time, stopping time."""

    def _flow_controls(self, size, tau):
        return {
            "weights": weights_choice(),
            "size": size_slider(size),
            "tau": tau_slider(tau, self.tau_range),
        }

    def _make_view(self):
        V, F = self._mesh
        return View([V, V, V], F, titles=["clean", "noisy", "denoised"])

    def _show_start(self, run, values):
        V_noisy = run.start.V_noisy
        decibels = next(iter(run.curves.values()))[0]
        self.view.update(
            V_noisy, panel=1, values=values(V_noisy), title=f"noisy: {decibels:.2f} {self.unit}"
        )


class AveragingExplorer(HeatExplorer):
    """Iterated averaging: the heat equation with a time step of 1."""

    clock = "iterations s"

    def _flow_controls(self, size, tau):
        return {"weights": weights_choice(), "size": size_slider(size)}

    def _time(self, step, run):
        return f"s = {step}"


class ComparisonExplorer(FlowExplorer):
    """The three weights side by side, on one mesh with one noise."""

    def _flow_controls(self, size, tau):
        return {"size": size_slider(size), "tau": tau_slider(tau, self.tau_range)}

    def _make_view(self):
        V, F = self._mesh
        return View([V] * len(WEIGHTS), F, titles=list(WEIGHTS))

    def _names(self, settings):
        return tuple(WEIGHTS)

    def _panel(self, name):
        return list(WEIGHTS).index(name)


class JetExplorer(ComparisonExplorer):
    """The three weights on a jet with or without missiles: fine detail under the flow.

    Parameters
    ----------
    detail : float
        Sampling of the jet, see `meshfair.shapes.jet`.
    decibels : float
        First SNR of the noisy jet.
    seed, tau, steps
        As in `FlowExplorer`.
    """

    quick = ("step", "colour", "look")
    whole, closer = "the aircraft", "a wing-tip missile"

    def __init__(self, *, detail=1.0, decibels=22.7, seed=1, tau=0.2, steps=20):
        self._detail, self._decibels = detail, decibels
        super().__init__(*jet(detail=detail), seed=seed, tau=tau, steps=steps)

    def _flow_controls(self, size, tau):
        return {
            "missiles": widgets.Checkbox(
                value=True, description="with missiles", tooltip="Whether the jet has missiles"
            ),
            "look": choice("look at", [self.whole, self.closer], self.whole, "What fills the view"),
            "noise": choice(
                "noise", NOISE, "uniform", "How the vertices are moved; uniform as in the seed"
            ),
            "decibels": slider(
                widgets.FloatSlider, "noise: SNR (dB)", self._decibels, 15.0, 40.0, 0.1,
                "SNR of the noisy jet: the noise is scaled to it", readout_format=".1f",
            ),
            "tau": tau_slider(tau, self.tau_range),
        }  # fmt: skip

    def _make_view(self):
        V, F = self._mesh
        return View([V] * len(WEIGHTS), F, titles=list(WEIGHTS), direction=(0.7, -0.6, 0.6))

    def _start(self, settings):
        V, F = jet(settings["missiles"], self._detail)
        decibels = settings["decibels"]
        return Start(V, add_noise(V, F, settings["noise"], self._seed, decibels=decibels), F)

    def _changed(self, name):
        super()._changed(name)
        if name in ("look", "missiles"):
            self._aim()

    def _aim(self):
        """Point the camera at what the settings ask for."""
        settings = self.settings()
        V, _ = jet(settings["missiles"], self._detail)
        labels, names = jet_labels(settings["missiles"], self._detail)
        if settings["look"] == self.closer and settings["missiles"]:
            self.view.look_at(V[labels == names.index("tip missile left")], (0.5, 0.9, 0.5))
        else:
            self.view.look_at(V)


class DenoisingExplorer(FlowExplorer):
    """A mesh of one's own, with no clean one to compare it to: before and after.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        The mesh as it is.
    F : array_like of integers, shape (m, 3)
    tau, steps
        As in `FlowExplorer`.
    """

    measure = "volume"
    unit = "%"

    def _flow_controls(self, size, tau):
        return {"weights": weights_choice("cotangent"), "tau": tau_slider(tau, self.tau_range)}

    def _make_view(self):
        V, F = self._mesh
        return View([V, V], F, titles=["before", "after"])

    def _start(self, settings):
        V, F = self._mesh
        return Start(V, V, F)

    def _measured(self, V, start):
        return 100 * (1 + volume_change(V, start.V_true, start.F))

    def mesh(self):
        """The mesh that the view shows: what to save.

        Returns
        -------
        V : ndarray of float64, shape (n, 3)
        F : ndarray of int64, shape (m, 3)
        """
        self.wait()
        run, settings = self._run, self.settings()
        return run.states[settings["weights"]][min(settings["step"], run.steps)], run.start.F
