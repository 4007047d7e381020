"""What the explorers of flows share: a mesh at every iteration, and a curve along them."""

from __future__ import annotations

import contextlib
import threading
import time
import warnings
from collections.abc import Iterator
from typing import Any

import ipywidgets as widgets
import numpy as np
from numpy.typing import ArrayLike

from meshfair import flow, noise
from meshfair.checks import (
    Floats,
    MeshError,
    StabilityWarning,
    check_count,
    check_mesh,
)
from meshfair.explorers.controls import PLAIN, color_choice, slider, two_digits
from meshfair.explorers.curves import CurvePlot
from meshfair.explorers.explorer import Explorer, Settings
from meshfair.explorers.framing import Frame
from meshfair.explorers.runs import Run, Start
from meshfair.explorers.worker import Job
from meshfair.metrics import snr
from meshfair.plotting import WEIGHT_COLORS, WEIGHT_MARKS
from meshfair.viewer import View, coloring

GROWTH = 0.3  # seconds between two pictures of a curve that is still being computed


class FlowExplorer(Explorer):
    """What the explorers of flows share: all iterations are computed once, then shown at will.

    It shows the best iteration, until the reader chooses one, and again after the
    button "go to best". A control that changes the flow starts it anew in the
    background. Those in ``quick`` choose what is shown of it, and do so at once.

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
    clock = "t"
    best_word = "best"
    best_tooltip = "Go to the iteration that is closest to the ground truth, by the SNR"
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
        self._follow = True  # show the best iteration, whichever that is
        self._placing: int | None = None  # the thread that moves the slider by itself
        self._frame: Frame
        self.plots = self._make_plots()
        self.plots[0].observe(self._picked, names="picked")
        iteration = slider(
            widgets.IntSlider,
            "iteration",
            "After how many iterations of the flow the mesh is shown",
            value=0,
            ends=(0, self._iterations),
            step=1,
        )
        self.controls = {
            **self._flow_controls(size, tau),
            "color": color_choice(),
            "iteration": iteration,
        }
        self.view = self._make_view()
        play = widgets.Play(min=0, max=self._iterations, interval=150, show_repeat=True)
        # The slider first: what it shows is what the play button goes on from.
        widgets.jslink((iteration, "value"), (play, "value"))
        self.best_button = widgets.Button(
            description=f"go to {self.best_word}", icon="bullseye", tooltip=self.best_tooltip
        )
        self.best_button.on_click(lambda _: self.go_to_best())
        self._begin(along=[play, iteration, self.best_button])

    def _flow_controls(self, size: float, tau: float) -> dict[str, Any]:
        """The controls that start the flow anew."""
        raise NotImplementedError

    def _make_view(self) -> View:
        """The view with its panels, on the ground truth."""
        raise NotImplementedError

    def _make_plots(self) -> list[CurvePlot]:
        """The plots, the one along the flow first."""
        names = {"t": "time t", "s": "iterations s"}
        return [
            CurvePlot(
                title=f"{self.measure} along the flow",
                x_label=names[self.clock],
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

    def _judged(self, run: Run, name: str, measured: float) -> float:
        """How good the newest state of a flow is, the larger the better."""
        return measured

    def _panel(self, name: str) -> int:
        """The panel in which the flow with some weights is seen."""
        return len(self.view.panels) - 1

    def _show_start(self, run: Run, values: Floats | None) -> None:
        """Show what all iterations have in common, once for each run and colouring."""

    def _frame_start(self, start: Start) -> None:
        """All of the noisy mesh, and of the ground truth, should be in the picture."""
        self._frame = Frame(self.view, [start.V_true, start.V_noisy], start.F)
        self._aim()

    def _aim(self) -> None:
        """Point the camera at the meshes; a reader's own turn of the view stays."""
        self.view.refit(self._frame.V)

    def go_to_best(self) -> None:
        """Show the best iteration, now and after whatever changes the flow."""
        self._follow = True
        if self._run is not None and self._run.iterations >= 0:
            self._place(self._run)

    @contextlib.contextmanager
    def _coming_back(self) -> Iterator[None]:
        follow = self._follow
        yield
        self._follow = follow

    # The work, in the background.

    def _work(self, job: Job, settings: Settings) -> None:
        run = Run(self._start_of(settings), self._names(settings), settings.get("tau", 1.0))
        self._run = run
        wanted, seen = settings["iteration"], -1
        growth = time.monotonic() + GROWTH
        try:
            for k, states in enumerate(self._flows(run)):
                for name, V in states.items():
                    run.states[name].append(V)
                    measured = self._measured(V, run.start)
                    run.curves[name].append(measured)
                    run.judged[name].append(self._judged(run, name, measured))
                    job.progress(k / self._iterations)
                passed = self._follow and seen < run.best_of_all() < k
                if passed:  # most likely the best of all
                    seen = run.best_of_all()
                    self._place(run)
                elif k == wanted and not self._follow:
                    self._show()
                if time.monotonic() > growth:
                    growth = time.monotonic() + GROWTH
                    self._draw_curves(run)
        except MeshError as error:
            if run.iterations < 0:
                raise
            self.say(f"after {run.iterations} iterations {error}")
        if self._follow:
            self._place(run)
        else:
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
                name: self._flow(run.start.V_noisy, name, run.tau, run.start) for name in run.states
            }
        self.say("; ".join(str(warning.message) for warning in caught))
        for states in zip(*flows.values(), strict=True):
            yield dict(zip(flows, states, strict=True))

    def _flow(self, V: Floats, name: str, tau: float, start: Start) -> Iterator[Floats]:
        """The meshes after 0, 1, ... iterations from somewhere, with the start's operator."""
        states = flow.heat(V, start.operator(name), tau, tau * self._iterations)
        return (X for _, X in states)

    def _draw_curves(self, run: Run) -> None:
        curves = {
            name: (run.tau * np.arange(len(curve)), curve) for name, curve in run.curves.items()
        }
        best = run.best()
        self.plots[0].draw(
            curves,
            colors=WEIGHT_COLORS,
            marks=WEIGHT_MARKS,
            x_range=(0, run.tau * self._iterations),
            best=best,
            legend={name: self._best_text(run, name, k) for name, k in best.items()},
        )

    def _best_text(self, run: Run, name: str, iteration: int) -> str:
        """What the legend says of the best iteration of a flow."""
        at = self._time(iteration, run)
        return f"{self.best_word} {two_digits(run.curves[name][iteration])} {self.unit} at {at}"

    # What is shown of it, at once.

    def _changed(self, name: str) -> None:
        if name == "iteration" and self._placing == threading.get_ident():
            return  # what moved the slider shows the mesh itself
        if name == "iteration":
            self._follow = False
        if name in self.quick and self._run is not None:
            self._show(anew=name != "iteration")
        else:
            self._request()

    def _picked(self, change: dict[str, Any]) -> None:
        """Go to the iteration at which the reader clicked in the plot."""
        if self._run is not None:
            iteration = round(change["new"] / self._run.tau)
            self.controls["iteration"].value = min(max(iteration, 0), self._iterations)

    def _place(self, run: Run) -> None:
        """Move the slider to the best iteration, where it follows that, and show what is wanted."""
        with self._showing:
            if self._follow:  # still: a reader may have moved the slider meanwhile
                self._placing = threading.get_ident()
                self.controls["iteration"].value = run.best_of_all()
                self._placing = None
            self._show()

    def _show(self, anew: bool = False) -> None:
        """Show the wanted iteration, or the last one that there is."""
        with self._showing:
            run, settings = self._run, self.settings()
            if run is None or run.iterations < 0:
                return
            iteration = min(settings["iteration"], run.iterations)
            shown = {name: states[iteration] for name, states in run.states.items()}
            values: dict[str, Floats | None] = dict.fromkeys(shown)
            first = None
            if settings["color"] != PLAIN:
                first = run.start.noisy_values(settings["color"])
                quantity = run.start.quantity(settings["color"])
                values = {name: quantity(V) for name, V in shown.items()}
            with self.view.together():
                if first is not None:
                    # The noisy mesh sets the limits, so that the colours fade as the noise goes;
                    # where a mesh gets worse than it, that one does.
                    look = coloring.COLORINGS[settings["color"]]
                    limits = look.limits(first, *(x for x in values.values() if x is not None))
                    self.view.color_by(look.label, limits, look.cmap)
                if not run.shown:
                    self._frame_start(run.start)
                if anew or not run.shown:
                    self._show_start(run, first)
                    run.shown = True
                for name, V in shown.items():
                    V_drawn, remark = self._frame.drawn(V)
                    title = self._title(name, iteration, run) + remark
                    self.view.update(
                        V_drawn,
                        panel=self._panel(name),
                        F=run.start.F,
                        values=values[name],
                        title=title,
                    )
            self.plots[0].marker = iteration * run.tau

    def _title(self, name: str, iteration: int, run: Run) -> str:
        return (
            f"{name}, {self._time(iteration, run)}, "
            f"{self.measure} {two_digits(run.curves[name][iteration])} {self.unit}"
        )

    def _time(self, iteration: int, run: Run) -> str:
        return f"{self.clock} = {iteration * run.tau:.2f}"
