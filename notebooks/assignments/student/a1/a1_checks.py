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


def unit(N):
    """The rows, made one long."""
    return N / np.maximum(np.linalg.norm(N, axis=1, keepdims=True), 1e-300)


def unit_rows(N, name):
    """Fail unless all rows have length one."""
    length = np.linalg.norm(N, axis=1)
    worst = np.argmax(np.abs(length - 1))
    hint = (
        "The normals are not of length one: divide each row by its own length, "
        "np.linalg.norm(N, axis=1, keepdims=True)."
    )
    if abs(np.linalg.norm(N) - 1) < 1e-6:
        hint += " You divided all rows by the norm of the whole array: axis=1 is missing."
    one, got = expect.differing(1.0, length[worst])
    expect.that(
        abs(length[worst] - 1) < 1e-6,
        hint,
        expected=f"length {one} of every row",
        got=f"length {got} of row {worst}",
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
    a, b, c = V[F[:, 0]], V[F[:, 1]], V[F[:, 2]]
    positions = (
        "This is the cross product of two positions; take that of two edges, (b - a) x (c - a)."
    )
    unit_columns = "You divided the columns by their lengths: the rows are the normals, axis=1."
    mistakes = [
        (inward, -N),
        (long, raw),
        (long, raw / np.linalg.norm(raw)),
        *((positions, unit(np.cross(u, v))) for u, v in ((a, b), (b, c), (a, c))),
        (unit_columns, raw / np.linalg.norm(raw, axis=0)),
    ]
    expect.close(student.face_normals(V, F), N, "N", mistakes=mistakes)


def added_without_repetition(V, F):
    """What N[F[:, k]] += ... gives: only the last triangle counts."""
    N = np.zeros(V.shape)
    for corner in range(3):
        N[F[:, corner]] += mesh.face_areas(V, F)[:, None] * mesh.face_normals(V, F)
    return unit(N)


def last_normals(V, F):
    """What N[F] = ... gives: the last triangle wins."""
    N = np.zeros(V.shape)
    N[F.ravel()] = np.repeat(mesh.face_normals(V, F), 3, axis=0)
    return N


def summed_by_angle(V, F):
    """What weighting by the angles gives: another usual definition."""
    N = np.zeros(V.shape)
    for corner in range(3):
        at, to, fro = (V[F[:, (corner + step) % 3]] for step in range(3))
        angles = np.arccos(np.clip((unit(to - at) * unit(fro - at)).sum(axis=1), -1, 1))
        np.add.at(N, F[:, corner], angles[:, None] * mesh.face_normals(V, F))
    return unit(N)


@check.part("vertex_normals", 1, closed_meshes)
def vertex_normals_have_length_one(student, V, F):
    """One unit vector for each vertex."""
    unit_rows(expect.array(student.vertex_normals(V, F), "N", V.shape), "N")


@check.part("vertex_normals", 3, closed_meshes)
def vertex_normals_are_right(student, V, F):
    """The mean, weighted by area."""
    N = mesh.vertex_normals(V, F)
    unweighted = unit(mesh.scatter(mesh.face_normals(V, F), F, len(V)))
    mistakes = [
        ("You add the unit normals: weight each by the area of its triangle.", unweighted),
        ("Your normals point inward: look at the order of the cross product.", -N),
        (
            "Each vertex has the normal of one triangle only: N[F[:, k]] += ... adds just once "
            "where an index is repeated; use np.add.at.",
            lambda: added_without_repetition(V, F),
        ),
        ("Each vertex has the normal of its last triangle; add all of them up, weighted.",
         lambda: last_normals(V, F)),
        ("You weight by the squares of the areas: the cross products hold the area once already.",
         lambda: unit(mesh.scatter(
             mesh.face_areas(V, F)[:, None] ** 2 * mesh.face_normals(V, F), F, len(V)))),
        ("You weight by the angles at the vertex; here the areas count.",
         lambda: summed_by_angle(V, F)),
        ("This is the direction from the middle of the mesh to the vertex, not a mean of normals.",
         lambda: unit(V - V.mean(axis=0))),
        ("This is the direction from the origin to the vertex, not a mean of normals.",
         lambda: unit(V)),
    ]  # fmt: skip
    expect.close(student.vertex_normals(V, F), N, "N", mistakes=mistakes)


def mean_over_faces(V, F):
    """What a loop over the triangles gives."""
    i, j = mesh.half_edges(F).T
    return np.linalg.norm(V[i] - V[j], axis=1).mean()


def mean_of_edges(V, E):
    """The mean length of the edges of a list, each once."""
    i, j = np.unique(np.sort(E, axis=1), axis=0).T
    return np.linalg.norm(V[i] - V[j], axis=1).mean()


def mean_of_means(V, F):
    """The mean over the vertices of the mean length of their edges."""
    E = mesh.Edges(F).ends
    both = np.repeat(np.linalg.norm(V[E[:, 0]] - V[E[:, 1]], axis=1), 2)
    return (np.bincount(E.ravel(), both) / np.bincount(E.ravel())).mean()


def check_mean_edge_length(student, V, F):
    """Compare, with hints."""
    lengths = mesh.edge_lengths(V, F)
    mistakes = [
        (
            "Inner edges count twice, once in each direction, and boundary edges once: go through "
            "the edges. (From the triangles: sort both indices of each row before np.unique.)",
            lambda: mean_over_faces(V, F),
        ),
        ("You take one of the three edges of each triangle; take ab, bc and ca.",
         lambda: np.linalg.norm(V[F[:, 0]] - V[F[:, 1]], axis=1).mean()),
        ("You take two of the three edges of each triangle: ca is missing.",
         lambda: mean_of_edges(V, np.concatenate([F[:, :2], F[:, 1:]]))),
        ("This is the norm of the whole array of differences: take that of each row, axis=1, and "
         "then the mean.", np.linalg.norm(lengths)),
        ("You take a mean for each vertex, and then the mean of those: each edge counts once.",
         lambda: mean_of_means(V, F)),
        ("This is the median; the mean is wanted.", np.median(lengths)),
        ("This is the mean distance between all vertices; only edges count.",
         lambda: np.linalg.norm(V[:, None] - V, axis=2).sum() / (len(V) * (len(V) - 1))),
        ("This is the sum of the lengths, not their mean.", lengths.sum()),
        ("This is the mean of the squared lengths: the root is missing.", (lengths**2).mean()),
        ("This is the root of the mean square; the mean of the lengths is wanted.",
         np.sqrt((lengths**2).mean())),
    ]  # fmt: skip
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


NOISE_ALONE = "This is the noise alone, without the mesh: return V + noise."


def off_the_normals(moved, N):
    """The part of vectors that is perpendicular to the normals."""
    sideways = moved - (moved * N).sum(axis=1, keepdims=True) * N
    return np.linalg.norm(sideways) / np.linalg.norm(moved)


def noise_alone(X, V, N):
    """Whether an answer is eps R N, without V."""
    return off_the_normals(X, N) < 1e-6 and np.linalg.norm(X) < np.linalg.norm(V) / 4


def independent(numbers):
    """Whether the three columns vary alike, and independently of each other."""
    there = numbers[np.isfinite(numbers).all(axis=1)]
    deviations = there.std(axis=0)
    between = np.corrcoef(there.T) - np.eye(3)
    return np.ptp(deviations) < 0.2 * deviations.mean() and np.abs(between).max() < 0.15


@check.part("add_noise", 1, noise_cases)
def noise_is_along_the_normals(student, V, N, eps, seed):
    """Every vertex moves along its normal."""
    X = expect.array(student.add_noise(V, N, eps, Seeded(seed)), "V", V.shape)
    moved = X - V
    expect.that(
        moved.any(),
        "Nothing has moved: the noise must be in what is returned.",
        expected="noise",
        got="none",
    )
    off = off_the_normals(moved, N)
    hint = "The vertices leave their normals: one number R_i scales the whole normal."
    if noise_alone(X, V, N):
        hint = NOISE_ALONE
    elif independent(moved) or independent(moved / np.where(np.abs(N) > 0.1, N, np.nan)):
        hint = (
            "Each coordinate has noise of its own: you drew three numbers a vertex. One number R_i "
            "scales the whole normal: draw shape (n, 1)."
        )
    rounded = 4 * expect.rounding(X) * np.linalg.norm(V) / np.linalg.norm(moved)
    expect.that(
        off < 1e-6 + rounded,
        hint,
        expected="moves parallel to the normals",
        got=f"{100 * off:.0f} % of the noise is sideways"
        if hint != NOISE_ALONE
        else "all vertices near the origin",
    )


@check.part("add_noise", 2, noise_cases)
def noise_is_white(student, V, N, eps, seed):
    """Normally distributed, standard deviation eps, independent."""
    X = expect.array(student.add_noise(V, N, eps, Seeded(seed)), "V", V.shape)
    moved = X - V
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
    elif (R >= 0).all() or (R <= 0).all():
        hint = "All vertices move to the same side: the numbers have both signs, without np.abs."
    elif abs(deviation - eps) < 0.1 * eps:
        hint = "The noise is eps times too small: was it multiplied by eps twice?"
    elif abs(deviation * eps - 1) < 0.1:
        hint = "The noise does not depend on eps: multiply by it."
    elif abs(deviation * np.sqrt(eps) - 1) < 0.1:
        hint = "eps is the standard deviation, not the variance: no square root."
    if noise_alone(X, V, N):
        hint = NOISE_ALONE
    elif off_the_normals(moved, N) > 0.1:
        hint = "The vertices do not move along their normals, so that this cannot be right either."
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


def noisy_in_the_denominator(V, V_noisy):
    noise, noisy = (np.linalg.norm(X, axis=1).sum() for X in (V - V_noisy, V_noisy))
    return -20 * np.log10(noise / noisy)


@check.part("snr", 1, noisy_pairs)
def snr_counts_in_decibels(student, V, V_noisy):
    """Noise ten times smaller: 20 dB more."""
    loud = expect.number(student.snr(V, V_noisy), "the SNR")
    quiet = expect.number(student.snr(V, V + (V_noisy - V) / 10), "the SNR")
    rounded = 100 * max(expect.rounding(loud), expect.rounding(quiet))
    hint = "Noise ten times smaller should give 20 dB more."
    if abs(quiet - loud - 20 * np.log(10)) < 0.1:
        hint += " You took the natural logarithm; decibels take np.log10."
    elif abs(quiet - loud + 20) < 0.1:
        hint += " The sign is wrong: more noise must give less SNR."
    elif abs(quiet - loud - 40) < 0.1:
        hint += " The norms are not squared in this definition."
    elif abs(quiet - loud - 10) < 0.1:
        hint += " The factor is 20, not 10."
    elif expect.alike(loud, noisy_in_the_denominator(V, V_noisy)):
        hint += " The noisy mesh is in the denominator; the signal is the clean one."
    right, got = expect.differing(20.0, quiet - loud, 4)
    expect.that(
        abs(quiet - loud - 20) < 1e-6 + 100 * rounded,
        hint,
        expected=f"{right} dB",
        got=f"{got} dB",
    )


@check.part("snr", 2, noisy_pairs)
def snr_is_right(student, V, V_noisy):
    """The values."""

    def decibels(noise, signal, factor=-20, log=np.log10):
        return factor * log(noise / signal)

    noise, clean = np.linalg.norm(V - V_noisy, axis=1), np.linalg.norm(V, axis=1)
    N, S = noise.sum(), clean.sum()
    mistakes = [
        ("You took the natural logarithm: decibels take np.log10.", decibels(N, S, log=np.log)),
        ("The sign is wrong: more noise must give less SNR.", decibels(N, S, 20)),
        ("The factor is 20, not 10.", decibels(N, S, -10)),
        (
            "The noisy mesh is in the denominator; the signal is the clean one.",
            noisy_in_the_denominator(V, V_noisy),
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
        ("You average the decibels of the vertices: add up above and below, then divide.",
         decibels(noise, clean).mean()),
        ("This is the ratio of the sums: its logarithm is missing.", N / S),
        ("You add up the absolute values of the coordinates: take the norm of each row.",
         decibels(np.abs(V - V_noisy).sum(), np.abs(V).sum())),
        ("You take the sums of the rows without a norm: np.linalg.norm(..., axis=1).",
         decibels(abs((V - V_noisy).sum()), abs(V.sum()))),
        ("You took the binary logarithm: decibels take np.log10.", decibels(N, S, log=np.log2)),
        ("The signal is the clean mesh as it stands; you moved it to the origin first.",
         decibels(N, np.linalg.norm(V - V.mean(axis=0), axis=1).sum())),
    ]  # fmt: skip
    expect.close(student.snr(V, V_noisy), decibels(N, S), "the SNR", mistakes=mistakes)


def pairs_of_normals(seed):
    rng = np.random.default_rng(seed)
    V, F = shapes.icosphere(2)
    V_noisy = V + 0.05 * rng.standard_normal(V.shape)
    yield "a sphere", mesh.face_normals(V_noisy, F), mesh.face_normals(V, F)


OUTSIDE = (
    "Rounding makes some cosines larger than 1, and their arccos is nan: np.clip(cosines, -1, 1) "
    "first."
)


@check.part("normal_angle", 2, pairs_of_normals)
def normal_angle_is_right(student, N, N_true):
    """The mean, in degrees."""
    angles = np.arccos(np.clip((N * N_true).sum(axis=1), -1, 1))
    mistakes = [
        (OUTSIDE, lambda: np.degrees(np.arccos((N * N_true).sum(axis=1))).mean()),
        ("The angle is in radians: np.arccos gives radians, np.degrees converts.", angles.mean()),
        ("This is the sum of the angles, not their mean.", np.degrees(angles.sum())),
        (
            "You take the arccos of the mean cosine: first the angles, then their mean.",
            np.degrees(np.arccos(np.cos(angles).mean())),
        ),
        ("This is the mean of the cosines: np.arccos is missing.", np.cos(angles).mean()),
        ("This is the largest angle; the mean is wanted.", np.degrees(angles).max()),
        ("This is the median; the mean is wanted.", np.median(np.degrees(angles))),
        ("This is 1 - cosine, converted to degrees: np.arccos is missing.",
         np.degrees(1 - np.cos(angles).mean())),
        ("This is the sine: np.arccos of the cosine is the angle.", np.sin(angles).mean()),
        ("This is the root of the mean square of the angles; their mean is wanted.",
         np.degrees(np.sqrt((angles**2).mean()))),
        ("This is np.radians of an angle that is in radians already; np.degrees is wanted.",
         np.radians(angles).mean()),
    ]  # fmt: skip
    got = student.normal_angle(N, N_true)
    expect.close(got, np.degrees(angles).mean(), "the angle", mistakes=mistakes)


@check.part("normal_angle", 1, pairs_of_normals)
def normal_angle_of_equal_normals(student, N, N_true):
    """Zero for equal normals, whatever the rounding."""
    got = student.normal_angle(N, N)
    with np.errstate(invalid="ignore"):
        unclipped = np.arccos((N * N).sum(axis=1)).mean()
    if np.isnan(unclipped) and isinstance(got, np.ndarray) and str(got) == "nan":
        raise expect.WrongAnswerError(OUTSIDE, expected="0", got="nan")
    got = expect.number(got, "the angle")
    # The arccos of 1 - rounding is the root of twice the rounding.
    rounded = np.degrees(np.sqrt(8 * expect.rounding(got)))
    hint = "Equal normals make no angle."
    expect.that(abs(got) < max(1e-4, rounded), hint, expected="0", got=f"{got:.3g}")
