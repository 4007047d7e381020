"""Train the learned filter: shapes, two stages, the file of weights, and the score.

    python data_scripts/train [--folder FOLDER] [--steps FIRST SECOND] [--shapes N]

What is interrupted goes on where it was: shapes and the state of each stage are kept in FOLDER.
The weights go to lib/meshfair/filters/learned.npz, the curve and the score to report/results.
"""

import argparse
import csv
import subprocess
from collections.abc import Iterator
from functools import cache, partial
from multiprocessing import Pool
from pathlib import Path

import numpy as np
import torch
import validation
from arrays import Mesh
from examples import KINDS, LARGEST, Example, Surface, noisy
from kernels import Moved
from learn import MESH, learn
from network import Stage
from score import score
from shapes import shape

from meshfair import mesh, noise, operators, weights
from meshfair import shapes as built_in
from meshfair.checks import Floats
from meshfair.filters.learned import MOVES, move_and_unfold

ROOT = Path(__file__).resolve().parents[2]
WEIGHTS = ROOT / "lib" / "meshfair" / "filters" / "learned.npz"
RESULTS = ROOT / "report" / "results"
FIGURES = ROOT / "tests" / "learned.npz"  # what torch makes of a small mesh, for the tests
NAMES = ("first", "second")
STEPS = 16_000, 12_000
SHAPES = 3_000


def main() -> None:
    """Do all that has not been done."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, default=ROOT / "data" / "train")
    parser.add_argument("--steps", type=int, nargs=2, default=STEPS)
    parser.add_argument("--shapes", type=int, default=SHAPES)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(1)
    meshes = training_shapes(options.folder / "shapes.npz", options.shapes)
    stages: list[Stage] = []
    for name, steps in zip(NAMES, options.steps, strict=True):
        make = Examples(meshes, stages)
        start = options.folder / f"{NAMES[0]}.pt" if stages else None
        validate = partial(angles, examples=validation_examples(make))
        stages.append(learn(name, make, steps, options.folder, start, validate))
    export(stages, options)
    score(options.folder, RESULTS / "validation.csv")


def training_shapes(path: Path, count: int) -> list[Mesh]:
    """The shapes, made by two processes or read from a file."""
    if not path.exists():
        with Pool(2) as pool:
            made = []
            for V, F in pool.imap(shape, range(count), chunksize=4):
                made.append((V, F))
                print(f"\rshapes: {len(made)} of {count}", end="", flush=True)
        print()
        new = path.with_suffix(".new.npz")
        np.savez(
            new,
            V=np.concatenate([V for V, _ in made]),
            F=np.concatenate([F for _, F in made]).astype(np.int32),
            sizes=[(len(V), len(F)) for V, F in made],
        )
        new.replace(path)
    with np.load(path) as file:
        ends = np.cumsum(file["sizes"], axis=0)[:-1].T
        V, F = np.split(file["V"], ends[0]), np.split(file["F"].astype(np.int64), ends[1])
    return list(zip(V, F, strict=True))


class Examples:
    """Examples by number for the stage after those that are there."""

    def __init__(self, meshes: list[Mesh], stages: list[Stage]) -> None:
        self.meshes, self.stages = meshes, list(stages)
        self.surface = cache(lambda k: Surface(*meshes[k]))

    def __call__(self, number: int) -> Example:
        """Example ``number``: the same whenever it is made."""
        rng = np.random.default_rng([len(self.stages), number])
        surface = self.surface(int(rng.integers(len(self.meshes))))
        return self.seen(surface, noisy(surface.V, surface.F, rng))

    def seen(self, surface: Surface, V: Floats) -> Example:
        """What the next stage sees of noisy positions."""
        *_, (example, _) = passes(self.stages, surface, V)
        return example


def passes(stages: list[Stage], surface: Surface, V: Floats) -> Iterator[tuple[Example, Floats]]:
    """What the first stage sees, and positions; then what each stage leaves of them."""
    F, free = surface.F, np.zeros(len(V), dtype=bool)
    A = operators.averaging(weights.combinatorial(F, len(V)))
    of_input = mesh.face_normals(V, F)
    example = Example(surface, V, np.zeros((len(F), 2, 3)))
    yield example, V
    for stage in stages:
        with torch.no_grad():
            wanted = stage(*example.inputs).numpy().astype(float)
        for _ in range(MOVES):
            V = move_and_unfold(V, F, surface.B, A, wanted, free)
        example = Example(surface, V, np.stack([of_input, wanted], axis=1))
        yield example, V


def validation_examples(make: Examples) -> dict[str, list[Example]]:
    """Of each validation shape with two noises, by the columns of the curve."""
    found: dict[str, list[Example]] = {}
    for column, group in (("sharp", validation.SHARP), ("smooth", validation.SMOOTH)):
        for k, build in enumerate(group.values()):
            surface = Surface(*build())
            rng = np.random.default_rng(k)
            for model, size in ((noise.along_normals, 0.3), (noise.gaussian, 0.2)):
                V = model(surface.V, surface.F, size, rng)
                found.setdefault(column, []).append(make.seen(surface, V))
    return found


def angles(stage: Stage, examples: dict[str, list[Example]]) -> dict[str, float]:
    """The mean angle, in degrees, of a mesh's normals after a stage from the true ones."""
    found = {}
    for column, group in examples.items():
        means = []
        for example in group:
            with torch.no_grad():
                N = Moved.apply(stage(*example.inputs), *example.mesh).numpy()
            cosine = np.sum(N * example.wanted.numpy(), axis=1)
            means.append(np.degrees(np.arccos(np.clip(cosine, -1, 1))).mean())
        found[column] = float(np.mean(means))
    return found


def export(stages: list[Stage], options: argparse.Namespace) -> None:
    """Write weights and their record, and the curves of both stages as one table."""
    arrays, seconds, rows = {}, [], []
    for k, (name, stage) in enumerate(zip(NAMES, stages, strict=True), start=1):
        for key, value in stage.state_dict().items():
            arrays[f"{k}/{key}"] = value.numpy()
        with (options.folder / f"{name}.csv").open(newline="") as file:
            curve = list(csv.DictReader(file))
        seconds.append(float(curve[-1]["seconds"]))
        rows += [{"stage": k} | row for row in curve]
    commit = subprocess.run(
        ["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    noises = ", ".join(f"{make.__name__} {share:g}" for make, share in KINDS.items())
    record = {
        "commit": commit.stdout.strip(),
        "seed": "0 (weights), each example's own number (noise), each step's own (order)",
        "data": f"{options.shapes} procedural shapes, noise up to {LARGEST:g} edges: {noises}",
        "loss": f"{MESH:.0%} of the mesh that comes of the normals, the rest of these",
        "steps": " and ".join(map(str, options.steps)),
        "seconds": " and ".join(f"{s:.0f}" for s in seconds),
        "torch": torch.__version__,
    }
    np.savez_compressed(WEIGHTS, record=np.array(list(record.items())).T, **arrays)
    V, F = built_in.torus(sections=8, sides=5)
    V = noise.gaussian(V, F, 0.2, np.random.default_rng(0))
    (_, V), (_, first), (_, second) = passes(stages, Surface(V, F), V)
    np.savez_compressed(FIGURES, V=V, F=F, first=first, second=second)
    with (RESULTS / "training.csv").open("w", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]))
        table.writeheader()
        table.writerows(rows)


if __name__ == "__main__":
    main()
