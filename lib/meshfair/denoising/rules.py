"""How forecasts of candidates are weighed against each other, for the choice among them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from meshfair.checks import Booleans, Floats
from meshfair.denoising.forecast import Forecast, Part
from meshfair.denoising.registry import find_method


class Rule(NamedTuple):
    """How forecasts are weighed against each other.

    What another choice than the usual one has to promise more, in log ratio, is larger the
    worse it is when the promise fails.
    """

    nearer: float
    """Of a choice that moves the vertices less than the usual one."""
    left: float
    """Of the noisy mesh as it is."""
    farther: float
    """Of a choice that moves the vertices more."""
    leaves_relief: bool = False
    """Whether a mesh whose relief filters take for noise is left as it is, or only not changed
    more than by the usual one."""
    worth: float = 0.0
    """What a decibel is worth: of choices that leave the normals alike, the one nearer to
    the true place."""
    doubt: float = 0.0
    """What is added for each decibel that a promise is short of `sure_gain`. A filter that takes
    detail for noise moves the vertices away from the truth, however good its normals look."""
    sure_gain: float = 0.0
    """Decibels from which on there is no doubt."""


# By training's meshes, families of shapes left out: what does least harm, and leaves the least
# error.
AMONG_ALL = Rule(0.2, 0.2, 0.2, leaves_relief=True, worth=0.05, doubt=0.15, sure_gain=3)
# Of one method's choices: what filters that look at normals leave is told better than what
# filters leave that smooth for any length or strength. With these, of training's meshes with
# families of shapes left out, one in a hundred ends more than 5 % worse than with the defaults.
LEFT, FARTHER, FARTHER_SMOOTHING = 0.4, 0.3, 0.55


def rule_of(method: str) -> Rule:
    """The rule by which one method's parameters are chosen.

    Parameters
    ----------
    method : str

    Returns
    -------
    Rule
    """
    # Who names averaging wants it, though it shrinks: an SNR that falls is no reason against it.
    found = find_method(method)
    return Rule(found.nearer_margin, LEFT, FARTHER if found.normals else FARTHER_SMOOTHING)


class Caution(NamedTuple):
    """How much less is done than all where the best part of the way is told to be short of it."""

    enough: float
    """The best part from which on all of the way is gone."""
    steep: float
    """By how much more than what the best part is short of that the strength is short of 1: the
    less of the way is right, the less it is known how much."""
    of_both: bool = False
    """Whether it has to be the best part for the places, too, and not for the normals alone."""


# By training's meshes, again. Among all methods, where the usual one is chosen; where the mesh
# would be left as it is, since its places, or its normals, are in doubt; and where that method is
# named, whose user wants it to do something.
CHOSEN, LEFT_ALONE, NAMED = Caution(0.75, 3), Caution(0.83, 3, of_both=True), Caution(0.5, 2)


def strength(part: Part, caution: Caution) -> float:
    """The part of the way that is gone, in eighths.

    Parameters
    ----------
    part : Part
        The best ones, as far as they can be told.
    caution : Caution

    Returns
    -------
    float
        From 0 to 1.
    """
    best = min(part) if caution.of_both else part.normals
    return float(np.round(8 * np.clip(1 - caution.steep * (caution.enough - best), 0, 1)) / 8)


class Results(NamedTuple):
    """What is known of r results without a forecast."""

    untouched: Booleans
    """Which ones are the noisy mesh itself, shape (r,)."""
    usual: Booleans
    """Which ones are of the method that is chosen where nothing speaks for another, shape
    (r,); the first one of them, with its defaults, counts."""
    moved: Floats
    """How far the vertices have moved, in any unit, shape (r,): it is only compared."""
    relief: bool
    """Whether what the usual filter takes away repeats along the surface, as relief does."""


def weighed(expected: Forecast, rule: Rule) -> Floats:
    """Expected log ratios, and with them what decibels count: the less the better.

    Parameters
    ----------
    expected : Forecast
        Of r results.
    rule : Rule

    Returns
    -------
    ndarray of float64, shape (r,)
    """
    short = np.maximum(0, rule.sure_gain - expected.gain)
    return expected.log_ratio - rule.worth * expected.gain + rule.doubt * short


def ranking(expected: Forecast, results: Results, rule: Rule) -> Floats:
    """What results are ranked by, the least first.

    Parameters
    ----------
    expected : Forecast
        Of r results.
    results : Results
    rule : Rule

    Returns
    -------
    ndarray of float64, shape (r,)
    """
    untouched, first = results.untouched, np.flatnonzero(results.usual)[:1]
    score = weighed(expected, rule)
    score[untouched] = 0
    farther = results.moved > (results.moved[first] if len(first) else np.inf)
    margin = np.where(untouched, rule.left, np.where(farther, rule.farther, rule.nearer))
    margin[first] = 0
    score += margin
    if results.relief and rule.leaves_relief:
        score[untouched] = -np.inf
    elif results.relief:
        score[farther] = np.inf
    return score
