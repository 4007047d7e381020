"""One vertex and its neighbours: what the three weights make of them."""

from __future__ import annotations

from typing import Any

import ipywidgets as widgets
import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from meshfair import noise
from meshfair.checks import Booleans, Floats, Integers, check_choice, check_mesh
from meshfair.explorers.controls import choice, size_slider, slider
from meshfair.explorers.curves import CurvePlot
from meshfair.explorers.explorer import Explorer, Settings
from meshfair.explorers.solids import Solids
from meshfair.explorers.worker import Job
from meshfair.mesh import mean_edge_length, vertex_normals
from meshfair.operators import averaging
from meshfair.plotting import WEIGHT_COLORS
from meshfair.viewer import View
from meshfair.weights import BY_NAME

RINGS = 2  # of faces around the vertex that are shown of the neighbourhood
ARROW = (0.1, 0.6, 0.25)  # its colour and that of both its ends, which no weight has
CLOSE, WHOLE = "the neighbourhood", "the whole mesh"
THINNEST, THICKEST = 0.02, 0.14  # radii of the edges, in mean edge lengths
RIM = 0.012  # and of those around


class NeighbourhoodExplorer(Explorer):
    """A vertex, its neighbours and their weighted mean, with the three weights side by side.

    A click on a mesh chooses the vertex. Its edges are the thicker, and the more deeply
    coloured, the larger their normalised weights w~_ij are; an arrow leads to the weighted
    mean, and the slider moves the vertex there. The faces between them are left out, so that
    the arrow can be seen.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        The ground truth.
    F : array_like of integers, shape (m, 3)
    size : float
        First size of the noise along the normals, in mean edge lengths.
    seed : int
        Of the noise.
    vertex : int, optional
        Which vertex is shown first; by default one with a negative cotangent weight.

    Attributes
    ----------
    weights : dict of str to ndarray
        The normalised weights of the neighbours, by the name of the weights.
    neighbours : ndarray of int64
        Their numbers, counter-clockwise.
    """

    main = "part"

    def __init__(
        self,
        V: ArrayLike,
        F: ArrayLike,
        *,
        size: float = 0.4,
        seed: int = 1,
        vertex: int | None = None,
    ) -> None:
        super().__init__()
        V, F = self._mesh = check_mesh(V, F)
        self._seed, self._edge = seed, mean_edge_length(V, F)
        self._noisy: tuple[float, Floats, dict[str, csr_array]] | None = None
        self._aimed: tuple[Any, ...] | None = None
        self._owner: Integers = np.arange(len(V))
        self.neighbours: Integers = np.zeros(0, dtype=np.int64)
        self.weights: dict[str, Floats] = {}
        if vertex is None:
            vertex = self._telling(size)
        check_choice(vertex, "vertex", range(len(V)))
        part = slider(
            widgets.FloatSlider,
            "part of the way",
            "How far the vertex has gone to the weighted mean: the time step τ",
            value=0.0,
            ends=(0.0, 1.0),
            step=0.05,
        )
        self.controls = {
            "vertex": slider(
                widgets.IntSlider,
                "vertex",
                "Its number; a click on a mesh chooses it, too",
                value=vertex,
                ends=(0, len(V) - 1),
                step=1,
            ),
            "size": size_slider(size),
            "look": choice("look at", [CLOSE, WHOLE], CLOSE, "What fills the view"),
            "part": part,
        }
        self.view = View([V] * 3, F, titles=list(BY_NAME))
        self.view.none = ARROW
        self.view.on_pick(self._picked)
        self.plots = [
            CurvePlot(
                title="Normalised weights of the neighbours",
                x_label="neighbour, counter-clockwise",
                y_label="w̃_ij",
            )
        ]
        self.move_button = widgets.Button(
            description="move it there",
            icon="arrow-right",
            tooltip="Move the vertex to the weighted mean, or back",
        )
        self.move_button.on_click(lambda _: self._move())
        self._begin(along=[part, self.move_button])

    def _telling(self, size: float) -> int:
        """A vertex with a negative cotangent weight, neither the most nor the least of them."""
        least = self._operators(size)[1]["cotangent"].min(axis=1).toarray().ravel()
        negative = np.flatnonzero(least < 0)
        return (
            int(negative[np.argsort(least[negative])[len(negative) // 4]]) if len(negative) else 0
        )

    def _operators(self, size: float) -> tuple[Floats, dict[str, csr_array]]:
        """The noisy mesh and its averaging operators."""
        if self._noisy is None or self._noisy[0] != size:
            V, F = self._mesh
            rng = np.random.default_rng(self._seed)
            V_noisy = noise.add(V, F, "normals", rng, size=size)
            operators = {name: averaging(build(V_noisy, F)) for name, build in BY_NAME.items()}
            self._noisy = (size, V_noisy, operators)
        return self._noisy[1:]

    def _work(self, job: Job, settings: Settings) -> None:
        i, part = settings["vertex"], settings["part"]
        V, operators = self._operators(settings["size"])
        F = self._mesh[1]
        around = (F == i).any(axis=1)
        near = self._near(F, i) if settings["look"] == CLOSE else np.ones(len(F), dtype=bool)
        rows = {name: A[[i]].toarray().ravel() for name, A in operators.items()}
        self.neighbours = self._ordered(V, i, np.setdiff1d(F[around], i))
        self.weights = {name: row[self.neighbours] for name, row in rows.items()}
        end = max([0.1, *(float(np.abs(w).max(initial=0)) for w in self.weights.values())])
        with self.view.together():
            self.view.color_by("normalised weight w̃_ij", (-end, end), "coolwarm")
            self._aim(V[np.unique(F[near])], V, i, settings)
            for panel, (name, w) in enumerate(self.weights.items()):
                mean = w @ V[self.neighbours] if len(w) else V[i]
                drawn = self._drawn(V, F[near & ~around], F[around], i, w / end, end, mean, part)
                away = float(np.linalg.norm(mean - V[i])) / self._edge
                negative = int(np.count_nonzero(w < 0))
                title = f"{name}: mean {away:.2f} edges away"
                if negative:
                    title += f", {negative} w < 0"
                V_drawn, F_drawn, values, self._owner = drawn
                self.view.update(V_drawn, panel=panel, F=F_drawn, values=values, title=title)
        shift = dict(zip(BY_NAME, (-0.12, 0.0, 0.12), strict=True))
        places = 1 + np.arange(len(self.neighbours))
        self.plots[0].draw(
            {name: (places + shift[name], w) for name, w in self.weights.items()},
            points=True,
            colors=WEIGHT_COLORS,
            x_range=(0.5, len(places) + 0.5),
        )
        count = len(self.neighbours)
        self.say(
            f"vertex {i} has {count} neighbours: {', '.join(map(str, self.neighbours))}"
            if count
            else f"vertex {i} has no neighbours"
        )

    def _drawn(
        self,
        V: Floats,
        others: Integers,
        around: Integers,
        i: int,
        strength: Floats,
        end: float,
        mean: Floats,
        part: float,
    ) -> tuple[Floats, Integers, Floats, Integers]:
        """Other faces than those around the vertex, and what is to be seen of it instead."""
        h, here = self._edge, V[i] + part * (mean - V[i])
        solids = Solids(V, others)
        for face in around:
            a, b = face[face != i]
            solids.bar(V[a], V[b], RIM * h, 0.0, int(a))
        for j, s in zip(self.neighbours, strength, strict=True):
            radius = h * (THINNEST + (THICKEST - THINNEST) * abs(s))
            solids.bar(here, V[j], radius, s * end, int(j))
            solids.ball(V[j], max(radius, 0.06 * h), s * end, int(j))
        solids.ball(here, 0.12 * h, np.nan, i)
        solids.arrow(here, mean, 0.05 * h, np.nan, i)
        solids.ball(mean, 0.07 * h, np.nan, i)
        return solids.mesh()

    def _ordered(self, V: Floats, i: int, neighbours: Integers) -> Integers:
        """Neighbours counter-clockwise, as seen from outside."""
        normal = vertex_normals(V, self._mesh[1])[i]
        u = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
        edges = V[neighbours] - V[i]
        angles = np.arctan2(edges @ np.cross(normal, u), edges @ u)
        return neighbours[np.argsort(angles)]

    def _near(self, F: Integers, i: int) -> Booleans:
        """Which faces are near a vertex: what else there is might stand before it."""
        inside = np.zeros(len(self._mesh[0]), dtype=bool)
        inside[i] = True
        for _ in range(RINGS):
            inside[F[inside[F].any(axis=1)]] = True
        return np.asarray(inside[F].all(axis=1))

    def _aim(self, shown: Floats, V: Floats, i: int, settings: Settings) -> None:
        """Look at the vertex from its side, where it is another one than before."""
        wanted = (settings["look"], i) if settings["look"] == CLOSE else (settings["look"],)
        if wanted == self._aimed:
            self.view.refit(shown)
            return
        self._aimed = wanted
        if settings["look"] == WHOLE:
            self.view.look_at(shown, self.view.direction)
            return
        normal = vertex_normals(self._mesh[0], self._mesh[1])[i]
        if not normal.any():
            normal = self.view.direction
        side = np.cross(self.view.up, normal)
        if np.linalg.norm(side) < 0.1:
            side = np.cross((1.0, 0.0, 0.0), normal)
        self.view.look_at(shown, normal + 0.9 * side / np.linalg.norm(side))

    def _picked(self, panel: int, vertex: int) -> None:
        self.controls["vertex"].value = int(self._owner[vertex])

    def _move(self) -> None:
        """Move the vertex all the way, or back where it came from."""
        part = self.controls["part"]
        part.value = 1.0 if part.value < 1 else 0.0
