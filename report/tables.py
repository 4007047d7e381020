"""The experiments that the report is made of: name -> function that returns its table.

Each takes ``draws`` (noise draws a cell) and ``journal`` (a file for the rows
of a sweep in progress) and returns a pandas table, or None where it needs a
real mesh that is not downloaded.
"""

import warnings
from functools import wraps

from meshfair import StabilityWarning, datasets, experiments
from meshfair.experiments.original import F16_DECIBELS, KNOT_DECIBELS

SEED = 1  # of every single-draw experiment
JET_NOISE = {"noise": "normals", "size": 0.3}
QUALITY_NOISE = 0.2  # along the normals, in mean edge lengths


def needs(name):
    """Run an experiment only where a real mesh has been downloaded."""

    def decorate(make):
        @wraps(make)
        def run(**options):
            return make(**options) if datasets.find(name) else None

        return run

    return decorate


def table_1(draws, journal):
    """Table 1 with both noise models."""
    return experiments.table_1(draws, path=journal)


def distance_readings(draws, **_):
    """Table 1's distance column, read otherwise."""
    return experiments.distance_readings(min(draws, 5))


def knot(**_):
    """Iterated averaging of the knot: Figures 2 to 4."""
    with warnings.catch_warnings():
        # That averaging is unstable with cotangent weights here is a result of the report.
        warnings.simplefilter("ignore", StabilityWarning)
        return experiments.curves(
            "knot", "uniform", SEED, decibels=KNOT_DECIBELS, tau=1.0, time=20, angles=True
        )


def spectrum(**_):
    """Eigenvalues behind the low-pass filter and the stability bound."""
    return experiments.spectrum("knot", "uniform", SEED, decibels=KNOT_DECIBELS)


def jet(**_):
    """The jet with missiles: Figures 5 to 7."""
    return experiments.curves("jet", seed=SEED, angles=True, **JET_NOISE)


def jet_parts(**_):
    """What happens to the missiles alone."""
    return experiments.part_errors("jet", seed=SEED, **JET_NOISE)


def jet_without_missiles(**_):
    """The jet without missiles: Figure 8."""
    return experiments.curves("jet without missiles", seed=SEED, angles=True, **JET_NOISE)


@needs("f16")
def f16(**_):
    """The seed's own F-16."""
    return experiments.curves("f16", "uniform", SEED, decibels=F16_DECIBELS)


@needs("bunny")
def bunny(**_):
    """The bunny at full resolution."""
    with warnings.catch_warnings():
        # As on the knot: with cotangent weights tau = 1 is above the stable step.
        warnings.simplefilter("ignore", StabilityWarning)
        return experiments.full_resolution("bunny", SEED)


def large_sphere(**_):
    """A mesh of the bunny's size that needs no download."""
    return experiments.full_resolution("large sphere", SEED)


def reduction(**_):
    """What reducing a mesh does to the cotangent weights."""
    return experiments.reduction("fine knot", SEED)


def origin(**_):
    """The SNR and the origin."""
    return experiments.origin("knot", SEED)


def agreement(**_):
    """Where SNR and other metrics would stop."""
    cases = [("knot", 0.3), ("torus", 0.3), ("sphere", 0.3), ("box", 0.3), ("jet", 0.3)]
    return experiments.agreement(cases, seed=SEED)


def quality(journal, **_):
    """Every filter, with default, automatic and tuned parameters."""
    meshes = ["box", "torus", "knot", "jet"]
    for mesh, pair in experiments.PAIRS.items():
        if datasets.find(pair.clean) and datasets.find(pair.noisy):
            meshes.append(mesh)
    return experiments.quality(meshes, QUALITY_NOISE, SEED, path=journal)


def missiles(**_):
    """The averaging filters at their best for the jet's missiles, with the same noise."""
    return experiments.averaging_for_missiles(QUALITY_NOISE, SEED)


TABLES = {
    make.__name__: make
    for make in (
        table_1, distance_readings, knot, spectrum, jet, jet_parts, jet_without_missiles,
        f16, bunny, large_sphere, reduction, origin, agreement, quality,
        missiles,
    )
}  # fmt: skip
