"""The experiments that the report is made of: name -> function that returns its table.

Each takes ``draws`` (noise draws a cell) and ``journal`` (a file for the rows
of a sweep in progress) and returns a pandas table, or None where it needs a
real mesh that is not downloaded.
"""

import multiprocessing
import os
import warnings
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import wraps
from pathlib import Path
from typing import Any

import pandas as pd

from grid_results import regret
from meshfair import StabilityWarning, _fast, datasets, experiments
from meshfair.experiments.original import F16_DECIBELS, KNOT_DECIBELS

Make = Callable[..., pd.DataFrame | None]

SEED = 1  # of every single-draw experiment
JET_NOISE: dict[str, Any] = {"noise": "normals", "size": 0.3}
JET_TIMES = {"early": 0.6, "halfway": 2.0, "late": 4.0}  # at which the jet is shown
BUNNY_STEPS = 5  # of averaging, after which the bunny is shown
QUALITY_NOISE = 0.2  # along the normals, in mean edge lengths


def needs(name: str) -> Callable[[Make], Make]:
    """Run an experiment only where a real mesh has been downloaded."""

    def decorate(make: Make) -> Make:
        @wraps(make)
        def run(**options: Any) -> pd.DataFrame | None:
            return make(**options) if datasets.find(name) else None

        return run

    return decorate


def table_1(draws: int, journal: Path) -> pd.DataFrame:
    """Table 1 with both noise models."""
    return experiments.table_1(draws, path=journal)


def distance_readings(draws: int, **_: Any) -> pd.DataFrame:
    """Table 1's distance column, read otherwise."""
    return experiments.distance_readings(min(draws, 5))


def knot(**_: Any) -> pd.DataFrame:
    """Iterated averaging of the knot: Figures 2 to 4."""
    with warnings.catch_warnings():
        # That averaging is unstable with cotangent weights here is a result of the report.
        warnings.simplefilter("ignore", StabilityWarning)
        return experiments.curves(
            "knot", "uniform", SEED, decibels=KNOT_DECIBELS, tau=1.0, time=20, angles=True
        )


def eigenvalues(**_: Any) -> pd.DataFrame:
    """Eigenvalues behind the low-pass filter and the stability bound."""
    return experiments.eigenvalue_table("knot", "uniform", SEED, decibels=KNOT_DECIBELS)


def jet(**_: Any) -> pd.DataFrame:
    """The jet with missiles: Figures 5 to 7."""
    return experiments.curves("jet", seed=SEED, angles=True, **JET_NOISE)


def jet_parts(**_: Any) -> pd.DataFrame:
    """What happens to the missiles alone."""
    return experiments.part_error_curves(seed=SEED, **JET_NOISE)


def jet_without_missiles(**_: Any) -> pd.DataFrame:
    """The jet without missiles: Figure 8."""
    return experiments.curves("jet without missiles", seed=SEED, angles=True, **JET_NOISE)


@needs("f16")
def f16(**_: Any) -> pd.DataFrame:
    """The original report's own F-16."""
    return experiments.curves("f16", "uniform", SEED, decibels=F16_DECIBELS)


@needs("bunny")
def bunny(**_: Any) -> pd.DataFrame:
    """The bunny at full resolution."""
    with warnings.catch_warnings():
        # As on the knot: with cotangent weights tau = 1 is above the stable step.
        warnings.simplefilter("ignore", StabilityWarning)
        return experiments.full_resolution("bunny", SEED)


def large_sphere(**_: Any) -> pd.DataFrame:
    """A mesh of the bunny's size that needs no download."""
    return experiments.full_resolution("large sphere", SEED)


def reduction(**_: Any) -> pd.DataFrame:
    """What reducing a mesh does to the cotangent weights."""
    return experiments.reduction("fine knot", SEED)


def origin_shift(**_: Any) -> pd.DataFrame:
    """The SNR and the origin."""
    return experiments.origin_shift("knot", SEED)


def agreement(**_: Any) -> pd.DataFrame:
    """Where SNR and other metrics would stop."""
    cases = [("knot", 0.3), ("torus", 0.3), ("sphere", 0.3), ("box", 0.3), ("jet", 0.3)]
    return experiments.agreement(cases, seed=SEED)


def quality(journal: Path, **_: Any) -> pd.DataFrame:
    """Every filter, with default, automatic and tuned parameters: on all cores, for it is long."""
    meshes = ["box", "torus", "knot", "jet"]
    for mesh, pair in experiments.PAIRS.items():
        if datasets.find(pair.ground_truth) and datasets.find(pair.noisy):
            meshes.insert(0, mesh)  # the large ones first, so that no core waits for them
    context = multiprocessing.get_context("spawn")  # threads of compiled loops bear no fork
    with ProcessPoolExecutor(os.cpu_count(), context, _fast.use_one_core) as workers:
        return experiments.quality(meshes, QUALITY_NOISE, SEED, executor=workers, path=journal)


def missiles(**_: Any) -> pd.DataFrame:
    """The averaging filters at their best for the jet's missiles, with the same noise."""
    return experiments.averaging_for_missiles(QUALITY_NOISE, SEED)


def kernel_transfer(**_: Any) -> pd.DataFrame:
    """Kernels learned from one mesh and tried on another, with the same noise."""
    return experiments.kernel_transfer(size=QUALITY_NOISE, seed=SEED)


TABLES = {
    make.__name__: make
    for make in (
        table_1, distance_readings, knot, eigenvalues, jet, jet_parts, jet_without_missiles,
        f16, bunny, large_sphere, reduction, origin_shift, agreement, quality,
        missiles, kernel_transfer, regret,
    )
}  # fmt: skip
