"""The checks of assignment 5. Reading them is allowed, changing them changes nothing."""

import numpy as np

from meshfair import noise, shapes
from meshfair_grading import expect
from meshfair_grading.assignment import Assignment, Graded, Rules

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


def decibels(V, V_noisy, V_true, part):
    """The gain on a part of the mesh."""
    before = np.linalg.norm(V_noisy - V_true, axis=1)[part].sum()
    after = np.linalg.norm(V - V_true, axis=1)[part].sum()
    return 20 * np.log10(before / max(after, 1e-12))


def three_meshes(seed):
    rng = np.random.default_rng(seed)
    V, _ = shapes.icosphere(1)
    V_noisy, V_denoised = (V + size * rng.standard_normal(V.shape) for size in (0.2, 0.05))
    yield "a sphere", V_denoised, V_noisy, V, V[:, 2] > 0.3


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
