"""Train the forecast by which `denoise` chooses a filter: examples, and boosted trees from them.

    python data_scripts/train/choices.py [--folder FOLDER] [--examples N]

An example is a noisy mesh with the traits and the true errors of all candidates on it. A third
of the shapes are of the generators that the learned filter was trained on, but other ones, and
the rest of families of which it has seen some reliefs only (`families`); the last `LATTICES` are
all of one family. Examples are kept in FOLDER, so that what is interrupted goes on where it was.
"""

import argparse
import subprocess
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import product
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import sklearn
from examples import correlated, impulsive, shared, uniform
from families import FAMILIES, family
from reliefs import lattices
from shapes import shape
from sklearn.ensemble import HistGradientBoostingRegressor
from tqdm import tqdm

from meshfair import _fast, mesh, metrics, noise
from meshfair.checks import Floats, Integers
from meshfair.denoising import BUILT_IN
from meshfair.denoising.choice import ALL, USUAL, Chooser
from meshfair.denoising.forecast import LEAST_ANGLE, Forecast, Forest, Part
from meshfair.denoising.registry import STRENGTHS
from meshfair.denoising.rules import (
    AMONG_ALL,
    CHOSEN,
    LEFT_ALONE,
    NAMED,
    Results,
    Rule,
    ranking,
    rule_of,
    strength,
    weighed,
)

ROOT = Path(__file__).resolve().parents[2]
WEIGHTS = ROOT / "lib" / "meshfair" / "denoising" / "forecast.npz"
FIGURES = ROOT / "tests" / "forecast.npz"  # what scikit-learn makes of some rows, for the tests
UNSEEN = 100_000  # the first number of a shape that the learned filter was not trained on
EXAMPLES = 4_200
LATTICES = 525  # more, all with relief that repeats: what it shows is seen in few of the others
CLEAN, FINE = 0.03, 0.5  # shares of examples without noise, and with little
KNOWN = 0.4  # share of the examples whose noise size is known
# How much a candidate counts: FLOOR + exp(-SHARP * (log ratio - the best one's)); the usual
# one, which is chosen where nothing speaks for another, counts 1: its failures have to be seen.
SHARP, FLOOR = 2.5, 0.3
MODELS = 4  # so many, on other rows each, err less together than one alone
# In each model; those of what going on for longer changes see two rows of an example only.
TREES = {"log_ratio": 200, "gain": 120, "alone": 200, "further": 60, "further_gain": 60}
# Those of the best part of the way: of an example they see one row, with what the others say of it.
PART_TREES = {"part_of_normals": 120, "part_of_places": 120}
MOST = 1.2  # of the way: a best part beyond counts as this
RELIEF = 2.0  # how much more an example on which relief repeats counts for these; there are few
LEAST_SQUARE = 0.3  # of what is left; smaller ones weigh the same in the fit of a parabola
BEST, OTHERS = 14, 20  # how many candidates of an example a model sees
OWN_BEST, OWN_OTHERS = 2, 2  # and of each method, beside its defaults, one that tells these apart
NOISE_TRAITS = 2  # the last ones are of the noise size
HIGHEST = 100.0  # dB: a clean mesh has an SNR without bound
LOG_RATIOS, GAINS = (-4, 2), (-30, 15)  # what lies beyond counts as these
CHANGES = {"further": (-0.5, 0.5), "further_gain": (-5, 5)}  # by going on for longer, likewise
FOLDS = 4  # so often are trees fitted without some families, to see how good the choice is


KINDS = {
    noise.along_normals: 0.2,
    noise.gaussian: 0.2,
    uniform: 0.1,
    impulsive: 0.2,
    correlated: 0.15,
    shared: 0.15,
}


def is_of_family(number: int) -> bool:
    """Whether an example's shape is one of the families."""
    return number >= EXAMPLES or number % 3 > 0


def of_family(number: int) -> int:
    """The number of an example's shape, where it is one of the families."""
    if number >= EXAMPLES:
        return number * len(FAMILIES) + FAMILIES.index(lattices)
    return number - number // 3 - 1


def example(number: int, folder: Path) -> Path:
    """Make an example, if it is not there: traits and errors of all candidates."""
    path = folder / f"{number}.npz"
    if path.exists():
        return path
    _fast.FILTER_ROWS = 0  # the loops are loaded anyway
    rng = np.random.default_rng([11, number])
    if is_of_family(number):
        V, F = family(of_family(number))
    else:
        V, F = shape(UNSEEN + number // 3)
    kind = list(KINDS)[rng.choice(len(KINDS), p=np.array(list(KINDS.values())))]
    size = rng.uniform(0.02, 0.15) if rng.random() < FINE else rng.uniform(0.05, 0.75)
    V_noisy = kind(V, F, 0.0 if rng.random() < CLEAN else size, rng)
    height = np.sum((V_noisy - V) * mesh.vertex_normals(V, F), axis=1)
    actual = float(np.sqrt(np.mean(height**2)) / mesh.mean_edge_length(V, F))
    chooser = Chooser(V_noisy, F, {}, actual if rng.random() < KNOWN else None, lambda part: None)
    candidates = chooser.candidates(BUILT_IN)
    V = V[chooser.vertices]
    usual = next(c for c in candidates if c.method == USUAL and c.stop is None)
    further, parts = chooser.further(), [chooser.part(usual, s) for s in STRENGTHS]
    candidates += further + parts
    tried = [chooser.V, *(c.X for c in candidates)]
    new = folder / f"{number}.new.npz"
    np.savez(
        new,
        rows=chooser.rows(candidates).astype(np.float32),
        angles=[metrics.normal_angle(X, V, chooser.F) for X in tried],
        ratios=[metrics.snr(V, X) for X in tried],
        methods=[c.method for c in candidates],
        ended=[c.stop is None for c in candidates],
        untouched=[c.X is chooser.V for c in candidates],
        moved=chooser.moved(candidates),
        relief=chooser.takes_relief(),
        further=len(further),
        parts=len(parts),
    )
    new.replace(path)
    return path


class Example:
    """What an example's file holds, and what the trees shall learn of it."""

    def __init__(self, path: Path) -> None:
        with np.load(path) as file:
            self.number = int(path.stem)
            self.rows = file["rows"].astype(float)
            before, self.angles = file["angles"][0], file["angles"][1:]
            ratios = np.minimum(file["ratios"], HIGHEST)
            self.untouched, self.methods = file["untouched"], file["methods"]
            self.ended, self.moved, self.relief = file["ended"], file["moved"], bool(file["relief"])
            rows = np.arange(len(self.rows))
            ends = len(rows) - file["parts"] - np.array([file["further"], 0])
            self.candidates, self.further, self.parts = np.split(rows, ends)
        self.before = float(before)
        # What trees say of the rows that have not seen this example: with the noise size, where
        # it is known, and without.
        self.said: dict[str, Floats] = {}
        self.said_without: dict[str, Floats] = {}
        log_ratio = np.log((self.angles + LEAST_ANGLE) / (before + LEAST_ANGLE))
        self.log_ratio = np.clip(log_ratio, *LOG_RATIOS)
        self.gain = np.clip(ratios[1:] - ratios[0], *GAINS)
        self.weight, self.weight_alone = np.ones((2, len(self.rows)))
        self.weight[self.candidates] = self._weights(self.candidates, USUAL)
        for name in BUILT_IN:
            self.weight_alone[self.own(name)] = self._weights(self.own(name), name) / len(BUILT_IN)

    def _weights(self, rows: Integers, usual: str) -> Floats:
        """How much each of some rows counts, all together 1; `usual` is a method."""
        near = np.exp(-SHARP * (self.log_ratio[rows] - self.log_ratio[rows].min())) + FLOOR
        near[rows == self.default(usual)] = 1
        return near / near.sum()

    def own(self, method: str) -> Integers:
        """The rows of a method's candidates."""
        return self.candidates[self.methods[self.candidates] == method]

    def lesson(self, name: str, rng: np.random.Generator) -> tuple[Floats, Floats, Floats]:
        """Rows for one model of some trees, what it shall say of them, and how much they count."""
        if name in PART_TREES:
            left = (
                np.exp(2 * self.log_ratio) if name == "part_of_normals" else 10 ** (-self.gain / 10)
            )
            weight = RELIEF if self.relief else 1.0
            return self.of_part(self.said, self.rows), self.best_part(left), np.array([weight])
        if name in CHANGES:
            told = self.log_ratio if name == "further" else self.gain
            change = told[self.further] - told[self.default(USUAL)]
            return self.rows[self.further], np.clip(change, *CHANGES[name]), np.ones(len(change))
        rows = self.kept_alone(rng) if name == "alone" else self.kept(rng)
        weight = (self.weight_alone if name == "alone" else self.weight)[rows]
        told = self.gain if name == "gain" else self.log_ratio
        return self.rows[rows], told[rows], weight / weight.sum()

    def of_part(self, said: dict[str, Floats], rows: Floats) -> Floats:
        """The row of the usual result, as `meshfair.denoising.forecast.best_part` takes it."""
        k = self.default(USUAL)
        return np.concatenate([rows[k], [said["log_ratio"][k], said["gain"][k]]])[None]

    def best_part(self, left: Floats) -> Floats:
        """Where the parabola through squared errors of rows, over the noisy mesh's, is least."""
        s, left = np.array([*STRENGTHS, 1.0]), left[[*self.parts, self.default(USUAL)]]
        weight = 1 / np.maximum(left, LEAST_SQUARE)
        A = np.column_stack([-2 * s, s**2]) * weight[:, None]
        (down, up), *_ = np.linalg.lstsq(A, (left - 1) * weight)
        return np.clip([down / max(up, 1e-6)], 0, MOST)

    def kept(self, rng: np.random.Generator) -> Integers:
        """Rows for one model: the best ones, some of the others, and the usual one."""
        order = np.argsort(self.log_ratio[self.candidates], kind="stable")
        others = rng.permutation(order[BEST:])[:OTHERS]
        return np.unique(np.concatenate([order[:BEST], others, [self.default(USUAL)]]))

    def kept_alone(self, rng: np.random.Generator) -> Integers:
        """Rows for a model that tells one method's apart: of each the best, and some others."""
        kept: list[Integers] = []
        for name in BUILT_IN:
            own = self.own(name)
            own = own[np.argsort(self.log_ratio[own], kind="stable")]
            kept += [own[:OWN_BEST], rng.permutation(own[OWN_BEST:])[:OWN_OTHERS]]
        return np.unique(np.concatenate([*kept, list(map(self.default, BUILT_IN))]))

    def without_noise_size(self) -> Floats:
        """The rows, as they are where the noise size is not known."""
        rows = self.rows.copy()
        rows[:, -NOISE_TRAITS:] = np.nan
        return rows

    def default(self, method: str) -> int:
        """The row of a method's defaults: the first that has run to its end."""
        return int(np.flatnonzero((self.methods == method) & self.ended)[0])

    def chosen(self, expected: Forecast, methods: Sequence[str], rule: Rule, usual: str) -> int:
        """The row that a rule chooses among some methods."""
        is_usual = (self.methods == usual) & self.ended
        score = ranking(expected, Results(self.untouched, is_usual, self.moved, self.relief), rule)
        score[~np.isin(self.methods, methods)] = np.inf
        score[self.further] = score[self.parts] = np.inf
        return int(score.argmin())

    def refined(self, row: int, said: Forecast, changes: Forecast, part: Part, alone: bool) -> int:
        """The row that is taken in place of a chosen one, as by the chooser; -1: the noisy mesh."""
        usual, left = self.default(USUAL), self.untouched[row]
        if row != usual and (not left or self.relief):
            return row
        s = strength(part, LEFT_ALONE if left else NAMED if alone else CHOSEN)
        if s == 0:
            return -1
        if s < 1:
            return int(self.parts[STRENGTHS.index(s)])
        return usual if left else self.longer(usual, said, changes)

    def longer(self, row: int, said: Forecast, changes: Forecast) -> int:
        """The row that goes on for longer from the usual one, or this."""
        of_further = Forecast(*(by[self.further] for by in changes))
        best = weighed(said.changed(row, of_further), AMONG_ALL).argmin()
        return int([row, *self.further][best])


Trees = dict[str, list[HistGradientBoostingRegressor]]


def fitted(examples: list[Example], counts: dict[str, int]) -> Trees:
    """So many trees of `meshfair.denoising.forecast.forests`: some models, whose mean it is."""
    trees: Trees = {name: [] for name in counts}
    for seed, (name, count) in product(range(MODELS), counts.items()):
        model = HistGradientBoostingRegressor(
            max_iter=count,
            learning_rate=0.08,
            max_leaf_nodes=12,
            min_samples_leaf=20,
            l2_regularization=2.0,
            max_features=0.15,
            max_bins=63,
            random_state=seed,
        )
        rng = np.random.default_rng(seed)
        lessons = zip(*(e.lesson(name, rng) for e in examples), strict=True)
        rows, wanted, weight = map(np.concatenate, lessons)
        model.fit(rows, wanted, weight * len(weight) / weight.sum())
        trees[name].append(model)
    return trees


def predicted(trees: Trees, rows: Floats) -> dict[str, Floats]:
    """What the trees say of rows of traits, by name."""
    return {
        name: np.mean([m.predict(rows[:, : m.n_features_in_]) for m in models], axis=0)
        for name, models in trees.items()
    }


def fold_of(number: int) -> int:
    """The fold in which an example is held out, one of a family with its whole family."""
    return (of_family(number) % len(FAMILIES) if is_of_family(number) else number) % FOLDS


def folds(examples: list[Example]) -> Iterator[tuple[list[Example], list[Example]]]:
    """The examples of each fold, and all others."""
    for fold in range(FOLDS):
        held_out = [e for e in examples if fold_of(e.number) == fold]
        yield held_out, [e for e in examples if fold_of(e.number) != fold]


def say(examples: list[Example]) -> None:
    """Let each example know what trees say of it that were fitted without its fold."""
    for held_out, others in folds(examples):
        trees = fitted(others, TREES)
        for e in held_out:
            e.said = predicted(trees, e.rows)
            e.said_without = predicted(trees, e.without_noise_size())


def report_choices(examples: list[Example]) -> None:
    """Print how far choices are from the best default, on families that were held out."""
    regret: dict[str, list[float]] = {"choice": [], **{name: [] for name in BUILT_IN}}
    worse, lost, count = 0, 0, 0
    for held_out, others in folds(examples):
        trees = fitted(others, PART_TREES)
        for e in held_out:
            if not is_of_family(e.number):
                continue
            said, rows = e.said_without, e.without_noise_size()
            angles, gain = np.append(e.angles, e.before) + LEAST_ANGLE, np.append(e.gain, 0)
            expected, alone = (Forecast(said[n], said["gain"]) for n in ("log_ratio", "alone"))
            changes = Forecast(said["further"], said["further_gain"])
            part = Part(*(float(p[0]) for p in predicted(trees, e.of_part(said, rows)).values()))
            best = min(angles[e.default(name)] for name in BUILT_IN)
            row = e.chosen(expected, ALL, AMONG_ALL, USUAL)
            row = e.refined(row, expected, changes, part, alone=False)
            regret["choice"].append(angles[row] / best)
            worse += angles[row] > 1.01 * e.before + LEAST_ANGLE
            lost += gain[row] < -0.1
            for name in BUILT_IN:
                own = e.chosen(alone, [name], rule_of(name), name)
                if name == USUAL:
                    own = e.refined(own, alone, changes, part, alone=True)
                regret[name].append(angles[own] / angles[e.default(name)])
            count += 1
    print(f"{count} examples of families held out; angle over the best default's, or the own:")
    for name, found in regret.items():
        print(
            f"{name}: median {np.median(found):.3f}, mean {np.exp(np.log(found).mean()):.3f}, up "
            f"to 1.05 in {np.mean(np.array(found) <= 1.05):.1%}, worst {max(found):.2f}"
        )
    print(f"choice worse than the noisy mesh: angle by 1 % in {worse}, SNR by 0.1 dB in {lost}")


def export(trees: Trees, count: int) -> None:
    """Write the trees and their record, and figures for the tests."""
    arrays = {}
    for name, models in trees.items():
        nodes = [tree.nodes for model in models for (tree,) in model._predictors]
        ends = np.cumsum([0, *map(len, nodes)])
        first = np.repeat(ends[:-1], np.diff(ends))
        all_nodes = np.concatenate(nodes)
        leaf = all_nodes["is_leaf"].astype(bool)
        columns = {
            "start": np.mean([model._baseline_prediction for model in models]),
            "roots": ends[:-1].astype(np.int32),
            "feature": np.where(leaf, -1, all_nodes["feature_idx"]).astype(np.int16),
            "threshold": np.where(leaf, 0, all_nodes["num_threshold"]),
            "left": np.where(leaf, 0, all_nodes["left"] + first).astype(np.int32),
            "right": np.where(leaf, 0, all_nodes["right"] + first).astype(np.int32),
            "unknown_left": all_nodes["missing_go_to_left"].astype(np.int8),
            "value": np.where(leaf, all_nodes["value"] / len(models), 0).astype(np.float32),
        }
        arrays |= {f"{name}/{field}": columns[field] for field in Forest._fields}
    commit = subprocess.run(
        ["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    record = {
        "commit": commit.stdout.strip(),
        "seed": f"each example's own number; 0 to {MODELS - 1} for the trees",
        "data": f"{count} noisy procedural shapes",
        "scikit-learn": sklearn.__version__,
    }
    np.savez_compressed(WEIGHTS, record=np.array(list(record.items())).T, **arrays)


def main() -> None:
    """Make the examples, train, say how good it is, and export."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, default=ROOT / "data" / "choices")
    parser.add_argument("--examples", type=int, default=EXAMPLES + LATTICES)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    make = partial(example, folder=options.folder)
    with get_context("spawn").Pool(2) as pool:
        numbers = range(options.examples)
        paths = list(tqdm(pool.imap_unordered(make, numbers), "examples", options.examples))
    examples = sorted(map(Example, paths), key=lambda e: e.number)
    say(examples)
    report_choices(examples)
    trees = fitted(examples, TREES) | fitted(examples, PART_TREES)
    export(trees, len(examples))
    rows = np.concatenate([e.of_part(e.said, e.rows) for e in examples[:40]])
    np.savez_compressed(FIGURES, rows=rows, **predicted(trees, rows))


if __name__ == "__main__":
    main()
