"""A low-pass filter made by hand, beside those that the flows are."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator
from typing import Any, NamedTuple

import ipywidgets as widgets
import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array, diags_array

from meshfair import filters, flow, noise, solve, spectrum
from meshfair.checks import Floats, check_mesh
from meshfair.explorers.controls import (
    PLAIN,
    choice,
    color_choice,
    size_slider,
    slider,
    two_digits,
    weights_choice,
)
from meshfair.explorers.curves import CurvePlot
from meshfair.explorers.explorer import Explorer, Settings
from meshfair.explorers.framing import Frame
from meshfair.explorers.transfer import (
    COLORS,
    HAND,
    LAM,
    LENGTH,
    MU,
    RIVALS,
    STEPS,
    TAU,
    by_hand,
    transfer,
)
from meshfair.explorers.worker import Job
from meshfair.metrics import snr
from meshfair.operators import averaging, degrees, laplacian
from meshfair.viewer import View, coloring
from meshfair.weights import BY_NAME

COUNTS = 60  # numbers of eigenmodes for which the curve is computed


class Spectrum(NamedTuple):
    """A noisy mesh, its eigenmodes, and what the other filters make of it."""

    V_noisy: Floats
    W: csr_array
    eigenvalues: Floats
    Phi: Floats
    states: dict[str, list[Floats]]
    decibels: dict[str, list[float]]


class LowPassExplorer(Explorer):
    """A low-pass filter by hand beside heat flow, Taubin's filter and implicit steps.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        The ground truth, of at most `meshfair.spectrum.LARGEST` vertices.
    F : array_like of integers, shape (m, 3)
    size : float
        First size of the noise along the normals, in mean edge lengths.
    seed : int
        Of the noise.
    """

    main = "modes"
    quick = ("modes", "rival", "steps", "color")

    def __init__(self, V: ArrayLike, F: ArrayLike, *, size: float = 0.3, seed: int = 1) -> None:
        super().__init__()
        V, F = self._mesh = check_mesh(V, F)
        self._seed = seed
        self._found: tuple[Settings, Spectrum] | None = None
        self._showing = threading.RLock()
        self._placing: int | None = None
        self._follow = True  # the best of everything, until the reader chooses
        self._steps = dict.fromkeys(RIVALS, 1)
        self._curve: tuple[Floats, Floats] = (np.zeros(0), np.zeros(0))
        modes = slider(
            widgets.IntSlider,
            "modes kept",
            "How many eigenmodes the filter by hand keeps, the slowest first",
            value=min(40, len(V)),
            ends=(4, len(V)),  # fewer make a line
            step=1,
        )
        self.controls = {
            "weights": weights_choice(),
            "size": size_slider(size),
            "width": slider(
                widgets.FloatSlider,
                "edge width",
                "On how much of the axis of eigenvalues the filter by hand falls from 1 to 0",
                value=0.0,
                ends=(0.0, 0.5),
                step=0.02,
            ),
            "rival": choice(
                "compare with", RIVALS, "heat", "The filter in the right panel", RIVALS
            ),
            "steps": slider(
                widgets.IntSlider,
                "its steps",
                "How many steps the other filter makes",
                value=1,
                ends=(0, STEPS),
                step=1,
            ),
            "color": color_choice("signed displacement"),
            "modes": modes,
        }
        self.view = View([V, V, V], F, titles=["noisy", HAND, "heat"])
        self.plots = [
            CurvePlot(
                title="Transfer functions",
                x_label="eigenvalue λ (fast left, slow right)",
                y_label="factor",
            ),
            CurvePlot(
                title="SNR against the number of modes",
                x_label="modes kept by hand",
                y_label="SNR (dB)",
            ),
        ]
        self.plots[1].observe(self._picked, names="picked")
        self.best_button = widgets.Button(
            description="go to best",
            icon="bullseye",
            tooltip="Take the best number of modes, and of steps",
        )
        self.best_button.on_click(lambda _: self.go_to_best())
        self._begin(along=[modes, self.best_button])

    def go_to_best(self) -> None:
        """Take the best number of modes and of steps, now and after whatever changes."""
        self._follow = True
        if self._found is not None:
            self._place()

    @contextlib.contextmanager
    def _coming_back(self) -> Iterator[None]:
        follow, steps = self._follow, dict(self._steps)
        yield
        self._follow, self._steps = follow, steps

    def _work(self, job: Job, settings: Settings) -> None:
        key = {name: settings[name] for name in ("weights", "size")}
        if self._found is None or self._found[0] != key:
            self._found = (key, self._compute(job, settings))
        found = self._found[1]
        V, n = self._mesh[0], len(found.eigenvalues)
        # Few modes make the difference: their numbers lie close where they are small.
        counts = np.unique(np.geomspace(4, n, COUNTS).round().astype(int))
        counts = np.union1d(counts, settings["modes"])
        decibels = []
        for k, count in enumerate(counts):
            job.progress(k / len(counts))
            decibels.append(snr(V, self._by_hand(found, count, settings["width"])))
        self._curve = (counts, np.array(decibels))
        if self._follow:
            self._place()
        else:
            self._show()

    def _compute(self, job: Job, settings: Settings) -> Spectrum:
        V, F = self._mesh
        rng = np.random.default_rng(self._seed)
        V_noisy = noise.add(V, F, "normals", rng, size=settings["size"])
        W = BY_NAME[settings["weights"]](V_noisy, F)
        self._say_how_long(len(V))
        eigenvalues, Phi = spectrum.eigenmodes(W)
        self.say("")
        states: dict[str, list[Floats]] = {}
        for rival in RIVALS:
            states[rival] = []
            for X in self._run(rival, V_noisy, W, settings["weights"]):
                job.check()
                states[rival].append(X)
        decibels = {rival: [snr(V, X) for X in found] for rival, found in states.items()}
        return Spectrum(V_noisy, W, eigenvalues, Phi, states, decibels)

    def _run(self, rival: str, V: Floats, W: csr_array, weights: str) -> Iterator[Floats]:
        """The meshes after 0, 1, ... steps of one of `RIVALS`, with weights built once."""
        yield V
        if rival == "heat":
            states = flow.heat(V, averaging(W), TAU, TAU * STEPS)
            next(states)
            yield from (X for _, X in states)
        elif rival == "taubin":
            F, options = self._mesh[1], {"lam": LAM, "mu": MU, "iterations": STEPS}
            yield from (X for _, X in filters.taubin(V, F, weights=weights, **options))
        else:
            L, D = laplacian(W), csr_array(diags_array(degrees(W)))
            for _ in range(STEPS):
                V = solve.implicit_step(V, L, D, LENGTH)
                yield V

    def _by_hand(self, found: Spectrum, count: int, width: float) -> Floats:
        factors = by_hand(found.eigenvalues, count, width)
        return spectrum.filtered(found.V_noisy, found.W, found.Phi, factors)

    def _changed(self, name: str) -> None:
        if self._placing == threading.get_ident():
            return
        if name in ("modes", "steps"):
            self._follow = False
        if name == "steps":
            self._steps[self.controls["rival"].value] = self.controls["steps"].value
        if name == "rival":
            self._set({"steps": self._steps[self.controls["rival"].value]})
        if name in self.quick and self._found is not None:
            self._show(anew=name == "color")
        else:
            self._request()

    def _picked(self, change: dict[str, Any]) -> None:
        self.controls["modes"].value = min(max(round(change["new"]), 4), len(self._mesh[0]))

    def _set(self, values: dict[str, Any]) -> None:
        """Move controls without being told of it."""
        self._placing = threading.get_ident()
        for name, value in values.items():
            self.controls[name].value = value
        self._placing = None

    def _place(self) -> None:
        """Move the controls to the best, where they follow that, and show what is wanted."""
        with self._showing:
            assert self._found is not None
            found, (counts, decibels) = self._found[1], self._curve
            if self._follow:  # still: a reader may have moved a slider meanwhile
                for rival in RIVALS:
                    self._steps[rival] = int(np.argmax(found.decibels[rival]))
                self._set(
                    {
                        "modes": int(counts[decibels.argmax()]),
                        "steps": self._steps[self.controls["rival"].value],
                    }
                )
            self._show()

    def _show(self, anew: bool = True) -> None:
        """Show the filters that the controls ask for."""
        with self._showing:
            assert self._found is not None
            settings, found = self.settings(), self._found[1]
            V, F = self._mesh
            count, rival, steps = settings["modes"], settings["rival"], settings["steps"]
            denoised = self._by_hand(found, count, settings["width"])
            other = found.states[rival][steps]
            frame = Frame(self.view, [V, found.V_noisy], F)
            shown = [found.V_noisy, denoised, other]
            decibels = [snr(V, X) for X in shown]
            titles = [
                f"noisy: {two_digits(decibels[0])} dB",
                f"{HAND}, {count} modes: {two_digits(decibels[1])} dB",
                f"{steps} {RIVALS[rival]}: {two_digits(decibels[2])} dB",
            ]
            values: list[Floats | None] = [None] * 3
            if settings["color"] != PLAIN:
                look = coloring.COLORINGS[settings["color"]]
                of = look.of(V, F)
                given = [of(X) for X in shown]
                values = list(given)
            with self.view.together():
                self.view.refit(frame.V)
                if settings["color"] != PLAIN:
                    self.view.color_by(look.label, look.limits(*given), look.cmap)
                for panel, (X, title) in enumerate(zip(shown, titles, strict=True)):
                    X_drawn, remark = frame.drawn(X)
                    title += remark
                    self.view.update(X_drawn, panel=panel, values=values[panel], title=title)
            self._draw(found, settings, decibels[1])

    def _draw(self, found: Spectrum, settings: Settings, decibels: float) -> None:
        eigenvalues, n = found.eigenvalues, len(found.eigenvalues)
        count = settings["modes"]
        curves = {HAND: (eigenvalues, by_hand(eigenvalues, count, settings["width"]))}
        for rival, steps in self._steps.items():
            curves[rival] = (eigenvalues, transfer(rival, eigenvalues, steps))
        counts, curve = self._curve
        at = np.searchsorted(counts, count)
        if at == len(counts) or counts[at] != count:
            counts, curve = np.insert(counts, at, count), np.insert(curve, at, decibels)
        lines = {HAND: (counts, curve)}
        best = int(self._curve[1].argmax())
        legend = {
            HAND: f"best {two_digits(self._curve[1][best])} dB with {self._curve[0][best]} modes"
        }
        for rival, steps in self._steps.items():
            reached = found.decibels[rival]
            lines[rival] = (np.array([4, n]), np.full(2, reached[steps]))
            legend[rival] = f"{two_digits(reached[steps])} dB"
        self.plots[0].draw(curves, colors=COLORS)
        self.plots[0].marker = None
        self.plots[1].draw(
            lines,
            colors=COLORS,
            best={HAND: int(np.searchsorted(counts, self._curve[0][best]))},
            legend=legend,
            x_range=(0, n),
        )
        self.plots[1].marker = count
