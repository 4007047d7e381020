"""From weights to operators: averaging, Laplacian, mass, and the stable time step."""

import numpy as np
from scipy.sparse import csr_array, diags_array, eye_array
from scipy.sparse.linalg import eigs

from meshfair.checks import MeshError, check_mesh
from meshfair.mesh import face_areas, scatter

# Below this size a dense eigenvalue problem is quicker and exact.
DENSE = 100


def _square(A, name):
    """Return a square sparse matrix of finite numbers as csr_array, or say why not."""
    shape = np.shape(A)
    if len(shape) != 2 or shape[0] != shape[1]:
        raise MeshError(f"{name} has shape {shape}; give a square sparse matrix")
    A = csr_array(A)
    if not np.isfinite(A.data).all():
        raise MeshError(f"{name} holds NaN or infinite entries; build it from a checked mesh")
    return A


def degrees(W):
    """The diagonal of D: d_i = sum_k w_ik over the edges (i, k).

    Parameters
    ----------
    W : sparse array, shape (n, n)

    Returns
    -------
    ndarray of float64, shape (n,)
    """
    return _square(W, "W").sum(axis=1)


def averaging(W):
    """The averaging operator W~ = D^-1 W (the seed, section 2.1).

    Parameters
    ----------
    W : sparse array, shape (n, n)
        Edge weights, see `meshfair.weights`.

    Returns
    -------
    csr_array of float64, shape (n, n)
        Each row sums to 1. Where d_i = 0 (a vertex without edges) the row is
        that of the identity: the vertex stays where it is.

    Raises
    ------
    MeshError
        ``W`` not square, or not finite.
    """
    W = _square(W, "W")
    d = degrees(W)
    isolated = d == 0
    inverse = np.divide(1.0, d, out=np.zeros_like(d), where=~isolated)
    A = diags_array(inverse) @ W
    return csr_array(A + diags_array(isolated.astype(float))) if isolated.any() else csr_array(A)


def laplacian(W):
    """The Laplacian L = D - W, positive semidefinite for nonnegative weights.

    With cotangent weights it is positive semidefinite too, whatever their
    signs: x' L x is the Dirichlet energy of x, a sum of squares over faces.

    Parameters
    ----------
    W : sparse array, shape (n, n)

    Returns
    -------
    csr_array of float64, shape (n, n)
        Rows sum to 0.

    Raises
    ------
    MeshError
        ``W`` not square, or not finite.
    """
    W = _square(W, "W")
    return csr_array(diags_array(degrees(W)) - W)


def mass(V, F):
    """The lumped mass matrix M: a third of the area of the faces at each vertex.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)

    Returns
    -------
    csr_array of float64, shape (n, n)
        Diagonal, in squared units of length; it sums to the surface's area. A
        vertex without faces has mass 0.

    Raises
    ------
    MeshError
        No mesh.
    """
    V, F = check_mesh(V, F)
    return csr_array(diags_array(scatter(face_areas(V, F) / 3, F, len(V))))


def diffusion(W, M):
    """The operator A = I - M^-1 L, with which a heat step is one of curvature flow.

    In `meshfair.flow.heat` it makes V+ = V - tau M^-1 L V, forward Euler for
    the mean curvature flow dV/dt = -M^-1 L V [MD99]; tau is then in squared
    units of length, and the stable step is small (see `stable_step`).

    Parameters
    ----------
    W : sparse array, shape (n, n)
        Edge weights, cotangent ones for the Laplace-Beltrami operator.
    M : sparse array, shape (n, n)
        Diagonal mass matrix, see `mass`.

    Returns
    -------
    csr_array of float64, shape (n, n)
        A vertex of mass 0 keeps its place.

    Raises
    ------
    MeshError
        A matrix that is not square or not finite, or different sizes.
    """
    L, M = laplacian(W), _square(M, "M")
    if L.shape != M.shape:
        raise MeshError(f"W has shape {L.shape} but M has {M.shape}; build both from one mesh")
    m = M.diagonal()
    inverse = np.divide(1.0, m, out=np.zeros_like(m), where=m > 0)
    return csr_array(eye_array(len(m)) - diags_array(inverse) @ L)


def stable_step(A):
    """The largest time step for which forward Euler stays bounded, estimated.

    A heat step multiplies by I - tau (I - A). An eigenvalue mu of I - A grows
    unless |1 - tau mu| <= 1, that is, unless tau <= 2 Re(mu) / |mu|^2. The
    largest mu decides.

    For averaging operators: with nonnegative weights mu <= 2, so tau = 1 is
    stable on every mesh. With cotangent weights, some of them negative,
    mu < 3: L and D = diag(L) are sums over faces of L_f and diag(L_f), and
    diag(L_f)^-1 L_f has trace 3 and eigenvalues 0 and two that are not
    negative. So every tau <= 2/3 is stable on every mesh, and tau = 1 need
    not be.

    Parameters
    ----------
    A : sparse array, shape (n, n)
        Averaging or diffusion operator.

    Returns
    -------
    float
        In the units of tau; relative accuracy about 1e-3. Infinite where A is
        the identity, 0 where the flow grows for any step.

    Raises
    ------
    MeshError
        ``A`` not square, or not finite.
    """
    A = _square(A, "A")
    n = A.shape[0]
    N = csr_array(eye_array(n) - A)
    if n <= DENSE:
        mu = np.linalg.eigvals(N.toarray())
        mu = mu[np.argmax(np.abs(mu))]
    else:
        start = np.random.default_rng(0).standard_normal(n)  # the same answer every time
        mu = eigs(N, k=1, which="LM", v0=start, tol=1e-3, return_eigenvectors=False)[0]
    if mu == 0:
        return np.inf
    return float(max(0.0, 2 * mu.real / abs(mu) ** 2))
