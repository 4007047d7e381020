# Instructor's file of assignment 1; `make assignments` makes the students' files from it.
# Its cells are explained in meshfair_grading.source. Each kind of cell becomes a file of
# its own, so names are imported once for each:
# ruff: noqa: F811

# %% [markdown]
# # Assignment 1: noise, normals and the signal-to-noise ratio
#
# A scanner sees every point of a surface a little wrong. Before we repair a mesh we
# learn to damage one in a controlled way, and to measure by how much: with the
# vertices (the signal-to-noise ratio) and with the normals (their mean angle).
#
# **20 points, about 3 hours.** Write your functions into the file `a1.py` beside this notebook: it
# holds a stub for each task. Run the cells here; after you save `a1.py` the notebook
# uses the new version at once. `check("...")` shows what is right and explains what
# is not. You hand in `a1.py` and nothing else; it will also be tried on meshes that
# you have not seen.
#
# **Allowed:** `numpy`, `scipy`, Python's own modules such as `math` and `itertools`.
# **Forbidden:** mesh libraries (`meshfair`, `igl`, `open3d`, `trimesh`, ...) inside
# `a1.py`: they hold the answers. Functions return new arrays and leave their
# arguments as they were.

# %%
# %load_ext autoreload
# %autoreload 2
# %load_ext meshfair_grading.notebook
import a1
import numpy as np
from a1_checks import check

from meshfair import mesh, noise, shapes
from meshfair_grading.notebook import show

# %% [markdown]
# ## Background
#
# A triangle mesh is two arrays. Row $i$ of `V`, shape $(n, 3)$, is the position $v_i$ of a
# vertex; a row $(a, b, c)$ of `F`, shape $(m, 3)$, names the three vertices of a triangle,
# **counter-clockwise seen from outside**. The cross product of two of its edges,
#
# $$ (v_b - v_a) \times (v_c - v_a) , $$
#
# is perpendicular to the triangle, points outward, and is twice as long as the
# triangle's area $A_f$ is large: one product holds the normal *and* the area.
#
# We assume that noise moves the vertices and leaves the triangles, that is `F`, alone.
# The model of this course moves each vertex along its normal $n_i$,
#
# $$ \tilde v_i = v_i + \varepsilon \, R_i \, n_i , \qquad R_i \sim \mathcal N(0, 1)
#    \text{ independent} . \tag{1} $$
#
# To mean the same on a mesh in metres and on one in millimetres, $\varepsilon$ is given as a
# fraction $\sigma$ of the mean edge length. This is what $\sigma = 0.1,\ 0.2,\ 0.4$ look like:

# %%
V, F = shapes.torus()
examples = {
    f"sigma = {sigma}": noise.along_normals(V, F, sigma, np.random.default_rng(1))
    for sigma in (0.1, 0.2, 0.4)
}
show(examples, F)

# %% module
"""Assignment 1: noise, normals and the signal-to-noise ratio.

Fill in the functions; the notebook a1.ipynb explains and checks them.
V: positions, shape (n, 3). F: triangles, shape (m, 3), indices of vertices.
"""

import numpy as np

# %% checks
"""The checks of assignment 1. Reading them is allowed, changing them changes nothing."""

import numpy as np

from meshfair import mesh, shapes
from meshfair_grading import expect
from meshfair_grading.answers import Seeded
from meshfair_grading.assignment import Assignment

### BEGIN HIDDEN TESTS
from meshfair_grading.meshes import unseen

### END HIDDEN TESTS

check = Assignment("a1", "Noise, normals and SNR", seed=2021)


def closed_meshes(seed):
    yield "a sphere", *shapes.icosphere(1, 2.0)
    yield "a torus", *shapes.torus(sections=12, sides=8)
    ### BEGIN HIDDEN TESTS
    yield "an unseen mesh", *unseen(seed)
    yield "an unseen ring", *unseen(seed, ring=True)
    ### END HIDDEN TESTS


def open_meshes(seed):
    V, F = shapes.icosphere(1)
    yield "a sphere with a hole", V, F[10:]
    ### BEGIN HIDDEN TESTS
    yield "an unseen mesh with a boundary", *unseen(seed, opened=True)
    ### END HIDDEN TESTS


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


# %% [markdown]
# ## Task 1: `face_normals` (3 points)
#
# The unit normal of each triangle,
#
# $$ n_f = \frac{(v_b - v_a) \times (v_c - v_a)}{\|(v_b - v_a) \times (v_c - v_a)\|} . $$
#
# *Hint.* `V[F[:, 0]]` is the array of all first corners: no loop is needed.


# %% module
def face_normals(V, F):
    """Unit normals of the triangles, outward.

    Returns
    -------
    array, shape (m, 3)
    """
    ### BEGIN SOLUTION
    a, b, c = V[F[:, 0]], V[F[:, 1]], V[F[:, 2]]
    N = np.cross(b - a, c - a)
    return N / np.linalg.norm(N, axis=1, keepdims=True)
    ### END SOLUTION


# %% checks
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


# %%
check("face_normals")

# %% [markdown]
# ## Task 2: `vertex_normals` (4 points)
#
# A vertex has no normal of its own. We take the mean of the normals of the triangles
# around it, **weighted by their areas**, so that cutting a triangle in two changes nothing:
#
# $$ n_i = \frac{s_i}{\|s_i\|} , \qquad s_i = \sum_{f \ni i} A_f \, n_f . $$
#
# *Hint.* The cross products themselves are $2 A_f n_f$. They must be *added up* at the
# vertices. `N[F[:, 0]] += ...` does not do that: where an index is repeated, NumPy
# keeps only the last addition. `np.add.at` adds them all.


# %% module
def vertex_normals(V, F):
    """Unit normals of the vertices: the mean of the faces' around, weighted by area.

    Returns
    -------
    array, shape (n, 3)
    """
    ### BEGIN SOLUTION
    a, b, c = V[F[:, 0]], V[F[:, 1]], V[F[:, 2]]
    doubled_area_normals = np.cross(b - a, c - a)
    N = np.zeros(V.shape)
    for corner in range(3):
        np.add.at(N, F[:, corner], doubled_area_normals)
    return N / np.linalg.norm(N, axis=1, keepdims=True)
    ### END SOLUTION


# %% checks
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


# %%
check("vertex_normals")

# %% [markdown]
# The picture shows the height of your normals, $n_z$: yellow looks up, blue looks down.

# %% result
V, F = shapes.torus()
show({"n_z": V}, F, values={"n_z": a1.vertex_normals(V, F)[:, 2]}, label="your normals' n_z")

# %% [markdown]
# ## Task 3: `mean_edge_length` (3 points)
#
# The mean length of the edges, where **each edge counts once**. Inside a mesh every edge
# belongs to two triangles, on the boundary to one: a loop over the triangles counts inner
# edges twice and boundary edges once. On a closed mesh both ways agree (why?), on an
# open one they do not.
#
# *Hint.* Collect the three edges of each triangle, sort both indices of each, and let
# `np.unique(..., axis=0)` throw out repetitions.


# %% module
def mean_edge_length(V, F):
    """Mean length of the edges, each counted once.

    Returns
    -------
    float
    """
    ### BEGIN SOLUTION
    E = np.concatenate([F[:, [0, 1]], F[:, [1, 2]], F[:, [2, 0]]])
    i, j = np.unique(np.sort(E, axis=1), axis=0).T
    return np.linalg.norm(V[i] - V[j], axis=1).mean()
    ### END SOLUTION


# %% checks
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


# %%
check("mean_edge_length")

# %% [markdown]
# ## Task 4: `add_noise` (4 points)
#
# Noise after equation (1). The normals `N` and the size `eps` are given. Draw **one** number
# for each vertex, from the normal distribution, with the generator `rng` that is handed in
# (`rng.standard_normal`): whoever starts with the same generator gets the same noise, which is
# what makes an experiment repeatable. `np.random.randn` would not.
#
# *Hint.* An array of shape $(n, 1)$ times one of shape $(n, 3)$ scales the rows.


# %% module
def add_noise(V, N, eps, rng):
    """White noise of standard deviation eps along the unit normals N.

    Returns
    -------
    array, shape (n, 3)
    """
    ### BEGIN SOLUTION
    R = rng.standard_normal((len(V), 1))
    return V + eps * R * N
    ### END SOLUTION


# %% checks
def noise_cases(seed):
    V, F = shapes.icosphere(4)
    yield "a sphere", V, mesh.vertex_normals(V, F), 0.05, seed
    ### BEGIN HIDDEN TESTS
    sections, sides = np.random.default_rng(seed).integers((60, 36), (70, 44))
    V, F = shapes.torus(3.0, 1.0, sections, sides)
    yield "an unseen torus", V, mesh.vertex_normals(V, F), 0.003, seed + 1
    ### END HIDDEN TESTS


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


# %%
check("add_noise")

# %% result
V, F = shapes.torus()
N, edge = mesh.vertex_normals(V, F), mesh.mean_edge_length(V, F)
V_noisy = a1.add_noise(V, N, 0.25 * edge, np.random.default_rng(5))
show({"clean": V, "with your noise, sigma = 0.25": V_noisy}, F)

# %% [markdown]
# ## Task 5: `snr` (3 points)
#
# How strong is the noise against the signal? In decibels,
#
# $$ \mathrm{SNR}(V, \tilde V) = -20 \log_{10}
#    \frac{\sum_i \|v_i - \tilde v_i\|}{\sum_i \|v_i\|} . $$
#
# Noise ten times smaller gives 20 dB more. The norms are *not* squared, and the
# *clean* mesh stands in the denominator.


# %% module
def snr(V, V_noisy):
    """Signal-to-noise ratio in decibels, V being the clean mesh.

    Returns
    -------
    float
    """
    ### BEGIN SOLUTION
    noise = np.linalg.norm(V - V_noisy, axis=1).sum()
    signal = np.linalg.norm(V, axis=1).sum()
    return -20 * np.log10(noise / signal)
    ### END SOLUTION


# %% checks
def noisy_pairs(seed):
    rng = np.random.default_rng(seed)
    V, _ = shapes.icosphere(1, 3.0)
    yield "a sphere", V, V + 0.1 * rng.standard_normal(V.shape)
    ### BEGIN HIDDEN TESTS
    for size in (0.02, 0.8):
        V, _ = unseen(seed)
        yield f"an unseen mesh with noise {size}", V, V + size * rng.standard_normal(V.shape)
    ### END HIDDEN TESTS


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


# %%
check("snr")

# %% [markdown]
# ## Task 6: `normal_angle` (3 points)
#
# A vertex that slides *along* the surface costs SNR although nobody sees it; a tilted
# triangle is seen at once. So the literature also gives the mean angle between the unit
# normals $n_f$ of a mesh and those of the clean one, $n_f^\ast$, **in degrees**:
#
# $$ \theta = \frac1m \sum_f \arccos \langle n_f, n_f^\ast \rangle . $$
#
# *Hint.* Rounding may give $\langle n, n \rangle = 1.0000000000000002$, and its arccos is
# `nan`: `np.clip` the cosines to $[-1, 1]$ first.


# %% module
def normal_angle(N, N_true):
    """Mean angle between two arrays of unit normals, in degrees.

    Returns
    -------
    float
    """
    ### BEGIN SOLUTION
    cosines = np.clip((N * N_true).sum(axis=1), -1, 1)
    return np.degrees(np.arccos(cosines)).mean()
    ### END SOLUTION


# %% checks
def pairs_of_normals(seed):
    rng = np.random.default_rng(seed)
    V, F = shapes.icosphere(2)
    V_noisy = V + 0.05 * rng.standard_normal(V.shape)
    yield "a sphere", mesh.face_normals(V_noisy, F), mesh.face_normals(V, F)
    ### BEGIN HIDDEN TESTS
    V, F = unseen(seed)
    V_noisy = V + 0.1 * rng.standard_normal(V.shape)
    yield "an unseen mesh", mesh.face_normals(V_noisy, F), mesh.face_normals(V, F)
    ### END HIDDEN TESTS


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


# %%
check("normal_angle")

# %% [markdown]
# The angle of each triangle, on the mesh. Where does noise along the normals tilt the
# triangles most, and why there?

# %% result
V, F = shapes.torus()
V_noisy = noise.along_normals(V, F, 0.2, np.random.default_rng(5))
N, N_true = a1.face_normals(V_noisy, F), a1.face_normals(V, F)
angles = np.array([a1.normal_angle(N[[f]], N_true[[f]]) for f in range(len(F))])
show({"noisy": V_noisy}, F, values={"noisy": angles}, label="degrees", limits=(0, 40))

# %% [markdown]
# ## All together

# %%
check()

# %% [markdown]
# ## To think about (no points)
#
# 1. Move a mesh and its noisy copy together, `V + 10` and `V_noisy + 10`: what does the SNR
#    do, and is that what a measure of noise should do?
# 2. Equation (1) has no noise along the surface. What would such noise do to the SNR, and
#    what to the mean angle?
# 3. The noise is added to each coordinate from `rng.random` instead, so that it has a mean.
#    Which part of it can no smoothing undo?
