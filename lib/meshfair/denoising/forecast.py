"""A forecast of how well a filter has done on a noisy mesh, learned from meshes with ground truth.

Gradient boosting [Friedman01]_: the forecast is a sum of many small decision trees over the
traits of the mesh and of the filter's result (`meshfair.denoising.traits`). Stein's estimate
(`meshfair.sure`) needs white Gaussian noise of known size; this one has seen other noise, too.
How the trees came about: `data_scripts/train/choices.py`.

References
----------
.. [Friedman01] J. Friedman, "Greedy function approximation: a gradient boosting machine",
   Annals of Statistics 29, 2001.
.. [James61] W. James, C. Stein, "Estimation with quadratic loss", Proceedings of the Fourth
   Berkeley Symposium on Mathematical Statistics and Probability 1, 1961.
"""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from typing import NamedTuple

import numpy as np

from meshfair.checks import Floats, Integers

LEAST_ANGLE = 0.1
"""Degrees that are added to both angles of a ratio, so that clean meshes have one."""


class Forest(NamedTuple):
    """Decision trees whose leaves are added up, all of their nodes in one array."""

    start: float
    """What all sums begin with."""
    roots: Integers
    """The first node of each tree, shape (t,)."""
    feature: Integers
    """The trait that a node looks at, shape (k,); -1 at a leaf."""
    threshold: Floats
    """A trait up to this leads to the left, shape (k,)."""
    left: Integers
    """The node to the left, shape (k,); the node to the right is `right`."""
    right: Integers
    unknown_left: Integers
    """1 where a trait that is not a number leads to the left, shape (k,)."""
    value: Floats
    """What a leaf adds, shape (k,)."""

    def __call__(self, X: Floats) -> Floats:
        """The sums for rows of traits.

        Parameters
        ----------
        X : ndarray of float64, shape (r, number of traits)

        Returns
        -------
        ndarray of float64, shape (r,)
        """
        node = np.repeat(self.roots[None], len(X), axis=0)
        row = np.arange(len(X))[:, None]
        while (inner := self.feature[node] >= 0).any():
            x = X[row, self.feature[node]]
            left = np.where(np.isnan(x), self.unknown_left[node] == 1, x <= self.threshold[node])
            node = np.where(inner, np.where(left, self.left[node], self.right[node]), node)
        return self.start + self.value[node].sum(axis=1)


class Forecast(NamedTuple):
    """What is expected of results, one entry for each."""

    log_ratio: Floats
    """log((angle + 0.1) / (noisy angle + 0.1)) of the mean normal angles in degrees."""
    gain: Floats
    """What the SNR gains, in decibels."""

    @property
    def ratio(self) -> Floats:
        """The normals' error after and before: 0.1 where a tenth of it is left."""
        return np.exp(self.log_ratio)

    def changed(self, k: int, changes: Forecast) -> Forecast:
        """What is expected of result k, and then of those that differ from it by these changes."""
        both = zip(self, changes, strict=True)
        return Forecast(*(said[k] + np.concatenate([[0.0], by]) for said, by in both))


class Part(NamedTuple):
    """The parts of the way, 0 to about 1, that come closest to the truth."""

    normals: float
    """By the mean normal angle."""
    places: float
    """By the SNR."""


def forecast(X: Floats, alone: bool = False) -> Forecast:
    """How much closer than the noisy mesh results are to the ground truth.

    Parameters
    ----------
    X : ndarray of float64, shape (r, number of traits)
        A row of traits for each result.
    alone : bool
        Whether the results are one method's: the trees for the ratio are then those that have
        learned to tell these apart, however good other methods are on the mesh.

    Returns
    -------
    Forecast
    """
    trees = forests()
    return Forecast(trees["alone" if alone else "log_ratio"](X), trees["gain"](X))


def change(X: Floats) -> Forecast:
    """How much closer results that go on for longer are than those they go on from.

    Parameters
    ----------
    X : ndarray of float64, shape (r, number of traits)
        A row of traits for each result of the learned filter that has moved the vertices for
        longer.

    Returns
    -------
    Forecast
        Relative to the learned filter's default: 0 is as good as that.
    """
    trees = forests()
    return Forecast(trees["further"](X), trees["further_gain"](X))


def best_part(x: Floats) -> Part:
    """How far to go towards the learned filter's result.

    What a filter takes away is noise e and detail. A part s of the way leaves of a residual r
    the squared error |e - s r|^2, a parabola in s: the least is at e'r / r'r, the share of r that
    is noise (a shrinkage estimate [James61]_). The angle of the normals behaves alike.

    Parameters
    ----------
    x : ndarray of float64, shape (number of traits,)
        The traits of that filter's result, which is all of the way.

    Returns
    -------
    Part
    """
    # What is expected of all of the way, by trees that have seen other filters, too, tells much.
    X = np.concatenate([x, np.concatenate(forecast(x[None]))])[None]
    trees = forests()
    return Part(float(trees["part_of_normals"](X)[0]), float(trees["part_of_places"](X)[0]))


@cache
def forests() -> dict[str, Forest]:
    """The trees from the file that comes with the package.

    Returns
    -------
    dict of str to Forest
        log_ratio and gain, see `Forecast`; alone, for the log_ratio of one method's results;
        further and further_gain, see `change`; part_of_normals and part_of_places, see `Part`.
    """
    names = (
        "log_ratio",
        "gain",
        "alone",
        "further",
        "further_gain",
        "part_of_normals",
        "part_of_places",
    )
    with np.load(str(files("meshfair.denoising") / "forecast.npz")) as file:
        return {
            name: Forest(*(file[f"{name}/{field}"] for field in Forest._fields)) for name in names
        }
