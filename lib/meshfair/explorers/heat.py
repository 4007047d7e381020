"""Heat flow and averaging beside the ground truth; three weights beside each other."""

from __future__ import annotations

from typing import Any

from meshfair.checks import Floats
from meshfair.explorers.controls import size_slider, tau_slider, two_digits, weights_choice
from meshfair.explorers.explorer import Settings
from meshfair.explorers.flows import FlowExplorer
from meshfair.explorers.runs import Run
from meshfair.viewer import View
from meshfair.weights import BY_NAME


class HeatExplorer(FlowExplorer):
    """The heat equation on one mesh: ground truth, noisy and denoised; where to stop.

    Parameters
    ----------
    V, F, size, seed, tau, iterations
        As in `meshfair.explorers.flows.FlowExplorer`.
    """

    def _flow_controls(self, size: float, tau: float) -> dict[str, Any]:
        return {
            "weights": weights_choice(),
            "size": size_slider(size),
            "tau": tau_slider(tau, self.tau_range),
        }

    def _make_view(self) -> View:
        V, F = self._mesh
        return View([V, V, V], F, titles=["ground truth", "noisy", "denoised"])

    def _show_start(self, run: Run, values: Floats | None) -> None:
        decibels = next(iter(run.curves.values()))[0]
        title = f"noisy: {two_digits(decibels)} {self.unit}"
        self.view.update(run.start.V_noisy, panel=1, values=values, title=title)


class AveragingExplorer(HeatExplorer):
    """Iterated averaging: the heat equation with a time step of 1.

    Parameters
    ----------
    V, F, size, seed, tau, iterations
        As in `meshfair.explorers.flows.FlowExplorer`.
    """

    clock = "s"

    def _flow_controls(self, size: float, tau: float) -> dict[str, Any]:
        return {"weights": weights_choice(), "size": size_slider(size)}

    def _time(self, iteration: int, run: Run) -> str:
        return f"s = {iteration}"


class ComparisonExplorer(FlowExplorer):
    """The three weights side by side, on one mesh with one noise.

    Parameters
    ----------
    V, F, size, seed, tau, iterations
        As in `meshfair.explorers.flows.FlowExplorer`.
    """

    def _flow_controls(self, size: float, tau: float) -> dict[str, Any]:
        return {"size": size_slider(size), "tau": tau_slider(tau, self.tau_range)}

    def _make_view(self) -> View:
        V, F = self._mesh
        return View([V] * len(BY_NAME), F, titles=list(BY_NAME))

    def _names(self, settings: Settings) -> tuple[str, ...]:
        return tuple(BY_NAME)

    def _panel(self, name: str) -> int:
        return list(BY_NAME).index(name)
