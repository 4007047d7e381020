"""The checks of assignment 3. Reading them is allowed, changing them changes nothing."""

import numpy as np
from scipy.linalg import expm
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


def root(W):
    """The matrix D^(-1/2)."""
    return diags_array(1 / np.sqrt(W.sum(axis=1)))


@check.part("laplacian", 2, weighted_meshes)
def laplacian_is_right(student, V, W):
    """Rows sum to zero, positive on the diagonal."""
    L, n = operators.laplacian(W), W.shape[0]
    d = diags_array(W.sum(axis=1))
    neighbours = diags_array(np.diff(csr_array(W).indptr).astype(float))
    mistakes = [
        ("The sign is wrong: this is W - D, and the heat would flow backwards. L = D - W.", -L),
        ("This is D + W: the weights enter with a minus.", d + W),
        ("This is I - W~, the Laplacian divided by D; here it is D - W.",
         lambda: eye_array(n) - operators.averaging(W)),
        ("This is I - W: the diagonal holds the row sums d_i.", lambda: eye_array(n) - W),
        ("This is D: the weights are missing.", d),
        ("The diagonal counts the neighbours; it holds the sums of their weights.",
         neighbours - W),
        ("The diagonal holds sums of absolute values: the signs of the weights count.",
         diags_array(abs(W).sum(axis=1)) - W),
        ("This is the symmetric Laplacian I - D^(-1/2) W D^(-1/2); here it is D - W.",
         lambda: eye_array(n) - root(W) @ W @ root(W)),
        ("Only the diagonal has the wrong sign: L = D - W.", -d - W),
    ]  # fmt: skip
    expect.close(expect.matrix(student.laplacian(W), "L", n), L, "L", mistakes=mistakes)


def gauss_seidel(V, A, tau, steps):
    """What comes out when vertices move one after the other, in place."""
    V, A = V.copy(), csr_array(A)
    for _ in range(steps):
        for i in range(len(V)):
            V[i] = (1 - tau) * V[i] + tau * (A[[i]] @ V)[0]
    return V


def average_mistakes(V, W, steps):
    """Hints, and what the mistakes give."""
    A = operators.averaging(W)
    states = [flow.average(V, A, step) for step in range(steps + 2)]
    return [
        ("One step too many.", states[-1]),
        *([("One step too few.", states[-3])] if steps else []),
        ("Only one step was made.", states[1]),
        ("Nothing has moved.", V),
        (f"A**{steps} raises each entry of A to a power: apply A @ V again and again.",
         lambda: csr_array((A.data**steps, A.indices, A.indptr), shape=A.shape) @ V),
        ("Vertices have moved one after the other, and the later ones have seen the earlier ones' "
         "new places: compute all new positions from the old ones, A @ V.",
         lambda: gauss_seidel(V, A, 1.0, steps)),
        ("You multiply by A transposed.", lambda: euler(V, lambda X: A.T @ X, steps)),
        ("These are half steps, (V + A V) / 2: here each step is A V.",
         lambda: flow_heat(V, A, 0.5, steps)),
        ("These are steps V + A V: the new place is A V alone.",
         lambda: euler(V, lambda X: X + A @ X, steps)),
        ("This is the sum of all states; only the last one is wanted.",
         lambda: sum(states[: steps + 1])),
        ("This is the mean of all states; only the last one is wanted.",
         lambda: sum(states[: steps + 1]) / (steps + 1)),
    ]  # fmt: skip


@check.part("average", 2, weighted_meshes)
def average_is_right(student, V, W):
    """Several steps."""
    A = operators.averaging(W)
    mistakes = average_mistakes(V, W, 4)
    expect.close(student.average(V, A, 4), flow.average(V, A, 4), "V", mistakes=mistakes)


@check.part("average", 1, weighted_meshes)
def average_of_no_step(student, V, W):
    """No step and one step."""
    A = operators.averaging(W)
    none, one = (average_mistakes(V, W, steps) for steps in (0, 1))
    expect.close(student.average(V, A, 0), V, "V after 0 steps", mistakes=none)
    expect.close(student.average(V, A, 1), A @ V, "V after 1 step", mistakes=one)


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
        ("The step is V - tau A V: what is subtracted is tau (V - A V).",
         lambda: euler(V, lambda X: X - tau * (A @ X), steps)),
        ("The part 1 - tau is missing: without it V + tau A V grows.",
         lambda: euler(V, lambda X: X + tau * (A @ X), steps)),
        ("tau is not used: this is averaging, tau = 1.", lambda: flow.average(V, A, steps)),
        ("This is V - tau L V: divide L by D, or use A, which is divided already.",
         lambda: euler(V, lambda X: X - tau * (L @ X), steps)),
        ("One step too many.", lambda: flow_heat(V, A, tau, steps + 1)),
        ("One step too few.", lambda: flow_heat(V, A, tau, steps - 1)),
        ("Only one step was made.", lambda: flow_heat(V, A, tau, 1)),
        ("This is one step of size tau * steps, or steps that all start from the first state: "
         "make steps of size tau, each from the state before.",
         lambda: flow_heat(V, A, tau * steps, 1)),
        ("This is the exact solution exp(-t (I - A)) V; forward Euler makes steps, equation (1).",
         lambda: expm(-tau * steps * (np.eye(len(V)) - A.toarray())) @ V),
        ("These are steps of backward Euler, (I + tau (I - A)) V+ = V; take the forward ones, "
         "equation (1).",
         lambda: euler(V, lambda X: np.linalg.solve(
             (1 + tau) * np.eye(len(V)) - tau * A.toarray(), X), steps)),
        ("You multiply by A transposed.",
         lambda: euler(V, lambda X: (1 - tau) * X + tau * (A.T @ X), steps)),
        ("The tau in front of A V is missing: (1 - tau) V + tau A V.",
         lambda: euler(V, lambda X: (1 - tau) * X + A @ X, steps)),
        ("tau is used as the number of steps' reciprocal: each step has size tau.",
         lambda: flow_heat(V, A, tau / steps, steps)),
        ("Nothing has moved.", V),
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
    dense = np.eye(A.shape[0]) - A.toarray()
    L = operators.laplacian(W).toarray()
    rows = np.abs(dense).sum(axis=1).max()
    mistakes = [
        ("This is mu_max itself; the bound is 2 / mu_max.", largest),
        ("This is 1 / mu_max: up to 2 / mu_max nothing grows, though it may overshoot.",
         1 / largest),
        ("This is 2 / the largest eigenvalue of A, in size, which is 1 where no weight is "
         "negative; the largest one of I - A decides.", 2 / radius),
        ("You used the largest eigenvalue of A; the largest one of I - A decides.",
         2 / (1 - mu).max()),
        ("You used the smallest eigenvalue; the largest one decides.", 2 / positive),
        ("This is close to 2 / 0: the smallest eigenvalue of I - A is 0; the largest one decides.",
         expect.Recognised(lambda step: step > 1e6)),
        ("This is 2 divided by the mean of the eigenvalues; the largest one decides.",
         2 / mu.mean()),
        ("This bound holds for all meshes; on this one a larger step is stable.", 2 / 3),
        ("This bound is Gershgorin's, from the sums of the rows, and holds for many meshes; the "
         "eigenvalue itself allows a larger step.", 2 / rows),
        ("The step 1 is stable for all weights that are not negative; here 2 / mu_max is wanted.",
         1.0),
        ("This is Gershgorin's bound for A; take the largest eigenvalue of I - A itself.",
         2 / np.abs(A.toarray()).sum(axis=1).max()),
        ("np.linalg.eigvalsh reads one half of a matrix and takes it for symmetric, which I - A "
         "is not: np.linalg.eigvals.", lambda: 2 / np.linalg.eigvalsh(dense).max()),
        ("np.linalg.eigvalsh reads one half of a matrix and takes it for symmetric, which A "
         "is not: np.linalg.eigvals.", lambda: 2 / (1 - np.linalg.eigvalsh(A.toarray()).min())),
        ("This is the norm of I - A, its largest singular value; the largest eigenvalue is wanted.",
         lambda: 2 / np.linalg.norm(dense, 2)),
        ("These are the eigenvalues of L = D - W, not of I - A = D^-1 L.",
         lambda: 2 / np.linalg.eigvalsh(L).max()),
        ("This is 2 / mu_max with the smallest eigenvalue of A alone: I - A has 1 minus that.",
         2 / np.abs((1 - mu).min())),
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


def two_numbers(answer, highest):
    """Time and SNR from a student's answer."""
    right_form = isinstance(answer, list) or (isinstance(answer, np.ndarray) and answer.ndim == 1)
    expect.that(
        right_form and len(answer) == 2,
        "Two numbers are wanted: return time, snr",
        expected="time, snr",
        got=f"{len(answer)} values" if right_form else "one value",
    )
    expect.that(
        not any(str(value) == "inf" for value in answer),
        "The SNR is infinite: at time 0 the noisy mesh is compared with itself. Compare with the "
        "clean one.",
        expected=f"{highest:.4g} dB",
        got="inf",
    )
    time, snr = (
        expect.number(value, name) for value, name in zip(answer, ("time", "snr"), strict=True)
    )
    expect.that(
        not expect.alike(time, highest) or expect.alike(snr, highest),
        "These are the SNR and the time, in this order: return time, snr",
        expected="time, snr",
        got=f"{time:.4g}, {snr:.4g}",
    )
    return time, snr


TAU, STEPS = 0.1, 25


@check.part("best_stopping", 2, noisy_meshes)
def best_time(student, V_noisy, V_true, A):
    """The time."""
    curve = flow.snr_curve(V_noisy, V_true, A, TAU, TAU * STEPS)
    best = curve[:, 1].argmax()
    answer = student.best_stopping(V_noisy, V_true, A, TAU, STEPS)
    time, snr = two_numbers(answer, curve[best, 1])
    # Two times that are equally good to six digits are both right.
    as_good = np.flatnonzero(np.isclose(curve[:, 1], curve[best, 1], rtol=1e-6, atol=0))
    if any(expect.alike(time, TAU * k) for k in as_good):
        return
    against_noisy = [metrics.snr(V_noisy, V) for _, V in flow.heat(V_noisy, A, TAU, TAU * STEPS)]
    worst = curve[:, 1].min()
    lowest = expect.alike(abs(snr), abs(worst))
    found = expect.alike(abs(snr), curve[best, 1])  # the right moment, under another name
    mistakes = [
        *([] if not found else [
            ("This is the number of steps; the time is tau times that.", best),
            ("One step off: the state before the first step has time 0.", TAU * (best + 1)),
            ("One step off: the state before the first step has time 0.", TAU * (best - 1)),
        ]),
        *([(LOWEST, TAU * curve[:, 1].argmin())] if lowest else []),
        *(("Compare with the clean mesh, not with the noisy one.", TAU * moment)
          for moment in {np.argmax(against_noisy[1:]), np.argmax(against_noisy[1:]) + 1, 0}
          if not lowest and not expect.alike(snr, curve[0, 1])),
        ("This is the end of the flow, not its best moment.", TAU * STEPS),
        ("The time is one of the flow, a multiple of tau, and no SNR.", snr),
    ]  # fmt: skip
    expect.close(time, TAU * best, "the time", mistakes=mistakes)


LOWEST = "This is where the SNR is lowest: noise has a minus in front, -20 log10."


def decibels(V, V_true):
    """How much larger the norms of a mesh are than those of another."""
    return 20 * np.log10(np.linalg.norm(V, axis=1).sum() / np.linalg.norm(V_true, axis=1).sum())


def squared_snr(V_true, V):
    return -10 * np.log10(((V_true - V) ** 2).sum() / (V_true**2).sum())


def best_after(curve):
    return curve[:, 1].argmax() + 1


@check.part("best_stopping", 2, noisy_meshes)
def best_snr(student, V_noisy, V_true, A):
    """The SNR at that time."""
    curve = flow.snr_curve(V_noisy, V_true, A, TAU, TAU * STEPS)
    answer = student.best_stopping(V_noisy, V_true, A, TAU, STEPS)
    _, snr = two_numbers(answer, curve[:, 1].max())
    best = euler(V_noisy, lambda X: (1 - TAU) * X + TAU * (A @ X), curve[:, 1].argmax())
    mistakes = [
        ("This is the SNR of the noisy mesh.", curve[0, 1]),
        ("This is the SNR at the end of the flow.", curve[-1, 1]),
        ("The sign is wrong.", -curve[:, 1].max()),
        (LOWEST, -curve[:, 1].min()),
        (LOWEST, curve[:, 1].min()),
        ("You took the natural logarithm.", curve[:, 1].max() * np.log(10)),
        ("The factor is 20, not 10.", curve[:, 1].max() / 2),
        ("The signal is the clean mesh: yours is the noisy one.",
         metrics.snr(V_true, best) + decibels(V_noisy, V_true)),
        ("The signal is the clean mesh: yours is the smoothed one.",
         metrics.snr(V_true, best) + decibels(best, V_true)),
        ("This is the SNR of one step later.", curve[min(best_after(curve), STEPS), 1]),
        ("You squared the norms: this definition adds up the norms themselves.",
         squared_snr(V_true, best)),
        ("You squared the norms: this definition adds up the norms themselves.",
         2 * squared_snr(V_true, best)),
    ]  # fmt: skip
    expect.close(snr, curve[:, 1].max(), "the SNR", mistakes=mistakes)


def meshes_that_heat_only_hurts(seed):
    V, F = shapes.icosphere(1)
    A = operators.averaging(weights.combinatorial(F, len(V)))
    yield "a sphere almost without noise", V * 1.0001, V, A


@check.part("best_stopping", 1, meshes_that_heat_only_hurts)
def best_time_is_zero(student, V_noisy, V_true, A):
    """Time 0 where the flow never helps."""
    # The sphere is a little too large: some shrinking helps, a whole step is far too much.
    answer = student.best_stopping(V_noisy, V_true, A, TAU, STEPS)
    time, snr = two_numbers(answer, metrics.snr(V_true, V_noisy))
    curve = flow.snr_curve(V_noisy, V_true, A, TAU, TAU * STEPS)
    hint = "Here every step makes it worse, so that it is best to stop at time 0."
    if expect.alike(time, TAU):
        hint += " Is the state before the first step among those that you look at?"
    elif expect.alike(snr, -curve[:, 1].min()):
        hint = LOWEST
    elif expect.alike(time, TAU * STEPS):
        hint += " This is the end of the flow."
    expect.that(abs(time) < 1e-9, hint, expected="time 0", got=f"time {time:.4g}")
