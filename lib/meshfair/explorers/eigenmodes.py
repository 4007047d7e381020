"""The waves of a mesh, one at a time, and what a heat step leaves of each."""

from __future__ import annotations

from typing import Any

import ipywidgets as widgets
import numpy as np
from numpy.typing import ArrayLike

from meshfair import spectrum
from meshfair.checks import Floats, check_count, check_mesh
from meshfair.explorers.controls import slider, tau_slider, weights_choice
from meshfair.explorers.curves import CurvePlot
from meshfair.explorers.explorer import Explorer, Settings
from meshfair.explorers.framing import Frame
from meshfair.explorers.worker import Job
from meshfair.mesh import mean_edge_length, vertex_normals
from meshfair.plotting import WEIGHT_COLORS
from meshfair.viewer import View
from meshfair.weights import BY_NAME

FIRST = 12  # the eigenmode that is shown first


class EigenmodeExplorer(Explorer):
    """One eigenmode of a mesh, as colours and as a relief, and its decay in the heat flow.

    A click into the transfer function goes to the eigenmode with that eigenvalue, one
    into the decay to that iteration.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        At most `meshfair.spectrum.LARGEST` vertices.
    F : array_like of integers, shape (m, 3)
    tau : float
        First time step.
    iterations : int
        Of the heat flow, at most.
    """

    def __init__(
        self, V: ArrayLike, F: ArrayLike, *, tau: float = 0.5, iterations: int = 20
    ) -> None:
        super().__init__()
        V, F = self._mesh = check_mesh(V, F)
        self._iterations = check_count(iterations, "iterations", 1)
        self._normals, self._edge = vertex_normals(V, F), mean_edge_length(V, F)
        self._modes: dict[str, tuple[Floats, Floats]] = {}
        mode = slider(
            widgets.IntSlider,
            "eigenmode k",
            "Which of the mesh's waves: 0 is the constant, and the larger the faster",
            value=min(FIRST, len(V) - 1),
            ends=(0, len(V) - 1),
            step=1,
        )
        iteration = slider(
            widgets.IntSlider,
            "iteration",
            "How many heat steps the relief has made",
            value=2,
            ends=(0, self._iterations),
            step=1,
        )
        self.controls = {
            "weights": weights_choice("cotangent"),
            "mode": mode,
            "tau": tau_slider(tau, (0.05, 2.0)),
            "height": slider(
                widgets.FloatSlider,
                "height (edges)",
                "How high the relief of the eigenmode is, in mean edge lengths",
                value=0.5,
                ends=(0.0, 2.0),
                step=0.05,
            ),
            "iteration": iteration,
        }
        self.view = View(
            [V, V],
            F,
            titles=["eigenmode", "its relief"],
            values=[np.zeros(len(V))] * 2,
            label="eigenmode (its largest value is 1)",
            limits=(-1, 1),
            cmap="coolwarm",
            smooth=True,
        )
        self.plots = [
            CurvePlot(
                title="What the flow leaves of each eigenmode",
                x_label="eigenvalue λ (fast left, slow right)",
                y_label="factor (1 - τ + τλ)^s",
            ),
            CurvePlot(
                title="The decay of this one", x_label="iterations s", y_label="what is left"
            ),
        ]
        self.plots[0].observe(self._picked_eigenvalue, names="picked")
        self.plots[1].observe(self._picked_iteration, names="picked")
        play = widgets.Play(min=0, max=self._iterations, interval=200, show_repeat=True)
        # The slider first: what it shows is what the play button goes on from.
        widgets.jslink((iteration, "value"), (play, "value"))
        self._begin(along=[play, iteration])

    def _work(self, job: Job, settings: Settings) -> None:
        V, F = self._mesh
        name, k, tau = settings["weights"], settings["mode"], settings["tau"]
        if name not in self._modes:
            self._say_how_long(len(V))
            self._modes[name] = spectrum.eigenmodes(BY_NAME[name](V, F))
        eigenvalues, Phi = self._modes[name]
        job.check()
        left = spectrum.transfer_function(eigenvalues[k], tau) ** np.arange(self._iterations + 1)
        steps = settings["iteration"]

        wave = Phi[:, k] / np.abs(Phi[:, k]).max()
        height = settings["height"] * self._edge
        frame = Frame(self.view, [V + s * height * self._normals for s in (-1, 1)], F)
        V_drawn, remark = frame.drawn(V + (left[steps] * height * wave)[:, None] * self._normals)
        with self.view.together():
            self.view.refit(frame.V)
            self.view.update(
                panel=0,
                values=wave,
                title=f"eigenmode {k} of {len(V) - 1}: λ = {eigenvalues[k]:.3f}",
            )
            self.view.update(
                V_drawn,
                panel=1,
                values=left[steps] * wave,
                title=f"after {steps} steps of τ = {tau:.2f}: {_percent(left[steps])} left{remark}",
            )
        factors = spectrum.transfer_function(eigenvalues, tau, steps)
        color = {name: WEIGHT_COLORS[name]}
        self.plots[0].draw({name: (eigenvalues, factors)}, points=True, colors=color)
        self.plots[0].marker = float(eigenvalues[k])
        self.plots[1].draw({name: (np.arange(len(left)), left)}, colors=color)
        self.plots[1].marker = steps
        self.say(
            "" if abs(left[1]) <= 1 else "This eigenmode grows: its factor is beyond -1 and 1."
        )

    def _picked_eigenvalue(self, change: dict[str, Any]) -> None:
        """Go to the eigenmode that is nearest to where the reader clicked."""
        modes = self._modes.get(self.controls["weights"].value)
        if modes:
            self.controls["mode"].value = int(np.abs(modes[0] - change["new"]).argmin())

    def _picked_iteration(self, change: dict[str, Any]) -> None:
        self.controls["iteration"].value = min(max(round(change["new"]), 0), self._iterations)


def _percent(part: Any) -> str:
    """A part of a whole, with three digits that count."""
    return f"{100 * part:.3g} %" if abs(part) < 10 else f"{part:.1e} times"
