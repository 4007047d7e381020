"""Training of one stage, step by step; it goes on where it was interrupted."""

import csv
import math
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from time import perf_counter

import numpy as np
import torch
from examples import Example
from network import Stage

RATE, WARMING = 2e-3, 100  # of Adam at its highest; steps until then
BATCH = 2  # meshes a step
MESH = 0.7  # share of the loss that looks at the mesh which comes of the normals
AVERAGED = 0.99  # how much of their mean the weights keep in each step
FIRST, NEW, KEPT = 100, 0.6, 700  # examples at first, new ones a step, examples kept
REPORT = 25  # steps between two lines
VALIDATED = 250  # steps between two looks at the validation shapes


def rate(step: int, steps: int) -> float:
    """The learning rate at a step, in the highest one: it rises, and falls along a cosine."""
    falling = (1 + math.cos(math.pi * step / steps)) / 2
    return min(1.0, (step + 1) / WARMING, max(falling, 0.01))


class Pool:
    """The latest examples, each made from its number alone, by a thread of its own."""

    def __init__(self, make: Callable[[int], Example]) -> None:
        self.make, self.thread = make, ThreadPoolExecutor(1)
        self.examples: dict[int, Future[Example]] = {}

    def draw(self, step: int, rng: np.random.Generator) -> list[Example]:
        """The examples of a step."""
        end = FIRST + int(NEW * step)
        first = max(0, end - KEPT)
        for number in [k for k in self.examples if k < first]:
            del self.examples[number]
        drawn = rng.integers(first, end, BATCH).tolist()
        # Those of the next step, too. Others, after an interruption, when they are drawn.
        for k in (*drawn, *range(end, FIRST + int(NEW * (step + 1)))):
            if k not in self.examples:
                self.examples[k] = self.thread.submit(self.make, k)
        return [self.examples[k].result() for k in drawn]


def learn(
    name: str,
    make: Callable[[int], Example],
    steps: int,
    folder: Path,
    start: Path | None = None,
    validate: Callable[[Stage], dict[str, float]] | None = None,
) -> Stage:
    """Train a stage.

    Parameters
    ----------
    name : str
        Of its files: NAME.pt, the state of things, and NAME.csv, the curve.
    make : function
        From a number to an example.
    steps : int
        How many to make, those before an interruption among them.
    folder : Path
    start : Path, optional
        The state of a stage whose weights to begin with.
    validate : function, optional
        From a stage to what the curve says of it, now and then.

    Returns
    -------
    Stage
        With the mean of the latest weights.
    """
    highest = RATE if start is None else RATE / 2  # what was learned shall not be forgotten
    state, curve = folder / f"{name}.pt", folder / f"{name}.csv"
    torch.manual_seed(0)
    stage, mean = Stage(), Stage()
    optimizer = torch.optim.AdamW(stage.parameters(), RATE, betas=(0.9, 0.995), weight_decay=1e-4)
    begin, seconds = 0, 0.0
    if state.exists():
        saved = torch.load(state, weights_only=True)
        stage.load_state_dict(saved["stage"])
        mean.load_state_dict(saved["mean"])
        optimizer.load_state_dict(saved["optimizer"])
        begin, seconds = saved["step"], saved["seconds"]
    elif start is not None:
        stage.load_state_dict(torch.load(start, weights_only=True)["mean"])
    if begin == 0:
        mean.load_state_dict(stage.state_dict())
    pool, recent, began = Pool(make), [], perf_counter() - seconds
    parameters = list(stage.parameters())

    def loss_of(example: Example) -> tuple[tuple[torch.Tensor, ...], float, float]:
        wanted, error = example.errors(stage(*example.inputs))
        loss = ((1 - MESH) * wanted + MESH * error) / (0.1 + example.noisy)
        return torch.autograd.grad(loss, parameters), float(loss.detach()), float(error.detach())

    threads = ThreadPoolExecutor(2)
    for step in range(begin, steps):
        examples = pool.draw(step, np.random.default_rng([1, step]))
        gradients, losses, errors = zip(*threads.map(loss_of, examples), strict=True)
        for parameter, *parts in zip(parameters, *gradients, strict=True):
            parameter.grad = sum(parts) / BATCH
        for group in optimizer.param_groups:
            group["lr"] = highest * rate(step, steps)
        size = torch.nn.utils.clip_grad_norm_(parameters, 1.0)
        if torch.isfinite(size):  # a step without end would be the last one
            optimizer.step()
        with torch.no_grad():
            keep = min(AVERAGED, step / (step + 10))
            for a, b in zip(mean.parameters(), stage.parameters(), strict=True):
                a.lerp_(b, 1 - keep)
        noisy = np.mean([example.noisy for example in examples])
        recent.append((np.mean(losses), noisy, np.mean(errors), float(size)))
        done = step + 1
        if done % REPORT == 0 or done == steps:
            seconds = perf_counter() - began
            row = dict(
                zip(("loss", "noisy", "error", "slope"), np.mean(recent, axis=0), strict=True)
            )
            row = {"step": done, "seconds": seconds, "rate": highest * rate(step, steps)} | row
            if validate is not None and (done % VALIDATED == 0 or done == steps):
                row |= validate(mean)
            recent = []
            _append(curve, row)
            print(name, *(f"{key} {value:.5g}" for key, value in row.items()), flush=True)
            new = state.with_suffix(".new")
            torch.save(
                {
                    "stage": stage.state_dict(), "mean": mean.state_dict(),
                    "optimizer": optimizer.state_dict(), "step": done, "seconds": seconds,
                },
                new,
            )  # fmt: skip
            new.replace(state)
    return mean


def _append(curve: Path, row: dict[str, float]) -> None:
    """One more row of the curve."""
    new = not curve.exists()
    with curve.open("a", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, restval="")
        if new:
            writer.writeheader()
        writer.writerow({key: f"{value:.6g}" for key, value in row.items()})


COLUMNS = ["step", "seconds", "rate", "loss", "noisy", "error", "slope", "sharp", "smooth"]
