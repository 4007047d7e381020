"""A kernel that is learned from one mesh and tried on another, beside the Gaussian one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import ipywidgets as widgets
import numpy as np
from numpy.typing import ArrayLike

from meshfair import filters, noise
from meshfair.checks import Floats, Integers, check_mesh
from meshfair.explorers.controls import choice, size_slider, slider
from meshfair.explorers.curves import CurvePlot
from meshfair.explorers.explorer import Explorer, Settings
from meshfair.explorers.framing import Frame
from meshfair.explorers.worker import Job
from meshfair.filters import kernel_table
from meshfair.filters.normal_filtering import gaussian
from meshfair.metrics import normal_angle
from meshfair.viewer import View, coloring

ANGLES = (0.0, 30.0)  # ends of the colour bar, the same for all panels
OTHERS = "all others"
FINE = np.linspace(0, 180, 91)  # degrees at which the Gaussian is drawn
GAUSSIAN, TABLE, LAST = "Gaussian", "table", "table, last pass"
VERTEX_ITERATIONS = 20
COLORS = {GAUSSIAN: "#E69F00", TABLE: "#0072B2", LAST: "#56B4E9"}
# The noise that is learned from is another draw than the one that is denoised.
LEARNED, TRIED = 1, 2


class KernelExplorer(Explorer):
    """The bilateral normal filter with a kernel from a table, fitted to a mesh to choose.

    Parameters
    ----------
    meshes : dict of str to (V, F)
        At least two ground truths by name. The kernel is learned from the first at the
        beginning, and tried on the second.
    size : float
        First size of the noise along the normals, in mean edge lengths.
    passes : int
        How often the normals are filtered, at first.
    """

    def __init__(
        self,
        meshes: Mapping[str, tuple[ArrayLike, ArrayLike]],
        *,
        size: float = 0.3,
        passes: int = 5,
    ) -> None:
        super().__init__()
        self._meshes = {name: check_mesh(*mesh) for name, mesh in meshes.items()}
        if len(self._meshes) < 2:
            raise ValueError("one mesh to learn from and another to try are needed; give two")
        self._tables: tuple[tuple[list[str], float], list[Floats]] | None = None
        self._shown: str | None = None
        first, second = list(self._meshes)[:2]
        self.controls = {
            "train": choice(
                "learn from",
                [*self._meshes, OTHERS],
                first,
                "The mesh to whose clean and noisy normals the table is fitted",
            ),
            "test": choice("try on", self._meshes, second, "The mesh that is denoised"),
            "size": size_slider(size),
            "passes": slider(
                widgets.IntSlider,
                "passes",
                "How often the normals are filtered; the table of each pass is fitted anew",
                value=passes,
                ends=(1, 10),
                step=1,
            ),
            "width": slider(
                widgets.FloatSlider,
                "kernel width",
                "Of the Gaussian kernel: the difference of two unit normals that still counts",
                value=0.35,
                ends=(0.1, 2.0),
                step=0.05,
            ),
        }
        V, F = self._meshes[second]
        self.view = View(
            [V] * 3,
            F,
            titles=["noisy", GAUSSIAN, TABLE],
            label="angle to the true normals (degrees)",
            limits=ANGLES,
        )
        self.plots = [
            CurvePlot(
                title="Weight of a face, one face away",
                x_label="angle between the normals (degrees)",
                y_label="weight (largest: 1)",
            ),
            CurvePlot(title="Mean normal angle after each pass", x_label="pass", y_label="degrees"),
        ]
        self._begin()

    def _work(self, job: Job, settings: Settings) -> None:
        V, F = self._meshes[settings["test"]]
        V_noisy, passes = self._noisy(settings["test"], settings["size"], TRIED), settings["passes"]
        tables = self._learn(job, settings)
        by_pass = {
            GAUSSIAN: self._by_gaussian(V_noisy, F, settings["width"], passes),
            TABLE: (
                kernel_table.fit_vertices(V_noisy, F, N, VERTEX_ITERATIONS)
                for N in kernel_table.normals_by_tables(V_noisy, F, tables[:passes])
            ),
        }
        found, errors = {}, {}
        for done, (name, states) in enumerate(by_pass.items()):
            angles = []
            for X in states:
                found[name] = X
                angles.append(normal_angle(X, V, F))
                job.progress(0.6 + 0.2 * (done + len(angles) / (passes + 1)))
            errors[name] = (np.arange(passes + 1), angles)
        self._show(settings["test"], {"noisy": V_noisy} | found)
        self._draw(settings["width"], tables[:passes])
        most = max(max(angles) for _, angles in errors.values())
        self.plots[1].draw(
            errors, colors=COLORS, x_range=(0, passes), y_range=(0, 1.05 * most or 1)
        )

    def _by_gaussian(self, V: Floats, F: Integers, width: float, passes: int) -> Iterator[Floats]:
        """The mesh after 0, 1, ... passes of the package's own filter."""
        options: dict[str, Any] = {"sigma_normal": width, "vertex_iterations": VERTEX_ITERATIONS}
        for count in range(passes + 1):
            *_, (_, X) = filters.bilateral_normal(V, F, normal_iterations=count, **options)
            yield X

    def _noisy(self, name: str, size: float, seed: int) -> Floats:
        V, F = self._meshes[name]
        return noise.add(V, F, "normals", np.random.default_rng(seed), size=size)

    def _learn(self, job: Job, settings: Settings) -> list[Floats]:
        """The tables that the settings ask for; those of more passes begin with them."""
        names = [settings["train"]]
        if names == [OTHERS]:
            names = [name for name in self._meshes if name != settings["test"]]
        key = names, settings["size"]
        if self._tables is None or self._tables[0] != key:
            most = self.controls["passes"].max
            examples = [
                (self._noisy(name, settings["size"], LEARNED), *self._meshes[name])
                for name in names
            ]
            tables = []
            for table in kernel_table.cascade(examples, most):
                tables.append(table)
                job.progress(0.6 * len(tables) / most)
            self._tables = key, tables
        return self._tables[1]

    def _show(self, name: str, states: dict[str, Floats]) -> None:
        V, F = self._meshes[name]
        color = coloring.normal_angle(V, F)
        with self.view.together():
            frame = Frame(self.view, [V, states["noisy"]], F)
            if self._shown != name:
                self.view.look_at(frame.V)
                self._shown = name
            else:
                self.view.refit(frame.V)
            for panel, (title, X) in enumerate(states.items()):
                drawn, remark = frame.drawn(X)
                title = f"{title}: {normal_angle(X, V, F):.1f}°{remark}"
                self.view.update(drawn, panel=panel, F=F, values=color(X), title=title)

    def _draw(self, width: float, tables: list[Floats]) -> None:
        """The kernels against the angle, at a mean distance."""
        apart = 2 - 2 * np.cos(np.radians(FINE))  # |n_i - n_j|^2
        curves = {GAUSSIAN: (FINE, gaussian(apart, width))}
        near = int(np.argmin(np.abs(kernel_table.DISTANCES - 1)))
        by_name = {TABLE: tables[0]} | ({LAST: tables[-1]} if len(tables) > 1 else {})
        for name, table in by_name.items():
            weight = table.reshape(len(kernel_table.ANGLES), -1)[:, near]
            curves[name] = (kernel_table.ANGLES, weight / (np.abs(weight).max() or 1.0))
        self.plots[0].draw(curves, colors=COLORS, x_range=(0, 180))
