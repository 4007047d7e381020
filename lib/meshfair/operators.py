"""From weights to operators: averaging, Laplacian, mass, and the stable time step."""

import numpy as np
from scipy.sparse import csr_array, diags_array, eye_array
from scipy.sparse.linalg import LinearOperator, eigs

from meshfair.checks import MeshError, check_mesh
from meshfair.kernels import compiled, on_all_cores, unsigned

# Below this size a dense eigenvalue problem is quicker and exact.
DENSE = 100
# Entries of a matrix that a thread checks at a time: they cost little each.
ENTRIES = 2**18
# Bounds on the eigenvalues that are tried before they are estimated.
BOUNDS = 6


def _square(A, name):
    """Return a square sparse matrix of finite numbers as csr_array of float64, or say why not."""
    shape = np.shape(A)
    if len(shape) != 2 or shape[0] != shape[1]:
        raise MeshError(f"{name} has shape {shape}; give a square sparse matrix")
    A = csr_array(A, dtype=np.float64)
    entries = (*unsigned(A.indices), A.data)
    if sum(on_all_cores(_count_bad, A.nnz, *entries, shape[1], block=ENTRIES)):
        if not np.isfinite(A.data).all():
            raise MeshError(f"{name} holds NaN or infinite entries; build it from a checked mesh")
        raise MeshError(f"{name} has an entry in a column that it does not have; build it anew")
    return A


@compiled
def _count_bad(first, last, indices, A, columns):
    bad = 0
    for p in range(first, last):
        bad += (not abs(A[p]) < np.inf) | (indices[p] >= columns)
    return bad


def pinned(fixed, n):
    """Which vertices are held in place, as a mask, or say why not.

    Parameters
    ----------
    fixed : array_like
        A boolean mask of shape (n,), or indices of vertices.
    n : int
        Number of vertices.

    Returns
    -------
    ndarray of bool, shape (n,)

    Raises
    ------
    MeshError
        A mask of another length, or an index outside 0 .. n - 1.
    """
    fixed = np.asarray(fixed)
    if fixed.dtype == bool:
        if fixed.shape != (n,):
            raise MeshError(f"fixed has shape {fixed.shape}; a mask needs ({n},), one a vertex")
        return fixed
    if fixed.size == 0:
        return np.zeros(n, dtype=bool)
    if fixed.dtype.kind not in "iu" or fixed.ndim != 1:
        raise MeshError(f"fixed is of type {fixed.dtype}; give a boolean mask or vertex indices")
    if fixed.min() < 0 or fixed.max() >= n:
        bad = fixed[(fixed < 0) | (fixed >= n)][0]
        raise MeshError(f"fixed has vertex index {bad}, but there are {n} vertices (0 to {n - 1})")
    mask = np.zeros(n, dtype=bool)
    mask[fixed] = True
    return mask


def check_operator(A, n):
    """Return an operator on n vertices as csr_array of float64, or say why not.

    Raises
    ------
    MeshError
        Not of shape (n, n), not finite, or a column index out of range.
    """
    if np.shape(A) != (n, n):
        raise MeshError(
            f"the operator has shape {np.shape(A)}, but V has {n} vertices; "
            "build it from the same mesh"
        )
    return _square(A, "A")


def degrees(W):
    """The diagonal of D: d_i = sum_k w_ik over the edges (i, k).

    Parameters
    ----------
    W : sparse array, shape (n, n)

    Returns
    -------
    ndarray of float64, shape (n,)
    """
    W = _square(W, "W")
    return W @ np.ones(W.shape[1])


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
    data = np.empty(len(W.data))
    isolated = np.empty(W.shape[0], dtype=bool)
    on_all_cores(_divide_by_degree, len(isolated), *unsigned(W.indptr), W.data, data, isolated)
    A = csr_array((data, W.indices.copy(), W.indptr.copy()), shape=W.shape)
    return csr_array(A + diags_array(isolated.astype(float))) if isolated.any() else A


@compiled
def _divide_by_degree(first, last, indptr, W, A, isolated):
    """a_ij = w_ij / d_i; zeros in row i where d_i = 0."""
    for i in range(first, last):
        d = 0.0
        for p in range(indptr[i], indptr[i + 1]):
            d += W[p]
        isolated[i] = d == 0
        for p in range(indptr[i], indptr[i + 1]):
            A[p] = 0.0 if isolated[i] else W[p] / d


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
    m = np.zeros(len(V))
    _add_thirds_of_areas(V, F, m)
    return csr_array(diags_array(m))


@compiled
def _add_thirds_of_areas(V, F, m):
    for f in range(len(F)):
        a, b, c = F[f, 0], F[f, 1], F[f, 2]
        ux, uy, uz = V[b, 0] - V[a, 0], V[b, 1] - V[a, 1], V[b, 2] - V[a, 2]
        vx, vy, vz = V[c, 0] - V[a, 0], V[c, 1] - V[a, 1], V[c, 2] - V[a, 2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        area = np.sqrt(nx * nx + ny * ny + nz * nz) / 2
        for i in (a, b, c):
            m[i] += area / 3


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
    L.data *= np.repeat(inverse, np.diff(L.indptr))
    return csr_array(eye_array(len(m)) - L)


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
    size = np.abs(N.data).max(initial=0)
    if size == 0:
        return np.inf
    if n <= DENSE:
        mu = np.linalg.eigvals(N.toarray() / size)
        mu = mu[np.argmax(np.abs(mu))]
    else:
        # Single precision is enough for three digits, and few vectors for one eigenvalue.
        N_rows = (*unsigned(N.indptr, N.indices), (N.data / size).astype(np.float32))

        def product(x):
            y = np.empty_like(x)
            on_all_cores(_multiply, n, *N_rows, x, y)
            return y

        start = np.random.default_rng(0).standard_normal(n)  # the same answer every time
        mu = eigs(
            LinearOperator((n, n), matvec=product, dtype=np.float32),
            k=1, which="LM", v0=start.astype(np.float32), ncv=8, tol=1e-3,
            return_eigenvectors=False,
        )[0]  # fmt: skip
    if mu == 0:
        return np.inf
    return float(max(0.0, 2 * mu.real / abs(mu) ** 2)) / float(size)


@compiled
def _multiply(first, last, indptr, indices, N, x, y):
    for i in range(first, last):
        total = x[i] * 0  # of its type
        for p in range(indptr[i], indptr[i + 1]):
            total += N[p] * x[indices[p]]
        y[i] = total


def surely_stable(A, tau):
    """Whether a bound that costs a few products shows a step to be stable.

    For every x > 0 the spectral radius of N = I - A is at most the largest
    (|N| x)_i / x_i, by Collatz and Wielandt; x = 1 gives Gershgorin's bound,
    and x + |N| x / bound a better one. Where the eigenvalues of N are real and
    not negative, as for the averaging and diffusion operators of cotangent and
    of nonnegative weights, a step is stable if the bound is at most 2 / tau.

    Parameters
    ----------
    A : csr_array of float64, shape (n, n)
        Averaging or diffusion operator.
    tau : float
        Time step, above 0.

    Returns
    -------
    bool
        False means that the bound does not tell; see `stable_step`.
    """
    A_rows = (*unsigned(A.indptr, A.indices), A.data)
    x, y = np.ones((2, A.shape[0]))
    for _ in range(BOUNDS):
        bound = max(on_all_cores(_bound, len(x), *A_rows, x, y))
        if bound <= 2 / tau:
            return True
        x += y / bound
    return False


@compiled
def _bound(first, last, indptr, indices, A, x, y):
    """y = |I - A| x; return the largest y_i / x_i."""
    largest = 0.0
    for i in range(first, last):
        diagonal, others = 1.0, 0.0
        for p in range(indptr[i], indptr[i + 1]):
            j = indices[p]
            if i == j:
                diagonal -= A[p]
            else:
                others += abs(A[p]) * x[j]
        y[i] = abs(diagonal) * x[i] + others
        largest = max(largest, y[i] / x[i])
    return largest
