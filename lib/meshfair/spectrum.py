"""The frequencies of a mesh, and what heat steps do to each of them.

With symmetric weights W and d_i > 0 the averaging operator W~ = D^-1 W has n
real eigenvalues lambda = 1 - mu and eigenvectors that are orthonormal in the
inner product of D, from L phi = mu D phi: the mesh's eigenmodes. One with a
small mu varies slowly over the mesh and carries its shape; one with a large mu
varies fast and carries its noise [Taubin95]_. These are dense problems: a
second for a thousand vertices, and the third power of that for more.

References
----------
.. [Taubin95] G. Taubin, "A signal processing approach to fair surface design",
   SIGGRAPH 1995.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import eigh, eigvalsh
from scipy.sparse import sparray

from meshfair.checks import Floats, MeshError, check_count, check_number, check_vertices
from meshfair.operators import degrees, laplacian

LARGEST = 4000  # vertices: a matrix of 128 MB, half a minute


def _dense(W: sparray) -> tuple[Floats, Floats]:
    """L and D as dense arrays, of a mesh that has a spectrum."""
    L, d = laplacian(W), degrees(W)
    if len(d) > LARGEST:
        raise MeshError(
            f"the mesh has {len(d)} vertices; all eigenvalues need a dense matrix, so take a "
            f"coarser mesh, of at most {LARGEST}"
        )
    if not d.min() > 0:
        raise MeshError(
            f"vertex {d.argmin()} has weights that sum to {d.min():g}; the spectrum needs "
            "positive sums, so remove vertices without faces, and degenerate faces"
        )
    return L.toarray(), np.diag(d)


def eigenvalues(W: sparray) -> Floats:
    """All eigenvalues of the averaging operator W~ = D^-1 W, the largest first.

    Parameters
    ----------
    W : sparse array, shape (n, n)
        Symmetric edge weights, see `meshfair.weights`.

    Returns
    -------
    ndarray of float64, shape (n,)
        From 1, the constants, downwards: to -1 at the least with weights that
        are not negative, and above -2 with cotangent weights (see
        `meshfair.stability.stable_step`).

    Raises
    ------
    MeshError
        More than 4000 vertices, or a vertex whose weights do not sum to a
        positive number.
    """
    return 1 - eigvalsh(*_dense(W))


def eigenmodes(W: sparray) -> tuple[Floats, Floats]:
    """Eigenvalues of W~ with their eigenvectors, the mesh's eigenmodes.

    Parameters
    ----------
    W : sparse array, shape (n, n)

    Returns
    -------
    eigenvalues : ndarray of float64, shape (n,)
        As `eigenvalues` gives them.
    Phi : ndarray of float64, shape (n, n)
        One eigenmode a column, Phi' D Phi = I.

    Raises
    ------
    MeshError
        As `eigenvalues`.
    """
    mu, Phi = eigh(*_dense(W))
    return 1 - mu, Phi


def coefficients(V: ArrayLike, W: sparray, Phi: Floats) -> Floats:
    """How much of each eigenmode is in a mesh: the norm of its three spectral coefficients.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        Positions; or a displacement, such as V_noisy - V.
    W : sparse array, shape (n, n)
    Phi : ndarray, shape (n, n)
        From `eigenmodes` of the same weights.

    Returns
    -------
    ndarray of float64, shape (n,)
        Their squares sum to sum_i d_i |v_i|^2.

    Raises
    ------
    MeshError
        No vertex positions.
    """
    return np.linalg.norm(Phi.T @ (degrees(W)[:, None] * check_vertices(V)), axis=1)


def filtered(V: ArrayLike, W: sparray, Phi: Floats, factors: ArrayLike) -> Floats:
    """A mesh with each of its eigenmodes multiplied by a factor: Phi diag(factors) Phi' D V.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    W : sparse array, shape (n, n)
    Phi : ndarray, shape (n, n)
        From `eigenmodes` of the same weights.
    factors : array_like, shape (n,)
        A transfer function at the eigenvalues, in their order. 1 leaves an
        eigenmode as it is, 0 takes it away.

    Returns
    -------
    ndarray of float64, shape (n, 3)

    Raises
    ------
    MeshError
        No vertex positions.
    """
    factors = np.asarray(factors, dtype=float)[:, None]
    return Phi @ (factors * (Phi.T @ (degrees(W)[:, None] * check_vertices(V))))


def transfer_function(eigenvalues: ArrayLike, tau: float, iterations: int = 1) -> Floats:
    """The factor by which heat steps multiply each eigenmode: (1 - tau + tau lambda)^s.

    Parameters
    ----------
    eigenvalues : array_like
        Eigenvalues lambda of W~.
    tau : float
        Time step.
    iterations : int
        Number s of steps.

    Returns
    -------
    ndarray of float64, of the same shape
        1 for what stays, 0 for what goes; a size above 1 grows.

    Notes
    -----
    Other filters have theirs made of it. Taubin's is that of a step of lambda times that of a
    step of mu < 0. An implicit step of length t, (D + t L) V+ = D V, undoes a step backwards:
    1 / (1 + t - t lambda), one over the transfer function with tau = -t.

    Raises
    ------
    ValueError
        tau not finite, or ``iterations`` no whole number >= 0.
    """
    tau = check_number(tau, "tau", -np.inf)
    iterations = check_count(iterations, "iterations")
    return (1 - tau + tau * np.asarray(eigenvalues, dtype=float)) ** iterations
