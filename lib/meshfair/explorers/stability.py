"""Why a time step past the bound blows up: the eigenvalues of the averaging operator."""

import numpy as np

from meshfair import spectrum
from meshfair.experiments.cases import WEIGHTS
from meshfair.explorers.chart import Chart
from meshfair.explorers.explorer import tau_slider, weights_choice
from meshfair.explorers.flows import FlowExplorer
from meshfair.viewer import View


class StabilityExplorer(FlowExplorer):
    """Heat flow with a time step of any size, beside what a step does to each wave.

    Parameters
    ----------
    V, F : array_like
        The clean mesh, of at most `meshfair.spectrum.LARGEST` vertices.
    size, seed, tau, steps
        As in `FlowExplorer`.
    """

    tau_range = (0.05, 2.0)

    def __init__(self, V, F, *, size=0.2, seed=1, tau=0.5, steps=30):
        self._size = size
        super().__init__(V, F, size=size, seed=seed, tau=tau, steps=steps)

    def _flow_controls(self, size, tau):
        self._factors = Chart(
            title="What one step does to each wave",
            x_label="eigenvalue λ of W̃ (fast waves left)",
            y_label="factor |1 - τ + τλ|",
        )
        self.charts.append(self._factors)
        self._eigenvalues = {}
        return {"weights": weights_choice("cotangent"), "tau": tau_slider(tau, self.tau_range)}

    def _make_view(self):
        V, F = self._mesh
        return View(V, F, titles="denoised")

    def _start(self, settings):
        return super()._start({"size": self._size})

    def _work(self, job, settings):
        super()._work(job, settings)
        name = settings["weights"]
        if name not in self._eigenvalues:
            start = self._run.start
            W = WEIGHTS[name](start.V_noisy, start.F)
            self._eigenvalues[name] = spectrum.eigenvalues(W)
        waves = self._eigenvalues[name]
        factors = np.abs(spectrum.transfer_function(waves, settings["tau"]))
        self._factors.draw({name: (waves, factors)}, points=True, threshold=1.0)
        growing = np.count_nonzero(factors > 1 + 1e-9)
        bound = 2 / (1 - waves.min())
        self.say(
            f"{growing} of {len(waves)} waves grow; stable up to τ = {bound:.3f}, where the "
            f"smallest eigenvalue, {waves.min():.3f}, has the factor -1"
        )
