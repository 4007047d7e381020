"""The experiments of the report: each a seeded function that returns a tidy table."""

from meshfair.experiments.cases import MESHES, NOISE, WEIGHTS, NotDownloadedError, load_mesh
from meshfair.experiments.extensions import agreement, full_resolution, origin, reduction, spectrum
from meshfair.experiments.original import (
    curves,
    distance_readings,
    knot_meshes,
    part_errors,
    published_table_1,
    stopping,
    table_1,
)
from meshfair.experiments.quality import (
    PAIRS,
    averaging_for_missiles,
    denoised,
    noisy_and_clean,
    quality,
)
from meshfair.experiments.sweep import sweep

__all__ = [
    "MESHES",
    "NOISE",
    "PAIRS",
    "WEIGHTS",
    "NotDownloadedError",
    "agreement",
    "averaging_for_missiles",
    "curves",
    "denoised",
    "distance_readings",
    "full_resolution",
    "knot_meshes",
    "load_mesh",
    "noisy_and_clean",
    "origin",
    "part_errors",
    "published_table_1",
    "quality",
    "reduction",
    "spectrum",
    "stopping",
    "sweep",
    "table_1",
]
