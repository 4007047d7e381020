"""The meshes that any filter goes through, with a slider along them."""

from __future__ import annotations

from collections.abc import Iterable

import ipywidgets as widgets
import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import Floats, MeshError, check_mesh, check_vertices
from meshfair.explorers.controls import slider
from meshfair.explorers.curves import CurvePlot
from meshfair.explorers.explorer import Explorer, Settings
from meshfair.explorers.framing import Frame
from meshfair.explorers.worker import Job
from meshfair.metrics import normal_angle
from meshfair.viewer import View


class IterationExplorer(Explorer):
    """A mesh at the iterations of a filter, of the package or of one's own.

    Parameters
    ----------
    states : iterable of array_like, shape (n, 3)
        The positions before the first iteration, after it, and so on, such as what the
        functions of `meshfair.filters` yield. Of equal ones in a row, the first is kept.
    F : array_like of integers, shape (m, 3)
    ground_truth : array_like, shape (n, 3), optional
        With it, a curve shows the mean angle to its normals.

    Attributes
    ----------
    states : list of ndarray, shape (n, 3)
        What the slider goes through.

    Raises
    ------
    MeshError
        No states, or positions that are no mesh with F, or not those of the ground truth's
        vertices; the message says which.
    """

    def __init__(
        self,
        states: Iterable[ArrayLike],
        F: ArrayLike,
        *,
        ground_truth: ArrayLike | None = None,
    ) -> None:
        super().__init__()
        self.states: list[Floats] = []
        for k, given in enumerate(states):
            V = check_vertices(given, f"state {k}")
            if not self.states or not np.array_equal(V, self.states[-1]):
                self.states.append(V.copy())
        if not self.states:
            raise MeshError("states is empty; give the positions before the first iteration")
        _, self._F = check_mesh(self.states[0], F)
        for k, V in enumerate(self.states):
            if len(V) != len(self.states[0]):
                raise MeshError(
                    f"state {k} has {len(V)} vertices, state 0 has {len(self.states[0])}; "
                    "give positions of the same vertices"
                )
        last = len(self.states) - 1
        self.controls = {
            "iteration": slider(
                widgets.IntSlider,
                "iteration",
                "After how many iterations the mesh is shown",
                value=last,
                ends=(0, last),
                step=1,
            )
        }
        self.view = View(self.states[0], self._F, titles=[""])
        self._frame = Frame(self.view, [self.states[-1], self.states[0]], self._F)
        self._angles: list[float] = []
        self.plots = []
        if ground_truth is not None:
            self._angles = [normal_angle(ground_truth, V, self._F) for V in self.states]
            curve = CurvePlot(
                title="Mean angle to the true normals", x_label="iteration", y_label="degrees"
            )
            curve.draw({"": (np.arange(last + 1), self._angles)}, x_range=(0, max(last, 1)))
            curve.observe(self._picked, names="picked")
            self.plots = [curve]
        iteration = self.controls["iteration"]
        play = widgets.Play(min=0, max=last, interval=150, show_repeat=True)
        widgets.jslink((iteration, "value"), (play, "value"))
        self._begin(along=[play, iteration])

    def _picked(self, change: dict[str, float]) -> None:
        """Go to the iteration at which the reader clicked in the plot."""
        last = len(self.states) - 1
        self.controls["iteration"].value = min(max(round(change["new"]), 0), last)

    def _work(self, job: Job, settings: Settings) -> None:
        k = settings["iteration"]
        V_drawn, remark = self._frame.drawn(self.states[k])
        title = f"iteration {k}"
        if self._angles:
            title += f": {self._angles[k]:.1f}°"
            self.plots[0].marker = k
        self.view.update(V_drawn, title=title + remark)
