"""The experiments of the report: each a seeded function that returns a tidy table."""

from meshfair.experiments.choices import compare_choices, conditions, noisy_mesh, outcome
from meshfair.experiments.draws import knot_draws, missile_draws
from meshfair.experiments.extensions import (
    agreement,
    eigenvalue_table,
    full_resolution,
    origin_shift,
    reduction,
)
from meshfair.experiments.learning import kernel_transfer
from meshfair.experiments.meshes import (
    MESHES,
    PAIRS,
    NotDownloadedError,
    load_mesh,
    load_noisy_mesh,
)
from meshfair.experiments.missiles import (
    averaging_for_missiles,
    missile_vertices,
    part_error_curves,
    part_errors,
)
from meshfair.experiments.original import (
    curves,
    distance_readings,
    knot_meshes,
    published_table_1,
    stopping,
    table_1,
)
from meshfair.experiments.quality import denoised, noisy_pair, quality
from meshfair.experiments.regret import regrets, summary
from meshfair.experiments.sweep import sweep

__all__ = [
    "MESHES",
    "PAIRS",
    "NotDownloadedError",
    "agreement",
    "averaging_for_missiles",
    "compare_choices",
    "conditions",
    "curves",
    "denoised",
    "distance_readings",
    "eigenvalue_table",
    "full_resolution",
    "kernel_transfer",
    "knot_draws",
    "knot_meshes",
    "load_mesh",
    "load_noisy_mesh",
    "missile_draws",
    "missile_vertices",
    "noisy_mesh",
    "noisy_pair",
    "origin_shift",
    "outcome",
    "part_error_curves",
    "part_errors",
    "published_table_1",
    "quality",
    "reduction",
    "regrets",
    "stopping",
    "summary",
    "sweep",
    "table_1",
]
