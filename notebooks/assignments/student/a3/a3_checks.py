"""The checks of assignment 3. Reading them is allowed, changing them changes nothing."""

import numpy as np
from scipy.sparse import csr_array, diags_array, eye_array

from meshfair import flow, metrics, noise, operators, shapes, weights
from meshfair_grading import expect
from meshfair_grading.assignment import Assignment, Rules

check = Assignment("a3", "Averaging and heat", seed=2023, rules=Rules(forbidden=("inv", "pinv")))


def weighted_meshes(seed):
    V, F = shapes.icosphere(1)
    yield "a sphere with combinatorial weights", V, weights.combinatorial(F, len(V))
    V, F = shapes.torus(sections=12, sides=8)
    yield "a torus with distance weights", V, weights.distance(V, F)


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


def cotangent_meshes(seed):
    V, F = shapes.icosphere(1)
    yield "a flat sphere with cotangent weights", weights.cotangent(V * [1, 1, 0.2], F)


@check.part("largest_stable_step", 3, regular_meshes)
def stable_step_for_positive_weights(student, W):
    """For weights that are not negative."""
    check_stable_step(student, W)


@check.part("largest_stable_step", 2, cotangent_meshes)
def stable_step_for_cotangent_weights(student, W):
    """For cotangent weights, some of them negative."""
    check_stable_step(student, W)


def noisy_meshes(seed):
    V, F = shapes.torus(sections=24, sides=12)
    A = operators.averaging(weights.combinatorial(F, len(V)))
    rng = np.random.default_rng(seed)
    yield "a noisy torus", noise.gaussian(V, F, 0.3, rng), V, A


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
