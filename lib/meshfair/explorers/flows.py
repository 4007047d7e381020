"""Heat flow and averaging: a mesh at every iteration, and the curve of its SNR."""

from __future__ import annotations

import threading
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import ipywidgets as widgets
import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from meshfair import flow, noise
from meshfair.checks import (
    Floats,
    Integers,
    MeshError,
    StabilityWarning,
    check_count,
    check_mesh,
)
from meshfair.explorers.curves import CurvePlot
from meshfair.explorers.explorer import (
    PLAIN,
    Explorer,
    Settings,
    choice,
    color_choice,
    noise_choice,
    size_slider,
    slider,
    tau_slider,
    weights_choice,
)
from meshfair.explorers.worker import Job
from meshfair.metrics import area_change, snr, volume_change
from meshfair.operators import averaging
from meshfair.plotting import WEIGHT_COLORS
from meshfair.shapes import jet, jet_labels
from meshfair.viewer import View, coloring
from meshfair.weights import BY_NAME

GROWTH = 0.3  # seconds between two pictures of a curve that is still being computed

Values = Callable[[Floats], Floats | None]


class Start:
    """Where flows begin: a noisy mesh, and its operators, each built when first wanted.

    Parameters
    ----------
    V_true, V_noisy : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    """

    def __init__(self, V_true: Floats, V_noisy: Floats, F: Integers) -> None:
        self.V_true, self.V_noisy, self.F = V_true, V_noisy, F
        self._operators: dict[str, csr_array] = {}

    def operator(self, name: str) -> csr_array:
        """The averaging operator with weights by name, see `meshfair.weights.BY_NAME`."""
        if name not in self._operators:
            self._operators[name] = averaging(BY_NAME[name](self.V_noisy, self.F))
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

    def __init__(self, start: Start, names: Sequence[str], tau: float) -> None:
        self.start, self.tau = start, tau
        # The mesh after each iteration, and what is measured of it.
        self.states: dict[str, list[Floats]] = {name: [] for name in names}
        self.curves: dict[str, list[float]] = {name: [] for name in names}
        self.shown = False
        self._colors: dict[str, tuple[coloring.Quantity, tuple[float, float]]] = {}

    @property
    def iterations(self) -> int:
        """How many iterations all flows have made; -1 before the first mesh is there."""
        return min(map(len, self.curves.values())) - 1

    def colors(self, name: str) -> tuple[coloring.Quantity, tuple[float, float]]:
        """A function from positions to values, and the ends of their colour bar."""
        if name not in self._colors:
            start = self.start
            values = coloring.COLORINGS[name].of(start.V_true, start.F)
            # The noisy mesh sets the limits, so that the colours fade as the noise goes.
            self._colors[name] = values, coloring.limits(values(start.V_noisy))
        return self._colors[name]


class FlowExplorer(Explorer):
    """What the explorers of flows share: all iterations are computed once, then shown at will.

    A control that changes the flow starts it anew in the background. Those
    in ``quick`` choose what is shown of it, and do so at once.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        The ground truth.
    F : array_like of integers, shape (m, 3)
    size : float
        First size of the noise along the normals, in mean edge lengths.
    seed : int
        Of the noise.
    tau : float
        First time step.
    iterations : int
        How many are computed.
    """

    measure = "SNR"
    unit = "dB"
    clock = "time t"
    quick: tuple[str, ...] = ("iteration", "color")
    tau_range = (0.05, 1.0)

    def __init__(
        self,
        V: ArrayLike,
        F: ArrayLike,
        *,
        size: float = 0.2,
        seed: int = 1,
        tau: float = 0.2,
        iterations: int = 40,
    ) -> None:
        super().__init__()
        self._mesh, self._seed = check_mesh(V, F), seed
        self._iterations = check_count(iterations, "iterations", 1)
        self._run: Run | None = None
        # Settings, and the start that they gave.
        self._started: tuple[Settings, Start] | None = None
        self._showing = threading.RLock()  # a slider and the background work both show
        iteration = slider(
            widgets.IntSlider,
            "iteration",
            "After how many iterations of the flow the mesh is shown",
            value=0,
            ends=(0, iterations),
            step=1,
        )
        self.plots = self._make_plots()
        self.plots[0].observe(self._picked, names="picked")
        self.controls = {
            **self._flow_controls(size, tau),
            "color": color_choice(),
            "iteration": iteration,
        }
        self.view = self._make_view()
        play = widgets.Play(min=0, max=iterations, interval=150, show_repeat=True)
        widgets.jslink((play, "value"), (iteration, "value"))
        self._begin(extra=[play])

    def _flow_controls(self, size: float, tau: float) -> dict[str, Any]:
        """The controls that start the flow anew."""
        raise NotImplementedError

    def _make_view(self) -> View:
        """The view with its panels, on the ground truth."""
        raise NotImplementedError

    def _make_plots(self) -> list[CurvePlot]:
        """The plots, the one along the flow first."""
        return [
            CurvePlot(
                title=f"{self.measure} along the flow",
                x_label=self.clock,
                y_label=f"{self.measure} ({self.unit})",
            )
        ]

    def _names(self, settings: Settings) -> tuple[str, ...]:
        """The weights whose flows are wanted."""
        return (settings["weights"],)

    def _start(self, settings: Settings) -> Start:
        """The noisy mesh that the settings ask for."""
        V, F = self._mesh
        rng = np.random.default_rng(self._seed)
        return Start(V, noise.add(V, F, "normals", rng, size=settings["size"]), F)

    def _measured(self, V: Floats, start: Start) -> float:
        """One number about a state, for the curve."""
        return snr(start.V_true, V)

    def _panel(self, name: str) -> int:
        """The panel in which the flow with some weights is seen."""
        return len(self.view.panels) - 1

    def _show_start(self, run: Run, values: Values) -> None:
        """Show what all iterations have in common, once for each run."""

    # The work, in the background.

    def _work(self, job: Job, settings: Settings) -> None:
        run = Run(self._start_of(settings), self._names(settings), settings.get("tau", 1.0))
        self._run = run
        wanted = settings["iteration"]
        growth = time.monotonic() + GROWTH
        for k, states in enumerate(self._flows(run)):
            for name, V in states.items():
                run.states[name].append(V)
                run.curves[name].append(self._measured(V, run.start))
                job.progress(k / self._iterations)
            if k == wanted:
                self._show()
            if time.monotonic() > growth:
                growth = time.monotonic() + GROWTH
                self._draw_curves(run)
        self._show()
        self._draw_curves(run)

    def _start_of(self, settings: Settings) -> Start:
        """`_start`, kept while only the time step or the weights change."""
        key = {k: v for k, v in settings.items() if k not in (*self.quick, "tau", "weights")}
        if self._started is None or self._started[0] != key:
            self._started = (key, self._start(settings))
        return self._started[1]

    def _flows(self, run: Run) -> Iterator[dict[str, Floats]]:
        """Yield the meshes after 0, 1, ... iterations, by weights; say what is warned of."""
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", StabilityWarning)
            flows = {
                name: flow.heat(
                    run.start.V_noisy,
                    run.start.operator(name),
                    run.tau,
                    run.tau * self._iterations,
                )
                for name in run.states
            }
        self.say("; ".join(str(warning.message) for warning in caught))
        for states in zip(*flows.values(), strict=True):
            yield {name: V for name, (_, V) in zip(flows, states, strict=True)}

    def _draw_curves(self, run: Run) -> None:
        curves = {
            name: (run.tau * np.arange(len(curve)), curve) for name, curve in run.curves.items()
        }
        ends = (0, run.tau * self._iterations)
        self.plots[0].draw(curves, colors=WEIGHT_COLORS, x_range=ends)

    # What is shown of it, at once.

    def _changed(self, name: str) -> None:
        if name in self.quick and self._run is not None:
            self._show(anew=name != "iteration")
        else:
            self._request()

    def _picked(self, change: dict[str, Any]) -> None:
        """Go to the iteration at which the reader clicked in the plot."""
        if self._run is not None:
            iteration = round(change["new"] / self._run.tau)
            self.controls["iteration"].value = min(max(iteration, 0), self._iterations)

    def _show(self, anew: bool = False) -> None:
        """Show the wanted iteration, or the last one that there is."""
        with self._showing, self.view.together():
            run, settings = self._run, self.settings()
            if run is None or run.iterations < 0:
                return
            iteration = min(settings["iteration"], run.iterations)
            values: Values = _no_values
            if settings["color"] != PLAIN:
                values, limits = run.colors(settings["color"])
                self.view.color_by(coloring.COLORINGS[settings["color"]].label, limits)
            if anew or not run.shown:
                self._show_start(run, values)
                run.shown = True
            for name, states in run.states.items():
                V = states[iteration]
                self.view.update(
                    V,
                    panel=self._panel(name),
                    F=run.start.F,
                    values=values(V),
                    title=self._title(name, iteration, run),
                )
            self.plots[0].marker = iteration * run.tau

    def _title(self, name: str, iteration: int, run: Run) -> str:
        return (
            f"{name}, {self._time(iteration, run)}, "
            f"{self.measure} {run.curves[name][iteration]:.2f} {self.unit}"
        )

    def _time(self, iteration: int, run: Run) -> str:
        return f"t = {iteration * run.tau:.2f}"


def _no_values(V: Floats) -> None:
    return None


class HeatExplorer(FlowExplorer):
    """The heat equation on one mesh: ground truth, noisy and denoised; where to stop."""

    def _flow_controls(self, size: float, tau: float) -> dict[str, Any]:
        return {
            "weights": weights_choice(),
            "size": size_slider(size),
            "tau": tau_slider(tau, self.tau_range),
        }

    def _make_view(self) -> View:
        V, F = self._mesh
        return View([V, V, V], F, titles=["ground truth", "noisy", "denoised"])

    def _show_start(self, run: Run, values: Values) -> None:
        V_noisy = run.start.V_noisy
        decibels = next(iter(run.curves.values()))[0]
        self.view.update(
            V_noisy, panel=1, values=values(V_noisy), title=f"noisy: {decibels:.2f} {self.unit}"
        )


class AveragingExplorer(HeatExplorer):
    """Iterated averaging: the heat equation with a time step of 1."""

    clock = "iterations s"

    def _flow_controls(self, size: float, tau: float) -> dict[str, Any]:
        return {"weights": weights_choice(), "size": size_slider(size)}

    def _time(self, iteration: int, run: Run) -> str:
        return f"s = {iteration}"


class ComparisonExplorer(FlowExplorer):
    """The three weights side by side, on one mesh with one noise."""

    def _flow_controls(self, size: float, tau: float) -> dict[str, Any]:
        return {"size": size_slider(size), "tau": tau_slider(tau, self.tau_range)}

    def _make_view(self) -> View:
        V, F = self._mesh
        return View([V] * len(BY_NAME), F, titles=list(BY_NAME))

    def _names(self, settings: Settings) -> tuple[str, ...]:
        return tuple(BY_NAME)

    def _panel(self, name: str) -> int:
        return list(BY_NAME).index(name)


class JetExplorer(ComparisonExplorer):
    """The three weights on a jet with or without missiles: fine detail under the flow.

    Parameters
    ----------
    detail : float
        Sampling of the jet, see `meshfair.shapes.jet`.
    decibels : float
        First SNR of the noisy jet.
    seed, tau, iterations
        As in `FlowExplorer`.
    """

    quick = ("iteration", "color", "look")
    whole, closer = "the aircraft", "a wing-tip missile"

    def __init__(
        self,
        *,
        detail: float = 1.0,
        decibels: float = 22.7,
        seed: int = 1,
        tau: float = 0.2,
        iterations: int = 20,
    ) -> None:
        self._detail, self._decibels = detail, decibels
        super().__init__(*jet(detail=detail), seed=seed, tau=tau, iterations=iterations)

    def _flow_controls(self, size: float, tau: float) -> dict[str, Any]:
        return {
            "missiles": widgets.Checkbox(
                value=True, description="with missiles", tooltip="Whether the jet has missiles"
            ),
            "look": choice("look at", [self.whole, self.closer], self.whole, "What fills the view"),
            "noise": noise_choice(
                noise.MODELS,
                "uniform",
                "How the vertices are moved; uniform as in the original report",
            ),
            "decibels": slider(
                widgets.FloatSlider,
                "noise: SNR (dB)",
                "SNR of the noisy jet: the noise is scaled to it",
                value=self._decibels,
                ends=(15.0, 40.0),
                step=0.1,
                readout_format=".1f",
            ),
            "tau": tau_slider(tau, self.tau_range),
        }

    def _make_view(self) -> View:
        V, F = self._mesh
        return View([V] * len(BY_NAME), F, titles=list(BY_NAME), direction=(0.7, -0.6, 0.6))

    def _start(self, settings: Settings) -> Start:
        V, F = jet(settings["missiles"], self._detail)
        rng, decibels = np.random.default_rng(self._seed), settings["decibels"]
        return Start(V, noise.add(V, F, settings["noise"], rng, decibels=decibels), F)

    def _changed(self, name: str) -> None:
        super()._changed(name)
        if name in ("look", "missiles"):
            self._aim()

    def _aim(self) -> None:
        """Point the camera at what the settings ask for."""
        settings = self.settings()
        V, F = jet(settings["missiles"], self._detail)
        labels, names = jet_labels(settings["missiles"], self._detail)
        if settings["look"] == self.closer and settings["missiles"]:
            self.view.look_at(V[labels == names.index("tip missile left")], (0.5, 0.9, 0.5))
        else:
            self.view.look_at(V[np.unique(F)])


class DenoisingExplorer(FlowExplorer):
    """A mesh of one's own, with no ground truth to compare it to: before and after.

    Measured by its volume, or where it encloses none by its area.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        The mesh as it is.
    F : array_like of integers, shape (m, 3)
    tau, iterations
        As in `FlowExplorer`.
    """

    unit = "%"

    def __init__(
        self, V: ArrayLike, F: ArrayLike, *, tau: float = 0.2, iterations: int = 40
    ) -> None:
        try:
            volume_change(V, V, F)
            self.measure, self._change = "volume", volume_change
        except MeshError:
            self.measure, self._change = "area", area_change
        super().__init__(V, F, tau=tau, iterations=iterations)

    def _flow_controls(self, size: float, tau: float) -> dict[str, Any]:
        return {"weights": weights_choice("cotangent"), "tau": tau_slider(tau, self.tau_range)}

    def _make_view(self) -> View:
        V, F = self._mesh
        return View([V, V], F, titles=["before", "after"])

    def _start(self, settings: Settings) -> Start:
        V, F = self._mesh
        return Start(V, V, F)

    def _measured(self, V: Floats, start: Start) -> float:
        return 100 * (1 + self._change(V, start.V_true, start.F))

    def mesh(self) -> tuple[Floats, Integers]:
        """The mesh that the view shows: what to save.

        Returns
        -------
        V : ndarray of float64, shape (n, 3)
        F : ndarray of int64, shape (m, 3)
        """
        self.wait()
        shown = self.view.panels[1]
        return shown.V.copy(), shown.F.copy()
