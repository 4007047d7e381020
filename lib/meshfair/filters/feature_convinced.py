"""Feature-convinced denoising: find the creases first, and never average across them.

References
----------
.. [LLL19] T. Li, W. Liu, H. Liu, J. Wang, L. Liu, "Feature-convinced mesh denoising",
   Graphical Models 101, 2019.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import (
    Floats,
    Integers,
    check_count,
    check_fixed,
    check_mesh,
    check_number,
)
from meshfair.filters.creases import crease_edges, crease_guidance
from meshfair.filters.diffusion import taubin
from meshfair.filters.neighbourhoods import face_rings
from meshfair.filters.normal_filtering import joint_bilateral, move_vertices, spatial_weights, sun
from meshfair.mesh import Edges, face_shapes, interior_edges
from meshfair.mesh.geometry import incidence


class Effort(NamedTuple):
    """How much work a level of noise asks for."""

    noise: float
    """Meant for estimated noise below this, in mean edge lengths."""
    taubin_iterations: int
    """Iterations of Taubin's filter on the copy in which creases are found."""
    sun_iterations: int
    """Iterations of Sun's filter on it."""
    crease_cosine: float
    """Edges may be creases where the cosine of their two normals is smaller."""
    normal_iterations: int
    """Iterations of the joint bilateral filter in an iteration."""
    iterations: int
    """How often all is done."""


# The table of [LLL19].
EFFORTS = (
    Effort(0.10, 0, 5, 0.75, 3, 3),
    Effort(0.25, 1, 8, 0.85, 4, 4),
    Effort(0.45, 2, 10, 0.82, 6, 6),
    Effort(np.inf, 2, 12, 0.78, 8, 8),
)


# How often Sun's filter moves the vertices of the copy in which creases are found [LLL19].
PREFILTER_MOVES = 4


def effort_for(noise: float) -> Effort:
    """The effort for a level of noise [LLL19]_.

    Parameters
    ----------
    noise : float
        As a fraction of the mean edge length.

    Returns
    -------
    Effort
        The first of `EFFORTS` that is meant for noise above this.
    """
    return next(effort for effort in EFFORTS if noise < effort.noise)


def noise_by_lengths(V: ArrayLike, F: ArrayLike) -> float:
    """The size of the noise, by the lengths of the edges [LLL19]_.

    Noise makes edges longer. With normal displacements of standard deviation
    sigma, the mean squared edge length grows by 2 sigma^2. Against a copy that
    Sun's filter has smoothed (T = 0.4, 4 normal and 4 vertex iterations),

        sigma / mean edge = sqrt( msel(V) / (2 msel(smoothed)) - 1/2 ).

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    float
        As a fraction of the noisy mesh's mean edge length.

    Raises
    ------
    MeshError
        No mesh.
    """
    V, F = check_mesh(V, F)
    smoothed = _last(
        sun(V, F, threshold=0.4, normal_iterations=4, vertex_iterations=4, fix_boundary=False), V
    )
    edges = Edges(F, len(V))
    if not len(edges):  # every face names one vertex three times
        return 0.0
    before, after = (float(np.mean(edges.lengths(X) ** 2)) for X in (V, smoothed))
    return float(np.sqrt(max(0.0, before / after - 1) / 2)) if after > 0 else 0.0


def fill_in(V: Floats, F: Integers, parameters: dict[str, Any]) -> dict[str, Any]:
    """The parameters of `feature_convinced`, with those that are None chosen from the mesh.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    parameters : dict
        With the keys noise and iterations, and any others.

    Returns
    -------
    dict
    """
    noise, iterations = parameters["noise"], parameters["iterations"]
    noise = noise_by_lengths(V, F) if noise is None else check_number(noise, "noise", 0)
    iterations = (
        effort_for(noise).iterations
        if iterations is None
        else check_count(iterations, "iterations")
    )
    return parameters | {"noise": noise, "iterations": iterations}


def feature_convinced(
    V: ArrayLike,
    F: ArrayLike,
    *,
    noise: float | None = None,
    iterations: int | None = None,
    vertex_iterations: int = 2,
    sigma_normal: float = 0.35,
    gap: int = 5,
    shortest: int = 2,
    fixed: ArrayLike | None = None,
) -> Iterator[tuple[float, Floats]]:
    """Feature-convinced denoising [LLL19]_, as an iterator: no normals mix across creases.

    In each iteration

    1. a copy is smoothed by Taubin's and by Sun's filter, and the lines of its
       creases are traced, see `meshfair.filters.creases.crease_edges`;
    2. each face gets a guidance normal, the mean over up to 12 faces around
       it that are reached without crossing a crease, see
       `meshfair.filters.creases.crease_guidance`;
    3. the normals are averaged by the joint bilateral filter over the faces
       that share a vertex;
    4. the vertices are moved to fit them; one that would move further than an
       edge (the root of the mean squared length) keeps its place.

    How much of each is done depends on the noise: see `EFFORTS`.

    Parameters
    ----------
    V, F, fixed
        As in `meshfair.filters.averaging`.
    noise : float, optional
        Size of the noise, as a fraction of the mean edge length. If it is not
        given, `noise_by_lengths` estimates it.
    iterations : int, optional
        As many as the noise asks for if not given.
    vertex_iterations : int
        How often the vertices are moved in an iteration.
    sigma_normal : float
        The difference of two guidance normals from which on normals hardly mix.
    gap : int
        This many edges that are no candidates may be bridged along a crease, and
        one more up to an earlier line.
    shortest : int
        Crease lines of fewer edges are dropped.

    Yields
    ------
    progress, V
        As `meshfair.filters.averaging`.

    Raises
    ------
    MeshError, ValueError
        As `meshfair.filters.averaging`.
    """
    V, F = check_mesh(V, F)
    vertex_iterations = check_count(vertex_iterations, "vertex_iterations", 1)
    sigma_normal = check_number(sigma_normal, "sigma_normal", 0, open_low=True)
    gap, shortest = check_count(gap, "gap"), check_count(shortest, "shortest")
    fixed = check_fixed(fixed, len(V))
    filled = fill_in(V, F, {"noise": noise, "iterations": iterations})
    effort, iterations = effort_for(filled["noise"]), filled["iterations"]
    H = interior_edges(F)
    edges = Edges(F, len(V))
    if not len(edges):
        return
    B = incidence(F, len(V))
    R = face_rings(B)
    parts = effort.sun_iterations + PREFILTER_MOVES + effort.normal_iterations + 1
    for k in range(iterations):
        step, copy = 0, V
        for copy in prefiltered(V, F, effort):  # noqa: B007
            step += 1
            yield (k + step / parts) / iterations, V
        crease = crease_edges(copy, H, effort.crease_cosine, gap=gap, shortest=shortest)
        N, area, C = face_shapes(V, F)
        G = crease_guidance(H.faces[~crease], N, area, C)
        longest = float(np.sqrt(np.mean(edges.lengths(V) ** 2)))
        S = spatial_weights(R, C, area, longest)
        for _ in range(effort.normal_iterations):
            step += 1
            yield (k + step / parts) / iterations, V
            N = joint_bilateral(S, N, G, sigma_normal)
        for _ in range(vertex_iterations):
            moved = move_vertices(V, F, B, N, fixed)
            too_far = np.linalg.norm(moved - V, axis=1) > longest
            V = np.where(too_far[:, None], V, moved)
        yield (k + 1) / iterations, V


def prefiltered(V: Floats, F: Integers, effort: Effort) -> Iterator[Floats]:
    """A copy on its way to be smooth enough to find creases in [LLL19]_.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    effort : Effort

    Yields
    ------
    ndarray of float64, shape (n, 3)
        After each iteration of Sun's filter; the last one is the copy.
    """
    V = _last(taubin(V, F, lam=0.6, mu=-0.636, iterations=effort.taubin_iterations), V)
    smooth = sun(
        V,
        F,
        threshold=0.4,
        normal_iterations=effort.sun_iterations,
        vertex_iterations=PREFILTER_MOVES,
        fix_boundary=False,
    )
    yield from (X for _, X in smooth)


def _last(states: Iterator[tuple[float, Floats]], V: Floats) -> Floats:
    """The last positions that a filter yields; V where it yields none."""
    for _, V in states:  # noqa: B007
        pass
    return V
