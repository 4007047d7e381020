# Instructor's file of assignment 3; `make assignments` makes the students' files from it.
# Its cells are explained in meshfair_grading.source. Each kind of cell becomes a file of
# its own, so names are imported once for each:
# ruff: noqa: F811

# %% [markdown]
# # Assignment 3: averaging, heat, and when to stop
#
# Let every vertex move to the mean of its neighbours, again and again: the noise vanishes, and
# in the end so does the mesh. You will slow the averaging down until it becomes the heat
# equation, find out how large a step may be before everything explodes, and find the best
# moment to stop.
#
# **20 points.** Write your functions into the file `a3.py` beside this notebook. Run the
# cells here; after you save `a3.py` the notebook uses the new version at once.
# `check("...")` shows what is right and explains what is not. You hand in `a3.py` and
# nothing else; it will also be tried on meshes that you have not seen.
#
# **Allowed:** `numpy`, `scipy` (for task 4 also `scipy.sparse.linalg.eigs`), `math`.
# **Forbidden:** mesh libraries (`meshfair`, `igl`, `open3d`, ...) inside `a3.py`, and
# `inv`: no matrix has to be inverted here.

# %%
# %load_ext autoreload
# %autoreload 2
# %load_ext meshfair_grading.notebook
import a3
import matplotlib.pyplot as plt
import numpy as np
from a3_checks import check

from meshfair import metrics, noise, operators, shapes, weights
from meshfair_grading.notebook import show

# %% [markdown]
# ## Background
#
# Let $W$ be symmetric edge weights, $D$ the diagonal matrix of the row sums
# $d_i = \sum_k w_{ik}$, and
#
# $$ A = \tilde W = D^{-1} W \quad \text{(averaging, rows sum to 1)}, \qquad
#    L = D - W \quad \text{(Laplacian, rows sum to 0)} . $$
#
# **Averaging** $s$ times is $V^{(s)} = A^s V$. **Heat** flows from hot to cold; here the
# coordinates flow towards the neighbours' mean:
#
# $$ \partial_t V = - D^{-1} L V = -(I - A) V . $$
#
# The simplest way to follow it, a small step $\tau$ after the other, is the *forward Euler*
# method:
#
# $$ \frac{V^{(k+1)} - V^{(k)}}{\tau} = -(I - A)\, V^{(k)}
#    \quad\Longleftrightarrow\quad
#    V^{(k+1)} = (1 - \tau)\, V^{(k)} + \tau A V^{(k)} . \tag{1} $$
#
# With $\tau = 1$ this *is* averaging; with a small $\tau$ each vertex goes only a part of the
# way. Look at the sign: with $+$ the heat would flow backwards, from cold to hot.

# %% module
"""Assignment 3: averaging, heat, and when to stop.

Fill in the functions; the notebook a3.ipynb explains and checks them.
V: positions, shape (n, 3). W, A, L: sparse matrices, shape (n, n).
"""

import numpy as np
from scipy.sparse import csr_array, diags_array, eye_array

# %% checks
"""The checks of assignment 3. Reading them is allowed, changing them changes nothing."""

import numpy as np
from scipy.sparse import csr_array, diags_array, eye_array

from meshfair import flow, metrics, noise, operators, shapes, weights
from meshfair_grading import expect
from meshfair_grading.assignment import Assignment, Rules

### BEGIN HIDDEN TESTS
from meshfair_grading.meshes import unseen

### END HIDDEN TESTS

check = Assignment("a3", "Averaging and heat", seed=2023, rules=Rules(forbidden=("inv", "pinv")))


def weighted_meshes(seed):
    V, F = shapes.icosphere(1)
    yield "a sphere with combinatorial weights", V, weights.combinatorial(F, len(V))
    V, F = shapes.torus(sections=12, sides=8)
    yield "a torus with distance weights", V, weights.distance(V, F)
    ### BEGIN HIDDEN TESTS
    V, F = unseen(seed)
    yield "an unseen mesh with combinatorial weights", V, weights.combinatorial(F, len(V))
    V, F = unseen(seed, ring=True)
    yield "an unseen ring with cotangent weights", V, weights.cotangent(V, F)
    ### END HIDDEN TESTS


# %% [markdown]
# ## Task 1: `laplacian` (2 points)
#
# $L = D - W$: the row sums on the diagonal, the negative weights beside it. (Some libraries,
# libigl among them, use the opposite sign. Here $L$ has positive numbers on the diagonal.)


# %% module
def laplacian(W):
    """The Laplacian D - W.

    Returns
    -------
    csr_array, shape (n, n)
    """
    ### BEGIN SOLUTION
    return csr_array(diags_array(W.sum(axis=1)) - W)
    ### END SOLUTION


# %% checks
@check.part("laplacian", 2, weighted_meshes)
def laplacian_is_right(student, V, W):
    """Rows sum to zero, positive on the diagonal."""
    L, n = operators.laplacian(W), W.shape[0]
    d = diags_array(W.sum(axis=1))
    mistakes = [
        ("The sign is wrong: this is W - D, and the heat would flow backwards. L = D - W.", -L),
        ("This is D + W: the weights enter with a minus.", d + W),
        ("This is I - W~, the Laplacian divided by D; here it is D - W.",
         lambda: eye_array(n) - operators.averaging(W)),
        ("This is I - W: the diagonal holds the row sums d_i.", lambda: eye_array(n) - W),
        ("This is D: the weights are missing.", d),
    ]  # fmt: skip
    expect.close(expect.matrix(student.laplacian(W), "L", n), L, "L", mistakes=mistakes)


# %%
check("laplacian")

# %% [markdown]
# ## Task 2: `average` (3 points)
#
# $V^{(s)} = A^s V$, for $s = 0, 1, 2, \dots$ Do not compute the matrix $A^s$, it fills up; apply
# $A$ to the vertices $s$ times. For $s = 0$ the result is a *copy* of $V$.


# %% module
def average(V, A, steps):
    """Positions after so many steps of averaging, A^steps V.

    Returns
    -------
    array, shape (n, 3)
    """
    ### BEGIN SOLUTION
    V = V.copy()
    for _ in range(steps):
        V = A @ V
    return V
    ### END SOLUTION


# %% checks
def gauss_seidel(V, A, tau, steps):
    """What comes out when vertices move one after the other, in place."""
    V, A = V.copy(), csr_array(A)
    for _ in range(steps):
        for i in range(len(V)):
            V[i] = (1 - tau) * V[i] + tau * (A[[i]] @ V)[0]
    return V


@check.part("average", 2, weighted_meshes)
def average_is_right(student, V, W):
    """Several steps."""
    A = operators.averaging(W)
    elementwise = csr_array((A.data**4, A.indices, A.indptr), shape=A.shape)
    mistakes = [
        ("One step too many.", lambda: flow.average(V, A, 5)),
        ("One step too few.", lambda: flow.average(V, A, 3)),
        ("Only one step was made.", lambda: A @ V),
        ("Nothing has moved.", V),
        ("A**4 raises each entry of A to a power: apply A @ V again and again.",
         lambda: elementwise @ V),
        ("Vertices have moved one after the other, and the later ones have seen the earlier ones' "
         "new places: compute all new positions from the old ones, A @ V.",
         lambda: gauss_seidel(V, A, 1.0, 4)),
    ]  # fmt: skip
    expect.close(student.average(V, A, 4), flow.average(V, A, 4), "V", mistakes=mistakes)


@check.part("average", 1, weighted_meshes)
def average_of_no_step(student, V, W):
    """No step and one step."""
    A = operators.averaging(W)
    expect.close(student.average(V, A, 0), V, "V after 0 steps")
    expect.close(student.average(V, A, 1), A @ V, "V after 1 step")


# %%
check("average")

# %% [markdown]
# ## Task 3: `heat` (5 points)
#
# Forward Euler, equation (1), for a number of steps. The time that has passed is
# $t = \tau \cdot$ `steps`.


# %% module
def heat(V, A, tau, steps):
    """Positions after so many steps of forward Euler for the heat equation.

    Returns
    -------
    array, shape (n, 3)
    """
    ### BEGIN SOLUTION
    for _ in range(steps):
        V = (1 - tau) * V + tau * (A @ V)
    return V
    ### END SOLUTION


# %% checks
def euler(V, step, steps):
    """Apply a step again and again."""
    for _ in range(steps):
        V = step(V)
    return V


def heat_mistakes(V, W, tau, steps):
    """Hints, and what the mistakes give."""
    A, L = operators.averaging(W), operators.laplacian(W)
    return [
        ("The sign of L is wrong: your flow runs backwards, from the mean away, and noise grows. "
         "V - tau (I - A) V is right.",
         lambda: euler(V, lambda X: X + tau * (X - A @ X), steps)),
        ("tau and 1 - tau are exchanged: a small tau must be a small step.",
         lambda: euler(V, lambda X: tau * X + (1 - tau) * (A @ X), steps)),
        ("The part 1 - tau is missing: without it V + tau A V grows.",
         lambda: euler(V, lambda X: X + tau * (A @ X), steps)),
        ("tau is not used: this is averaging, tau = 1.", lambda: flow.average(V, A, steps)),
        ("This is V - tau L V: divide L by D, or use A, which is divided already.",
         lambda: euler(V, lambda X: X - tau * (L @ X), steps)),
        ("One step too many.", lambda: flow_heat(V, A, tau, steps + 1)),
        ("One step too few.", lambda: flow_heat(V, A, tau, steps - 1)),
        ("Only one step was made.", lambda: flow_heat(V, A, tau, 1)),
        ("Vertices have moved one after the other, and the later ones have seen the earlier ones' "
         "new places: compute all new positions from the old ones.",
         lambda: gauss_seidel(V, A, tau, steps)),
    ]  # fmt: skip


def flow_heat(V, A, tau, steps):
    return euler(V, lambda X: (1 - tau) * X + tau * (A @ X), steps)


@check.part("heat", 2, weighted_meshes)
def heat_with_full_steps(student, V, W):
    """With tau = 1 it is averaging."""
    A = operators.averaging(W)
    expect.close(
        student.heat(V, A, 1.0, 3),
        flow.average(V, A, 3),
        "V",
        mistakes=heat_mistakes(V, W, 1.0, 3),
    )


@check.part("heat", 3, weighted_meshes)
def heat_is_right(student, V, W):
    """With small steps."""
    A = operators.averaging(W)
    for tau, steps in ((0.2, 5), (0.35, 1)):
        expect.close(
            student.heat(V, A, tau, steps),
            flow_heat(V, A, tau, steps),
            f"V (tau = {tau}, {steps} steps)",
            mistakes=heat_mistakes(V, W, tau, steps),
        )


# %%
check("heat")

# %% result
V, F = shapes.torus()
V_noisy = noise.along_normals(V, F, 0.3, np.random.default_rng(2))
A = operators.averaging(weights.combinatorial(F, len(V)))
times = (0, 1, 4, 40)
show({f"t = {t}": a3.heat(V_noisy, A, 0.2, round(t / 0.2)) for t in times}, F)

# %% [markdown]
# ## How large may a step be?
#
# Write $V$ in eigenvectors of $I - A$. Along an eigenvector with eigenvalue $\mu$ one step of
# (1) multiplies by $1 - \tau\mu$. Nothing grows as long as $|1 - \tau\mu| \le 1$ for every
# eigenvalue,
#
# $$ 0 \le \tau \le \frac{2}{\mu_{\max}} . \tag{2} $$
#
# **Weights that are not negative.** Every row of $A$ is a mean, so $\|AV\|_\infty \le
# \|V\|_\infty$: the eigenvalues of $A$ lie in $[-1, 1]$, those of $I - A$ in $[0,
# 2]$, and **every $\tau \in (0,
# 1]$ is stable on every mesh.** No vertex can leave the box around its neighbours.
#
# **Cotangent weights** may be negative, a "mean" may lie outside, and $\tau = 1$ may explode.
# How bad can it get? Both $L$ and $D = \operatorname{diag}(L)$ are sums over the triangles, of
# $L_f$ and $D_f = \operatorname{diag}(L_f)$. The $3 \times 3$ matrix $D_f^{-1} L_f$ has only
# ones on its diagonal, so its eigenvalues add up to 3; one of them is 0 (constants), the other
# two are positive. Each is therefore below 3, that is $x^\top L_f x < 3\, x^\top D_f x$. Summed
# over all triangles, $x^\top L x < 3\, x^\top D x$, so
#
# $$ \mu_{\max} < 3 \quad\text{and every}\quad \boxed{\ \tau \le \tfrac23\ }
#    \text{ is stable on every mesh.} $$
#
# (For triangles without obtuse angles all weights are positive and $\tau \le 1$ will do.)
#
# ## Task 4: `largest_stable_step` (5 points)
#
# The bound (2) for a given operator $A$, as a number.
#
# *Hint.* $A$ is not symmetric, but similar to a symmetric matrix, so its eigenvalues are
# real; a routine for general matrices may still return them as complex numbers: take `.real`.
# The meshes have up to 200 vertices, so that `np.linalg.eigvals` of a dense matrix will do. On
# large ones, `scipy.sparse.linalg.eigs(N, k=1, which="LM")`.


# %% module
def largest_stable_step(A):
    """The largest tau for which forward Euler stays bounded, 2 / mu_max.

    Returns
    -------
    float
    """
    ### BEGIN SOLUTION
    mu = np.linalg.eigvals((eye_array(A.shape[0]) - A).toarray())
    return 2 / mu.real.max()
    ### END SOLUTION


# %% checks
def check_stable_step(student, W):
    """Compare, with hints."""
    A = operators.averaging(W)
    mu = np.linalg.eigvals((eye_array(A.shape[0]) - A).toarray()).real
    largest, radius = mu.max(), np.abs(1 - mu).max()
    positive = mu[mu > 1e-9].min()
    mistakes = [
        ("This is mu_max itself; the bound is 2 / mu_max.", largest),
        ("This is 1 / mu_max: up to 2 / mu_max nothing grows, though it may overshoot.",
         1 / largest),
        ("You used the eigenvalues of A; those of I - A decide.", 2 / radius),
        ("You used the largest eigenvalue of A; the largest one of I - A decides.",
         2 / (1 - mu).max()),
        ("You used the smallest eigenvalue; the largest one decides.", 2 / positive),
        ("This bound holds for all meshes; on this one a larger step is stable.", 2 / 3),
    ]  # fmt: skip
    got = student.largest_stable_step(A)
    expect.close(got, 2 / largest, "the step", mistakes=mistakes, rtol=2e-3)


def regular_meshes(seed):
    V, F = shapes.icosphere(0)  # the icosahedron: mu_max = 1 + 1 / sqrt(5)
    yield "an icosahedron", weights.combinatorial(F, len(V))
    V, F = shapes.torus(sections=12, sides=8)
    yield "a torus with distance weights", weights.distance(V, F)
    ### BEGIN HIDDEN TESTS
    V, F = unseen(seed)
    yield "an unseen mesh with combinatorial weights", weights.combinatorial(F, len(V))
    ### END HIDDEN TESTS


def cotangent_meshes(seed):
    V, F = shapes.icosphere(1)
    yield "a flat sphere with cotangent weights", weights.cotangent(V * [1, 1, 0.2], F)
    ### BEGIN HIDDEN TESTS
    yield "an unseen mesh with cotangent weights", weights.cotangent(*unseen(seed))
    yield "an unseen ring with cotangent weights", weights.cotangent(*unseen(seed, ring=True))
    ### END HIDDEN TESTS


@check.part("largest_stable_step", 3, regular_meshes)
def stable_step_for_positive_weights(student, W):
    """For weights that are not negative."""
    check_stable_step(student, W)


@check.part("largest_stable_step", 2, cotangent_meshes)
def stable_step_for_cotangent_weights(student, W):
    """For cotangent weights, some of them negative."""
    check_stable_step(student, W)


# %%
check("largest_stable_step")

# %% [markdown]
# Just below and just above your bound. (The second picture is no mistake of yours.)

# %% result
V, F = shapes.torus(sections=24, sides=12)
V_noisy = noise.along_normals(V, F, 0.1, np.random.default_rng(2))
A = operators.averaging(weights.combinatorial(F, len(V)))
bound = a3.largest_stable_step(A)
show(
    {
        f"tau = {factor} x {bound:.3f}": a3.heat(V_noisy, A, factor * bound, 20)
        for factor in (0.95, 1.1)
    },
    F,
)

# %% [markdown]
# ## Task 5: `best_stopping` (5 points)
#
# First the flow removes noise, then it removes the mesh. With the clean mesh at hand, we can
# watch: the signal-to-noise ratio
#
# $$ \mathrm{SNR}(V, \tilde V) = -20 \log_{10}
#    \frac{\sum_i \|v_i - \tilde v_i\|}{\sum_i \|v_i\|} $$
#
# rises and falls again. Return the **time** $t = k\tau$, $k = 0, 1, \dots,$ `steps`, at which
# the SNR is highest, and that SNR. Time 0 counts: sometimes it is best to leave a mesh alone.


# %% module
def best_stopping(V_noisy, V_true, A, tau, steps):
    """When the heat flow is closest to the clean mesh.

    Returns
    -------
    time : float
        A multiple of tau from 0 to tau * steps.
    snr : float
        The signal-to-noise ratio at that time, in decibels.
    """

    ### BEGIN SOLUTION
    def snr(V):
        noise = np.linalg.norm(V_true - V, axis=1).sum()
        return -20 * np.log10(noise / np.linalg.norm(V_true, axis=1).sum())

    V = V_noisy
    curve = [snr(V)]
    for _ in range(steps):
        V = heat(V, A, tau, 1)
        curve.append(snr(V))
    best = int(np.argmax(curve))
    return best * tau, curve[best]
    ### END SOLUTION


# %% checks
def noisy_meshes(seed):
    V, F = shapes.torus(sections=24, sides=12)
    A = operators.averaging(weights.combinatorial(F, len(V)))
    rng = np.random.default_rng(seed)
    yield "a noisy torus", noise.gaussian(V, F, 0.3, rng), V, A
    ### BEGIN HIDDEN TESTS
    for ring in (False, True):
        V, F = unseen(seed, ring=ring)
        A = operators.averaging(weights.combinatorial(F, len(V)))
        yield "an unseen noisy mesh", noise.gaussian(V, F, 0.5, rng), V, A
    ### END HIDDEN TESTS


def two_numbers(answer):
    """Time and SNR from a student's answer."""
    right_form = isinstance(answer, list) or (isinstance(answer, np.ndarray) and answer.ndim == 1)
    expect.that(
        right_form and len(answer) == 2,
        "Two numbers are wanted: return time, snr",
        expected="time, snr",
        got=f"{len(answer)} values" if right_form else "one value",
    )
    return [expect.number(value, name) for value, name in zip(answer, ("time", "snr"), strict=True)]


TAU, STEPS = 0.1, 25


@check.part("best_stopping", 2, noisy_meshes)
def best_time(student, V_noisy, V_true, A):
    """The time."""
    curve = flow.snr_curve(V_noisy, V_true, A, TAU, TAU * STEPS)
    best = curve[:, 1].argmax()
    time, _ = two_numbers(student.best_stopping(V_noisy, V_true, A, TAU, STEPS))
    against_noisy = [metrics.snr(V_noisy, V) for _, V in flow.heat(V_noisy, A, TAU, TAU * STEPS)]
    mistakes = [
        ("This is the number of steps; the time is tau times that.", best),
        (
            "This is where the SNR is lowest: noise has a minus in front.",
            TAU * curve[:, 1].argmin(),
        ),
        (
            "Compare with the clean mesh, not with the noisy one.",
            TAU * np.argmax(against_noisy[1:]),
        ),
        ("Compare with the clean mesh, not with the noisy one.", TAU * np.argmax(against_noisy)),
        ("One step off: the state before the first step has time 0.", TAU * (best + 1)),
        ("One step off: the state before the first step has time 0.", TAU * (best - 1)),
        ("This is the end of the flow, not its best moment.", TAU * STEPS),
    ]
    expect.close(time, TAU * best, "the time", mistakes=mistakes)


@check.part("best_stopping", 2, noisy_meshes)
def best_snr(student, V_noisy, V_true, A):
    """The SNR at that time."""
    curve = flow.snr_curve(V_noisy, V_true, A, TAU, TAU * STEPS)
    _, snr = two_numbers(student.best_stopping(V_noisy, V_true, A, TAU, STEPS))
    mistakes = [
        ("This is the SNR of the noisy mesh.", curve[0, 1]),
        ("This is the SNR at the end of the flow.", curve[-1, 1]),
        ("The sign is wrong.", -curve[:, 1].max()),
        ("You took the natural logarithm.", curve[:, 1].max() * np.log(10)),
    ]
    expect.close(snr, curve[:, 1].max(), "the SNR", mistakes=mistakes)


def meshes_that_heat_only_hurts(seed):
    V, F = shapes.icosphere(1)
    A = operators.averaging(weights.combinatorial(F, len(V)))
    yield "a sphere almost without noise", V * 1.0001, V, A


@check.part("best_stopping", 1, meshes_that_heat_only_hurts)
def best_time_is_zero(student, V_noisy, V_true, A):
    """Time 0 where the flow never helps."""
    # The sphere is a little too large: some shrinking helps, a whole step is far too much.
    time, _ = two_numbers(student.best_stopping(V_noisy, V_true, A, TAU, STEPS))
    hint = "Here every step makes it worse: the state before the first step is one to look at too."
    expect.that(abs(time) < 1e-9, hint, expected="time 0", got=f"time {time:.4g}")


# %%
check("best_stopping")

# %% [markdown]
# The curve of the SNR on a noisy knot, with three weights, and your best moments on it.

# %% result
V, F = shapes.knot()
V = V - V.mean(axis=0)
V_noisy = noise.gaussian(V, F, 0.25, np.random.default_rng(1))
figure, axes = plt.subplots(figsize=(6, 3.5))
for name, W in (
    ("combinatorial", weights.combinatorial(F, len(V))),
    ("distance", weights.distance(V_noisy, F)),
    ("cotangent", weights.cotangent(V_noisy, F)),
):
    A = operators.averaging(W)
    curve = [a3.best_stopping(a3.heat(V_noisy, A, 0.1, k), V, A, 0.1, 0)[1] for k in range(31)]
    (line,) = axes.plot(0.1 * np.arange(31), curve, label=name)
    axes.plot(*a3.best_stopping(V_noisy, V, A, 0.1, 30), "o", color=line.get_color())
axes.set(xlabel="time t", ylabel="SNR in dB", title="When to stop")
axes.legend()
plt.show()

# %% [markdown]
# ## All together

# %%
check()

# %% [markdown]
# ## To think about (no points)
#
# 1. With more noise, does the best time come earlier or later? Try it on the knot.
# 2. The knot was moved to the origin above. Leave that line out: what changes, and why?
# 3. Without the clean mesh nobody can compute the SNR. How would you decide when to stop?
