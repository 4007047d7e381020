"""Train the forecast by which `denoise` chooses a filter: examples, and boosted trees from them.

    python data_scripts/train/choices.py [--folder FOLDER] [--examples N]

An example is a noisy mesh with the traits and the true errors of all candidates on it. A third
of the shapes are of the generators that the learned filter was trained on, but other ones, and
the rest of families that it has not seen (`families`). Examples are kept in FOLDER, so that
what is interrupted goes on where it was.
"""

import argparse
import subprocess
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import sklearn
from examples import correlated, impulsive, uniform
from families import family
from shapes import shape
from sklearn.ensemble import HistGradientBoostingRegressor
from tqdm import tqdm

from meshfair import _fast, mesh, metrics, noise
from meshfair.checks import Floats, Integers
from meshfair.denoising import BUILT_IN
from meshfair.denoising.choice import ALL, FIRST, WORTH, Chooser, ranking
from meshfair.denoising.forecast import LEAST_ANGLE, Forest

ROOT = Path(__file__).resolve().parents[2]
WEIGHTS = ROOT / "lib" / "meshfair" / "denoising" / "forecast.npz"
FIGURES = ROOT / "tests" / "forecast.npz"  # what scikit-learn makes of some rows, for the tests
UNSEEN = 100_000  # the first number of a shape that the learned filter was not trained on
EXAMPLES = 1_200
CLEAN, FINE = 0.03, 0.5  # shares of examples without noise, and with little
KNOWN = 0.4  # share of the examples whose noise size is known
SHARP = 2.5  # how much more the best candidates count: exp(-SHARP * log ratio)
TREES = {"log_ratio": 350, "gain": 150}
HIGHEST = 100.0  # dB: a clean mesh has an SNR without bound
SOME = 4  # how many candidates of each method alone are among them
VALIDATED = 5  # every so many-th pair of shapes is held out once, to see how good the choice is


def shared(V: Floats, F: Integers, sigma: float, rng: np.random.Generator) -> Floats:
    """Noise that neighbours share, over a width of its own."""
    return noise.correlated(V, F, sigma, rng, int(rng.integers(1, 9)))


KINDS = {
    noise.along_normals: 0.2,
    noise.gaussian: 0.2,
    uniform: 0.1,
    impulsive: 0.2,
    correlated: 0.15,
    shared: 0.15,
}


def example(number: int, folder: Path) -> Path:
    """Make an example, if it is not there: traits and errors of all candidates."""
    path = folder / f"{number}.npz"
    if path.exists():
        return path
    _fast.FILTER_ROWS = 0  # the loops are loaded anyway
    rng = np.random.default_rng([11, number])
    V, F = family(number - number // 3 - 1) if number % 3 else shape(UNSEEN + number // 3)
    kind = list(KINDS)[rng.choice(len(KINDS), p=np.array(list(KINDS.values())))]
    size = rng.uniform(0.02, 0.15) if rng.random() < FINE else rng.uniform(0.05, 0.75)
    V_noisy = kind(V, F, 0.0 if rng.random() < CLEAN else size, rng)
    height = np.sum((V_noisy - V) * mesh.vertex_normals(V, F), axis=1)
    actual = float(np.sqrt(np.mean(height**2)) / mesh.mean_edge_length(V, F))
    chooser = Chooser(V_noisy, F, {}, actual if rng.random() < KNOWN else None, lambda part: None)
    candidates = chooser.candidates(ALL)
    for name in BUILT_IN:
        others = chooser.candidates([name])
        candidates += [others[k] for k in rng.permutation(len(others))[:SOME]]
    V = V[chooser.vertices]
    tried = [chooser.V, *(c.X for c in candidates)]
    new = folder / f"{number}.new.npz"
    np.savez(
        new,
        rows=chooser.rows(candidates).astype(np.float32),
        angles=[metrics.normal_angle(X, V, chooser.F) for X in tried],
        ratios=[metrics.snr(V, X) for X in tried],
        usual=[c.stop is None and c.method == FIRST for c in candidates],
        untouched=[c.X is chooser.V for c in candidates],
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
            self.untouched, self.usual = file["untouched"], file["usual"]
        self.before = float(before)
        self.log_ratio = np.log((self.angles + LEAST_ANGLE) / (before + LEAST_ANGLE))
        self.gain = np.clip(ratios[1:] - ratios[0], -30, 15)
        near = np.exp(-SHARP * (self.log_ratio - self.log_ratio.min())) + 0.05
        self.weight = near / near.sum()


Trees = dict[str, HistGradientBoostingRegressor]


def fitted(examples: list[Example]) -> Trees:
    """Trees for both numbers of a `Forecast`."""
    rows = np.concatenate([e.rows for e in examples])
    weight = np.concatenate([e.weight for e in examples])
    trees: Trees = {}
    for name, count in TREES.items():
        trees[name] = HistGradientBoostingRegressor(
            max_iter=count,
            learning_rate=0.06,
            max_leaf_nodes=12,
            min_samples_leaf=30,
            l2_regularization=2.0,
            max_features=0.2,
            random_state=0,
        )
        wanted = np.concatenate([getattr(e, name) for e in examples])
        trees[name].fit(rows, np.clip(wanted, -30, 15), weight * len(weight) / weight.sum())
    return trees


def report_choices(trees: Trees, examples: list[Example]) -> None:
    """Print how far the choice is from the best candidate, on examples that were held out."""
    regret, regret_of_usual, worse = [], [], 0
    for e in examples:
        expected = {name: model.predict(e.rows) for name, model in trees.items()}
        score = ranking(expected["log_ratio"], WORTH * expected["gain"], e.untouched, e.usual)
        chosen, best = score.argmin(), e.angles.min() + LEAST_ANGLE
        regret.append((e.angles[chosen] + LEAST_ANGLE) / best)
        regret_of_usual.append((e.angles[e.usual.argmax()] + LEAST_ANGLE) / best)
        worse += e.angles[chosen] > 1.01 * e.before
    for name, found in (("choice", regret), (FIRST, regret_of_usual)):
        print(
            f"{name}: angle over the best candidate's, {len(found)} examples held out: median "
            f"{np.median(found):.3f}, 90 % {np.quantile(found, 0.9):.3f}, worst {max(found):.2f}"
        )
    print(f"worse than the noisy mesh by more than 1 %: {worse}")


def export(trees: Trees, count: int) -> None:
    """Write the trees and their record, and figures for the tests."""
    arrays = {}
    for name, model in trees.items():
        nodes = [tree.nodes for (tree,) in model._predictors]
        ends = np.cumsum([0, *map(len, nodes)])
        first = np.repeat(ends[:-1], np.diff(ends))
        all_nodes = np.concatenate(nodes)
        leaf = all_nodes["is_leaf"].astype(bool)
        columns = {
            "start": np.ravel(model._baseline_prediction)[0],
            "roots": ends[:-1].astype(np.int32),
            "feature": np.where(leaf, -1, all_nodes["feature_idx"]).astype(np.int16),
            "threshold": np.where(leaf, 0, all_nodes["num_threshold"]),
            "left": np.where(leaf, 0, all_nodes["left"] + first).astype(np.int32),
            "right": np.where(leaf, 0, all_nodes["right"] + first).astype(np.int32),
            "unknown_left": all_nodes["missing_go_to_left"].astype(np.int8),
            "value": np.where(leaf, all_nodes["value"], 0),
        }
        arrays |= {f"{name}/{field}": columns[field] for field in Forest._fields}
    commit = subprocess.run(
        ["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    record = {
        "commit": commit.stdout.strip(),
        "seed": "each example's own number; 0 for the trees",
        "data": f"{count} noisy procedural shapes",
        "scikit-learn": sklearn.__version__,
    }
    np.savez_compressed(WEIGHTS, record=np.array(list(record.items())).T, **arrays)


def main() -> None:
    """Make the examples, train, say how good it is, and export."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, default=ROOT / "data" / "choices")
    parser.add_argument("--examples", type=int, default=EXAMPLES)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    make = partial(example, folder=options.folder)
    with get_context("spawn").Pool(2) as pool:
        numbers = range(options.examples)
        paths = list(tqdm(pool.imap_unordered(make, numbers), "examples", options.examples))
    examples = sorted(map(Example, paths), key=lambda e: e.number)
    held_out = [e for e in examples if e.number // 2 % VALIDATED == 0]
    report_choices(fitted([e for e in examples if e.number // 2 % VALIDATED]), held_out)
    trees = fitted(examples)
    export(trees, len(examples))
    rows = np.concatenate([e.rows[:2] for e in held_out[:20]])
    figures = {name: model.predict(rows) for name, model in trees.items()}
    np.savez_compressed(FIGURES, rows=rows, **figures)


if __name__ == "__main__":
    main()
