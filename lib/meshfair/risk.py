"""How wrong a denoised mesh is, estimated without the clean one: Stein's unbiased risk.

[S81] Stein, Estimation of the mean of a multivariate normal distribution, Annals of
Statistics 9, 1981. [RBU08] Ramani, Blu, Unser, Monte-Carlo SURE, IEEE Transactions on
Image Processing 17, 2008.
"""

import numpy as np

from meshfair.checks import MeshError, check_mesh, check_number, check_rng
from meshfair.mesh import mean_edge_length, vertex_normals
from meshfair.mesh.topology import group_edges
from meshfair.noise import estimate

# Size of the probe, in standard deviations of the noise: small, so that the filter is
# nearly linear over it, yet far above rounding errors.
PROBE = 0.1


class Risk:
    """Estimates a filter's error on a noisy mesh, linear or not [S81].

    Heights h along the normals carry white noise of variance sigma^2. What
    makes a face's normal wrong is the *difference* of the errors at the ends
    of its edges; so the risk is the mean over the edges of

        ((h~_i - h_i) - (h~_j - h_j))^2,

    with the filtered heights h~ and the unknown clean ones h. With the residual
    r = h~ - h_noisy and the differences D along the edges its expectation is that of

        mean (D r)^2 + 2 sigma^2 tr(D dh~/dh_noisy D') / k - mean (D noise)^2,

    where the last term is 2 sigma^2. The trace measures how much the filter
    follows the noise; [RBU08] estimates it with a second run of the filter
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
        mean edge length. If it is not given, `meshfair.noise.estimate` estimates it
        by differences.

    Attributes
    ----------
    V_probed : ndarray of float64, shape (n, 3)
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

    def __init__(self, V, F, rng, sigma=None):
        self.V, self.F = check_mesh(V, F)
        check_rng(rng)
        length = mean_edge_length(self.V, self.F)
        if length == 0:
            raise MeshError(
                "V, F: all edges have length 0, so that no noise can be told from shape"
            )
        if sigma is None:
            sigma = estimate(self.V, self.F, by="differences")
        check_number(sigma, "sigma", 0)
        self.sigma = sigma * length
        self.edges = group_edges(self.F).ends
        self.step = PROBE * max(sigma, 1e-6) * length
        self.signs = rng.choice([-1.0, 1.0], len(self.V))
        normals = vertex_normals(self.V, self.F)
        self.V_probed = self.V + self.step * self.signs[:, None] * normals

    def __call__(self, X, X_probed):
        """The estimated risk of a filtered mesh.

        Parameters
        ----------
        X : ndarray of float64, shape (n, 3)
            What the filter made of V.
        X_probed : ndarray of float64, shape (n, 3)
            What it made of `V_probed`.

        Returns
        -------
        float
            In squared units of V. An estimate: below 0 where the error is small.
        """
        normals = vertex_normals(X, self.F)
        residual = np.sum((X - self.V) * normals, axis=1)
        response = np.sum((X_probed - X) * normals, axis=1) / self.step
        followed = np.mean(self._differences(self.signs) * self._differences(response))
        misfit = np.mean(self._differences(residual) ** 2)
        return float(misfit + 2 * self.sigma**2 * (followed - 1))

    def _differences(self, heights):
        """Those along the edges, D heights."""
        i, j = self.edges.T
        return heights[i] - heights[j]
