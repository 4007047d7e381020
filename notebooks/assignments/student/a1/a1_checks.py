"""The checks of assignment 1. Reading them is allowed, changing them changes nothing."""

import numpy as np

from meshfair import mesh, shapes
from meshfair_grading import expect
from meshfair_grading.answers import Seeded
from meshfair_grading.assignment import Assignment

check = Assignment("a1", "Noise, normals and SNR", seed=2021)


def closed_meshes(seed):
    yield "a sphere", *shapes.icosphere(1, 2.0)
    yield "a torus", *shapes.torus(sections=12, sides=8)


def open_meshes(seed):
    V, F = shapes.icosphere(1)
    yield "a sphere with a hole", V, F[10:]


def unit_rows(N, name):
    """Fail unless all rows have length one."""
    length = np.linalg.norm(N, axis=1)
    worst = np.argmax(np.abs(length - 1))
    expect.that(
        abs(length[worst] - 1) < 1e-6,
        "The normals are not of length one: divide each row by its own length, "
        "np.linalg.norm(N, axis=1, keepdims=True).",
        expected="length 1 of every row",
        got=f"length {length[worst]:.6g} of row {worst}",
    )


@check.part("face_normals", 1, closed_meshes)
def face_normals_have_length_one(student, V, F):
    """One unit vector for each triangle."""
    N = expect.array(student.face_normals(V, F), "N", F.shape)
    unit_rows(N, "N")


@check.part("face_normals", 2, closed_meshes)
def face_normals_are_right(student, V, F):
    """The directions, outward."""
    N = mesh.face_normals(V, F)
    inward = (
        "Your normals point inward: the order of the cross product decides, "
        "(b - a) x (c - a) for corners a, b, c."
    )
    raw = 2 * mesh.face_areas(V, F)[:, None] * N
    long = "The directions are right; what is missing is the division by the length."
    expect.close(student.face_normals(V, F), N, "N", mistakes=[(inward, -N), (long, raw)])


def added_without_repetition(V, F):
    """What N[F[:, k]] += ... gives: only the last triangle counts."""
    N = np.zeros(V.shape)
    for corner in range(3):
        N[F[:, corner]] += mesh.face_areas(V, F)[:, None] * mesh.face_normals(V, F)
    return N / np.maximum(np.linalg.norm(N, axis=1, keepdims=True), 1e-300)


@check.part("vertex_normals", 1, closed_meshes)
def vertex_normals_have_length_one(student, V, F):
    """One unit vector for each vertex."""
    unit_rows(expect.array(student.vertex_normals(V, F), "N", V.shape), "N")


@check.part("vertex_normals", 3, closed_meshes)
def vertex_normals_are_right(student, V, F):
    """The mean, weighted by area."""
    N = mesh.vertex_normals(V, F)
    summed = mesh.scatter(mesh.face_normals(V, F), F, len(V))
    unweighted = summed / np.linalg.norm(summed, axis=1, keepdims=True)
    mistakes = [
        ("You add the unit normals: weight each by the area of its triangle.", unweighted),
        ("Your normals point inward: look at the order of the cross product.", -N),
        (
            "Each vertex has the normal of one triangle only: N[F[:, k]] += ... adds just once "
            "where an index is repeated; use np.add.at.",
            lambda: added_without_repetition(V, F),
        ),
    ]
    expect.close(student.vertex_normals(V, F), N, "N", mistakes=mistakes)


def mean_over_faces(V, F):
    """What a loop over the triangles gives."""
    i, j = mesh.half_edges(F).T
    return np.linalg.norm(V[i] - V[j], axis=1).mean()


def check_mean_edge_length(student, V, F):
    """Compare, with hints."""
    lengths = mesh.edge_lengths(V, F)
    mistakes = [
        (
            "You go through the triangles: inner edges count twice, boundary edges once. "
            "Go through the edges.",
            lambda: mean_over_faces(V, F),
        ),
        ("This is the sum of the lengths, not their mean.", lengths.sum()),
        ("This is the mean of the squared lengths: the root is missing.", (lengths**2).mean()),
    ]
    expect.close(student.mean_edge_length(V, F), lengths.mean(), "the mean", mistakes=mistakes)


@check.part("mean_edge_length", 1.5, closed_meshes)
def mean_edge_length_on_closed_meshes(student, V, F):
    """On closed meshes."""
    check_mean_edge_length(student, V, F)


@check.part("mean_edge_length", 1.5, open_meshes)
def mean_edge_length_on_open_meshes(student, V, F):
    """On meshes with a boundary."""
    check_mean_edge_length(student, V, F)


def noise_cases(seed):
    V, F = shapes.icosphere(4)
    yield "a sphere", V, mesh.vertex_normals(V, F), 0.05, seed


@check.part("add_noise", 1, noise_cases)
def noise_is_along_the_normals(student, V, N, eps, seed):
    """Every vertex moves along its normal."""
    moved = expect.array(student.add_noise(V, N, eps, Seeded(seed)), "V", V.shape) - V
    expect.that(
        moved.any(), "Nothing has moved: the noise must be in what is returned.", got="no noise"
    )
    sideways = moved - (moved * N).sum(axis=1, keepdims=True) * N
    off = np.linalg.norm(sideways) / np.linalg.norm(moved)
    expect.that(
        off < 1e-6,
        "The vertices leave their normals. Did you draw three numbers a vertex? One number R_i "
        "scales the whole normal: draw shape (n, 1).",
        expected="moves parallel to the normals",
        got=f"{100 * off:.0f} % of the noise is sideways",
    )


@check.part("add_noise", 2, noise_cases)
def noise_is_white(student, V, N, eps, seed):
    """Normally distributed, standard deviation eps, independent."""
    moved = expect.array(student.add_noise(V, N, eps, Seeded(seed)), "V", V.shape) - V
    R = (moved * N).sum(axis=1) / eps
    mean, deviation = R.mean(), R.std()
    got = f"mean {mean:.3g} eps, standard deviation {deviation:.3g} eps"
    expected = "mean 0, standard deviation eps"
    different = len(np.unique(R.round(9)))
    expect.that(
        different > 0.9 * len(R),
        "Many vertices move by the same amount: draw a number for each of them.",
        expected=f"{len(R)} different numbers",
        got=f"{different}",
    )
    hint = "The size of the noise is wrong: R ~ N(0, 1) times eps."
    if abs(mean - 0.5) < 0.1 and abs(deviation - 12**-0.5) < 0.05:
        hint = "These are uniform numbers from [0, 1): rng.random. Take rng.standard_normal."
    elif abs(mean) < 0.1 and abs(deviation - 3**-0.5) < 0.05:
        hint = "These are uniform numbers from [-1, 1): take rng.standard_normal."
    elif abs(deviation - eps) < 0.1 * eps:
        hint = "The noise is eps times too small: was it multiplied by eps twice?"
    elif abs(deviation * eps - 1) < 0.1:
        hint = "The noise does not depend on eps: multiply by it."
    elif abs(deviation - np.sqrt(eps)) < 0.1 * np.sqrt(eps):
        hint = "eps is the standard deviation, not the variance: no square root."
    expect.that(abs(mean) < 0.1 and abs(deviation - 1) < 0.1, hint, expected=expected, got=got)
    kurtosis = ((R - mean) ** 4).mean() / deviation**4
    expect.that(
        abs(kurtosis - 3) < 0.6,
        "Mean and size are right, the shape is not: a normal distribution is wanted.",
        expected="fourth moment 3",
        got=f"{kurtosis:.2f}",
    )


@check.part("add_noise", 1, noise_cases)
def noise_is_repeatable(student, V, N, eps, seed):
    """The generator decides: the same one, the same noise."""
    first, again, other = (
        expect.array(student.add_noise(V, N, eps, Seeded(s)), "V", V.shape)
        for s in (seed, seed, seed + 99)
    )
    expect.that(
        np.array_equal(first, again),
        "Two calls with equal generators give different noise: draw with rng, not with np.random.",
        expected="equal noise",
        got="different noise",
    )
    expect.that(
        not np.array_equal(first, other),
        "Two different generators give the same noise: draw with rng, make no generator inside.",
        expected="different noise",
        got="equal noise",
    )


def noisy_pairs(seed):
    rng = np.random.default_rng(seed)
    V, _ = shapes.icosphere(1, 3.0)
    yield "a sphere", V, V + 0.1 * rng.standard_normal(V.shape)


@check.part("snr", 1, noisy_pairs)
def snr_counts_in_decibels(student, V, V_noisy):
    """Noise ten times smaller: 20 dB more."""
    loud = expect.number(student.snr(V, V_noisy), "the SNR")
    quiet = expect.number(student.snr(V, V + (V_noisy - V) / 10), "the SNR")
    hint = "Noise ten times smaller should give 20 dB more."
    if abs(quiet - loud - 20 * np.log(10)) < 0.1:
        hint += " You took the natural logarithm; decibels take np.log10."
    elif abs(quiet - loud + 20) < 0.1:
        hint += " The sign is wrong: more noise must give less SNR."
    elif abs(quiet - loud - 40) < 0.1:
        hint += " The norms are not squared in this definition."
    elif abs(quiet - loud - 10) < 0.1:
        hint += " The factor is 20, not 10."
    expect.that(abs(quiet - loud - 20) < 1e-6, hint, expected="20 dB", got=f"{quiet - loud:.4g} dB")


@check.part("snr", 2, noisy_pairs)
def snr_is_right(student, V, V_noisy):
    """The values."""

    def decibels(noise, signal, factor=-20, log=np.log10):
        return factor * log(noise / signal)

    noise, clean = np.linalg.norm(V - V_noisy, axis=1), np.linalg.norm(V, axis=1)
    noisy = np.linalg.norm(V_noisy, axis=1)
    N, S = noise.sum(), clean.sum()
    mistakes = [
        ("You took the natural logarithm: decibels take np.log10.", decibels(N, S, log=np.log)),
        ("The sign is wrong: more noise must give less SNR.", decibels(N, S, 20)),
        ("The factor is 20, not 10.", decibels(N, S, -10)),
        (
            "The noisy mesh is in the denominator; the signal is the clean one.",
            decibels(N, noisy.sum()),
        ),
        (
            "You squared the norms: this definition adds up the norms themselves.",
            decibels((noise**2).sum(), (clean**2).sum(), -10),
        ),
        (
            "You squared the norms: this definition adds up the norms themselves.",
            decibels((noise**2).sum(), (clean**2).sum()),
        ),
        (
            "This is the ratio for whole arrays: take the norm of each row, axis=1, and add.",
            decibels(np.linalg.norm(V - V_noisy), np.linalg.norm(V)),
        ),
        (
            "You average the ratios of the vertices: add up above and below, then divide.",
            decibels((noise / clean).mean(), 1),
        ),
    ]
    expect.close(student.snr(V, V_noisy), decibels(N, S), "the SNR", mistakes=mistakes)


def pairs_of_normals(seed):
    rng = np.random.default_rng(seed)
    V, F = shapes.icosphere(2)
    V_noisy = V + 0.05 * rng.standard_normal(V.shape)
    yield "a sphere", mesh.face_normals(V_noisy, F), mesh.face_normals(V, F)


@check.part("normal_angle", 2, pairs_of_normals)
def normal_angle_is_right(student, N, N_true):
    """The mean, in degrees."""
    angles = np.arccos(np.clip((N * N_true).sum(axis=1), -1, 1))
    mistakes = [
        ("The angle is in radians: np.arccos gives radians, np.degrees converts.", angles.mean()),
        ("This is the sum of the angles, not their mean.", np.degrees(angles.sum())),
        (
            "You take the arccos of the mean cosine: first the angles, then their mean.",
            np.degrees(np.arccos(np.cos(angles).mean())),
        ),
        ("This is the mean of the cosines: np.arccos is missing.", np.cos(angles).mean()),
    ]
    got = student.normal_angle(N, N_true)
    expect.close(got, np.degrees(angles).mean(), "the angle", mistakes=mistakes)


@check.part("normal_angle", 1, pairs_of_normals)
def normal_angle_of_equal_normals(student, N, N_true):
    """Zero for equal normals, whatever the rounding."""
    got = expect.number(student.normal_angle(N, N), "the angle")
    expect.that(abs(got) < 1e-4, "Equal normals make no angle.", expected="0", got=f"{got:.3g}")
