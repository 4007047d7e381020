"""The report's pictures of meshes: name -> function(folder, data) that draws them.

They are PNG files, all of one wall from one camera and cropped alike.
"""

import json
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from PIL import Image

from meshfair import denoising, experiments, flow, plotting
from meshfair.checks import Booleans, Floats, Integers
from meshfair.experiments import load_mesh, load_noisy_mesh, noisy_pair
from meshfair.experiments.original import F16_DECIBELS, TAU, TIME
from meshfair.mesh import cluster, inspect, repair, unique_faces
from meshfair.metrics import normal_angles
from meshfair.operators import averaging
from meshfair.shapes import jet_parts
from meshfair.viewer import CMAPS, Camera, render
from meshfair.viewer.coloring import displacement
from meshfair.weights import BY_NAME
from tables import BUNNY_STEPS, JET_NOISE, JET_TIMES, QUALITY_NOISE, SEED

Tables = dict[str, pd.DataFrame]

PIXELS = (1000, 750)
WIDE = (1400, 700)
LOW = (1400, 670)
ERRORS = "viridis"
ANGLES = "reds"


class Wall:
    """Meshes from one camera, saved as PNG files when all are there: cropped to what is drawn."""

    def __init__(self, folder: Path, camera: Camera, size: tuple[int, int] = PIXELS) -> None:
        self.folder, self.camera, self.size = folder, camera, size
        self.pictures: dict[str, Any] = {}

    def hang(self, name: str, V: Floats, F: Integers, **options: Any) -> None:
        """Draw one more mesh."""
        self.pictures[name] = render(V, F, self.camera, size=self.size, **options)

    def save(self) -> None:
        """Crop all pictures alike, and write them."""
        drawn = np.any([picture[..., 3] > 0 for picture in self.pictures.values()], axis=0)
        rows, columns = (np.flatnonzero(drawn.any(axis=axis)) for axis in (1, 0))
        for name, picture in self.pictures.items():
            cropped = picture[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
            Image.fromarray(np.ascontiguousarray(cropped)).save(self.folder / f"{name}.png")


def colour_bar(
    path: Path, limits: tuple[float, float], label: str, cmap: str = ERRORS, width: float = 4.0
) -> None:
    """A colour bar of its own, to stand beside meshes; ``cmap`` as Polyscope has it."""
    with plotting.figure(path, (width, 0.58)) as axes:
        axes.imshow(
            np.linspace(0, 1, 256)[None],
            aspect="auto",
            extent=(*limits, 0, 1),
            cmap=CMAPS[cmap],
        )
        axes.set(yticks=[], xlabel=label)
        axes.grid(False)


def knot_meshes(folder: Path, _: Tables) -> None:
    """Figures 2 and 4: the knot, noisy, and after one and ten iterations."""
    V, F = load_mesh("knot")
    meshes = experiments.knot_meshes(SEED, iterations=(1, 10))
    error = displacement(V, F)
    in_view = np.concatenate([V, meshes["noisy", 0]])
    camera = Camera.around(in_view, (0.35, -1.0, 0.45))
    limits = (0.0, 2.0)
    plain, coloured = Wall(folder, camera), Wall(folder, camera)
    plain.hang("knot-clean", V, F)
    for (name, iterations), V_now in meshes.items():
        if iterations < 10:
            plain.hang(f"knot-{name}-{iterations}", V_now, F)
        else:
            coloured.hang(
                f"knot-{name}-{iterations}-error", V_now, F,
                values=error(V_now), limits=limits, cmap=ERRORS, smooth=True,
            )  # fmt: skip
    plain.save()
    coloured.save()
    colour_bar(
        folder / "knot-errors.svg", limits, "distance from the ground truth, in mean edge lengths"
    )


JET_CAMERA: dict[str, Any] = {"direction": (0.75, 0.85, 0.5), "aspect": 2.0}
MISSILE_CAMERA: dict[str, Any] = {"direction": (0.9, 1.0, 0.45), "margin": 0.0}
MISSILES_IN_VIEW = ("tip missile left", "outer missile left")


def jet_states(
    name: str, times: tuple[float, ...]
) -> tuple[Floats, Integers, dict[tuple[str, float], Floats]]:
    """V, F, and {(weights, time): V} of the jet's heat flows; time 0 is the noisy mesh."""
    V_noisy, V, F = load_noisy_mesh(name, JET_NOISE["noise"], SEED, size=JET_NOISE["size"])
    states = {("noisy", 0.0): V_noisy}
    for kind, build in BY_NAME.items():
        for time, V_now in flow.heat(V_noisy, averaging(build(V_noisy, F)), TAU, max(times)):
            if time in times:
                states[kind, time] = V_now
    return V, F, states


def jet_meshes(folder: Path, _: Tables) -> None:
    """Figures 5 and 7: the jet with missiles under the flow, whole and close by."""
    V, F, states = jet_states("jet", tuple(JET_TIMES.values()))
    parts = jet_parts()
    in_view = np.concatenate([parts[name][0] for name in MISSILES_IN_VIEW])
    whole = Wall(folder, Camera.around(V, **JET_CAMERA), WIDE)
    close = Wall(folder, Camera.around(in_view, **MISSILE_CAMERA, aspect=LOW[0] / LOW[1]), LOW)
    named = {"clean": V, "noisy": states["noisy", 0.0]} | {
        f"{name}-{when}": states[name, time] for name in BY_NAME for when, time in JET_TIMES.items()
    }
    for name, V_now in named.items():
        whole.hang(f"jet-{name}", V_now, F)
        close.hang(f"missiles-{name}", V_now, F)
    whole.save()
    close.save()


def jet_without_missiles(folder: Path, data: Tables) -> None:
    """Figure 8: the jet without missiles, each weights at its best time."""
    table = data["jet_without_missiles"]
    best = table.loc[table.groupby("weights")["snr"].idxmax()].set_index("weights")["time"]
    V, F, states = jet_states("jet without missiles", tuple(best))
    wall = Wall(folder, Camera.around(V, **JET_CAMERA), WIDE)
    wall.hang("plain-noisy", states["noisy", 0.0], F)
    for name in BY_NAME:
        wall.hang(f"plain-{name}", states[name, best[name]], F)
    wall.save()


def f16_meshes(folder: Path, data: Tables) -> None:
    """The original report's own F-16, where it is downloaded."""
    if "f16" not in data:
        return
    V_noisy, V, F = load_noisy_mesh("f16", "uniform", SEED, decibels=F16_DECIBELS)
    in_view = np.concatenate([V, V_noisy])
    camera = Camera.around(in_view, (-0.75, 0.5, 0.85), up=(0, 1, 0), aspect=2.0)
    wall = Wall(folder, camera, WIDE)
    wall.hang("f16-clean", V, F)
    wall.hang("f16-noisy", V_noisy, F)
    for name in ("combinatorial", "cotangent"):
        A = averaging(BY_NAME[name](V_noisy, F))
        wall.hang(f"f16-{name}", dict(flow.heat(V_noisy, A, TAU, TIME))[TIME], F)
    wall.save()


def bunny_meshes(folder: Path, data: Tables) -> None:
    """The bunny at full resolution, where it is downloaded."""
    if "bunny" not in data:
        return
    V_noisy, V, F = load_noisy_mesh("bunny", "normals", SEED, size=0.2)
    camera = Camera.around(V[np.unique(F)], (0.1, 0.25, 1.0), up=(0, 1, 0), aspect=1.0)
    wall = Wall(folder, camera, (1200, 1200))
    wall.hang("bunny-clean", V, F)
    wall.hang("bunny-noisy", V_noisy, F)
    for name, build in BY_NAME.items():
        V_now = flow.average(V_noisy, averaging(build(V_noisy, F)), BUNNY_STEPS)
        wall.hang(f"bunny-{name}", V_now, F)
    wall.save()


def reduction(folder: Path, data: Tables) -> None:
    """The reduced knot's bad triangles, before and after the repair."""
    V, F = cluster(*load_mesh("fine knot"), data["reduction"]["cell"].max())
    camera = Camera.around(V, (0.35, -1.0, 0.45))
    split = repair(V, F, duplicates=True, split=True)
    wall = Wall(folder, camera)
    for name, X, T in (("reduced", V, F), ("split", split.V, split.F)):
        bad = bad_faces(X, T).astype(float)
        wall.hang(f"reduction-{name}", X, T, values=bad, limits=(0, 1), cmap="reds", edges=True)
    wall.save()


def bad_faces(V: Floats, F: Integers) -> Booleans:
    """Duplicate faces, and those with an edge that has more than two faces, each counted once."""
    F = np.sort(F, axis=1)
    stored = {found.kind: found.where for found in inspect(V, F).findings}
    once = {found.kind: found.where for found in inspect(V, unique_faces(F)).findings}
    duplicates = set(map(tuple, F[stored.get("duplicate_faces", [])].tolist()))
    crowded = set(map(tuple, once.get("nonmanifold_edges", np.empty((0, 2))).tolist()))
    return np.array(
        [
            tuple(face) in duplicates or not crowded.isdisjoint(combinations(face, 2))
            for face in F.tolist()
        ]
    )


GALLERIES: dict[str, dict[str, Any]] = {
    "jet": JET_CAMERA,
    "torus": {"direction": (0.3, -0.7, 0.75)},
}
GALLERY_ANGLES = (0.0, 30.0)


def gallery(folder: Path, data: Tables) -> None:
    """Every method with automatic parameters, coloured by the angle to the true normals."""
    table = data["quality"]
    for mesh in GALLERIES:
        rows = table[(table["mesh"] == mesh) & (table["parameters"] == "auto")]
        noisy, V, F = noisy_pair(mesh, QUALITY_NOISE, SEED)
        camera = Camera.around(np.concatenate([V, noisy]), **GALLERIES[mesh])
        wall = Wall(folder, camera, WIDE if GALLERIES[mesh].get("aspect") == 2.0 else PIXELS)
        results = {"none": noisy} | {
            row.method: denoising.denoise(noisy, F, row.method, **json.loads(row.used)).V
            for row in rows.itertuples()
        }
        for name, X in results.items():
            angles = normal_angles(X, V, F)
            wall.hang(
                f"gallery-{mesh}-{name}", X, F, values=angles, limits=GALLERY_ANGLES, cmap=ANGLES
            )
        wall.save()
    label = "angle to the true normal (degrees)"
    colour_bar(folder / "gallery-angles.svg", GALLERY_ANGLES, label, ANGLES, width=2.4)


PICTURES = {
    draw.__name__: draw
    for draw in (
        knot_meshes, jet_meshes, jet_without_missiles, f16_meshes, bunny_meshes, reduction, gallery,
    )
}  # fmt: skip
