"""Any method on any of several meshes: what it makes of the noise, by eye and by numbers."""

import html
import time

from meshfair import denoising
from meshfair.checks import check_mesh
from meshfair.experiments.cases import add_noise
from meshfair.explorers.chart import Chart
from meshfair.explorers.explorer import Explorer, choice, size_slider, widgets
from meshfair.explorers.latest import Job, Obsolete
from meshfair.metrics import compare
from meshfair.viewer import View, colouring

# The colour bar has the same ends for all methods, so that their colours can be compared.
ANGLES = (0.0, 30.0)

# What the table says of each number of `metrics.compare`: its name, and how to write it.
COLUMNS = {
    "snr": ("SNR", "{:.2f} dB"),
    "normal_angle": ("mean normal angle", "{:.2f}°"),
    "surface_distance": ("mean distance to the clean surface", "{:.3f} edges"),
    "hausdorff": ("Hausdorff distance", "{:.3f} edges"),
    "volume_change": ("change of volume", "{:+.2%}"),
    "area_change": ("change of area", "{:+.2%}"),
}


CELL = 'style="padding:0 0 0 1.5em;text-align:right;font-variant-numeric:tabular-nums"'


class FilterExplorer(Explorer):
    """Every method that `meshfair.denoise` knows, on meshes to choose from.

    Parameters
    ----------
    meshes : dict of str to (V, F)
        Clean meshes by name; the first is shown first.
    method : str
        First method, see `meshfair.denoising.methods`.
    size : float
        First size of the noise along the normals, in mean edge lengths.
    seed : int
        Of the noise.

    Attributes
    ----------
    result : meshfair.denoising.Denoised or None
        What is shown.
    """

    def __init__(self, meshes, *, method="bilateral-normal", size=0.2, seed=1):
        super().__init__()
        self._meshes = {name: check_mesh(*mesh) for name, mesh in meshes.items()}
        self._seed = seed
        self._noisy = (None, None)  # mesh and size, and what they gave
        self._shown = None  # the name of the mesh in the panels
        self.result = None
        first = next(iter(self._meshes))
        self.controls = {
            "mesh": choice("mesh", self._meshes, first, "What is made noisy and denoised"),
            "method": choice(
                "method", denoising.methods(), method, "The filter, by its name in denoise"
            ),
            "parameters": choice(
                "parameters", ["default", "auto"], "default",
                "The method's own, or those whose estimated risk is smallest",
            ),
            "size": size_slider(size),
        }  # fmt: skip
        V, F = self._meshes[first]
        self.view = View(
            [V] * 3,
            F,
            titles=["noisy", "denoised", ""],
            label="angle to the clean normals (degrees)",
            limits=ANGLES,
        )
        self.charts = [
            Chart(
                title="Mean normal angle of the denoised mesh",
                x_label="iteration",
                y_label="degrees",
            ),
            Chart(title="SNR of the denoised mesh", x_label="iteration", y_label="dB"),
        ]
        self.table = widgets.HTML()
        # Some methods take seconds: the progress stands where the choice was made.
        self._begin(extra=[self._busy])
        view, row, _ = self.widget.children
        self.widget.children = (view, row, self._note, self.table)

    def _work(self, job, settings):
        V, F = self._meshes[settings["mesh"]]
        V_noisy, before = self._start(settings)
        # Slow work shows its noisy mesh meanwhile; quick work does not flicker.
        interim = time.monotonic() + Job.PATIENCE
        waiting = self._shown != (settings["mesh"], settings["size"])

        def go_on(done):
            nonlocal waiting
            if waiting and time.monotonic() > interim:
                waiting = False
                self._show(settings, V_noisy, V_noisy, before, f"{settings['method']}: at work")
                self._tell({"noisy": before})
            try:
                job.progress(done)
            except Obsolete:
                return False

        result = denoising.denoise(
            V_noisy,
            F,
            settings["method"],
            parameters=settings["parameters"],
            ground_truth=V,
            callback=go_on,
        )
        if not result.finished and settings != self.settings():
            raise Obsolete  # a new choice, and not the button
        self.result = result
        after = compare(result.V, F, V, F)
        method = settings["method"] if result.finished else f"{settings['method']}, cancelled"
        self._show(
            settings,
            V_noisy,
            result.V,
            before,
            f"{method}: {after['snr']:.2f} dB, {after['normal_angle']:.2f}°",
        )
        self._tell({"noisy": before, "denoised": after}, result)

    def _start(self, settings):
        """The noisy mesh that the settings ask for, and its metrics."""
        key = settings["mesh"], settings["size"]
        if self._noisy[0] != key:
            V, F = self._meshes[settings["mesh"]]
            V_noisy = add_noise(V, F, "normals", self._seed, size=settings["size"])
            self._noisy = (key, (V_noisy, compare(V_noisy, F, V, F)))
        return self._noisy[1]

    def _show(self, settings, V_noisy, V_new, before, title):
        V, F = self._meshes[settings["mesh"]]
        with self.view.together():
            if self._shown is not None and self._shown[0] != settings["mesh"]:
                self.view.look_at(V)
            self._shown = settings["mesh"], settings["size"]
            noisy = f"noisy: {before['snr']:.2f} dB, {before['normal_angle']:.2f}°"
            self.view.update(V_noisy, panel=0, F=F, title=noisy)
            self.view.update(V_new, panel=1, F=F, title=title)
            angles = colouring.normal_angle(V, F)(V_new)
            self.view.update(V_new, panel=2, F=F, values=angles, title="where its normals are off")

    def _tell(self, compared, result=None):
        """Show the metrics of some meshes by name, and what a result has to say of itself."""
        self.table.value = _table(compared)
        self.say(_used(result) if result else "")
        for chart, column in zip(self.charts, ("normal_angle", "snr"), strict=True):
            if result is None:
                chart.marker = None
                chart.draw({})
                continue
            iteration = result.history["iteration"]
            last = int(iteration.iloc[-1])
            chart.draw({column: (iteration, result.history[column])}, x_range=(0, max(last, 1)))
            chart.marker = last


def _used(result):
    """One line on what was done: parameters, and time."""
    used = {name: value for name, value in result.parameters.items() if name != "fixed"}
    written = ", ".join(
        f"{name} = {value:.3g}" if isinstance(value, float) else f"{name} = {value}"
        for name, value in used.items()
    )
    return f"{result.method} with {written or 'no parameters'}; {result.seconds:.2f} s"


def _table(compared):
    """The metrics of meshes by name, as HTML: a row for each."""

    def row(tag, name, texts):
        cells = "".join(f"<{tag} {CELL}>{html.escape(text)}</{tag}>" for text in texts)
        return f'<tr><th style="text-align:left">{name}</th>{cells}</tr>'

    rows = [row("th", "", (name for name, _ in COLUMNS.values()))]
    for name, numbers in compared.items():
        known = {key: numbers[key] for key in COLUMNS}
        texts = (
            "unknown" if number is None else COLUMNS[key][1].format(number)
            for key, number in known.items()
        )
        rows.append(row("td", name, texts))
    return f'<table style="border-collapse:collapse;line-height:1.5">{"".join(rows)}</table>'
