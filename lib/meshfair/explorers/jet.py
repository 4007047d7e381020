"""The jet and its missiles under the flow: what becomes of fine detail."""

from __future__ import annotations

from typing import Any

import ipywidgets as widgets
import numpy as np

from meshfair import noise
from meshfair.explorers.controls import choice, noise_choice, slider, tau_slider
from meshfair.explorers.explorer import Settings
from meshfair.explorers.heat import ComparisonExplorer
from meshfair.explorers.runs import Start
from meshfair.shapes import jet, jet_labels
from meshfair.viewer import View
from meshfair.weights import BY_NAME


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
                "noise SNR (dB)",
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
        if name not in ("look", "missiles"):
            return
        if self._closer():
            V, _ = jet(True, self._detail)
            labels, names = jet_labels(True, self._detail)
            self.view.look_at(V[labels == names.index("tip missile left")], (0.5, 0.9, 0.5))
        elif self._run is not None:
            self.view.look_at(self._frame.V)  # a new flow, without missiles, adapts it

    def _aim(self) -> None:
        if not self._closer():
            super()._aim()

    def _closer(self) -> bool:
        """Whether a missile fills the picture, and not the jet."""
        return self.controls["look"].value == self.closer and self.controls["missiles"].value
