"""SURE, Stein's unbiased risk estimate: how wrong a denoised mesh is, without the ground truth.

References
----------
.. [Stein81] C. Stein, "Estimation of the mean of a multivariate normal distribution",
   Annals of Statistics 9, 1981.
.. [RBU08] S. Ramani, T. Blu, M. Unser, "Monte-Carlo SURE", IEEE Transactions on Image
   Processing 17, 2008.
.. [DJ94] D. Donoho, I. Johnstone, "Ideal spatial adaptation by wavelet shrinkage",
   Biometrika 81, 1994.
"""

from itertools import accumulate
from operator import matmul

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array, eye_array

from meshfair import weights
from meshfair.checks import (
    Floats,
    Integers,
    MeshError,
    check_mesh,
    check_number,
    check_rng,
    check_same_vertices,
)
from meshfair.mesh import Edges, mean_edge_length, vertex_normals
from meshfair.operators import averaging

# Size of the probe, in standard deviations of the noise: small, so that the filter is
# nearly linear over it, yet far above rounding errors.
PROBE = 0.1


def noise_by_differences(V: ArrayLike, F: ArrayLike) -> float:
    """The size of the noise along the normals, by third differences [DJ94]_.

    With K = (I - W~)^3 and equal weights, K V holds hardly any shape, but of
    the noise known parts, those of row i with standard deviation sigma |K_i|.
    So, along normals n that one averaging step has made reliable,

        sigma = median_i |<(K V)_i, n_i>| / |K_i| / 0.6745,

    with the median of |N(0, 1)|.

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
    R, _, K = high_passes(F, len(V), 3)
    size = np.sqrt(K.power(2).sum(axis=1))
    inside = size > 0  # a vertex without faces has no neighbours
    length = mean_edge_length(V, F)
    if length == 0:
        return 0.0
    heights = np.sum((K @ V) * vertex_normals(V - R @ V, F), axis=1)[inside] / size[inside]
    return float(np.median(np.abs(heights)) / 0.6745 / length)


def high_passes(F: Integers, n: int, powers: int) -> list[csr_array]:
    """The operators K = (I - W~)^p for p = 1 .. powers and equal weights: high-pass filters.

    Parameters
    ----------
    F : ndarray of int64, shape (m, 3)
    n : int
        Number of vertices.
    powers : int

    Returns
    -------
    list of csr_array, each of shape (n, n)
    """
    R = eye_array(n, format="csr") - averaging(weights.combinatorial(F, n))
    return list(accumulate([R] * powers, matmul))


def true_risk(X: ArrayLike, V_true: ArrayLike, F: ArrayLike) -> float:
    """What `SURE` estimates, where the ground truth is known.

    The mean over the edges of ((h~_i - h_i) - (h~_j - h_j))^2, where h~ - h are the
    heights of the errors along the filtered mesh's normals.

    Parameters
    ----------
    X : array_like, shape (n, 3)
        What a filter made of a noisy mesh.
    V_true : array_like, shape (n, 3)
        The ground truth.
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    float
        In squared units of X.

    Raises
    ------
    MeshError
        No mesh, or different numbers of vertices.
    """
    X, F = check_mesh(X, F)
    X, V_true = check_same_vertices(X, V_true, ("X", "V_true"))
    i, j = Edges(F, len(X)).ends.T
    heights = np.sum((X - V_true) * vertex_normals(X, F), axis=1)
    return float(np.mean((heights[i] - heights[j]) ** 2))


class SURE:
    """Estimates a filter's error on a noisy mesh, linear or not [Stein81]_.

    Heights h along the normals carry white noise of variance sigma^2. What
    makes a face's normal wrong is the *difference* of the errors at the ends
    of its edges; so the risk is the mean over the edges of

        ((h~_i - h_i) - (h~_j - h_j))^2,

    with the filtered heights h~ and the unknown clean ones h. With the residual
    r = h~ - h_noisy and the differences D along the edges its expectation is that of

        mean (D r)^2 + 2 sigma^2 tr(D dh~/dh_noisy D') / k - mean (D noise)^2,

    where the last term is 2 sigma^2. The trace measures how much the filter
    follows the noise; [RBU08]_ estimates it with a second run of the filter
    on the mesh moved by a small random probe.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        The noisy mesh.
    F : array_like of integers, shape (m, 3)
    rng : numpy.random.Generator
        Draws the probe, a sign for each vertex.
    sigma : float, optional
        Standard deviation of the noise along the normals, as a fraction of the
        mean edge length. If it is not given, `noise_by_differences` estimates it.

    Attributes
    ----------
    V_perturbed : ndarray of float64, shape (n, 3)
        The second mesh to run the filter on, with the same parameters.

    Raises
    ------
    MeshError, ValueError, TypeError
        No mesh, or one whose edges have no length; sigma below 0; no generator.

    Notes
    -----
    It holds for noise along the normals (isotropic noise included) that is
    independent at different vertices, and is as good as sigma. Noise
    larger than 0.4 edges is underestimated, so that too little smoothing looks best. A
    filter that jumps, as guided normal filtering does from patch to patch, has no
    derivative for the probe to find: there the estimate varies with the probe.
    """

    def __init__(
        self,
        V: ArrayLike,
        F: ArrayLike,
        rng: np.random.Generator,
        sigma: float | None = None,
    ) -> None:
        self.V, self.F = check_mesh(V, F)
        check_rng(rng)
        length = mean_edge_length(self.V, self.F)
        if length == 0:
            raise MeshError(
                "V, F: all edges have length 0, so that no noise can be told from shape"
            )
        if sigma is None:
            sigma = noise_by_differences(self.V, self.F)
        check_number(sigma, "sigma", 0)
        self.sigma = sigma * length
        self.edges = Edges(self.F, len(self.V)).ends
        self.step = PROBE * max(sigma, 1e-6) * length
        self.signs = rng.choice([-1.0, 1.0], len(self.V))
        normals = vertex_normals(self.V, self.F)
        self.V_perturbed = self.V + self.step * self.signs[:, None] * normals

    def __call__(self, X: Floats, X_perturbed: Floats) -> float:
        """The estimated risk of a filtered mesh.

        Parameters
        ----------
        X : ndarray of float64, shape (n, 3)
            What the filter made of V.
        X_perturbed : ndarray of float64, shape (n, 3)
            What it made of `V_perturbed`.

        Returns
        -------
        float
            In squared units of V. An estimate: below 0 where the error is small.
        """
        normals = vertex_normals(X, self.F)
        residual = np.sum((X - self.V) * normals, axis=1)
        response = np.sum((X_perturbed - X) * normals, axis=1) / self.step
        followed = np.mean(self._differences(self.signs) * self._differences(response))
        misfit = np.mean(self._differences(residual) ** 2)
        return float(misfit + 2 * self.sigma**2 * (followed - 1))

    def _differences(self, heights: Floats) -> Floats:
        """Those along the edges, D heights."""
        i, j = self.edges.T
        return heights[i] - heights[j]
