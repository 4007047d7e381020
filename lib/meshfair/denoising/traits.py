"""Traits: what a noisy mesh and a filter's result on it show, in numbers.

By these `meshfair.denoising.forecast` tells how well a filter has done, without the ground
truth. They are ratios, angles, and lengths in mean edges of the noisy mesh, so that neither
scale nor place matters. Many compare a result with those of reference filters: where filters
that work in different ways agree, they are right more often than not. Others look for shape in
what a result has taken away, which is to be noise alone: what is taken shall be the same
everywhere, and in all directions [Buades05]_.

References
----------
.. [Buades05] A. Buades, B. Coll, J.-M. Morel, "A review of image denoising algorithms, with a
   new one", Multiscale Modeling & Simulation 4(2), 2005: section 2, the method noise.
.. [Weickert99] J. Weickert, "Coherence-enhancing diffusion filtering", International Journal of
   Computer Vision 31, 1999: section 2.2, the structure tensor and its coherence.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.sparse import csr_array, eye_array

from meshfair.checks import Floats, Integers
from meshfair.mesh import Edges, face_shapes, interior_edges, mean_edge_length, normalised
from meshfair.mesh.geometry import incidence
from meshfair.sure import high_passes, noise_by_differences

# Below these, logarithms and ratios are of rounding, not of a mesh.
LENGTH, RATIO, SQUARE = 1e-3, 1e-4, 1e-8
TINY = np.finfo(float).tiny  # in place of 0 where that would be divided by
POWERS = 4
"""Highest power of I - W~ whose output is looked at."""
FARTHEST = 6
"""Edges between vertices, at most, of which it is looked at whether they have moved alike."""
AROUND = 3
"""Edges to the vertices round another one over which local means are taken."""


class Traits:
    """Of one noisy mesh, and of what filters make of it.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
        Noisy positions.
    F : ndarray of int64, shape (m, 3)
    sigma : float, optional
        The noise size, as a fraction of the mean edge length, if it is known.
    """

    def __init__(self, V: Floats, F: Integers, sigma: float | None = None) -> None:
        self.V, self.F = V, F
        self.length, self.sigma = mean_edge_length(V, F), sigma
        self.B = incidence(F, len(V))
        self.edges = Edges.of_all(F, len(V))
        self.beside = interior_edges(F).faces.T
        self.N, self.area, _ = face_shapes(V, F)
        self.references: list[tuple[Floats, Floats]] = []
        self._away = at_distances(self.edges, FARTHEST)
        self._mean_around = mean_around(self._away[:AROUND])
        self._K = high_passes(F, len(V), POWERS)
        self._norms = [np.sqrt(K.power(2).sum(axis=1)) for K in self._K]
        for norm in self._norms:
            norm[norm == 0] = 1  # a vertex without faces has no neighbours

    def add_reference(self, X: Floats) -> None:
        """Add a filter's result, shape (n, 3), with which all results are compared."""
        self.references.append((X, face_shapes(X, self.F)[0]))

    def of_mesh(self) -> Floats:
        """The noisy mesh's own traits; the first reference's traits are among them.

        Returns
        -------
        ndarray of float64, shape (k,)
        """
        smooth = self._averaged(self.V)
        N, area, _ = face_shapes(smooth, self.F)
        n = self._vertex_normals(N, area)
        found: list[Any] = []
        rough = [self._high_frequencies(self.V, n, power) for power in range(POWERS)]
        for along, across in rough:
            low, middle, high, higher, highest = np.quantile(along, [0.25, 0.5, 0.75, 0.95, 0.995])
            found += [
                np.log(middle + LENGTH),
                np.log(_rms(along) + LENGTH),
                np.log((low + RATIO) / (high + RATIO)),
                np.log((higher + RATIO) / (middle + RATIO)),
                np.log((highest + RATIO) / (middle + RATIO)),
                np.log(np.median(across) + LENGTH),
            ]
        lengths = np.log(self.edges.lengths(self.V) / self.length + LENGTH)
        found += [*np.quantile(lengths, [0.05, 0.25, 0.75, 0.95])]
        degrees = np.bincount(self.edges.ends.ravel(), minlength=len(self.V))
        found += [np.mean(np.abs(degrees - 6))]
        bends = self._bends(self.N)
        found += [*np.quantile(bends, [0.1, 0.25, 0.5, 0.75, 0.9, 0.99]), bends.mean()]
        found += _spread(self._mean_around @ rough[2][0] ** 2)
        return np.array([*found, np.log(len(self.V)), *self.of_result(self.references[0][0])])

    def of_result(self, X: Floats) -> Floats:
        """The traits of a result.

        Parameters
        ----------
        X : ndarray of float64, shape (n, 3)

        Returns
        -------
        ndarray of float64, shape (k,)
        """
        i, j = self.edges.ends.T
        N, area, _ = face_shapes(X, self.F)
        along, across = self.residual(X)
        n = self._vertex_normals(N, area)
        square, square_across = np.mean(along**2) + SQUARE, _mean_dot(across, across) + SQUARE
        centred = along - along.mean()
        rough, _ = self._high_frequencies(X, n, 2)
        bends = self._bends(N)
        lengths = self.edges.lengths(X) / self.length
        found: list[Any] = [
            _angles(N, self.N).mean(),
            np.log(np.sqrt(square) + LENGTH),
            np.log(np.sqrt(square_across) + LENGTH),
            np.log((np.mean(np.abs(along)) + RATIO) / np.sqrt(square)),
            np.mean(along[i] * along[j]) / square,
            np.mean(along * self._averaged(self._averaged(along))) / square,
            _mean_dot(across[i], across[j]) / square_across,
            np.mean(along) / np.sqrt(square),
            *self.alike(centred)[1:],
            *self._shape_in(centred, X, n, self._coherence(centred, X, N, area)),
            np.log(np.median(rough) + LENGTH),
            np.log(_rms(rough) + LENGTH),
            bends.mean(),
            *np.quantile(bends, [0.25, 0.5, 0.75, 0.9, 0.97]),
            *(np.mean(bends < angle) for angle in (1, 3)),
            *(np.mean(bends > angle) for angle in (25, 90)),
            np.mean(np.sum(N * self.N, axis=1) < 0),
            np.log(max(area.sum(), TINY) / max(self.area.sum(), TINY)),
            np.log(lengths.mean() + SQUARE),
            lengths.std(),
        ]
        found += [_angles(N, other).mean() for _, other in self.references]
        for Y, _ in self.references:
            found.append(np.log(np.sqrt(_mean_dot(X - Y, X - Y)) / self.length + LENGTH))
        return np.array(found)

    def of_noise_size(self, X: Floats) -> Floats:
        """The known noise size beside its estimate, and beside what a result took away.

        Parameters
        ----------
        X : ndarray of float64, shape (n, 3)

        Returns
        -------
        ndarray of float64, shape (2,)
            Not numbers where it is unknown.
        """
        if self.sigma is None:
            return np.full(2, np.nan)
        sigma = self.sigma + LENGTH
        estimate, taken = noise_by_differences(self.V, self.F), _rms(self.residual(X)[0])
        return np.log([sigma / (estimate + LENGTH), (taken + LENGTH) / sigma])

    def residual(self, X: Floats) -> tuple[Floats, Floats]:
        """What a result has taken away, in mean edges: along its normals (n,), and across (n, 3).

        Parameters
        ----------
        X : ndarray of float64, shape (n, 3)

        Returns
        -------
        along : ndarray of float64, shape (n,)
        across : ndarray of float64, shape (n, 3)
        """
        N, area, _ = face_shapes(X, self.F)
        n, moved = self._vertex_normals(N, area), (self.V - X) / self.length
        along = np.sum(moved * n, axis=1)
        return along, moved - along[:, None] * n

    def _high_frequencies(self, X: Floats, n: Floats, power: int) -> tuple[Floats, Floats]:
        """Lengths of (I - W~)^(power + 1) X along normals n and across; 1 sigma for white noise."""
        D = (self._K[power] @ X) / self._norms[power][:, None] / self.length
        along = np.sum(D * n, axis=1)
        return np.abs(along), np.linalg.norm(D - along[:, None] * n, axis=1)

    def alike(self, x: Floats) -> list[float]:
        """How far vertices some edges apart have moved alike: relief that repeats shows in that.

        Parameters
        ----------
        x : ndarray of float64, shape (n,)

        Returns
        -------
        list of float
            Of vertices 1 .. FARTHEST edges apart, the mean product in the mean square.
        """
        square = np.mean(x**2) + SQUARE
        return [x @ (D @ x) / max(D.nnz, 1) / square for D in self._away]

    def _shape_in(self, x: Floats, X: Floats, n: Floats, coherence: Floats) -> list[float]:
        """Signs of shape in x, which a result X has taken away and which is to be noise.

        Heights x (n,) are in mean edges and of mean 0, along the vertex normals n (n, 3) of X
        (n, 3); their coherence (n,) is that of `_coherence`.
        """
        square = np.mean(x**2) + SQUARE
        bend = np.sum((X - self._averaged(X)) * n, axis=1) / self.length
        bend -= bend.mean()
        bends = np.abs(bend) + SQUARE
        return [
            *_spread(self._mean_around @ x**2),  # more in some places than in others
            np.mean((self._mean_around @ x) ** 2) / square,  # in bumps some edges wide
            np.abs(np.mean(x**3)) / square**1.5,  # bumps or dents, but not both
            np.mean(x * bend) / np.sqrt(square * (np.mean(bend**2) + SQUARE)),  # as X still bends
            np.log((np.mean(bends * x**2) / bends.mean() + SQUARE) / square),  # more where X bends
            coherence.mean(),  # along one direction
            np.quantile(coherence, 0.9),
        ]

    def _coherence(self, x: Floats, X: Floats, N: Floats, area: Floats) -> Floats:
        """How far x changes in one direction only, round each vertex: 1 for a wave, 0 for a bump.

        x (n,), as the result; N (m, 3) and area (m,) are of the faces of positions X (n, 3).
        (l1 - l2) / (l1 + l2) of the structure tensor's eigenvalues [Weickert99]_, which is flat:
        l1^2 + l2^2 is its squared norm, and l1 + l2 its trace.
        """
        P = X[self.F]
        sides = P[:, [2, 0, 1]] - P[:, [1, 2, 0]]  # opposite each corner
        G = np.einsum("fk,fki->fi", x[self.F], np.cross(N[:, None], sides))
        G /= np.sqrt(np.maximum(area, SQUARE * self.length**2))[:, None]
        T = self._mean_around @ (self.B @ (G[:, :, None] * G[:, None]).reshape(-1, 9))
        T /= T[:, [0, 4, 8]].sum(axis=1)[:, None] + TINY
        return np.sqrt(np.maximum(2 * np.sum(T**2, axis=1) - 1, 0))

    def _averaged(self, X: Floats) -> Floats:
        """W~ X."""
        return X - self._K[0] @ X

    def _bends(self, N: Floats) -> Floats:
        if not self.beside.size:  # a mesh of separate triangles
            return np.zeros(1)
        return _angles(*(N[faces] for faces in self.beside))

    def _vertex_normals(self, N: Floats, area: Floats) -> Floats:
        return normalised(self.B @ (N * area[:, None]))


def at_distances(edges: Edges, farthest: int) -> list[csr_array]:
    """Which vertices are 1, 2 .. ``farthest`` edges apart, as ones in a matrix for each.

    Parameters
    ----------
    edges : Edges
    farthest : int

    Returns
    -------
    list of csr_array of float64, each of shape (n, n)
    """
    i, j = edges.ends.T
    ones = np.ones(len(i), dtype=bool)
    A = csr_array((ones, (i, j)), shape=(edges.n, edges.n))
    reached = eye_array(edges.n, dtype=bool, format="csr")
    near = A + A.T + reached
    found = []
    for _ in range(farthest):
        before, reached = reached, reached @ near
        found.append(reached.astype(float) - before.astype(float))
        found[-1].eliminate_zeros()
    return found


def mean_around(away: Sequence[csr_array]) -> csr_array:
    """The mean over each vertex and those that are as far away as in some of `at_distances`.

    Parameters
    ----------
    away : sequence of csr_array of float64, each of shape (n, n)

    Returns
    -------
    csr_array of float64, shape (n, n)
        A matrix whose rows add up to 1.
    """
    near = sum(away, eye_array(away[0].shape[0], format="csr"))
    return csr_array(near / near.sum(axis=1)[:, None])


def _spread(square: Floats) -> list[float]:
    """How far mean squares at places are apart: low and high ones beside the middle one."""
    low, middle, high = np.log(np.quantile(square, [0.05, 0.5, 0.95]) + SQUARE)
    return [low - middle, high - middle]


def _angles(M: Floats, N: Floats) -> Floats:
    """Between unit vectors, in degrees."""
    return np.degrees(np.arccos(np.clip(np.sum(M * N, axis=1), -1, 1)))


def _rms(x: Floats) -> float:
    return float(np.sqrt(np.mean(x**2)))


def _mean_dot(x: Floats, y: Floats) -> float:
    return float(np.mean(np.sum(x * y, axis=1)))
