"""The noise models, and what the SNR makes of them."""

import numpy as np

from meshfair import metrics, noise
from meshfair.explorers.chart import Chart
from meshfair.explorers.explorer import PLAIN, Explorer, choice, colour_choice, slider, widgets
from meshfair.mesh import mean_edge_length
from meshfair.viewer import View, colouring

# Name -> function(V, F, size in mean edge lengths, rng).
MODELS = {
    "along normals": noise.along_normals,
    "Gaussian": noise.gaussian,
    "uniform": lambda V, F, size, rng: noise.uniform(V, size * mean_edge_length(V, F), rng),
    "impulsive (one in ten)": lambda V, F, size, rng: noise.impulsive(V, F, size, 0.1, rng),
}
SIZES = np.geomspace(0.02, 1, 40)  # of the curve: the SNR is nearly straight over log(size)


class NoiseExplorer(Explorer):
    """A clean mesh beside a noisy one: model, size, seed, and where the origin lies.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    size : float
        First size of the noise, in mean edge lengths.
    """

    def __init__(self, V, F, *, size=0.2):
        super().__init__()
        self._V, self._F = V, F
        self._diagonal = np.linalg.norm(np.ptp(V, axis=0))
        self.view = View([V, V], F, titles=["clean", "noisy"])
        self.charts = [
            Chart(
                title="SNR against the size of the noise",
                x_label="size (mean edge lengths)",
                y_label="SNR (dB)",
            )
        ]
        self.controls = {
            "model": choice("noise", MODELS, "along normals", "How the vertices are moved"),
            "size": slider(
                widgets.FloatSlider, "size (edges)", size, 0.0, 1.0, 0.01,
                "Standard deviation, or for uniform noise its range, in mean edge lengths",
            ),
            "seed": slider(
                widgets.IntSlider, "seed", 1, 0, 20, 1,
                "The same seed draws the same random numbers",
            ),
            "shift": slider(
                widgets.FloatSlider, "shift (diagonals)", 0.0, 0.0, 4.0, 0.1,
                "Move the clean and the noisy mesh along x, in diagonals of the bounding box",
                readout_format=".1f",
            ),
            "colour": colour_choice(),
        }  # fmt: skip
        self._begin()

    def _work(self, job, settings):
        V, F = self._V, self._F
        model = MODELS[settings["model"]]
        move = [settings["shift"] * self._diagonal, 0, 0]

        def noisy(size):
            return model(V, F, size, np.random.default_rng(settings["seed"]))

        V_noisy = noisy(settings["size"])
        self.snr = metrics.snr(V + move, V_noisy + move)
        values = None
        with self.view.together():
            if settings["colour"] != PLAIN:
                colours = colouring.COLOURINGS[settings["colour"]]
                values = colours.of(V, F)(V_noisy)
                self.view.colour_by(colours.label, colouring.limits(values))
            # The picture stays where it is: moving both meshes changes nothing but the SNR.
            self.view.update(V_noisy, panel=1, values=values, title=f"noisy: {self.snr:.2f} dB")
        self.charts[0].marker = settings["size"]

        curve = []
        for k, size in enumerate(SIZES):
            job.progress(k / len(SIZES))
            curve.append(metrics.snr(V + move, noisy(size) + move))
        self.charts[0].draw({"SNR": (SIZES, curve)}, x_range=(0, 1))
