"""The checks of assignment 6. Reading them is allowed, changing them changes nothing."""

import numpy as np

from meshfair import mesh, noise, shapes
from meshfair.filters import kernel_table
from meshfair_grading import expect
from meshfair_grading.assignment import Assignment, Rules

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


def numbers_between(seed):
    yield "evenly spaced nodes", np.array([0.0, 0.25, 1.0, 1.75, 2.6, 3.0]), np.arange(4.0)
    yield "uneven nodes", np.linspace(0, 2, 9), DIFFERENCES


def numbers_past_the_ends(seed):
    yield "numbers past the last node", np.array([0.5, 2.0, 2.5, 40.0]), np.array([0.0, 1.0, 2.0])


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


def three_faces(seed):
    """Every pair by hand: three faces at right angles, as at a corner of a box."""
    N = np.eye(3)
    i, j = np.divmod(np.arange(9), 3)
    share, distance = np.tile([0.2, 0.3, 0.5], 3), np.where(i == j, 0.0, 1.0)
    nodes = np.array([0.0, np.sqrt(2), 2, 3])
    yield "three faces at right angles", N, i, j, share, distance, nodes, np.array([0.0, 1.0])


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


def contributions_of(V, F, seed):
    """G and the true normals of a mesh with noise."""
    N, N_true, (i, j, share, distance) = example(V, F, seed)
    apart = np.linalg.norm(N[i] - N[j], axis=1)
    G = summed(N, i, j, share, hats_at(apart, DIFFERENCES), hats_at(distance, DISTANCES))
    return G, N_true


def to_fit(seed):
    yield "a noisy box", *contributions_of(*shapes.box(segments=3), seed), RIDGE
    yield "a noisy torus", *contributions_of(*shapes.torus(sections=12, sides=8), seed), 2 * RIDGE


def never_asked_for(seed):
    G, N_true = contributions_of(*shapes.torus(sections=12, sides=8), seed)
    G[:, [2, 5]] = 0
    yield "a table with entries that no pair asks for", G, N_true, RIDGE


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


def to_filter(seed):
    G, N_true = contributions_of(*shapes.box(segments=3), seed)
    yield "a noisy box", G, best_table(G, N_true, RIDGE)


def nothing_left(seed):
    G, N_true = contributions_of(*shapes.torus(sections=12, sides=8), seed)
    G[::7] = 0
    yield "a torus, some of whose faces have no neighbours", G, best_table(G, N_true, RIDGE)


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


def several_shapes(seed):
    def pooled(meshes):
        parts = [contributions_of(V, F, seed + k) for k, (V, F) in enumerate(meshes)]
        G, N_true = (np.concatenate(part) for part in zip(*parts, strict=True))
        return G, N_true, np.repeat(np.arange(len(parts)), [len(N) for _, N in parts]), RIDGE

    box, ball = shapes.box(segments=4), shapes.icosphere(2)
    yield "a box, a torus and a sphere", *pooled([box, shapes.torus(sections=12, sides=8), ball])


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
