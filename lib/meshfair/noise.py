"""Noise on vertex positions.

Every function returns new positions and leaves its input alone. A noise size
``sigma`` is a fraction of the mean edge length, so that it means the same on
a mesh in metres and on one in millimetres. Copies of a vertex along a seam (see
`meshfair.mesh.join`) move as one.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array, diags_array, eye_array

from meshfair.checks import (
    MOST_PAIRS,
    Floats,
    Integers,
    MeshError,
    check_choice,
    check_count,
    check_mesh,
    check_number,
    check_rng,
    check_same_vertices,
    check_vertices,
    warn,
)
from meshfair.mesh import Edges, mean_edge_length, vertex_normals
from meshfair.mesh.joining import on_joined
from meshfair.mesh.objects import takes_meshes

SNR_RANGE = -300.0, 300.0
"""In decibels: beyond, noise is lost in the rounding of float64, and so is the mesh."""


@takes_meshes
@on_joined
def along_normals(V: ArrayLike, F: ArrayLike, sigma: float, rng: np.random.Generator) -> Floats:
    """White noise along the vertex normals: the original report's noise model.

    v~_i = v_i + eps (R n_i) with R ~ N(0, 1) drawn for each vertex (the
    original report, section 1) and eps = ``sigma`` times the mean edge length.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    sigma : float
        Standard deviation, as a fraction of the mean edge length.
    rng : numpy.random.Generator

    Returns
    -------
    ndarray of float64, shape (n, 3)
        A vertex without a normal stays where it is: one without faces, or one
        whose faces' normals cancel, of which a `MeshWarning` tells.

    Raises
    ------
    MeshError, ValueError, TypeError
        No mesh; ``sigma`` negative or not finite; ``rng`` not a generator.
    """
    V, F = check_mesh(V, F)
    eps = check_number(sigma, "sigma", 0) * mean_edge_length(V, F)
    R = check_rng(rng).standard_normal((len(V), 1))
    normals = vertex_normals(V, F)
    _warn_of_cancelled(normals, F)
    return V + eps * R * normals


def _warn_of_cancelled(normals: Floats, F: Integers) -> None:
    """Warn of vertices that have faces and no normal."""
    cancelled = np.setdiff1d(F, np.flatnonzero(normals.any(axis=1)))
    if len(cancelled):
        warn(
            f"the faces' normals cancel at {len(cancelled):,} vertices (the first is "
            f"{cancelled[0]}), which noise leaves where they are; mesh.inspect says why, such as "
            "faces that are turned against each other"
        )


@takes_meshes
@on_joined
def gaussian(V: ArrayLike, F: ArrayLike, sigma: float, rng: np.random.Generator) -> Floats:
    """Isotropic Gaussian noise: each coordinate moved by eps N(0, 1).

    Parameters
    ----------
    V, F, sigma, rng
        As in `along_normals`.

    Returns
    -------
    ndarray of float64, shape (n, 3)

    Raises
    ------
    MeshError, ValueError, TypeError
        As `along_normals`.
    """
    V, F = check_mesh(V, F)
    eps = check_number(sigma, "sigma", 0) * mean_edge_length(V, F)
    return V + eps * check_rng(rng).standard_normal(V.shape)


@takes_meshes
def uniform(V: ArrayLike, amplitude: float, rng: np.random.Generator) -> Floats:
    """Each coordinate plus a uniform draw from [0, amplitude).

    The noise that the original report's Table 1 was made with (that of Open3D's
    mesh-filtering tutorial). Its mean is amplitude / 2 along each axis: it
    also shifts the whole mesh, which no filter can undo.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    amplitude : float
        In the units of ``V``, not a fraction of the edge length.
    rng : numpy.random.Generator

    Returns
    -------
    ndarray of float64, shape (n, 3)

    Raises
    ------
    MeshError, ValueError, TypeError
        No vertices; ``amplitude`` negative or not finite; ``rng`` not a generator.
    """
    V = check_vertices(V)
    amplitude = check_number(amplitude, "amplitude", 0)
    return V + amplitude * check_rng(rng).random(V.shape)


@takes_meshes
@on_joined
def impulsive(
    V: ArrayLike, F: ArrayLike, sigma: float, fraction: float, rng: np.random.Generator
) -> Floats:
    """Outliers: `along_normals` noise on a random part of the vertices.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    sigma : float
        Standard deviation, as a fraction of the mean edge length.
    fraction : float
        Share of the vertices that are moved, 0 to 1; the number of moved
        vertices is rounded to the nearest whole one.
    rng : numpy.random.Generator

    Returns
    -------
    ndarray of float64, shape (n, 3)

    Raises
    ------
    MeshError, ValueError, TypeError
        As `along_normals`, or ``fraction`` outside [0, 1].
    """
    V, _ = check_mesh(V, F)
    count = round(check_number(fraction, "fraction", 0, 1) * len(V))
    moved = check_rng(rng).permutation(len(V))[:count]
    V_noisy = V.copy()
    V_noisy[moved] = along_normals(V, F, sigma, rng)[moved]
    return V_noisy


@takes_meshes
@on_joined
def correlated(
    V: ArrayLike, F: ArrayLike, sigma: float, rng: np.random.Generator, steps: int = 3
) -> Floats:
    """Noise along the normals that neighbours share, as scanners leave it.

    v~_i = v_i + eps (S R)_i / |S_i| n_i with eps and R ~ N(0, 1) as in `along_normals`, and
    S = ((I + A) / 2)^steps, where A takes the mean over the neighbours. Each vertex's
    displacement has the same standard deviation, eps, and those of near vertices
    are alike: what is smooth looks like shape, and is hard to tell from it.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    sigma : float
        Standard deviation, as a fraction of the mean edge length.
    rng : numpy.random.Generator
    steps : int
        How often neighbours are averaged, at least 0: the noise is alike over about the
        square root of this many edges; 0 is `along_normals`.

    Returns
    -------
    ndarray of float64, shape (n, 3)

    Raises
    ------
    MeshError, ValueError, TypeError
        As `along_normals`, or ``steps`` no whole number of at least 0, or so many that memory
        does not hold what is that many edges around each vertex.
    """
    V, F = check_mesh(V, F)
    eps = check_number(sigma, "sigma", 0) * mean_edge_length(V, F)
    R = check_rng(rng).standard_normal((len(V), 1))
    steps, most = check_count(steps, "steps", 0), MOST_PAIRS / len(V)
    if most < len(V) and 3 * steps**2 > most:  # six neighbours, twelve around them, and so on
        raise ValueError(
            f"steps is {steps}: with {len(V):,} vertices, what is that many edges around each is "
            f"more than memory holds; give up to {int(np.sqrt(most / 3))}"
        )
    S = _spreading(F, len(V), steps)
    size = np.sqrt(S.power(2).sum(axis=1))[:, None]
    normals = vertex_normals(V, F)
    _warn_of_cancelled(normals, F)
    return V + eps * (S @ R) / size * normals


def _spreading(F: Integers, n: int, steps: int) -> csr_array:
    """((I + A) / 2)^steps, with A the mean over the neighbours, or oneself where there are none."""
    from scipy.sparse.linalg import matrix_power  # slow to load, and seldom needed

    edges = Edges(F, n)
    W = edges.matrix(np.ones(len(edges)))
    degree = W.sum(axis=1)
    A = diags_array(1 / np.maximum(degree, 1)) @ W + diags_array((degree == 0).astype(float))
    return csr_array(matrix_power(csr_array(eye_array(n) + A) / 2, steps))


def at_snr(V: ArrayLike, displacement: ArrayLike, decibels: float) -> Floats:
    """Scale a displacement so that the noisy mesh has just the SNR asked for.

    `meshfair.metrics.snr` solved for the size of the noise: with s the factor,
    s sum_i |d_i| = 10^(-decibels / 20) sum_i |v_i|.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        The ground truth.
    displacement : array_like, shape (n, 3)
        Any noise, such as ``noise.gaussian(V, F, 1, rng) - V``.
    decibels : float
        The SNR wanted.

    Returns
    -------
    ndarray of float64, shape (n, 3)
        V + s * displacement.

    Raises
    ------
    MeshError, ValueError
        Arrays that do not fit together, a displacement that is zero
        everywhere, or ``decibels`` outside `SNR_RANGE`.
    """
    V, displacement = check_same_vertices(V, displacement, ("V", "displacement"))
    decibels = check_number(decibels, "decibels", *SNR_RANGE)
    size = np.linalg.norm(displacement, axis=1).sum()
    if size == 0:
        raise MeshError("displacement is zero everywhere; no scale gives it an SNR")
    signal = np.linalg.norm(V, axis=1).sum()
    return V + 10 ** (-decibels / 20) * signal / size * displacement


MODELS: dict[str, Callable[[Floats, ArrayLike, float, np.random.Generator], Floats]] = {
    "normals": along_normals,
    "gaussian": gaussian,
    "uniform": on_joined(lambda V, F, size, rng: uniform(V, size, rng)),
    "correlated": correlated,
}
"""The noise models of one size by name, as functions of V, F, the size and the generator."""


@takes_meshes
def add(
    V: ArrayLike,
    F: ArrayLike,
    model: str,
    rng: np.random.Generator,
    *,
    size: float | None = None,
    decibels: float | None = None,
) -> Floats:
    """Add noise of a model by its name, of a given size or to a given SNR.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    model : {"normals", "gaussian", "uniform", "correlated"}
        One of `MODELS`.
    rng : numpy.random.Generator
    size : float, optional
        The model's own size: a fraction of the mean edge length, or for
        "uniform" the amplitude in units of length.
    decibels : float, optional
        Instead of ``size``: scale the noise to this SNR, see `at_snr`.

    Returns
    -------
    ndarray of float64, shape (n, 3)

    Raises
    ------
    MeshError, ValueError, TypeError
        As the model; an unknown model, or not exactly one of ``size`` and ``decibels``.
    """
    check_choice(model, "model", MODELS)
    V, F = check_mesh(V, F)
    if size is not None and decibels is None:
        return MODELS[model](V, F, size, rng)
    if decibels is not None and size is None:
        return at_snr(V, MODELS[model](V, F, 1.0, rng) - V, decibels)
    raise ValueError("give the noise either a size or its decibels")
