"""The noise models, and what the SNR makes of them."""

from __future__ import annotations

import ipywidgets as widgets
import numpy as np
from numpy.typing import ArrayLike

from meshfair import metrics, noise
from meshfair.checks import Floats, Integers, check_mesh
from meshfair.explorers.controls import (
    LARGEST_SIZE,
    NOISES,
    PLAIN,
    color_choice,
    noise_choice,
    size_slider,
    slider,
    two_digits,
)
from meshfair.explorers.curves import CurvePlot
from meshfair.explorers.explorer import Explorer, Settings
from meshfair.explorers.worker import Job
from meshfair.mesh import mean_edge_length
from meshfair.viewer import View, coloring

# Of the curve: the SNR is nearly straight over log(size).
SIZES = np.geomspace(0.02, LARGEST_SIZE, 40)
SHARE = 0.1  # of the vertices that impulsive noise moves


def noisy(V: Floats, F: Integers, model: str, size: float, seed: int) -> Floats:
    """A mesh with noise of a size in mean edge lengths, whatever the model's own unit.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    model : str
        One of `meshfair.explorers.controls.NOISES`.
    size : float
    seed : int

    Returns
    -------
    ndarray of float64, shape (n, 3)
    """
    rng = np.random.default_rng(seed)
    if model == "impulsive":
        return noise.impulsive(V, F, size, SHARE, rng)
    unit = mean_edge_length(V, F) if model == "uniform" else 1.0
    return noise.add(V, F, model, rng, size=size * unit)


class NoiseExplorer(Explorer):
    """The ground truth beside a noisy mesh: model, size, seed, and where the origin lies.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    size : float
        First size of the noise, in mean edge lengths.
    """

    main = "size"

    def __init__(self, V: ArrayLike, F: ArrayLike, *, size: float = 0.2) -> None:
        super().__init__()
        self._V, self._F = check_mesh(V, F)
        self._diagonal = np.linalg.norm(np.ptp(self._V, axis=0))
        self.view = View([self._V] * 2, self._F, titles=["ground truth", "noisy"])
        self.plots = [
            CurvePlot(
                title="SNR against the size of the noise",
                x_label="size (mean edge lengths)",
                y_label="SNR (dB)",
            )
        ]
        self.controls = {
            "model": noise_choice(NOISES, "normals", "How the vertices are moved"),
            "size": size_slider(size, any_model=True),
            "seed": slider(
                widgets.IntSlider,
                "seed",
                "The same seed draws the same random numbers",
                value=1,
                ends=(0, 20),
                step=1,
            ),
            "shift": slider(
                widgets.FloatSlider,
                "shift both",
                "Move both meshes along x, away from the origin, in diagonals of the bounding box",
                value=0.0,
                ends=(0.0, 4.0),
                step=0.1,
                readout_format=".1f",
            ),
            "color": color_choice(),
        }
        self._begin()

    def _work(self, job: Job, settings: Settings) -> None:
        V, F = self._V, self._F
        model, seed = settings["model"], settings["seed"]
        move = np.array([settings["shift"] * self._diagonal, 0, 0])

        V_noisy = noisy(V, F, model, settings["size"], seed)
        self.snr = metrics.snr(V + move, V_noisy + move)
        used, values = np.unique(F), None
        if settings["color"] != PLAIN:
            look = coloring.COLORINGS[settings["color"]]
            values = look.of(V, F)(V_noisy)
        with self.view.together():
            self.view.refit(np.concatenate([V[used], V_noisy[used]]))
            if values is not None:
                self.view.color_by(look.label, look.limits(values), look.cmap)
            # The picture stays as it is: moving both meshes changes nothing but the SNR.
            self.view.update(
                V_noisy, panel=1, values=values, title=f"noisy: {two_digits(self.snr)} dB"
            )
        self.plots[0].marker = settings["size"]

        # With the size that is shown among those of the curve, its label is the title's number.
        sizes = np.union1d(SIZES, settings["size"])
        curve = []
        for k, size in enumerate(sizes):
            job.progress(k / len(sizes))
            curve.append(metrics.snr(V + move, noisy(V, F, model, size, seed) + move))
        self.plots[0].draw({"SNR": (sizes, curve)}, x_range=(0, LARGEST_SIZE))
