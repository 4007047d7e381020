"""The choice of a method and its parameters, from the noisy mesh alone.

Each candidate is tried, on a sample of a large mesh; `meshfair.denoising.forecast` tells from
the traits of what comes of it how much of the noisy mesh's error is left, and the least wins.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from meshfair.checks import Floats, Integers, MeshError
from meshfair.denoising.forecast import forecast
from meshfair.denoising.registry import (
    Parameters,
    defaults,
    distinct,
    find_method,
    with_noise,
)
from meshfair.denoising.traits import Traits
from meshfair.mesh import face_shapes, mean_edge_length
from meshfair.solve import SolveError

# Numbers of iterations at which a result is looked at, beside the last.
STEPS = frozenset((0, 1, 2, 3, 5, 8, 12, 20, 30, 45))
# Filters whose results all others are compared with: in the order of the forecast's traits.
REFERENCES: tuple[tuple[str, Parameters], ...] = (
    ("learned", {}),
    ("learned", {"stages": 1}),
    *((name, {}) for name in ("taubin", "averaging", "feature-convinced", "bilateral-normal")),
    *((name, {}) for name in ("l0", "sun", "guided-normal", "bilateral")),
)
WHOLE = 6_000
"""Faces up to which a mesh is tried whole; of a larger one `PATCHES` patches are."""
PATCHES, PATCH = 4, 1_000
# What another choice than the one that is right most often has to promise more, in log ratio;
# and the gain (decibels) below which a choice counts as worse, each decibel as much as WORTH.
MARGIN, GAIN, WORTH = 0.05, 0.3, 0.05
# What the residual's parts look like for each kind of noise: measured on training's meshes.
ISOTROPIC, IMPULSIVE, CORRELATED = 0.9, 0.3, 0.3
FIRST = "learned"
"""The method that is chosen where nothing speaks for another."""


class Candidate(NamedTuple):
    """A method with parameters, and what comes of it on the sample."""

    method: str
    parameters: Parameters
    """With None where the mesh decides."""
    stop: int | None
    """The number of new positions after which it stops; None: it runs to its end."""
    X: Floats
    """Its result, shape (n, 3)."""


class Choice(NamedTuple):
    """A method with parameters, as in `Candidate`, and what is expected of it."""

    method: str
    parameters: Parameters
    stop: int | None
    ratio: float
    """The normals' error after and before."""
    reason: str
    """Why it was chosen, in a sentence."""


class Chooser:
    """Tries candidates on a mesh.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
        Noisy positions.
    F : ndarray of int64, shape (m, 3)
    chosen : dict
        Parameters that are given, for all candidates; ``fixed`` as a mask.
    sigma : float, optional
        The known noise size.
    report : function
        Called with the progress, 0 to 1.

    Raises
    ------
    MeshError
        All edges have length 0.
    """

    def __init__(
        self,
        V: Floats,
        F: Integers,
        chosen: Parameters,
        sigma: float | None,
        report: Callable[[float], None],
    ) -> None:
        if mean_edge_length(V, F) == 0:
            raise MeshError(
                "V, F: all edges have length 0, so that no noise can be told from shape"
            )
        vertices, self.F = sample(V, F)
        self.V, self.chosen, self.report = V[vertices], chosen, report
        if chosen.get("fixed") is not None:
            self.chosen = chosen | {"fixed": chosen["fixed"][vertices]}
        self.sigma = sigma
        self.traits = Traits(self.V, self.F, sigma)
        self.failed: list[tuple[Parameters, SolveError]] = []
        self.tried = 0

    def ranked(self, names: list[str]) -> list[Choice]:
        """All candidates of some methods, the best one first.

        Parameters
        ----------
        names : list of str

        Returns
        -------
        list of Choice

        Raises
        ------
        SolveError
            No candidate can be solved.
        """
        trials = [(name, p) for name in names for p in self._parameters(name)]
        self.tried, steps = len(trials), len(REFERENCES) + len(trials)
        for number, (name, parameters) in enumerate(REFERENCES, start=1):
            self.traits.add_reference(self._reference(name, defaults(name) | parameters))
            self.report(number / steps)
        candidates: list[Candidate] = []
        for number, (name, parameters) in enumerate(trials, start=len(REFERENCES) + 1):
            try:
                candidates += self._results(name, parameters)
            except SolveError as error:
                self.failed.append((parameters, error))
            self.report(number / steps)
        if not candidates:
            raise self.failed[0][1]
        return self._choices(candidates, FIRST if len(names) > 1 else names[0])

    def _parameters(self, name: str) -> list[Parameters]:
        """Those of a method's trials, each once: its defaults first."""
        given = with_noise(name, self.chosen, self.sigma)
        return distinct(defaults(name) | p | given for p in ({}, *find_method(name).candidates))

    def _reference(self, name: str, parameters: Parameters) -> Floats:
        try:
            *_, (_, X) = find_method(name).function(
                self.V, self.F, **self._filled(name, parameters)
            )
        except SolveError:
            return self.V
        return X

    def _filled(self, name: str, parameters: Parameters) -> Parameters:
        return find_method(name).filled_in(self.V, self.F, parameters)

    def _results(self, name: str, parameters: Parameters) -> Iterator[Candidate]:
        """What comes of a trial, after some of its iterations where it can stop there."""
        method = find_method(name)
        last, count = self.V, 0
        for _, X in method.function(self.V, self.F, **self._filled(name, parameters)):
            if X is not last:
                if method.count and count in STEPS:
                    yield Candidate(name, parameters, count, last)
                last, count = X, count + 1
        yield Candidate(name, parameters, None, last)

    def _choices(self, candidates: list[Candidate], usual: str) -> list[Choice]:
        """The candidates by what is expected of them."""
        mesh = self.traits.of_mesh()
        rows = [
            np.concatenate([mesh, self.traits.of_result(c.X), self.traits.of_noise_size(c.X)])
            for c in candidates
        ]
        expected = forecast(np.array(rows))
        untouched = np.array([c.X is self.V for c in candidates])
        score = expected.log_ratio + WORTH * np.maximum(0, GAIN - expected.gain)
        score = np.where(untouched, 0, score)
        is_usual = np.array([c.stop is None and c.method == usual for c in candidates])
        score[np.flatnonzero(is_usual)[:1]] -= MARGIN  # the first one has the defaults
        ratio = np.where(untouched, 1, expected.ratio)
        return [
            Choice(c.method, c.parameters, c.stop, float(ratio[k]), self._reason(c, ratio[k]))
            for k in np.argsort(score, kind="stable")
            for c in (candidates[k],)
        ]

    def _reason(self, candidate: Candidate, ratio: float) -> str:
        """What the noise looks like beside the result, and what is left of it."""
        if candidate.X is self.V:
            return "left as it is: nothing promises to bring it closer to the true mesh"
        along, across = self.traits.residual(candidate.X)
        size = np.sqrt(np.mean(along**2))
        words = ["along the normals", "in all directions"]
        kind = words[int(np.sqrt(np.mean(np.sum(across**2, axis=1))) > ISOTROPIC * size)]
        if np.median(np.abs(along)) < IMPULSIVE * size:
            kind += ", at some vertices more"
        i, j = self.traits.edges.ends.T
        if np.mean(along[i] * along[j]) > CORRELATED * size**2:
            kind += ", alike at neighbours"
        return f"noise of {size:.2g} edges {kind}; {ratio:.0%} of the error should be left"


def sample(V: Floats, F: Integers) -> tuple[Integers, Integers]:
    """A mesh's vertices and faces, or those of some patches of a large one.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)

    Returns
    -------
    vertices : ndarray of int64, shape (k,)
        Which ones they are.
    F : ndarray of int64, shape (l, 3)
        Their faces, by positions in ``vertices``.
    """
    if len(F) <= WHOLE:
        return np.arange(len(V)), F
    C = face_shapes(V, F)[2]
    axis = np.linalg.svd(np.cov(C.T))[0][:, 0]  # along which the mesh is longest
    order = np.argsort(C @ axis, kind="stable")
    centres = C[order[(2 * np.arange(PATCHES) + 1) * len(F) // (2 * PATCHES)]]
    faces = np.unique(cKDTree(C).query(centres, PATCH)[1])
    vertices, small = np.unique(F[faces], return_inverse=True)
    return vertices, small.reshape(-1, 3)
