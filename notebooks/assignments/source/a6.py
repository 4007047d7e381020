# Instructor's file of assignment 6; `make assignments` makes the students' files from it.
# Its cells are explained in meshfair_grading.source. Each kind of cell becomes a file of
# its own, so names are imported once for each:
# ruff: noqa: F811

# %% [markdown]
# # Assignment 6: a filter that learns
#
# The bilateral normal filter has a kernel that somebody has chosen. You will leave it open, let
# examples choose it, and then do what is harder: find out honestly how good it is. It practises
# notebook 8, *What a filter can learn*.
#
# **20 points, about 5 hours.** Write your functions into the file `a6.py` beside this
# notebook. Run the cells here; after you save `a6.py` the notebook uses the new version at once.
# `check("...")` shows what is right and explains what is not. You hand in `a6.py` and
# nothing else; it will also be tried on meshes that you have not seen.
#
# **Allowed:** `numpy`, `scipy`, Python's own modules.
# **Forbidden:** mesh libraries (`meshfair`, `igl`, `open3d`, ...) inside `a6.py`, and libraries
# that learn. Nothing here is larger than a linear system of a dozen unknowns.

# %%
# %load_ext autoreload
# %autoreload 2
# %load_ext meshfair_grading.notebook
import a6
import matplotlib.pyplot as plt
import numpy as np
from a6_checks import DIFFERENCES, DISTANCES, RIDGE, check

from meshfair import mesh, noise, shapes
from meshfair.filters import kernel_table
from meshfair_grading.notebook import show

# %% [markdown]
# ## Background
#
# A filter of normals replaces the normal $n_i$ of each face by a weighted mean of the normals
# around it, made one long:
#
# $$ n_i \leftarrow \sum_j a_{ij}\, K\big(\lVert n_i - n_j \rVert,\ d_{ij}\big)\; n_j
#    \ \text{, normalised.} \tag{1} $$
#
# The sum goes over the faces $j$ that share a vertex with face $i$, and face $i$ itself;
# $a_{ij}$ is the share that face $j$ has in their area, and $d_{ij}$ the distance of the two
# centroids, in mean distances of adjacent faces. The **kernel** $K$ says how much a neighbour
# counts that differs by so much and is so far away. The bilateral normal filter (Zheng 2011)
# takes a Gaussian of both. You take a **table**: numbers $K_{ab}$ at some differences and
# distances, straight lines in between.
#
# All pairs $(i, j)$ of a mesh come as four arrays of one length, `i, j, share, distance`:

# %%
V, F = shapes.box(segments=8)
V_noisy = noise.along_normals(V, F, 0.3, np.random.default_rng(1))
i, j, share, distance = kernel_table.face_pairs(V_noisy, F)
print(f"{len(F)} faces, {len(i)} pairs; face 0 has the faces {j[i == 0]}")
show({"clean": V, "noisy": V_noisy}, F, direction=(1, -1, 0.9))

# %% module
"""Assignment 6: a filter that learns.

Fill in the functions; the notebook a6.ipynb explains and checks them.
N: unit normals, shape (m, 3). i, j, share, distance: the pairs of faces, each of shape (p,).
G: what each entry of the table contributes to each face, shape (m, k, 3). table: shape (k,).
"""

import numpy as np
from scipy.sparse import csr_array

# %% checks
"""The checks of assignment 6. Reading them is allowed, changing them changes nothing."""

import numpy as np

from meshfair import mesh, noise, shapes
from meshfair.filters import kernel_table
from meshfair_grading import expect
from meshfair_grading.assignment import Assignment, Rules

### BEGIN HIDDEN TESTS
from meshfair_grading.meshes import unseen

### END HIDDEN TESTS

check = Assignment("a6", "A filter that learns", seed=2026, rules=Rules())

# The nodes of the table: differences of unit normals, and distances.
DIFFERENCES = np.array([0.0, 0.2, 0.6, 1.2, 2.0])
DISTANCES = np.array([0.0, 1.0, 2.5])
RIDGE = 0.5


def hats_at(x, nodes):
    """The right hats."""
    left = np.clip(np.searchsorted(nodes, x, "right") - 1, 0, len(nodes) - 2)
    t = np.clip((x - nodes[left]) / (nodes[left + 1] - nodes[left]), 0, 1)
    H = np.zeros((len(x), len(nodes)))
    H[np.arange(len(x)), left] = 1 - t
    H[np.arange(len(x)), left + 1] = t
    return H


# %% [markdown]
# ## Task 1: `hats` (4 points)
#
# A number between two nodes belongs to both of them, more to the nearer one. Let the
# nodes be $x_0 < x_1 < \dots$, not necessarily evenly spaced. The **hat** of node $a$ is 1
# at $x_a$, 0 at all other nodes, and straight in between. A number past the last node counts as
# if it were there (and so does one before the first). With
# $H_{ka} = \mathrm{hat}_a(x_k)$, a table of one row of values $y_a$ is read at $x_k$ by
# $\sum_a H_{ka}\, y_a$.


# %% module
def hats(x, nodes):
    """How much of each node each number has.

    Parameters: x of shape (p,), nodes of shape (q,), rising.

    Returns
    -------
    array, shape (p, q)
        The rows add up to 1.
    """
    ### BEGIN SOLUTION
    return np.stack([np.interp(x, nodes, one) for one in np.eye(len(nodes))], axis=1)
    ### END SOLUTION


# %% checks
def numbers_between(seed):
    yield "evenly spaced nodes", np.array([0.0, 0.25, 1.0, 1.75, 2.6, 3.0]), np.arange(4.0)
    yield "uneven nodes", np.linspace(0, 2, 9), DIFFERENCES
    ### BEGIN HIDDEN TESTS
    rng = np.random.default_rng(seed)
    nodes = np.cumsum(rng.uniform(0.3, 2, rng.integers(4, 9)))
    yield "unseen nodes", rng.uniform(nodes[0], nodes[-1], 40), nodes
    ### END HIDDEN TESTS


def numbers_past_the_ends(seed):
    yield "numbers past the last node", np.array([0.5, 2.0, 2.5, 40.0]), np.array([0.0, 1.0, 2.0])
    ### BEGIN HIDDEN TESTS
    rng = np.random.default_rng(seed + 1)
    nodes = np.cumsum(rng.uniform(0.3, 2, rng.integers(4, 9)))
    yield "unseen numbers past both ends", rng.uniform(-3, 20, 40), nodes
    ### END HIDDEN TESTS


PAST = "Past the ends all your hats are 0: such a number counts as the last (or first) node."


def check_hats(student, x, nodes):
    """Compare, with hints."""
    right = hats_at(x, nodes)
    rows, size = np.arange(len(x)), len(nodes)
    left = np.clip(np.searchsorted(nodes, x, "right") - 1, 0, size - 2)
    t = (x - nodes[left]) / (nodes[left + 1] - nodes[left])

    def two(first, second):
        H = np.zeros((len(x), size))
        H[rows, left], H[rows, left + 1] = first, second
        return H

    one = np.eye(size)
    apart = np.abs(x[:, None] - nodes)
    inside = (x >= nodes[0]) & (x <= nodes[-1])
    mistakes = [
        ("This is 1 at the nearest node alone: between two nodes a number belongs to both.",
         one[apart.argmin(axis=1)]),
        ("This is 1 for the whole interval after a node: go straight from 1 to 0 in it.",
         one[left]),
        ("The two parts are exchanged: the nearer node gets more.",
         two(np.clip(t, 0, 1), np.clip(1 - t, 0, 1))),
        ("All your hats have the same width; each goes down to 0 at the next node, wherever "
         "that is.", np.maximum(0, 1 - apart / (nodes[1] - nodes[0]))),
        ("All your hats have the same width; each goes down to 0 at the next node, wherever "
         "that is.", np.maximum(0, 1 - apart / np.diff(nodes).mean())),
        (PAST, right * inside[:, None]),
        ("Past the ends the straight lines go on, so that weights become negative: such a number "
         "counts as the last (or first) node.", two(1 - t, t)),
        ("At a node itself your hats are all 0: there, one of them is 1.",
         right * ~np.isin(x, nodes)[:, None]),
        ("Only whole numbers came back: an array of integers cuts off what lies between.",
         np.trunc(right)),
        ("The last node is missing: its column is 0.", right * (np.arange(size) < size - 1)),
    ]  # fmt: skip
    expect.close(student.hats(x, nodes), right, "H", mistakes=mistakes)


@check.part("hats", 3, numbers_between)
def hats_between_the_nodes(student, x, nodes):
    """Between the nodes, and at them."""
    check_hats(student, x, nodes)


@check.part("hats", 1, numbers_past_the_ends)
def hats_past_the_ends(student, x, nodes):
    """Past the ends."""
    check_hats(student, x, nodes)


# %%
check("hats")

# %% [markdown]
# Your hats, at the differences that the table below has:

# %% result
x = np.linspace(0, 2.3, 300)
figure, axes = plt.subplots(figsize=(6, 2.2))
axes.plot(x, a6.hats(x, DIFFERENCES))
axes.set(xlabel="difference of two unit normals", xticks=DIFFERENCES)
plt.show()

# %% [markdown]
# ## Task 2: `contributions` (6 points)
#
# With the table read by hats, the sum in (1) is linear in its entries:
#
# $$ \sum_j a_{ij}\, K(\dots)\; n_j = \sum_{a, b} K_{ab}\; g_{i,ab}, \qquad
#    g_{i,ab} = \sum_j a_{ij}\; \mathrm{hat}_a\big(\lVert n_i - n_j \rVert\big)\;
#    \mathrm{hat}_b\big(d_{ij}\big)\; n_j . \tag{2} $$
#
# Return the $g$ as one array of shape $(m, k, 3)$, $k$ = number of differences times number of
# distances; the entry $(a, b)$ stands at place `a * len(distances) + b`, as
# `reshape` puts it.
#
# *Hint.* One entry of the table at a time: the weights of all pairs make a sparse $(m, m)$
# matrix, and its product with `N` sums them up. `np.add.at` will do, too. Assigning to
# `G[i]` will not: a face is in many pairs.


# %% module
def contributions(N, i, j, share, distance, differences, distances):
    """What each entry of the table contributes to the normal of each face.

    Returns
    -------
    array, shape (m, len(differences) * len(distances), 3)
    """
    ### BEGIN SOLUTION
    m = len(N)
    of_difference = hats(np.linalg.norm(N[i] - N[j], axis=1), differences)
    of_distance = hats(distance, distances)
    columns = []
    for a in range(len(differences)):
        for b in range(len(distances)):
            w = share * of_difference[:, a] * of_distance[:, b]
            columns.append(csr_array((w, (i, j)), shape=(m, m)) @ N)
    return np.stack(columns, axis=1)
    ### END SOLUTION


# %% checks
def example(V, F, seed, sigma=0.3):
    """Noisy normals, true normals, and the pairs of the noisy mesh."""
    V_noisy = noise.along_normals(V, F, sigma, np.random.default_rng(seed))
    pairs = kernel_table.face_pairs(V_noisy, F)
    return mesh.face_normals(V_noisy, F), mesh.face_normals(V, F), pairs


def noisy_meshes(seed):
    for name, (V, F) in (
        ("box", shapes.box(segments=3)),
        ("torus", shapes.torus(sections=12, sides=8)),
    ):
        N, _, pairs = example(V, F, seed)
        yield f"a noisy {name}", N, *pairs, DIFFERENCES, DISTANCES
    ### BEGIN HIDDEN TESTS
    for ring in (False, True):
        N, _, pairs = example(*unseen(seed, ring=ring), seed)
        yield "an unseen noisy mesh", N, *pairs, np.array([0, 0.3, 0.5, 1, 1.9]), DISTANCES[:2]
    ### END HIDDEN TESTS


def three_faces(seed):
    """Every pair by hand: three faces at right angles, as at a corner of a box."""
    N = np.eye(3)
    i, j = np.divmod(np.arange(9), 3)
    share, distance = np.tile([0.2, 0.3, 0.5], 3), np.where(i == j, 0.0, 1.0)
    nodes = np.array([0.0, np.sqrt(2), 2, 3])
    yield "three faces at right angles", N, i, j, share, distance, nodes, np.array([0.0, 1.0])
    ### BEGIN HIDDEN TESTS
    rng = np.random.default_rng(seed)
    share = rng.uniform(0.2, 0.8, 9)
    N = N[rng.permutation(3)]
    yield "three other faces", N, i, j, share, distance, nodes, np.array([0.0, 1.0, 2.0])
    ### END HIDDEN TESTS


def summed(N, i, j, share, Ha, Hb, add=True):
    """sum_j share Ha Hb n_j of each face; the last j alone if not add."""
    each = share[:, None, None] * Ha[:, :, None] * Hb[:, None, :]
    each = each.reshape(len(share), -1, 1) * N[j][:, None]
    G = np.zeros((len(N), each.shape[1], 3))
    if add:
        np.add.at(G, i, each)
    else:
        G[i] = each
    return G


def check_contributions(student, N, i, j, share, distance, differences, distances):
    """Compare, with hints."""
    apart = np.linalg.norm(N[i] - N[j], axis=1)
    Ha, Hb = hats_at(apart, differences), hats_at(distance, distances)
    right = summed(N, i, j, share, Ha, Hb)
    a, b = Ha.shape[1], Hb.shape[1]
    angle = 2 * np.arcsin(np.minimum(apart / 2, 1))
    others = i != j

    def with_difference(x):
        return summed(N, i, j, share, hats_at(x, differences), Hb)

    def with_distance_first():
        return right.reshape(-1, a, b, 3).swapaxes(1, 2).reshape(right.shape)

    def normalised_entries():
        weight = summed(np.ones_like(N), i, j, share, Ha, Hb)
        return np.divide(right, weight, out=np.zeros_like(right), where=weight > 0)

    mistakes = [
        ("The shares of the areas are missing: a small face counts less.",
         lambda: summed(N, i, j, np.ones_like(share), Ha, Hb)),
        ("You assign where you have to add: face i is in many pairs, and the last one is left.",
         lambda: summed(N, i, j, share, Ha, Hb, add=False)),
        ("You add up the normals n_i of the face itself; those of the faces j around it are "
         "wanted.", lambda: summed(N, i, i, share, Ha, Hb)),
        ("You add up at face j what belongs to face i: in the matrix i is the row, j the column.",
         lambda: summed(N, j, i, share, Ha, Hb)),
        ("The entries stand in another order: (a, b) at a * len(distances) + b.",
         with_distance_first),
        ("You left out the pairs of a face with itself: they belong to the sum, too.",
         lambda: summed(N, i[others], j[others], share[others], Ha[others], Hb[others])),
        ("You took the angle of the normals (in radians); the difference of two unit normals is "
         "wanted, |n_i - n_j|.", lambda: with_difference(angle)),
        ("You took the angle of the normals (in degrees); the difference of two unit normals is "
         "wanted, |n_i - n_j|.", lambda: with_difference(np.degrees(angle))),
        ("You took the square of the difference: |n_i - n_j| itself is wanted.",
         lambda: with_difference(apart**2)),
        ("You took the cosine of the angle in place of the difference |n_i - n_j|.",
         lambda: with_difference(1 - apart**2 / 2)),
        ("The distance does not count in yours: multiply by its hats, too.",
         lambda: summed(N, i, j, share, Ha, np.ones_like(Hb))),
        ("The difference does not count in yours: multiply by its hats, too.",
         lambda: summed(N, i, j, share, np.ones_like(Ha), Hb)),
        ("You divide each entry by the sum of its weights: then it is no longer linear in the "
         "table; add up and leave it.", normalised_entries),
        ("Each g is made one long: only the sum over all entries is normalised, at the end.",
         lambda: right / np.maximum(np.linalg.norm(right, axis=2, keepdims=True), 1e-300)),
    ]  # fmt: skip
    got = student.contributions(N, i, j, share, distance, differences, distances)
    expect.close(got, right, "G", mistakes=mistakes)


@check.part("contributions", 2, three_faces)
def contributions_of_three_faces(student, N, i, j, share, distance, differences, distances):
    """For three faces."""
    check_contributions(student, N, i, j, share, distance, differences, distances)


@check.part("contributions", 4, noisy_meshes)
def contributions_on_meshes(student, N, i, j, share, distance, differences, distances):
    """On noisy meshes."""
    check_contributions(student, N, i, j, share, distance, differences, distances)


# %%
check("contributions")

# %% [markdown]
# ## Task 3: `fit` (4 points)
#
# On a mesh whose true normals $n_i^\ast$ we know, ask for the table with which the sums (2) come
# closest to them, by **least squares**:
#
# $$ \min_K\ \sum_i \Big\lVert \sum_k K_k\, g_{i,k} - n_i^\ast \Big\rVert^2
#    + \rho\, \lVert K \rVert^2 . \tag{3} $$
#
# The second term, the **ridge**, keeps an entry small that hardly any pair asks for: without
# it, chance would decide. Set the derivative to zero: a linear system of $k$
# equations. Each face has three equations, one for each coordinate, and they all share the same
# $K$.


# %% module
def fit(G, N_true, ridge):
    """The table that is best on an example, by (3).

    Returns
    -------
    array, shape (k,)
    """
    ### BEGIN SOLUTION
    X = G.transpose(0, 2, 1).reshape(-1, G.shape[1])
    A = X.T @ X + ridge * np.eye(G.shape[1])
    return np.linalg.solve(A, X.T @ N_true.ravel())
    ### END SOLUTION


# %% checks
def contributions_of(V, F, seed):
    """G and the true normals of a mesh with noise."""
    N, N_true, (i, j, share, distance) = example(V, F, seed)
    apart = np.linalg.norm(N[i] - N[j], axis=1)
    G = summed(N, i, j, share, hats_at(apart, DIFFERENCES), hats_at(distance, DISTANCES))
    return G, N_true


def to_fit(seed):
    yield "a noisy box", *contributions_of(*shapes.box(segments=3), seed), RIDGE
    yield "a noisy torus", *contributions_of(*shapes.torus(sections=12, sides=8), seed), 2 * RIDGE
    ### BEGIN HIDDEN TESTS
    yield "an unseen noisy mesh", *contributions_of(*unseen(seed), seed), 0.7
    ### END HIDDEN TESTS


def never_asked_for(seed):
    G, N_true = contributions_of(*shapes.torus(sections=12, sides=8), seed)
    G[:, [2, 5]] = 0
    yield "a table with entries that no pair asks for", G, N_true, RIDGE
    ### BEGIN HIDDEN TESTS
    G, N_true = contributions_of(*unseen(seed, ring=True), seed)
    G[:, [1, 7, 8]] = 0
    yield "an unseen mesh, entries that no pair asks for", G, N_true, 0.3
    ### END HIDDEN TESTS


def equations(G):
    """Three rows for each face."""
    return np.concatenate([G[:, :, axis] for axis in range(3)])


def best_table(G, N_true, ridge):
    """The right table, by least squares with the ridge as further equations."""
    size = G.shape[1]
    X = np.concatenate([equations(G), np.sqrt(ridge) * np.eye(size)])
    return np.linalg.lstsq(X, np.concatenate([N_true.T.ravel(), np.zeros(size)]), rcond=None)[0]


def check_fit(student, G, N_true, ridge):
    """Compare, with hints."""
    right, size = best_table(G, N_true, ridge), G.shape[1]
    X, y = equations(G), N_true.T.ravel()
    A, b, one = X.T @ X, X.T @ y, np.eye(size)
    other = G.transpose(0, 2, 1).reshape(-1, size).T @ y  # the rows by face, the answers by axis

    def solved(A, b):
        try:
            return np.linalg.solve(A, b)
        except np.linalg.LinAlgError:  # then no student's solve has given an answer either
            return np.full(size, np.nan)

    def mixed():
        rows = G.reshape(-1, size)
        return solved(rows.T @ rows + ridge * one, rows.T @ N_true.ravel())

    mistakes = [
        ("The ridge is missing.", lambda: np.linalg.lstsq(X, y, rcond=None)[0]),
        ("The ridge is missing.", lambda: solved(A, b)),
        ("Your ridge is its square: rho itself stands before |K|^2.",
         lambda: best_table(G, N_true, ridge**2)),
        ("Your ridge is its square root: rho itself stands before |K|^2.",
         lambda: best_table(G, N_true, ridge**0.5)),
        ("Your ridge counts twice: where the derivative has 2 rho, it has the other 2 as well.",
         lambda: best_table(G, N_true, 2 * ridge)),
        ("Your ridge counts half.", lambda: best_table(G, N_true, ridge / 2)),
        ("You take means over the faces, so that the ridge weighs too much: (3) has sums.",
         lambda: best_table(G, N_true, ridge * len(G))),
        ("You take means over the equations, so that the ridge weighs too much: (3) has sums.",
         lambda: best_table(G, N_true, ridge * len(X))),
        ("You add the ridge to all entries of the matrix: rho |K|^2 adds it on the diagonal.",
         lambda: solved(A + ridge, b)),
        ("The sign of the ridge is wrong.", lambda: solved(A - ridge * one, b)),
        ("`reshape` alone mixes entries and coordinates: bring the coordinates before the entries "
         "first, G.transpose(0, 2, 1).", mixed),
        ("The equations and their right-hand sides stand in different orders: go face by face in "
         "both, or coordinate by coordinate.", lambda: solved(A + ridge * one, other)),
        ("You cut off negative entries: least squares may want them.", np.maximum(right, 0)),
        ("You make the entries add up to 1: the table of least squares is the answer as it is.",
         right / right.sum()),
        ("You use one coordinate of three: all of them share the same table.",
         lambda: best_table(G * [1, 0, 0], N_true * [1, 0, 0], ridge)),
        ("You use one coordinate of three: all of them share the same table.",
         lambda: best_table(G * [0, 0, 1], N_true * [0, 0, 1], ridge)),
        ("You take the mean of three tables, one for each coordinate: they are one system.",
         lambda: np.mean([best_table(G * axis, N_true * axis, ridge) for axis in np.eye(3)],
                         axis=0)),
        ("This is the right-hand side alone: the linear system is still to be solved.", b),
    ]  # fmt: skip
    got = student.fit(G, N_true, ridge)
    if isinstance(got, np.ndarray) and got.shape == (size, 3):
        expect.that(
            False,
            "You fit a table for each coordinate; one table is wanted, for all three at once.",
            expected=f"shape ({size},)",
            got=f"shape {got.shape}",
        )
    expect.close(got, right, "the table", mistakes=mistakes)


@check.part("fit", 3, to_fit)
def fit_of_one_mesh(student, G, N_true, ridge):
    """The best table."""
    check_fit(student, G, N_true, ridge)


@check.part("fit", 1, never_asked_for)
def fit_where_nothing_is_known(student, G, N_true, ridge):
    """Entries that no pair asks for."""
    check_fit(student, G, N_true, ridge)


# %%
check("fit")

# %% [markdown]
# ## Task 4: `filtered` (2 points)
#
# The filter (1) itself, with the table that you have: add up, and make each normal one long. Where
# the sum is zero, no direction is left: return zero there, and no `nan`.


# %% module
def filtered(G, table):
    """The filtered normals.

    Returns
    -------
    array, shape (m, 3)
    """
    ### BEGIN SOLUTION
    sums = np.einsum("mkx,k->mx", G, table)
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.divide(sums, length, out=np.zeros_like(sums), where=length > 0)
    ### END SOLUTION


# %% checks
def to_filter(seed):
    G, N_true = contributions_of(*shapes.box(segments=3), seed)
    yield "a noisy box", G, best_table(G, N_true, RIDGE)
    ### BEGIN HIDDEN TESTS
    G, N_true = contributions_of(*unseen(seed), seed)
    yield "an unseen noisy mesh", G, np.random.default_rng(seed).uniform(0.5, 2, G.shape[1])
    ### END HIDDEN TESTS


def nothing_left(seed):
    G, N_true = contributions_of(*shapes.torus(sections=12, sides=8), seed)
    G[::7] = 0
    yield "a torus, some of whose faces have no neighbours", G, best_table(G, N_true, RIDGE)
    ### BEGIN HIDDEN TESTS
    G, N_true = contributions_of(*unseen(seed, ring=True), seed)
    G[3::5] = 0
    yield "an unseen mesh, some of whose faces have no neighbours", G, np.ones(G.shape[1])
    ### END HIDDEN TESTS


def directions(G, table):
    """The right normals."""
    sums = (G * table[:, None]).sum(axis=1)
    return sums / np.maximum(np.sqrt((sums**2).sum(axis=1)), 1e-300)[:, None]


def check_filtered(student, G, table):
    """Compare, with hints."""
    sums = (G * table[:, None]).sum(axis=1)
    with np.errstate(all="ignore"):
        undefined = sums / np.linalg.norm(sums, axis=1, keepdims=True)
    got = student.filtered(G, table)
    if np.isnan(undefined).any() and isinstance(got, np.ndarray) and got.shape == sums.shape:
        expect.that(
            not np.isnan(got).any(),
            "0 / 0 is nan: where the sum is zero, return zero.",
            expected="zero",
            got="nan",
        )
    mistakes = [
        ("The sums are right, but not made one long.", sums),
        ("You divide by the sum of the table: each normal has a length of its own.",
         lambda: sums / table.sum()),
        ("You divide by the norm of the whole array: axis=1 gives one for each row.",
         lambda: sums / np.linalg.norm(sums)),
        ("You divide by the sum of the coordinates, which is no length.",
         lambda: sums / np.where(sums.any(axis=1), sums.sum(axis=1), 1)[:, None]),
        ("You divide by the squared length.", lambda: directions(G, table)
         / np.where(sums.any(axis=1), np.linalg.norm(sums, axis=1), 1)[:, None]),
        ("You add up the entries without the table.", lambda: directions(G, np.ones_like(table))),
    ]  # fmt: skip
    expect.close(got, directions(G, table), "N", mistakes=mistakes)


@check.part("filtered", 1, to_filter)
def filtered_normals(student, G, table):
    """The directions."""
    check_filtered(student, G, table)


@check.part("filtered", 1, nothing_left)
def filtered_zero(student, G, table):
    """Zero where nothing is left."""
    check_filtered(student, G, table)


# %%
check("filtered")

# %% [markdown]
# A table that has learned from your box, at work on the same box with *other* noise, and one
# that has learned from a torus. Five passes, each with a table that is fitted to
# what the passes before leave (a *cascade*):


# %% result
def cascade(V, F, seed, tables=None, passes=5):
    """Tables learned from a mesh; or, if tables are given, the mesh that they make."""
    V_noisy = noise.along_normals(V, F, 0.3, np.random.default_rng(seed))
    pairs, N = kernel_table.face_pairs(V_noisy, F), mesh.face_normals(V_noisy, F)
    learned = []
    for k in range(passes):
        G = a6.contributions(N, *pairs, DIFFERENCES, DISTANCES)
        learned.append(tables[k] if tables else a6.fit(G, mesh.face_normals(V, F), RIDGE))
        N = a6.filtered(G, learned[-1])
    return kernel_table.fit_vertices(V_noisy, F, N) if tables else learned


# %% result
box, torus = shapes.box(segments=8), shapes.torus(sections=30, sides=16)
show(
    {
        f"learned from the {name}": cascade(*box, 2, tables=cascade(*example, 1))
        for name, example in (("box", box), ("torus", torus))
    },
    box[1],
    direction=(1, -1, 0.9),
)

# %% [markdown]
# ## Task 5: `held_out` (4 points)
#
# How good is your filter? On the shape that it has learned from it is as good as it can be, and
# that says little. **Leave one out:** for each shape, learn from all *other* shapes, and measure on
# the one that was left out. All shapes come in one array, in any order: `shape[f]` is the
# number of the shape to which face `f` belongs, 0, 1, 2, ...
#
# For each shape $s$: pool the equations of all faces with `shape != s`, `fit` one table, apply
# `filtered` to the faces of $s$, and return the mean angle to their true normals, in degrees.


# %% module
def held_out(G, N_true, shape, ridge):
    """The error on each shape, of the table learned from all others.

    Returns
    -------
    array, shape (number of shapes,)
        Mean angles, in degrees.
    """
    ### BEGIN SOLUTION
    errors = []
    for s in range(shape.max() + 1):
        table = fit(G[shape != s], N_true[shape != s], ridge)
        N = filtered(G[shape == s], table)
        cosine = np.clip((N * N_true[shape == s]).sum(axis=1), -1, 1)
        errors.append(np.degrees(np.arccos(cosine)).mean())
    return np.array(errors)
    ### END SOLUTION


# %% checks
def several_shapes(seed):
    def pooled(meshes):
        parts = [contributions_of(V, F, seed + k) for k, (V, F) in enumerate(meshes)]
        G, N_true = (np.concatenate(part) for part in zip(*parts, strict=True))
        return G, N_true, np.repeat(np.arange(len(parts)), [len(N) for _, N in parts]), RIDGE

    box, ball = shapes.box(segments=4), shapes.icosphere(2)
    yield "a box, a torus and a sphere", *pooled([box, shapes.torus(sections=12, sides=8), ball])
    ### BEGIN HIDDEN TESTS
    yield "unseen shapes", *pooled([unseen(seed), unseen(seed, ring=True), box, ball])
    ### END HIDDEN TESTS


def shuffled_shapes(seed):
    for name, G, N_true, shape, ridge in several_shapes(seed):
        order = np.random.default_rng(seed).permutation(len(G))
        yield f"{name}, their faces mixed", G[order], N_true[order], shape[order], ridge


def angles(G, table, N_true):
    """Of the filtered normals to the true ones, in radians."""
    apart = np.linalg.norm(directions(G, table) - N_true, axis=1)
    return 2 * np.arcsin(np.minimum(apart / 2, 1))


def check_held_out(student, G, N_true, shape, ridge):
    """Compare, with hints."""
    count = shape.max() + 1
    of = [shape == s for s in range(count)]
    own = [best_table(G[f], N_true[f], ridge) for f in of]
    rest = [best_table(G[~f], N_true[~f], ridge) for f in of]

    def errors(tables, mean=np.mean):
        return [np.degrees(mean(angles(G[f], t, N_true[f])))
                for f, t in zip(of, tables, strict=True)]  # fmt: skip

    right = errors(rest)

    def means_of_tables():
        return errors([np.mean([own[k] for k in range(count) if k != s], axis=0)
                       for s in range(count)])  # fmt: skip

    def in_blocks():
        blocks = np.sort(shape)
        tables = [best_table(G[blocks != s], N_true[blocks != s], ridge) for s in range(count)]
        return [np.degrees(angles(G[blocks == s], t, N_true[blocks == s]).mean())
                for s, t in enumerate(tables)]  # fmt: skip

    def on_the_others(tables):
        return [np.degrees(angles(G[~f], t, N_true[~f]).mean())
                for f, t in zip(of, tables, strict=True)]  # fmt: skip

    mistakes = [
        ("The tables have learned from all shapes, the one that they are tried on among them: "
         "leave it out.", lambda: errors([best_table(G, N_true, ridge)] * count)),
        ("Each table is tried on the shape that it has learned from: learn from all the others.",
         lambda: errors(own)),
        ("You learn from one shape and try on the others: learn from the others, try on the one.",
         lambda: on_the_others(own)),
        ("You measure on the shapes that the table has learned from, not on the one left out.",
         lambda: on_the_others(rest)),
        ("You take the mean of tables: pool the equations, and fit one table.", means_of_tables),
        ("The angles are in radians: np.degrees.", lambda: np.radians(right)),
        ("This is the median angle; the mean is wanted.", lambda: errors(rest, np.median)),
        ("This is the root of the mean square; the mean angle is wanted.",
         lambda: errors(rest, lambda x: np.sqrt((x**2).mean()))),
        ("You take the mean of the cosines, and then one angle: the mean of the angles is wanted.",
         lambda: errors(rest, lambda x: np.arccos(np.cos(x).mean()))),
        ("This is the largest angle; the mean is wanted.", lambda: errors(rest, np.max)),
        ("You take the faces of a shape to stand in blocks, one shape after the other: `shape` "
         "says which face belongs to which.", in_blocks),
        ("The ridge is not passed on to `fit`.",
         lambda: errors([best_table(G[~f], N_true[~f], 0) for f in of])),
        ("This is the mean over all shapes; an error for each of them is wanted.",
         lambda: np.full(count, np.mean(right))),
    ]  # fmt: skip
    got = student.held_out(G, N_true, shape, ridge)
    if isinstance(got, (int, float)) or (isinstance(got, np.ndarray) and got.size == 1):
        expect.that(
            False,
            "One number came back; an error for each shape is wanted.",
            expected=f"{count} angles",
            got="one",
        )
    if isinstance(got, list):
        got = np.array([expect.number(value, "an error") for value in got])
    expect.close(got, right, "the errors", mistakes=mistakes, rtol=1e-5)


@check.part("held_out", 3, several_shapes)
def held_out_shapes(student, G, N_true, shape, ridge):
    """One shape after the other."""
    check_held_out(student, G, N_true, shape, ridge)


@check.part("held_out", 1, shuffled_shapes)
def held_out_mixed(student, G, N_true, shape, ridge):
    """Faces in any order."""
    check_held_out(student, G, N_true, shape, ridge)


# %%
check("held_out")

# %% [markdown]
# Your filter on four shapes (one pass): what it says of itself, and what is true on a shape that it
# does not know.

# %% result
known = {
    "box": shapes.box(segments=8),
    "torus": shapes.torus(sections=30, sides=16),
    "knot": shapes.knot(90, 12),
    "sphere": shapes.icosphere(3),
}
parts = []
for V, F in known.values():
    V_noisy = noise.along_normals(V, F, 0.3, np.random.default_rng(1))
    pairs, N = kernel_table.face_pairs(V_noisy, F), mesh.face_normals(V_noisy, F)
    G = a6.contributions(N, *pairs, DIFFERENCES, DISTANCES)
    parts.append((G, mesh.face_normals(V, F)))
G, N_true = (np.concatenate(part) for part in zip(*parts, strict=True))
shape = np.repeat(np.arange(len(parts)), [len(part) for _, part in parts])
honest = a6.held_out(G, N_true, shape, RIDGE)
for s, name in enumerate(known):
    g, n = G[shape == s], N_true[shape == s]
    cosine = np.clip((a6.filtered(g, a6.fit(g, n, RIDGE)) * n).sum(axis=1), -1, 1)
    print(f"{name}: on itself {np.degrees(np.arccos(cosine)).mean():.1f}, honest {honest[s]:.1f}")

# %% [markdown]
# ## All together

# %%
check()

# %% [markdown]
# ## To think about (no points)
#
# 1. On which of the four shapes is the honest error much larger than the other? Why on that one?
# 2. The noise of the shape that is left out was never seen either. Does leaving out the noise alone
#    (the same shape, another draw) give an honest error?
# 3. Somebody chooses the ridge that makes the held-out errors smallest. Are these errors
#    still honest?
