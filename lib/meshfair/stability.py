"""The largest time step for which a flow stays bounded."""

import numpy as np
from scipy.sparse import csr_array, eye_array, sparray

from meshfair import _fast
from meshfair.checks import (
    StabilityWarning,
    check_number,
    check_square,
    warn,
)

# Below this size a dense eigenvalue problem is quicker and exact.
DENSE = 100
# Bounds on the eigenvalues that are tried before they are estimated.
BOUNDS = 6


def stable_step(A: sparray) -> float:
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
    A = check_square(A)
    N = csr_array(eye_array(A.shape[0]) - A)
    size = np.abs(N.data).max(initial=0)
    if size == 0:
        return np.inf
    N.data /= size
    mu = _largest_eigenvalue(N)
    if mu == 0:
        return np.inf
    return float(max(0.0, 2 * mu.real / abs(mu) ** 2)) / float(size)


def _largest_eigenvalue(N: csr_array) -> complex:
    from scipy.sparse.linalg import LinearOperator, eigs  # slow to load, and seldom needed

    n = N.shape[0]
    if n <= DENSE:
        mu = np.linalg.eigvals(N.toarray())
        return complex(mu[np.argmax(np.abs(mu))])
    # Single precision is enough for three digits, and few vectors for one eigenvalue.
    N = N.astype(np.float32)
    if _fast.wanted(n):
        N = LinearOperator((n, n), matvec=_fast.stability.product(N), dtype=np.float32)
    start = np.random.default_rng(0).standard_normal(n).astype(np.float32)
    mu = eigs(N, k=1, which="LM", v0=start, ncv=8, tol=1e-3, return_eigenvectors=False)
    return complex(mu[0])


def surely_stable(A: sparray, tau: float) -> bool:
    """Whether a bound that costs a few products shows a step to be stable.

    For every x > 0 the spectral radius of N = I - A is at most the largest
    (|N| x)_i / x_i, by Collatz and Wielandt; x = 1 gives Gershgorin's bound,
    and x + |N| x / bound a better one. Where the eigenvalues of N are real and
    not negative, as for the averaging and diffusion operators of cotangent and
    of nonnegative weights, a step is stable if the bound is at most 2 / tau.

    Parameters
    ----------
    A : sparse array, shape (n, n)
        Averaging or diffusion operator.
    tau : float
        Time step, above 0.

    Returns
    -------
    bool
        False means that the bound does not tell; see `stable_step`.

    Raises
    ------
    MeshError, ValueError
        ``A`` not square, or not finite; tau not above 0.
    """
    A, tau = check_square(A), check_number(tau, "tau", 0, open_low=True)
    n = A.shape[0]
    product = _fast.stability.absolute_product(A) if _fast.wanted(n) else abs(eye_array(n) - A).dot
    x = np.ones(n)
    for _ in range(BOUNDS):
        y = product(x)
        bound = np.max(y / x, initial=0)
        if bound <= 2 / tau:
            return True
        x += y / bound
    return False


def warn_if_unstable(A: csr_array, tau: float) -> None:
    """Warn of a time step with which the flow may grow; the message names the bound.

    Parameters
    ----------
    A : csr_array, shape (n, n)
        Averaging or diffusion operator.
    tau : float
        Time step, not 0.

    Warns
    -----
    StabilityWarning
        tau is outside (0, 1], or past the `stable_step` that negative weights leave.
    """
    if 0 < tau <= 1 and (not A.nnz or A.data.min() >= 0):
        return  # every new vertex is a mean of old ones: nothing can grow
    if 0 < tau <= 1 and surely_stable(A, tau):
        return
    bound = stable_step(A)
    if 0 < tau <= 1 and tau <= bound * (1 + 1e-3):  # the accuracy of the bound
        return
    advice = f"the bound on this mesh is tau = {bound:.3g}" if bound else "no step is stable"
    reason = "with negative weights" if 0 < tau <= 1 else "outside (0, 1]"
    warn(
        f"tau = {tau:g} {reason}: the flow may grow instead of smoothing; {advice}, "
        "2 over the spectral radius of I - A",
        StabilityWarning,
    )
