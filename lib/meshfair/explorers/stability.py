"""Why a time step past the bound blows up: the eigenvalues of the averaging operator."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from meshfair import spectrum
from meshfair.checks import Floats
from meshfair.explorers.controls import tau_slider, weights_choice
from meshfair.explorers.curves import CurvePlot
from meshfair.explorers.explorer import Settings
from meshfair.explorers.flows import FlowExplorer
from meshfair.explorers.runs import Start
from meshfair.explorers.worker import Job
from meshfair.viewer import View
from meshfair.weights import BY_NAME


class StabilityExplorer(FlowExplorer):
    """Heat flow with a time step of any size, beside the transfer function of an iteration.

    Parameters
    ----------
    V, F : array_like
        The ground truth, of at most `meshfair.spectrum.LARGEST` vertices.
    size, seed, tau, iterations
        As in `FlowExplorer`.
    """

    tau_range = (0.05, 2.0)

    def __init__(
        self,
        V: ArrayLike,
        F: ArrayLike,
        *,
        size: float = 0.2,
        seed: int = 1,
        tau: float = 0.5,
        iterations: int = 30,
    ) -> None:
        self._size = size
        self._eigenvalues: dict[str, Floats] = {}
        super().__init__(V, F, size=size, seed=seed, tau=tau, iterations=iterations)

    def _flow_controls(self, size: float, tau: float) -> dict[str, Any]:
        return {"weights": weights_choice("cotangent"), "tau": tau_slider(tau, self.tau_range)}

    def _make_view(self) -> View:
        return View(*self._mesh, titles="denoised")

    def _make_plots(self) -> list[CurvePlot]:
        transfer = CurvePlot(
            title="What one iteration does to each eigenmode",
            x_label="eigenvalue λ (fast left, slow right)",
            y_label="factor |1 - τ + τλ|",
        )
        return [*super()._make_plots(), transfer]

    def _start(self, settings: Settings) -> Start:
        return super()._start({"size": self._size})

    def _work(self, job: Job, settings: Settings) -> None:
        super()._work(job, settings)
        name = settings["weights"]
        if name not in self._eigenvalues:
            start = self._start_of(settings)
            self._say_how_long(len(start.V_noisy))
            W = BY_NAME[name](start.V_noisy, start.F)
            self._eigenvalues[name] = spectrum.eigenvalues(W)
        eigenvalues = self._eigenvalues[name]
        factors = np.abs(spectrum.transfer_function(eigenvalues, settings["tau"]))
        self.plots[1].draw({name: (eigenvalues, factors)}, points=True, threshold=1.0)
        growing = np.count_nonzero(factors > 1 + 1e-9)
        bound = 2 / (1 - eigenvalues.min())
        self.say(
            f"{growing} of {len(eigenvalues)} eigenmodes grow; stable up to τ = {bound:.3f}, where "
            f"the smallest eigenvalue, {eigenvalues.min():.3f}, has the factor -1"
        )
