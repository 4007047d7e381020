"""Any method on any of several meshes: what it makes of the noise, by eye and by numbers."""

from __future__ import annotations

import html
import time
from collections.abc import Iterable, Mapping

import ipywidgets as widgets
import numpy as np
from numpy.typing import ArrayLike

from meshfair import denoising
from meshfair.checks import Floats, check_mesh
from meshfair.explorers import worker
from meshfair.explorers.controls import NOISES, choice, noise_choice, size_slider, slider
from meshfair.explorers.curves import CurvePlot
from meshfair.explorers.explorer import Explorer, Settings
from meshfair.explorers.framing import Frame
from meshfair.explorers.noises import noisy
from meshfair.metrics import Measure, compare
from meshfair.viewer import View, coloring

Metrics = dict[str, Measure]
NoisyMesh = tuple[str, str, float]

# The colour bar has the same ends for all methods, so that their colours can be compared.
ANGLES = (0.0, 30.0)

# What the table says of each number of `metrics.compare`: its name, and how to write it.
COLUMNS = {
    "snr": ("SNR", "{:.2f} dB"),
    "normal_angle": ("mean normal angle", "{:.2f}°"),
    "surface_distance": ("mean distance of the surfaces", "{:.3f} edges"),
    "hausdorff": ("Hausdorff distance", "{:.3f} edges"),
    "volume_change": ("change of volume", "{:+.2%}"),
    "area_change": ("change of area", "{:+.2%}"),
}
CELL = 'style="padding:0 0 0 1.5em;text-align:right;font-variant-numeric:tabular-nums"'


class FilterExplorer(Explorer):
    """Every method that `meshfair.denoise` knows, and its own choice, on meshes to choose from.

    Parameters
    ----------
    meshes : dict of str to (V, F)
        Ground truths by name; the first is shown first.
    method : str
        First method, see `meshfair.denoising.methods`; or "auto".
    size : float
        First size of the noise, in mean edge lengths.
    seed : int
        Of the noise.

    Attributes
    ----------
    result : meshfair.denoising.Denoised or None
        What is shown.
    """

    main = "method"

    def __init__(
        self,
        meshes: Mapping[str, tuple[ArrayLike, ArrayLike]],
        *,
        method: str = "bilateral-normal",
        size: float = 0.2,
        seed: int = 1,
    ) -> None:
        super().__init__()
        self._meshes = {name: check_mesh(*mesh) for name, mesh in meshes.items()}
        self._seed = seed
        # Mesh, noise and its size: what they gave, and which are in the panels.
        self._noisy: tuple[NoisyMesh, Floats, Metrics] | None = None
        self._shown: NoisyMesh | None = None
        self.result: denoising.Denoised | None = None
        first = next(iter(self._meshes))
        self.controls = {
            "mesh": choice("mesh", self._meshes, first, "What is made noisy and denoised"),
            "method": choice(
                "method",
                [*denoising.methods(), denoising.DEFAULT],
                method,
                "The filter, by its name in denoise; auto looks at the mesh, and chooses one",
            ),
            "parameters": choice(
                "parameters",
                ["default", "auto"],
                "default",
                "The method's own, or those that promise to leave the least error",
            ),
            "strength": slider(
                widgets.FloatSlider,
                "strength",
                "The part of the way to the filter's result: less keeps more detail, and noise; "
                "at 1, auto may choose less",
                value=1.0,
                ends=(0.05, 1.0),  # at 0 there is nothing to see
                step=0.05,
            ),
            "noise": noise_choice(NOISES, "normals", "How the vertices are moved"),
            "size": size_slider(size, any_model=True),
        }
        V, F = self._meshes[first]
        self.view = View(
            [V] * 3,
            F,
            titles=["noisy", "denoised", ""],
            label="angle to the true normals (degrees)",
            limits=ANGLES,
        )
        self.plots = [
            CurvePlot(
                title="Mean normal angle of the denoised mesh",
                x_label="iteration",
                y_label="degrees",
            ),
            CurvePlot(title="SNR of the denoised mesh", x_label="iteration", y_label="dB"),
        ]
        self.table = widgets.HTML()
        self._begin(below=[self.table])

    def _work(self, job: worker.Job, settings: Settings) -> None:
        V, F = self._meshes[settings["mesh"]]
        V_noisy, before = self._start(settings)
        # Slow work shows its noisy mesh meanwhile; quick work does not flicker.
        interim = time.monotonic() + worker.DELAY
        waiting = self._shown != _noisy_mesh(settings)

        def go_on(done: float) -> bool | None:
            nonlocal waiting
            if waiting and time.monotonic() > interim:
                waiting = False
                self._show(settings, V_noisy, f"{settings['method']}: at work")
                self._show_metrics({"noisy": before})
            try:
                job.progress(done)
            except worker.Cancelled:
                return False
            return None

        part = {} if settings["strength"] == 1 else {"strength": settings["strength"]}
        result = denoising.denoise(
            V_noisy,
            F,
            settings["method"],
            parameters=settings["parameters"],
            ground_truth=V,
            callback=go_on,
            **part,
        )
        if not result.finished and settings != self.settings():
            raise worker.Cancelled  # by a new choice, and not by the button
        self.result = result
        after = compare(result.V, F, V, F)
        title = [settings["method"]]
        if settings["method"] == denoising.DEFAULT and result.finished:
            left = np.array_equal(result.V, V_noisy)
            title.append("left as it is" if left else result.method)
        title += [] if result.finished else ["cancelled"]
        self._show(settings, result.V, f"{', '.join(title)}: {_summary(after)}")
        self._show_metrics({"noisy": before, "denoised": after}, result)

    def _start(self, settings: Settings) -> tuple[Floats, Metrics]:
        """The noisy mesh that the settings ask for, and its metrics."""
        key = _noisy_mesh(settings)
        if self._noisy is None or self._noisy[0] != key:
            V, F = self._meshes[settings["mesh"]]
            V_noisy = noisy(V, F, settings["noise"], settings["size"], self._seed)
            self._noisy = (key, V_noisy, compare(V_noisy, F, V, F))
        return self._noisy[1:]

    def _show(self, settings: Settings, V_new: Floats, title: str) -> None:
        """Show the noisy mesh beside a new one, in its own look and coloured by its errors."""
        V, F = self._meshes[settings["mesh"]]
        V_noisy, before = self._start(settings)
        angles = coloring.normal_angle(V, F)(V_new)
        frame = Frame(self.view, [V, V_noisy], F)
        with self.view.together():
            if self._shown is not None and self._shown[0] != settings["mesh"]:
                self.view.look_at(frame.V)
            else:
                self.view.refit(frame.V)
            self._shown = _noisy_mesh(settings)
            V_drawn, remark = frame.drawn(V_new)
            self.view.update(V_noisy, panel=0, F=F, title=f"noisy: {_summary(before)}")
            self.view.update(V_drawn, panel=1, F=F, title=title + remark)
            self.view.update(
                V_drawn, panel=2, F=F, values=angles, title="where its normals are off"
            )

    def _show_metrics(
        self, compared: dict[str, Metrics], result: denoising.Denoised | None = None
    ) -> None:
        """Show the metrics of some meshes by name, and how a result came about."""
        self.table.value = _table(compared)
        self.say(_used(result) if result else "")
        for plot, column in zip(self.plots, ("normal_angle", "snr"), strict=True):
            if result is None or result.history is None:
                plot.marker = None
                plot.draw({})
                continue
            iteration = result.history["iteration"]
            last = int(iteration.iloc[-1])
            plot.draw({column: (iteration, result.history[column])}, x_range=(0, max(last, 1)))
            plot.marker = last


def _noisy_mesh(settings: Settings) -> NoisyMesh:
    """The mesh, the noise and its size, which tell one noisy mesh from another."""
    return settings["mesh"], settings["noise"], settings["size"]


def _written(column: str, numbers: Metrics) -> str:
    """One of the metrics in words."""
    value = numbers[column].value
    return "none" if value is None else COLUMNS[column][1].format(value).replace("inf", "∞")


def _summary(numbers: Metrics) -> str:
    """SNR and normal angle, for a panel's title."""
    return f"{_written('snr', numbers)}, {_written('normal_angle', numbers)}"


def _used(result: denoising.Denoised) -> str:
    """One line on what was done: parameters, time, and why, where something was chosen."""
    used = {name: value for name, value in result.parameters.items() if name != "fixed"}
    written = ", ".join(
        f"{name} = {value:.3g}" if isinstance(value, float) else f"{name} = {value}"
        for name, value in used.items()
    )
    done = f"{result.method} with {written or 'no parameters'}; {result.seconds:.2f} s"
    return f"{done}; {result.reason}" if result.reason else done


def _table(compared: dict[str, Metrics]) -> str:
    """The metrics of meshes by name, as HTML: a row for each, why one is missing as its title."""

    def row(tag: str, name: str, texts: Iterable[tuple[str, str]]) -> str:
        cells = "".join(
            f'<{tag} {CELL} title="{html.escape(why)}">{html.escape(text)}</{tag}>'
            for text, why in texts
        )
        return f'<tr><th style="text-align:left">{name}</th>{cells}</tr>'

    rows = [row("th", "", ((name, "") for name, _ in COLUMNS.values()))]
    for name, numbers in compared.items():
        texts = ((_written(column, numbers), numbers[column].reason) for column in COLUMNS)
        rows.append(row("td", name, texts))
    return f'<table style="border-collapse:collapse;line-height:1.5">{"".join(rows)}</table>'
