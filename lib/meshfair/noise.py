"""Noise on vertex positions, and the seed's signal-to-noise ratio.

Every function returns new positions and leaves its input alone. A noise size
``sigma`` is a fraction of the mean edge length, so that it means the same on
a mesh in metres and on one in millimetres.

[DJ94] Donoho, Johnstone, Ideal spatial adaptation by wavelet shrinkage, Biometrika 81, 1994.
[LLL+19] Li, Liu, Liu, Wang, Liu, Feature-convinced mesh denoising, Graphical Models 101, 2019.
"""

import numpy as np

from meshfair.checks import (
    MeshError,
    check_mesh,
    check_number,
    check_rng,
    check_same_vertices,
    check_vertices,
)
from meshfair.mesh import edge_lengths, mean_edge_length, vertex_normals


def along_normals(V, F, sigma, rng):
    """White noise along the vertex normals: the seed's noise model.

    v~_i = v_i + eps (R n_i) with R ~ N(0, 1) drawn for each vertex (the
    seed, section 1) and eps = ``sigma`` times the mean edge length.

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
        A vertex without faces has no normal and stays where it is.

    Raises
    ------
    MeshError, ValueError, TypeError
        No mesh; ``sigma`` negative or not finite; ``rng`` not a generator.
    """
    V, F = check_mesh(V, F)
    eps = check_number(sigma, "sigma", 0) * mean_edge_length(V, F)
    R = check_rng(rng).standard_normal((len(V), 1))
    return V + eps * R * vertex_normals(V, F)


def gaussian(V, F, sigma, rng):
    """Isotropic Gaussian noise: each coordinate moved by eps N(0, 1).

    Parameters, errors and eps are those of `along_normals`.

    Returns
    -------
    ndarray of float64, shape (n, 3)
    """
    V, F = check_mesh(V, F)
    eps = check_number(sigma, "sigma", 0) * mean_edge_length(V, F)
    return V + eps * check_rng(rng).standard_normal(V.shape)


def uniform(V, amplitude, rng):
    """Each coordinate plus a uniform draw from [0, amplitude).

    The noise that the seed's Table 1 was made with (that of Open3D's
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


def impulsive(V, F, sigma, fraction, rng):
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
    hit = check_rng(rng).permutation(len(V))[:count]
    V_noisy = V.copy()
    V_noisy[hit] = along_normals(V, F, sigma, rng)[hit]
    return V_noisy


def estimate(V, F, by="lengths"):
    """The size of the noise on a mesh, estimated without the clean one.

    By "lengths" [LLL+19]: noise makes edges longer. With normal displacements of
    standard deviation sigma, the mean squared edge length grows by 2 sigma^2.
    Against a copy that Sun's filter has smoothed (T = 0.4, 4 normal and 4 vertex
    iterations),

        sigma / mean edge = sqrt( msel(V) / (2 msel(smoothed)) - 1/2 ).

    By "differences", as [DJ94] do for signals: with K = (I - W~)^3 and equal
    weights, K V holds hardly any shape, but of the noise known parts, those of
    row i with standard deviation sigma |K_i|. So, along normals n that one
    averaging step has made reliable,

        sigma = median_i |<(K V)_i, n_i>| / |K_i| / 0.6745,

    with the median of |N(0, 1)|. Closer on coarse meshes, and with strong noise.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    by : {"lengths", "differences"}

    Returns
    -------
    float
        As a fraction of the mean edge length, as in `along_normals`; but of the
        noisy mesh's, since the clean one's is unknown. From about 0.4 on
        too small: normals are lost. On clean meshes with much detail
        too large, since detail looks like noise.

    Raises
    ------
    MeshError, ValueError
        No mesh; another word for ``by``.
    """
    V, F = check_mesh(V, F)
    if by not in _ESTIMATES:
        raise ValueError(f"by is {by!r}; give one of {', '.join(_ESTIMATES)}")
    return _ESTIMATES[by](V, F)


def _estimate_by_lengths(V, F):
    # The filters build on this module's successors; so this cannot be imported above.
    from meshfair.filters.normals import sun

    *_, (_, smoothed) = sun(
        V, F, threshold=0.4, normal_iterations=4, vertex_iterations=4, hold_boundary=False
    )
    before, after = (np.mean(edge_lengths(X, F) ** 2) for X in (V, smoothed))
    return float(np.sqrt(max(0.0, before / after - 1) / 2)) if after > 0 else 0.0


def _estimate_by_differences(V, F):
    from scipy.sparse import eye_array

    from meshfair import operators, weights

    A = operators.averaging(weights.combinatorial(F, len(V)))
    R = eye_array(len(V), format="csr") - A
    K = R @ R @ R
    size = np.sqrt(K.power(2).sum(axis=1))
    inside = size > 0  # a vertex without faces has no neighbours
    length = mean_edge_length(V, F)
    if length == 0:
        return 0.0
    heights = np.sum((K @ V) * vertex_normals(A @ V, F), axis=1)[inside] / size[inside]
    return float(np.median(np.abs(heights)) / 0.6745 / length)


_ESTIMATES = {"lengths": _estimate_by_lengths, "differences": _estimate_by_differences}


def snr(V, V_noisy):
    """Signal-to-noise ratio of a noisy mesh, in decibels (the seed, Definition 1).

    SNR = -20 log10( sum_i |v_i - v~_i| / sum_i |v_i| ). The denominator
    depends on where the origin lies: moving both meshes together changes the
    ratio.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        The clean mesh.
    V_noisy : array_like, shape (n, 3)
        The noisy or the denoised one, vertices in the same order.

    Returns
    -------
    float
        Decibels; infinite where both meshes are equal.

    Raises
    ------
    MeshError
        No vertices, different numbers of them, or a clean mesh that has all
        its vertices at the origin.
    """
    V, V_noisy = check_same_vertices(V, V_noisy, ("V", "V_noisy"))
    signal = np.linalg.norm(V, axis=1).sum()
    noise = np.linalg.norm(V - V_noisy, axis=1).sum()
    if signal == 0:
        raise MeshError("V has all its vertices at the origin, so it has no SNR; move it")
    return float(-20 * np.log10(noise / signal)) if noise else np.inf


def at_snr(V, displacement, decibels):
    """Scale a displacement so that the noisy mesh has just the SNR asked for.

    `snr` solved for the size of the noise: with s the factor,
    s sum_i |d_i| = 10^(-decibels / 20) sum_i |v_i|.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        The clean mesh.
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
        everywhere, or ``decibels`` not finite.
    """
    V, displacement = check_same_vertices(V, displacement, ("V", "displacement"))
    decibels = check_number(decibels, "decibels", -np.inf)
    size = np.linalg.norm(displacement, axis=1).sum()
    if size == 0:
        raise MeshError("displacement is zero everywhere; no scale gives it an SNR")
    signal = np.linalg.norm(V, axis=1).sum()
    return V + 10 ** (-decibels / 20) * signal / size * displacement
