"""The choice of a method and its parameters, from the noisy mesh alone.

Each candidate is tried, on a sample of a large mesh; `meshfair.denoising.forecast` tells from
the traits of what comes of it how much of the noisy mesh's error is left, and the least wins.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from meshfair.checks import Booleans, Floats, Integers, MeshError
from meshfair.denoising.forecast import Forecast, best_part, change, forecast
from meshfair.denoising.registry import (
    BUILT_IN,
    STRENGTH,
    Parameters,
    defaults,
    distinct,
    find_method,
    same,
    with_noise,
)
from meshfair.denoising.rules import (
    AMONG_ALL,
    CHOSEN,
    LEFT_ALONE,
    NAMED,
    Caution,
    Results,
    ranking,
    rule_of,
    strength,
    weighed,
)
from meshfair.denoising.traits import Traits
from meshfair.filters.learned import MOVES
from meshfair.mesh import face_shapes, mean_edge_length
from meshfair.solve import SolveError

# Numbers of iterations at which a result is looked at, beside the last.
STEPS = frozenset((1, 2, 3, 5, 8, 12, 20, 30, 45))
# Among all methods: without those that are nearly another one.
ALL = tuple(name for name in BUILT_IN if name not in ("heat", "regularised", "bilateral"))
# Filters whose results all others are compared with: in the order of the forecast's traits.
REFERENCES: tuple[tuple[str, Parameters], ...] = (
    ("learned", {}),
    ("learned", {"stages": 1}),
    *((name, {}) for name in ("taubin", "averaging", "feature-convinced", "bilateral-normal")),
    *((name, {}) for name in ("l0", "sun", "guided-normal", "bilateral")),
)
WHOLE = 6_000
"""Faces up to which a mesh is tried whole, as training's are; of a larger one `PATCHES` patches."""
PATCHES, PATCH, INNER = 4, 800, 500
"""How many, their faces, and those inside of a patch that are looked at: a filter makes of a
patch's border what it would not make of it in the mesh."""
# Of what the learned filter takes away: mean size over root mean square, which is below this for
# noise on some vertices in 19 of 20 of training's meshes, and for other noise in 1 of 20; and
# the correlation of neighbours, above this for correlated noise in 3 of 4, for other in 1 of 10.
SPARSE, CORRELATED = 0.72, 0.1
# What the learned filter takes away is relief, where vertices three edges apart have moved more
# alike than those two edges apart, by this much, and neighbours less alike than this;
REPEATS, NEIGHBOURS = 0.12, 0.3
# or, where noise that is alike at neighbours hides that, where those two and four edges apart have
# moved oppositely, by this much, and those between them more alike by as much. On 20 of 23 meshes
# that show either, and that were made after these bounds were set, the filter does harm.
OPPOSITE = 0.04
# Noise, in mean edges, below which there is no error of which to tell how much is left.
HARDLY = 1e-3
HARDLY_ANY = f"hardly any noise, less than {HARDLY:g} edges"
USUAL = "learned"
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
    X: Floats
    """Its result on the sample."""
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
        Parameters that are given, for all candidates; ``fixed`` as a mask. A given
        ``strength`` plays no part in the choice: what is chosen is done by so much.
    sigma : float, optional
        The known noise size.
    report : function
        Called with the progress, 0 to 1.

    Attributes
    ----------
    vertices : ndarray of int64, shape (l,)
        Those of the sample that candidates are looked at by: its inside, see `Sample`.
    V, F
        Its positions and faces, as V and F are given.
    traits : Traits
        Of these.
    failed : list of (dict, SolveError)
        Parameters that could not be tried, and why.
    trials : int
        How many parameters were.

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
        self._sample = sample(V, F, chosen.get("fixed"))
        self._start = V[self._sample.vertices]
        self.vertices, self.F = self._sample.vertices[self._sample.inner], self._sample.F_inner
        self.V, self.report = V[self.vertices], report
        self.chosen = {name: value for name, value in chosen.items() if name != STRENGTH}
        self.strength: float | None = chosen.get(STRENGTH)
        if chosen.get("fixed") is not None:
            self.chosen |= {"fixed": chosen["fixed"][self._sample.vertices]}
        self.sigma = sigma
        self.traits = Traits(self.V, self.F, sigma)
        self.failed: list[tuple[Parameters, SolveError]] = []
        self.trials = 0
        self._known = list(self._passed_by())
        for number, (name, parameters) in enumerate(REFERENCES, start=1):
            self.traits.add_reference(self._reference(name, self._whole(name, parameters)))
            report(0.5 * number / len(REFERENCES))

    def ranked(self, names: Sequence[str]) -> list[Choice]:
        """All candidates of some methods, the best one first.

        Parameters
        ----------
        names : sequence of str

        Returns
        -------
        list of Choice

        Raises
        ------
        SolveError
            No candidate can be solved.
        """
        candidates = self.candidates(names)
        usual = USUAL if len(names) > 1 else names[0]
        is_usual = np.array([c.stop is None and c.method == usual for c in candidates])
        first = np.flatnonzero(is_usual)[:1]
        if self._is_whole and _rms(self._taken()) < HARDLY:
            k = int(first[0]) if len(first) else 0
            return [self._choice(self.part(candidates[k], 0.0), 1.0, HARDLY_ANY)]
        expected = forecast(self.rows(candidates), alone=len(names) == 1)
        untouched = np.array([c.X is self.V for c in candidates])
        results = Results(untouched, is_usual, self.moved(candidates), self.takes_relief())
        rule = AMONG_ALL if len(names) > 1 else rule_of(usual)
        score = ranking(expected, results, rule)
        why_not = "nothing promises to bring it closer to the true mesh"
        if results.relief and rule.leaves_relief:
            why_not = "what filters would take away repeats, as a relief does"
        order = np.argsort(score, kind="stable")
        caution = None
        if order[0] in first:
            caution = NAMED if len(names) == 1 else CHOSEN
        elif untouched[order[0]] and not results.relief:
            caution = LEFT_ALONE
        choices: list[Choice] = []
        if caution and usual == USUAL and len(first) and not set(self.chosen) - {"fixed"}:
            choices = self._refined(candidates[first[0]], expected, first[0], caution)
        for k in order:
            choices.append(self._choice(candidates[k], float(expected.ratio[k]), why_not))
        if self.strength is None:
            return choices
        return self._by_so_much(choices, self.strength, "the strength is 0")

    def candidates(self, names: Sequence[str]) -> list[Candidate]:
        """Try all candidates of some methods.

        Parameters
        ----------
        names : sequence of str

        Returns
        -------
        list of Candidate

        Raises
        ------
        SolveError
            None can be solved.
        """
        trials = [(name, p) for name in names for p in self._parameters(name)]
        self.trials = len(trials)
        candidates: list[Candidate] = []
        for number, (name, parameters) in enumerate(trials, start=1):
            try:
                for result in self._results(name, parameters):
                    if not _comes_again(result, candidates):
                        candidates.append(result)
            except SolveError as error:
                self.failed.append((parameters, error))
            self.report(0.5 + 0.5 * number / len(trials))
        if not candidates:
            raise self.failed[0][1]
        return candidates

    def further(self) -> list[Candidate]:
        """Results of the usual method, where it goes on for longer than by its defaults.

        Returns
        -------
        list of Candidate
        """
        counts = find_method(USUAL).further.items()
        longer = [self._whole(USUAL, {name: k}) for name, several in counts for k in several]
        return [c for parameters in longer for c in self._found(USUAL, parameters)]

    def rows(self, candidates: list[Candidate]) -> Floats:
        """The traits of candidates, as `meshfair.denoising.forecast` takes them.

        Parameters
        ----------
        candidates : list of Candidate

        Returns
        -------
        ndarray of float64, shape (number of candidates, number of traits)
        """
        of_mesh, traits = self.traits.of_mesh(), self.traits
        return np.array(
            [
                np.concatenate([of_mesh, traits.of_result(c.X), traits.of_noise_size(c.X)])
                for c in candidates
            ]
        )

    def moved(self, candidates: list[Candidate]) -> Floats:
        """How far candidates have moved the vertices along the normals, root mean square in edges.

        Parameters
        ----------
        candidates : list of Candidate

        Returns
        -------
        ndarray of float64, shape (number of candidates,)
        """
        return np.array([_rms(self.traits.residual(c.X)[0]) for c in candidates])

    def takes_relief(self) -> bool:
        """Whether what the usual filter takes away repeats along the surface.

        Returns
        -------
        bool
        """
        along = self._taken()
        one, two, three, four, *_ = self.traits.alike(along - along.mean())
        strong = three - two > REPEATS and one < NEIGHBOURS
        return strong or (max(two, four) < -OPPOSITE and three - (two + four) / 2 > OPPOSITE)

    def part(self, candidate: Candidate, strength: float) -> Candidate:
        """What comes of a candidate at some strength.

        Parameters
        ----------
        candidate : Candidate
        strength : float
            The part of the way to its result.

        Returns
        -------
        Candidate
        """
        parameters = candidate.parameters | {STRENGTH: strength}
        if strength == 0 or candidate.X is self.V:
            return candidate._replace(parameters=parameters, X=self.V)
        X = candidate.X if strength == 1 else self.V + strength * (candidate.X - self.V)
        return candidate._replace(parameters=parameters, X=X)

    def _refined(
        self, usual: Candidate, expected: Forecast, k: int, caution: Caution
    ) -> list[Choice]:
        """What is better than the usual result, the k-th of those that are expected, if anything.

        A part of the way to it, or, where all of the way is not in doubt, one that goes on from it.
        """
        left = caution is LEFT_ALONE
        s = strength(best_part(self.rows([usual])[0]), caution)
        if s == 0 and left:
            return []
        if s < 1 and self.strength is None:
            whole = self._choice(usual, float(expected.ratio[k]), "")
            why_not = "filters would take away more detail than noise"
            return self._by_so_much([whole], s, why_not, ": beyond, detail would go")
        further = [] if left else self.further()
        if further:
            expected = expected.changed(k, change(self.rows(further)))
            k = int(weighed(expected, AMONG_ALL).argmin())
            usual = [usual, *further][k]
        return [self._choice(usual, float(expected.ratio[k]), "")]

    def _by_so_much(
        self, choices: list[Choice], strength: float, why_not: str, beyond: str = ""
    ) -> list[Choice]:
        """The choices, each a part of the way to its result; why not, where that is nothing."""
        parts = [self.part(Candidate(*c[:4]), strength) for c in choices]
        ratios = [c.ratio for c in choices]
        if strength < 1:  # by the trees for one method's results: the others promise too much
            ratios = forecast(self.rows(parts), alone=True).ratio.tolist()
        found = []
        for c, part, ratio in zip(choices, parts, ratios, strict=True):
            told = self._choice(part, ratio, why_not)
            reason = f"{told.reason}, {strength:g} of the way{beyond}"
            if part.X is self.V:
                reason = c.reason if c.X is self.V else told.reason
            found.append(told._replace(reason=reason))
        return found

    def _choice(self, c: Candidate, ratio: float, why_not: str) -> Choice:
        """A candidate with what is expected of it, and, where it is the noisy mesh, why."""
        if c.X is self.V:
            return Choice(*c, 1.0, f"left as it is: {why_not}")
        if _rms(self._taken()) < HARDLY:
            return Choice(*c, ratio, HARDLY_ANY)
        return Choice(*c, ratio, f"{self.noise}; {ratio:.0%} of the error should be left")

    def _parameters(self, name: str) -> list[Parameters]:
        """Those of a method's trials, each once: its defaults first."""
        given = with_noise(name, self.chosen, self.sigma)
        return distinct(defaults(name) | p | given for p in ({}, *find_method(name).candidates))

    def _passed_by(self) -> Iterator[Candidate]:
        """The usual method's results that the longest run of it passes by."""
        ((name, counts),) = find_method(USUAL).further.items()
        longest = self._whole(USUAL, {name: max(counts)})
        # The vertices are moved so often in each stage, and last for longer.
        passed = {MOVES: {"stages": 1}, 2 * MOVES: {}} | {MOVES + k: {name: k} for k in counts}
        last, count = self._start, 0
        for _, X in self._run(USUAL, longest):
            if X is not last:
                last, count = X, count + 1
                if count in passed:
                    parameters = self._whole(USUAL, passed[count])
                    yield Candidate(USUAL, parameters, None, self._inside(X))

    def _whole(self, name: str, parameters: Parameters) -> Parameters:
        """A method's parameters with its defaults, and the vertices that stay."""
        fixed = {"fixed": self.chosen["fixed"]} if "fixed" in self.chosen else {}
        return defaults(name) | parameters | fixed

    def _found(self, name: str, parameters: Parameters) -> list[Candidate]:
        """What is known already of these parameters: one candidate, or none."""
        return [c for c in self._known if c.method == name and same(parameters, c.parameters)]

    def _reference(self, name: str, parameters: Parameters) -> Floats:
        """What comes of a reference; the noisy mesh stands for what cannot be solved."""
        if not (found := self._found(name, parameters)):
            try:
                *_, (_, X) = self._run(name, parameters)
            except SolveError:
                return self.V
            found = [Candidate(name, parameters, None, self._inside(X))]
            self._known += found
        return found[0].X

    def _run(self, name: str, parameters: Parameters) -> Iterator[tuple[float, Floats]]:
        """A method on the patches."""
        method, V, F = find_method(name), self._start, self._sample.F
        return method.states(V, F, method.filled_in(V, F, parameters))

    def _results(self, name: str, parameters: Parameters) -> Iterator[Candidate]:
        """What comes of a trial; where it is the method's only one, after fewer iterations, too."""
        method = find_method(name)
        if method.count:
            yield Candidate(name, parameters, 0, self.V)
        if len(method.candidates) > 1 and (known := self._found(name, parameters)):
            yield known[0]
            return
        last, count = self._start, 0
        for _, X in self._run(name, parameters):
            if X is not last:
                if len(method.candidates) == 1 and method.count and count in STEPS:
                    yield Candidate(name, parameters, count, self._inside(last))
                last, count = X, count + 1
        yield Candidate(name, parameters, None, self._inside(last))

    def _inside(self, X: Floats) -> Floats:
        """Of positions on the patches those that are looked at."""
        return self.V if X is self._start else X[self._sample.inner]

    def _taken(self) -> Floats:
        """What the usual filter takes away along the normals, in mean edges, shape (l,)."""
        return self.traits.residual(self.traits.references[0][0])[0]

    @property
    def _is_whole(self) -> bool:
        """Whether it is all of the mesh's faces that are looked at."""
        return self._sample.F is self._sample.F_inner

    @cached_property
    def noise(self) -> str:
        """What the noise looks like, in words."""
        along, (i, j) = self._taken(), self.traits.edges.ends.T
        size = _rms(along)
        kind = ""
        if np.mean(np.abs(along)) < SPARSE * size:
            kind = ", mostly at some vertices"
        elif np.mean(along[i] * along[j]) > CORRELATED * size**2:
            kind = ", alike at neighbours"
        return f"noise of {size:.2g} edges{kind}"


def _rms(x: Floats) -> float:
    return float(np.sqrt(np.mean(x**2)))


def _comes_again(result: Candidate, earlier: list[Candidate]) -> bool:
    """Whether it is one on the way to another result, and the method has led there before."""
    return result.stop is not None and any(
        c.method == result.method and np.array_equal(c.X, result.X) for c in earlier
    )


class Sample(NamedTuple):
    """Some patches of a mesh, or all faces of a small one."""

    vertices: Integers
    """Which ones of the mesh's, shape (k,)."""
    F: Integers
    """Their faces, by positions in ``vertices``; shape (m, 3)."""
    inner: Integers
    """Which ones of ``vertices`` lie inside, away from the patches' borders; shape (l,)."""
    F_inner: Integers
    """The faces inside, by positions in ``inner``; shape (p, 3)."""


def sample(V: Floats, F: Integers, fixed: Booleans | None = None) -> Sample:
    """A small mesh without vertices that have no face, or some patches of a large one.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    fixed : ndarray of bool, shape (n,), optional
        Vertices that stay: patches are round faces with others, if there are any.

    Returns
    -------
    Sample
    """
    if len(F) <= WHOLE:
        vertices, small = np.unique(F, return_inverse=True)
        small = small.reshape(-1, 3)
        return Sample(vertices, small, np.arange(len(vertices)), small)
    C = face_shapes(V, F)[2]
    axis = np.linalg.svd(np.cov(C.T))[0][:, 0]  # along which the mesh is longest
    order = np.argsort(C @ axis, kind="stable")
    if fixed is not None and len(free := order[~fixed[F[order]].all(axis=1)]):
        order = free
    centres = C[order[(2 * np.arange(PATCHES) + 1) * len(order) // (2 * PATCHES)]]
    near = cKDTree(C).query(centres, PATCH)[1]  # the nearest first
    vertices, small = np.unique(F[np.unique(near)], return_inverse=True)
    within, small_within = np.unique(F[np.unique(near[:, :INNER])], return_inverse=True)
    inner = np.searchsorted(vertices, within)
    return Sample(vertices, small.reshape(-1, 3), inner, small_within.reshape(-1, 3))
