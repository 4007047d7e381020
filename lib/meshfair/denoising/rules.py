"""How forecasts of candidates are weighed against each other, for the choice among them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from meshfair.checks import Booleans, Floats
from meshfair.denoising.forecast import Forecast
from meshfair.denoising.registry import find_method


class Rule(NamedTuple):
    """How forecasts are weighed against each other."""

    margin: float
    """What another choice than the usual one has to promise more, in log ratio."""
    worth: float
    """What a decibel is worth: of choices that leave the normals alike, the one nearer to
    the true place."""
    doubt: float
    """What is added for each decibel that a promise is short of `sure_gain`. A filter that takes
    detail for noise moves the vertices away from the truth, however good its normals look."""
    sure_gain: float
    """Decibels from which on there is no doubt."""


# By training's meshes, families of shapes left out: what does least harm, and leaves the least
# error.
AMONG_ALL = Rule(margin=0.2, worth=0.05, doubt=0.15, sure_gain=3)


def rule_of(method: str) -> Rule:
    """The rule by which one method's parameters are chosen."""
    # Who names averaging wants it, though it shrinks: an SNR that falls is no reason against it.
    return Rule(find_method(method).margin, worth=0, doubt=0, sure_gain=0)


def ranking(expected: Forecast, untouched: Booleans, usual: Booleans, rule: Rule) -> Floats:
    """What candidates are ranked by, the least first.

    Parameters
    ----------
    expected : Forecast
        Of r candidates.
    untouched : ndarray of bool, shape (r,)
        Which ones are the noisy mesh itself.
    usual : ndarray of bool, shape (r,)
        Which ones are of the method that is chosen where nothing speaks for another;
        the first one of them, with its defaults, counts.
    rule : Rule

    Returns
    -------
    ndarray of float64, shape (r,)
    """
    short = np.maximum(0, rule.sure_gain - expected.gain)
    score = expected.log_ratio - rule.worth * expected.gain + rule.doubt * short
    score[untouched] = 0
    score[np.flatnonzero(usual)[:1]] -= rule.margin
    return score
