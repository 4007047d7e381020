# Instructor's file of assignment 5; `make assignments` makes the students' files from it.
# Its cells are explained in meshfair_grading.source. Each kind of cell becomes a file of
# its own, so names are imported once for each:
# ruff: noqa: F811

# %% [markdown]
# # Assignment 5: keep the missiles
#
# A fighter aircraft carries six thin missiles. Averaging cleans the airframe quickly, and fires
# the missiles off: they shrink to needles. Cotangent weights keep them longer and clean less.
# There is no single right answer here. **Find a filter that cleans the airframe *and* keeps the
# missiles**, and see how far up the leaderboard it gets.
#
# **20 points, about 6 hours, and a leaderboard.** Write your functions into the file `a5.py`
# beside this notebook; `check("...")` shows how far you are. You hand in `a5.py` and nothing
# else; it will be tried on aircraft that you have not seen: turned, moved, with other noise and
# another number of triangles.
#
# **Allowed:** `numpy`, `scipy`, and meshfair's building blocks `meshfair.mesh`,
# `meshfair.weights`, `meshfair.operators` and `meshfair.flow`.
# **Forbidden:** ready-made filters, other mesh libraries, `meshfair.shapes` (it has the clean
# aircraft), and anything that recognises the aircraft instead of filtering the mesh. One call
# may take ten seconds on an ordinary computer.

# %%
# %load_ext autoreload
# %autoreload 2
# %load_ext meshfair_grading.notebook
import a5
import numpy as np
from a5_checks import check, noisy_jet

from meshfair import flow, operators, shapes, weights
from meshfair_grading.notebook import show

# %% [markdown]
# ## Background
#
# The noise is that of assignment 1, along the normals:
# $\tilde v_i = v_i + \varepsilon R_i n_i$. What averaging does to it, and to the
# missiles, after $t$ = 0.4 and $t$ = 2:

# %%
V, F = shapes.jet(detail=0.7)
V_noisy, missiles = noisy_jet(V, F, 0.3, seed=1)
A = operators.averaging(weights.combinatorial(F, len(V)))
states = {round(t, 1): X for t, X in flow.heat(V_noisy, A, 0.2, 2.0)}
under = (0.9, 1.3, -0.75)  # from below, where the missiles hang
show({"clean": V, "noisy": V_noisy, "t = 0.4": states[0.4], "t = 2": states[2.0]}, F,
     direction=under)  # fmt: skip

# %% [markdown]
# What can tell noise from a missile? Some ideas, from simple to ambitious:
#
# * **Stop early**, with cotangent weights: the baseline to beat.
# * **Use what you know about the noise.** It moves vertices along their normals only. Whatever a
#   filter changes *along* the surface is damage, and can be undone.
# * **Two steps forward, one back.** A step of heat with $\lambda > 0$ and one with $\mu < -\lambda$
#   (Taubin 1995) remove the high frequencies and leave the low ones: no shrinking.
# * **Penalise curvature, not slope**: minimise $\|X - V\|^2 + \lambda \|L X\|^2$.
# * **Weights that look.** Neighbours on the other side of an edge get a small weight: bilateral
#   filters, of vertices (Fleishman 2003) or of normals (Zheng 2011).
# * **Treat thin parts differently.** The mesh falls into connected components, and
#   some of them are small.

# %% module
"""Assignment 5: keep the missiles.

Fill in the functions; the notebook a5.ipynb explains and checks them.
V: positions, shape (n, 3). F: triangles, shape (m, 3), indices of vertices.
"""

import numpy as np

from meshfair import mesh, operators, weights

# %% checks
"""The checks of assignment 5. Reading them is allowed, changing them changes nothing."""

import numpy as np

from meshfair import noise, shapes
from meshfair_grading import expect
from meshfair_grading.assignment import Assignment, Graded, Rules

### BEGIN HIDDEN TESTS
from meshfair_grading.meshes import disguised

### END HIDDEN TESTS

check = Assignment(
    "a5",
    "Keep the missiles",
    seed=2025,
    rules=Rules(
        allowed=(
            "numpy",
            "scipy",
            "meshfair.mesh",
            "meshfair.weights",
            "meshfair.operators",
            "meshfair.flow",
        ),
        blocked=("meshfair.shapes", "meshfair.filters", "meshfair.io", "meshfair.datasets"),
    ),
)

# Gains in decibels that give all points of their checks.
FULL_AIRFRAME, FULL_MISSILES, FULL_BOTH = 4.0, 2.0, 2.0


def missile_vertices(detail):
    """Mask of the vertices that belong to a missile."""
    labels, names = shapes.jet_labels(detail=detail)
    return np.isin(labels, [place for place, name in enumerate(names) if "missile" in name])


def noisy_jet(V, F, sigma, seed, detail=0.7):
    """Noise along the normals of the jet, and the mask of its missiles."""
    V_noisy = noise.along_normals(V, F, sigma, np.random.default_rng(seed))
    return V_noisy, missile_vertices(detail)


def jets(seed):
    V, F = shapes.jet(detail=0.7)
    V_noisy, missiles = noisy_jet(V, F, 0.3, seed)
    yield "the jet", V_noisy, V, F, missiles
    ### BEGIN HIDDEN TESTS
    rng = np.random.default_rng(seed)
    detail, sigma = rng.uniform((0.66, 0.27), (0.72, 0.29))
    V, F = shapes.jet(detail=detail)
    V, F, order = disguised(V, F, rng)
    V_noisy = noise.along_normals(V, F, sigma, rng)
    yield "an unseen jet", V_noisy, V, F, missile_vertices(detail)[order]
    ### END HIDDEN TESTS


def decibels(V, V_noisy, V_true, part):
    """The gain on a part of the mesh."""
    before = np.linalg.norm(V_noisy - V_true, axis=1)[part].sum()
    after = np.linalg.norm(V - V_true, axis=1)[part].sum()
    return 20 * np.log10(before / max(after, 1e-12))


# %% [markdown]
# ## Task 1: `gain` (4 points)
#
# To compete one needs a measure. For a part $P$ of the vertices (a boolean mask),
# the **gain** in decibels is how much smaller the error has become:
#
# $$ \mathrm{gain}_P = 20 \log_{10}
#    \frac{\sum_{i \in P} \|\tilde v_i - v_i^\ast\|}{\sum_{i \in P} \|v_i - v_i^\ast\|} , $$
#
# with $\tilde v$ noisy, $v$ denoised, $v^\ast$ clean. Positive: the filter has helped. Zero: it
# might as well have done nothing. Negative: it did harm. It is the increase of the SNR, and
# does not depend on the origin as the SNR does. (Why?)


# %% module
def gain(V, V_noisy, V_true, part):
    """How much closer to the clean mesh a part has come, in decibels.

    V is the denoised mesh, part a boolean mask of shape (n,).

    Returns
    -------
    float
    """
    ### BEGIN SOLUTION
    before = np.linalg.norm(V_noisy - V_true, axis=1)[part].sum()
    after = np.linalg.norm(V - V_true, axis=1)[part].sum()
    return 20 * np.log10(before / after)
    ### END SOLUTION


# %% checks
def three_meshes(seed):
    rng = np.random.default_rng(seed)
    V, _ = shapes.icosphere(1)
    V_noisy, V_denoised = (V + size * rng.standard_normal(V.shape) for size in (0.2, 0.05))
    yield "a sphere", V_denoised, V_noisy, V, V[:, 2] > 0.3
    ### BEGIN HIDDEN TESTS
    yield "a sphere that got worse", V_noisy, V_denoised, V, rng.random(len(V)) < 0.5
    ### END HIDDEN TESTS


@check.part("gain", 4, three_meshes)
def gain_is_right(student, V, V_noisy, V_true, part):
    """The values, on a part of the mesh."""
    everywhere = np.ones(len(V), dtype=bool)
    right = decibels(V, V_noisy, V_true, part)
    before, after = (np.linalg.norm(X - V_true, axis=1)[part] for X in (V_noisy, V))
    squared = 20 * np.log10((before**2).sum() / (after**2).sum())
    mistakes = [
        ("The sign is wrong: less error than before is a positive gain.", -right),
        ("This is the gain on the whole mesh: the part is not used.",
         decibels(V, V_noisy, V_true, everywhere)),
        ("This is the gain on all vertices but those of the part.",
         decibels(V, V_noisy, V_true, ~part)),
        ("You took the natural logarithm: decibels take np.log10.", right * np.log(10)),
        ("You took the binary logarithm: decibels take np.log10.", right * np.log2(10)),
        ("The factor is 20, not 10.", right / 2),
        ("This is the ratio itself: its logarithm is missing.", 10 ** (right / 20)),
        ("You measured how far the filter has moved the vertices, not how far they are from "
         "the clean mesh.", decibels(V, V_true, V_noisy, part)),
        ("You squared the norms: this definition adds up the norms themselves.", squared / 2),
        ("You squared the norms: this definition adds up the norms themselves.", squared),
        ("This is the ratio for whole arrays: take the norm of each row, axis=1, and add.",
         squared / 2),
        ("You average the decibels of the vertices: add up above and below, then divide.",
         20 * np.log10(before / after).mean()),
        ("You average the ratios of the vertices: add up above and below, then divide.",
         20 * np.log10((before / after).mean())),
        ("This is the SNR of the denoised mesh, not what it has gained.",
         20 * np.log10(np.linalg.norm(V_true, axis=1)[part].sum() / after.sum())),
    ]  # fmt: skip
    expect.close(student.gain(V, V_noisy, V_true, part), right, "the gain", mistakes=mistakes)


# %%
check("gain")

# %% [markdown]
# ## Task 2: `denoise` (16 points)
#
# The open task. You get a noisy mesh, and return better positions for its vertices, in the same
# order. The points:
#
# | points | for |
# |---|---|
# | 2 | finite positions of the right shape, neither all as before nor all destroyed |
# | 6 | the airframe: in proportion up to a gain of 4 dB |
# | 6 | the missiles: in proportion up to a gain of 2 dB |
# | 2 | both at once: in proportion, the smaller gain of the two up to 2 dB |
#
# The **leaderboard** counts the smaller gain of the two, in decibels, without an upper end, on
# the mesh where it is smallest. Averaging reaches about 1.0 here, cotangent weights 1.4.


# %% module
def denoise(V, F):
    """Clean the airframe and keep the missiles.

    Returns
    -------
    array, shape (n, 3)
    """
    ### BEGIN SOLUTION
    # Taubin's filter does not shrink what is long and thin; the noise has moved each vertex
    # along its normal only, so that only the part of the correction along it is kept.
    A = operators.averaging(weights.combinatorial(F, len(V)))
    X = V
    for _ in range(4):
        for step in (0.5, -0.53):
            X = X + step * (A @ X - X)
    N = mesh.vertex_normals(X, F)
    return V + ((X - V) * N).sum(axis=1, keepdims=True) * N
    ### END SOLUTION


# %% checks
def gains(student, V_noisy, V, F, missiles):
    """Gains on the airframe and on the missiles."""
    X = denoised(student, V_noisy, F)
    return decibels(X, V_noisy, V, ~missiles), decibels(X, V_noisy, V, missiles)


def denoised(student, V_noisy, F):
    """The student's positions, once for all checks."""
    X = expect.array(student.once("denoise", V_noisy, F), "V", V_noisy.shape)
    size, largest = np.abs(V_noisy).max(), np.abs(X).max()
    expect.that(
        largest < 1e6 * size,
        "The vertices have flown away: is the step too large, so that the flow explodes?",
        expected=f"positions of the size of the mesh, {size:.3g}",
        got=f"up to {largest:.3g}",
    )
    return X


def graded(value, full, name, metric=None):
    """Points in proportion to a gain."""
    hint = "" if value >= full else f"For all points of this part: {full:g} dB."
    if value < -0.005:
        hint = f"Negative: {name} came out worse than they went in. Smooth less, or elsewhere."
    elif value < 0.005:
        hint = f"Nothing is gained: {name} are neither better nor worse than before."
    # Two decimals, or as many as tell it from the full gain.
    shown = (f"{value:.{digits}f}" for digits in range(2, 9))
    got = next(text for text in shown if value >= full or float(text) < full)
    return Graded(
        share=float(np.clip(value / full, 0, 1)),
        hint=hint,
        expected=f"{full:g} dB",
        got="0.00 dB" if float(got) == 0 else f"{got} dB",
        metric=metric,
    )


@check.part("denoise", 2, jets)
def denoise_gives_a_mesh(student, V_noisy, V, F, missiles):
    """A mesh, neither untouched nor destroyed."""
    X = denoised(student, V_noisy, F)
    expect.that(
        not np.allclose(X, V_noisy, rtol=0, atol=1e-9),
        "Nothing has moved.",
        expected="another mesh",
        got="the noisy mesh",
    )
    gain = decibels(X, V_noisy, V, np.ones(len(V), dtype=bool))
    expect.that(
        gain > -6,
        "The mesh is much worse than before: is the step too large, or the flow too long?",
        expected="an error that is at most doubled",
        got=f"a gain of {gain:.1f} dB",
    )


@check.part("denoise", 6, jets)
def denoise_cleans_the_airframe(student, V_noisy, V, F, missiles):
    """The gain on the airframe."""
    airframe, _ = gains(student, V_noisy, V, F, missiles)
    return graded(airframe, FULL_AIRFRAME, "the airframe's vertices")


@check.part("denoise", 6, jets)
def denoise_keeps_the_missiles(student, V_noisy, V, F, missiles):
    """The gain on the missiles."""
    _, kept = gains(student, V_noisy, V, F, missiles)
    return graded(kept, FULL_MISSILES, "the missiles")


@check.part("denoise", 2, jets)
def denoise_does_both(student, V_noisy, V, F, missiles):
    """The smaller gain of the two: the leaderboard's figure."""
    smaller = min(gains(student, V_noisy, V, F, missiles))
    return graded(smaller, FULL_BOTH, "some vertices", metric=smaller)


# %%
check("denoise")

# %% [markdown]
# Look at it: your result, and where the remaining error sits, in mean edge lengths.

# %% result
V, F = shapes.jet(detail=0.7)
V_noisy, missiles = noisy_jet(V, F, 0.3, seed=1)
X = a5.denoise(V_noisy, F)
edge = np.linalg.norm(V[F[:, 0]] - V[F[:, 1]], axis=1).mean()
error = {
    name: np.linalg.norm(Y - V, axis=1) / edge for name, Y in (("noisy", V_noisy), ("yours", X))
}
show({"noisy": V_noisy, "yours": X}, F, direction=under, values=error, limits=(0, 0.5),
     label="error / edge length")  # fmt: skip

# %% result
for name, part in (("airframe", ~missiles), ("missiles", missiles)):
    print(f"{name}: {a5.gain(a5.denoise(V_noisy, F), V_noisy, V, part):.2f} dB")

# %% [markdown]
# ## All together

# %%
check()

# %% [markdown]
# ## To think about (no points)
#
# 1. Which of your choices depend on this noise? Try `meshfair.noise.gaussian`, which also
#    moves vertices along the surface.
# 2. The gain counts each vertex the same. Which other measure would notice a lost missile?
# 3. Could one learn the right amount of smoothing for each vertex from examples?
