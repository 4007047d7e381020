"""A kernel that is learned from one mesh and tried on another, beside the Gaussian one."""

from __future__ import annotations

from collections.abc import Mapping

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
from meshfair.plotting import OTHER_COLORS
from meshfair.viewer import View, coloring

ANGLES = (0.0, 30.0)  # ends of the colour bar, the same for all panels
OTHERS = "all others"
FINE = np.linspace(0, 180, 91)  # degrees at which the Gaussian is drawn
GAUSSIAN, TABLE, LAST = "Gaussian", "table", "table, last pass"
VERTEX_ITERATIONS = 20
COLORS = dict(zip((TABLE, GAUSSIAN, LAST), OTHER_COLORS, strict=False))
# The noise that is learned from is another draw than the one that is denoised.
LEARNED, TRIED = 1, 2


class Tried:
    """A noisy mesh after any number of passes, each computed once.

    Parameters
    ----------
    V_noisy : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    """

    def __init__(self, V_noisy: Floats, F: Integers) -> None:
        self.V_noisy, self._F = V_noisy, F
        self._gaussian: dict[tuple[float, int], Floats] = {}
        self._tables: list[Floats] = []

    def use(self, tables: list[Floats]) -> None:
        """Filter with other tables, if they are others."""
        if self._tables is not tables:
            self._tables = tables
            self._normals = kernel_table.normals_by_tables(self.V_noisy, self._F, tables)
            self._by_table: dict[int, Floats] = {}

    def by_table(self, count: int) -> Floats:
        """Positions after this many passes with the tables."""
        if count not in self._by_table:
            N = self._normals[count]
            found = kernel_table.fit_vertices(self.V_noisy, self._F, N, VERTEX_ITERATIONS)
            self._by_table[count] = found
        return self._by_table[count]

    def by_gaussian(self, width: float, count: int) -> Floats:
        """Positions after this many passes of the package's own filter."""
        if (width, count) not in self._gaussian:
            *_, (_, found) = filters.bilateral_normal(
                self.V_noisy,
                self._F,
                sigma_normal=width,
                normal_iterations=count,
                vertex_iterations=VERTEX_ITERATIONS,
            )
            self._gaussian[width, count] = found
        return self._gaussian[width, count]


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

    main = "passes"

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
        self._tried: tuple[tuple[str, float], Tried] | None = None
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
        tables = self._learn(job, settings)
        tried = self._try(settings, tables)
        width, passes = settings["width"], settings["passes"]
        after = {
            GAUSSIAN: lambda count: tried.by_gaussian(width, count),
            TABLE: lambda count: tried.by_table(count),
        }
        found = {name: state(passes) for name, state in after.items()}
        job.progress(0.7)
        self._show(settings["test"], {"noisy": tried.V_noisy} | found)
        self._draw(width, tables[:passes])
        errors: dict[str, list[float]] = {name: [] for name in after}
        for count in range(passes + 1):  # what the charts need is less urgent than the meshes
            for name, state in after.items():
                errors[name].append(normal_angle(state(count), V, F))
            job.progress(0.7 + 0.3 * (count + 1) / (passes + 1))
        most = max(max(angles) for angles in errors.values())
        self.plots[1].draw(
            {name: (np.arange(passes + 1), angles) for name, angles in errors.items()},
            colors=COLORS,
            x_range=(0, passes),
            y_range=(0, 1.05 * most or 1),
        )

    def _try(self, settings: Settings, tables: list[Floats]) -> Tried:
        """The mesh that is denoised, with what is known of it from before."""
        key = settings["test"], settings["size"]
        if self._tried is None or self._tried[0] != key:
            F = self._meshes[settings["test"]][1]
            self._tried = key, Tried(self._noisy(*key, TRIED), F)
        tried = self._tried[1]
        tried.use(tables)
        return tried

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
        values = [color(X) for X in states.values()]
        angles = [normal_angle(X, V, F) for X in states.values()]
        frame = Frame(self.view, [V, states["noisy"]], F)
        with self.view.together():
            if self._shown != name:
                self.view.look_at(frame.V)
                self._shown = name
            else:
                self.view.refit(frame.V)
            for panel, (title, X) in enumerate(states.items()):
                drawn, remark = frame.drawn(X)
                title = f"{title}: {angles[panel]:.1f}°{remark}"
                self.view.update(drawn, panel=panel, F=F, values=values[panel], title=title)

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
