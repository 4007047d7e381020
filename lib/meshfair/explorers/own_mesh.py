"""A mesh of one's own under the flow: before and after, with nothing to compare it to."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import Floats, Integers, MeshError, StabilityWarning
from meshfair.explorers.controls import tau_slider, weights_choice
from meshfair.explorers.explorer import Settings
from meshfair.explorers.flows import FlowExplorer
from meshfair.explorers.runs import Run, Start
from meshfair.metrics import area_change, volume_change
from meshfair.sure import SURE
from meshfair.viewer import View


class DenoisingExplorer(FlowExplorer):
    """A mesh of one's own, with no ground truth to compare it to: before and after.

    Measured by its volume, or where it encloses none by its area. It begins where
    the risk that `meshfair.sure.SURE` estimates is smallest.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        The mesh as it is.
    F : array_like of integers, shape (m, 3)
    tau, iterations
        As in `FlowExplorer`.
    """

    unit = "%"
    best_word = "least estimated risk"
    best_tooltip = "Go to the iteration with the smallest error, as far as it can be estimated"

    def __init__(
        self, V: ArrayLike, F: ArrayLike, *, tau: float = 0.2, iterations: int = 40
    ) -> None:
        try:
            volume_change(V, V, F)
            self.measure, self._change = "volume", volume_change
        except MeshError:
            self.measure, self._change = "area", area_change
        self._risk: SURE | None = None
        self._perturbed: dict[str, Floats] = {}
        super().__init__(V, F, tau=tau, iterations=iterations)
        self.best_button.description = "go to least risk"

    def _flow_controls(self, size: float, tau: float) -> dict[str, Any]:
        return {"weights": weights_choice("cotangent"), "tau": tau_slider(tau, self.tau_range)}

    def _make_view(self) -> View:
        V, F = self._mesh
        return View([V, V], F, titles=["before", "after"])

    def _start(self, settings: Settings) -> Start:
        V, F = self._mesh
        self._risk = SURE(V, F, np.random.default_rng(self._seed))
        # The same mesh moved a little, which tells how much a flow follows the noise.
        self._beside = Start(V, self._risk.V_perturbed, F)
        return Start(V, V, F)

    def _flows(self, run: Run) -> Iterator[dict[str, Floats]]:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", StabilityWarning)  # said of the mesh itself
            others = {
                name: self._flow(self._beside.V_noisy, name, run.tau, self._beside)
                for name in run.states
            }
        for states in super()._flows(run):
            self._perturbed = {name: next(other) for name, other in others.items()}
            yield states

    def _measured(self, V: Floats, start: Start) -> float:
        return 100 * (1 + self._change(V, start.V_true, start.F))

    def _judged(self, run: Run, name: str, measured: float) -> float:
        assert self._risk is not None
        return -self._risk(run.states[name][-1], self._perturbed[name])

    def mesh(self) -> tuple[Floats, Integers]:
        """The mesh that the view shows: what to save.

        Returns
        -------
        V : ndarray of float64, shape (n, 3)
        F : ndarray of int64, shape (m, 3)
        """
        self.wait()
        run = self._run
        if run is None or run.iterations < 0:
            V, F = self._mesh
            return V.copy(), F.copy()
        (states,) = run.states.values()
        iteration = min(self.controls["iteration"].value, run.iterations)
        return states[iteration].copy(), run.start.F.copy()
