"""The checks of assignment 4. Reading them is allowed, changing them changes nothing."""

import numpy as np
from scipy.sparse import csc_array, diags_array, eye_array
from scipy.sparse.linalg import splu

from meshfair import mesh, operators, shapes, weights
from meshfair_grading import expect
from meshfair_grading.assignment import Assignment, Rules

check = Assignment(
    "a4",
    "Backward Euler and regularisation",
    seed=2024,
    rules=Rules(forbidden=("inv", "pinv", "toarray", "todense")),
)


def meshes(seed):
    yield "a sphere", *shapes.icosphere(1, 2.0)
    yield "a torus", *shapes.torus(sections=12, sides=8)


def solve(A, B):
    return splu(csc_array(A)).solve(B)


@check.part("mass_matrix", 1, meshes)
def mass_adds_up(student, V, F):
    """Diagonal, positive, and in sum the area of the surface."""
    M = expect.matrix(student.mass_matrix(V, F), "M", len(V))
    beside = abs(M - diags_array(M.diagonal())).max()
    expect.that(
        beside == 0,
        "M is diagonal: nothing stands beside the diagonal.",
        expected="0 beside the diagonal",
        got=f"up to {beside:.4g}",
    )
    area, total = mesh.area(V, F), M.diagonal().sum()
    expected, got = expect.differing(area, total)
    hint = "The masses do not add up to the area of the surface."
    if abs(total - 3 * area) < 1e-6 * area:
        hint += " Each triangle is counted three times: a third of it belongs to each vertex."
    elif abs(total - 2 * area) < 1e-6 * area:
        hint += " The cross product is twice the area: the half is missing."
    elif abs(total - 6 * area) < 1e-6 * area:
        hint += " The cross product is twice the area, and each vertex gets a third of it."
    expect.that(expect.alike(total, area), hint, expected=expected, got=got)


@check.part("mass_matrix", 3, meshes)
def mass_is_right(student, V, F):
    """The values."""
    M = operators.mass(V, F)
    valence = np.bincount(F.ravel(), minlength=len(V))
    areas = mesh.face_areas(V, F)

    def last_only():
        m = np.zeros(len(V))
        for corner in range(3):
            m[F[:, corner]] += areas / 3
        return diags_array(m)

    mistakes = [
        ("This is the whole area around the vertex: a third of it is the vertex's own.", 3 * M),
        ("The cross product is twice the area: the half is missing.", 2 * M),
        ("The half of the cross product and the third are missing.", 6 * M),
        ("This is the mean area around the vertex: a third of the sum is wanted.",
         3 * diags_array(1 / valence) @ M),
        ("This is the inverse of M.", diags_array(1 / M.diagonal())),
        ("Each vertex has few of its triangles: m[F[:, k]] += ... adds just once where an index "
         "is repeated; use np.bincount or np.add.at.", last_only),
        ("This is the number of triangles around each vertex; add up their areas.",
         diags_array(valence.astype(float))),
        ("This is the root of M.", diags_array(np.sqrt(M.diagonal()))),
        ("All vertices have the same mass here; each has the area around it.",
         eye_array(len(V)) * (mesh.area(V, F) / len(V))),
    ]  # fmt: skip
    expect.close(expect.matrix(student.mass_matrix(V, F), "M", len(V)), M, "M", mistakes=mistakes)


def check_implicit_step(student, V, F, t):
    """Compare, with hints."""
    M, L = operators.mass(V, F), operators.laplacian(weights.cotangent(V, F))
    inverse_mass = diags_array(1 / M.diagonal())
    mistakes = [
        ("The sign of L is wrong: (M + t L), with L = D - W. Yours blows noise up.",
         lambda: solve(M - t * L, M @ V)),
        ("On the right-hand side M is missing: (M + t L) V+ = M V.", lambda: solve(M + t * L, V)),
        ("M is missing on both sides: this is (I + t L) V+ = V.",
         lambda: solve(eye_array(len(V)) + t * L, V)),
        ("M stands on the right-hand side only: (M + t L), not (I + t L).",
         lambda: solve(eye_array(len(V)) + t * L, M @ V)),
        ("M stands on the left-hand side only, and its inverse on the right: "
         "(M + t L) V+ = M V.", lambda: solve(M + t * L, inverse_mass @ V)),
        ("This is Crank and Nicolson's step, half forward, half backward; take backward Euler.",
         lambda: solve(M + t / 2 * L, M @ V - t / 2 * (L @ V))),
        ("You made two steps: one solves (M + t L) V+ = M V once.",
         lambda: solve(M + t * L, M @ solve(M + t * L, M @ V))),
        ("t stands at the right-hand side: it belongs to L, (M + t L) V+ = M V.",
         lambda: solve(M + L, t * (M @ V))),
        ("M stands in front of L: M^-1 L is wanted, which is (M + t L) V+ = M V.",
         lambda: solve(eye_array(len(V)) + t * M @ L, V)),
        ("The step has size t squared.", lambda: solve(M + t**2 * L, M @ V)),
        ("The step has size t / 2: here (M + t L).", lambda: solve(M + t / 2 * L, M @ V)),
        ("The step has size 2 t: here (M + t L).", lambda: solve(M + 2 * t * L, M @ V)),
        ("This is (t M + L) V+ = t M V, a step of size 1 / t.",
         lambda: solve(t * M + L, t * (M @ V))),
        ("This is what has moved, V+ - V; the new positions are wanted.",
         lambda: solve(M + t * L, M @ V) - V),
        ("This is forward Euler, V - t M^-1 L V; backward Euler solves a system.",
         lambda: V - t * inverse_mass @ (L @ V)),
        ("This is forward Euler backwards, V + t M^-1 L V; backward Euler solves a system.",
         lambda: V + t * inverse_mass @ (L @ V)),
        ("t is not used.", lambda: solve(M + L, M @ V)),
        ("Nothing has moved.", V),
    ]  # fmt: skip
    got = student.implicit_step(V, M, L, t)
    right = solve(M + t * L, M @ V)
    expect.close(got, right, f"V+ (t = {t:.3g})", mistakes=mistakes, nearly=0.5)


@check.part("implicit_step", 3, meshes)
def implicit_step_is_right(student, V, F):
    """A step of ordinary size."""
    check_implicit_step(student, V, F, 0.5 * mesh.mean_edge_length(V, F) ** 2)


@check.part("implicit_step", 2, meshes)
def large_implicit_step(student, V, F):
    """A step 200 times as large, which forward Euler would not survive."""
    check_implicit_step(student, V, F, 100 * mesh.mean_edge_length(V, F) ** 2)


@check.part("regularise", 3, meshes)
def regularise_is_right(student, V, F):
    """The values."""
    L, unit = operators.laplacian(weights.cotangent(V, F)), eye_array(len(V))
    lam = 0.7
    mistakes = [
        ("A factor 2 is left over: both terms of the gradient have it, and it cancels.",
         lambda: solve(unit + 2 * lam * L, V)),
        ("A factor 1/2 is left over: both terms of the gradient have a 2, and it cancels.",
         lambda: solve(unit + lam / 2 * L, V)),
        ("The sign of L is wrong: (I + lam L) X = V.", lambda: solve(unit - lam * L, V)),
        ("The weights lam are at the wrong term: (I + lam L) X = V.",
         lambda: solve(lam * unit + L, lam * V)),
        ("lam is at the wrong term: (I + lam L) X = V.", lambda: solve(lam * unit + L, V)),
        ("This is one step down the gradient; the minimum solves a linear system.",
         lambda: V - lam * (L @ V)),
        ("This is one step down the gradient; the minimum solves a linear system.",
         lambda: V - 2 * lam * (L @ V)),
        ("You penalise L X instead of the gradient: (I + lam L), not (I + lam L L).",
         lambda: solve(unit + lam * L @ L, V)),
        ("You penalise L X instead of the gradient: (I + lam L), not (I + lam L L).",
         lambda: solve(unit + lam**2 * L @ L, V)),
        ("This is a mixture (1 - lam) I + lam L: in (3) the first term has the weight 1.",
         lambda: solve((1 - lam) * unit + lam * L, (1 - lam) * V)),
        ("This is a mixture (1 - lam) I + lam L: in (3) the first term has the weight 1.",
         lambda: solve((1 - lam) * unit + lam * L, V)),
        ("This is what has moved, X - V; the new positions are wanted.",
         lambda: solve(unit + lam * L, V) - V),
        ("lam enters squared.", lambda: solve(unit + lam**2 * L, V)),
        ("lam is not used.", lambda: solve(unit + L, V)),
        ("The right-hand side has lam too many: (I + lam L) X = V.",
         lambda: solve(unit + lam * L, lam * V)),
        ("The mass matrix belongs to task 2: here (I + lam L) X = V.",
         lambda: solve(operators.mass(V, F) + lam * L, operators.mass(V, F) @ V)),
        ("Nothing has moved.", V),
    ]  # fmt: skip
    right = solve(unit + lam * L, V)
    expect.close(student.regularise(V, L, lam), right, "X", mistakes=mistakes, nearly=0.5)


@check.part("regularise", 1, meshes)
def regularise_at_both_ends(student, V, F):
    """Nothing moves for lam = 0; for a huge lam only the centre is left."""
    L = operators.laplacian(weights.cotangent(V, F))
    expect.close(student.regularise(V, L, 0.0), V, "X (lam = 0)")
    X = expect.array(student.regularise(V, L, 1e9), "X (lam = 1e9)", V.shape)
    off = np.abs(X - V.mean(axis=0)).max() / np.abs(V - V.mean(axis=0)).max()
    hint = "With a huge lam only smoothness counts, and a point is as smooth as it gets."
    if expect.single(X):
        hint += " Your numbers are float32: lam times their rounding is no small thing here."
    expect.that(
        off < 1e-3,
        hint,
        expected="all vertices at their mean",
        got=f"still {100 * off:.3g} % of the size",
    )


@check.part("regularise_fixed", 1, meshes)
def fixed_vertices_stay(student, V, F):
    """The fixed vertices stay, the others move."""
    L, fixed = operators.laplacian(weights.cotangent(V, F)), V[:, 2] > V[:, 2].mean()
    X = expect.array(student.regularise_fixed(V, L, 0.7, fixed), "X", V.shape)
    rounded = 4 * expect.rounding(X) * np.abs(V).max()
    moved = np.linalg.norm(X - V, axis=1) > rounded
    hint = "Fixed vertices have moved."
    if not moved.any():
        hint = "Nothing has moved, the free vertices neither."
    elif not moved[~fixed].any():
        hint = "The free vertices stayed instead: `fixed` is True for those that must not move."
    elif not moved[fixed].any():
        hint = "Some of the free vertices have not moved."
    expect.that(
        not moved[fixed].any() and moved[~fixed].all(),
        hint,
        expected=f"{fixed.sum()} vertices in place, {(~fixed).sum()} moved",
        got=f"{(~moved[fixed]).sum()} of the fixed ones in place, {moved[~fixed].sum()} of the "
        "others moved",
    )


@check.part("regularise_fixed", 3, meshes)
def regularise_fixed_is_right(student, V, F):
    """The values."""
    L, fixed = operators.laplacian(weights.cotangent(V, F)), V[:, 2] > V[:, 2].mean()
    lam, free = 0.7, ~fixed
    A = (eye_array(len(V)) + lam * L).tocsr()

    def solved(right_hand_side):
        X = V.copy()
        X[free] = solve(A[free][:, free], right_hand_side)
        return X

    def put_back():
        X = solve(A, V)
        X[fixed] = V[fixed]
        return X

    def exchanged():
        X = V.copy()
        right_hand_side = V[fixed] - A[fixed][:, free] @ V[free]
        X[fixed] = solve(A[fixed][:, fixed], right_hand_side)
        return X

    def alone():
        X, inside = V.copy(), operators.laplacian(-(A - diags_array(A.diagonal()))[free][:, free])
        X[free] = solve(eye_array(free.sum()) + inside, V[free])
        return X

    coupling = A[free][:, fixed] @ V[fixed]
    mistakes = [
        ("You solve without the constraint and put the fixed vertices back afterwards: their "
         "neighbours must feel them, as lam L_fc V_c on the right-hand side.", put_back),
        ("The term lam L_fc V_c is missing on the right-hand side.", lambda: solved(V[free])),
        ("The term lam L_fc V_c has the wrong sign on the right-hand side.",
         lambda: solved(V[free] + coupling)),
        ("lam is missing in front of L_fc V_c.", lambda: solved(V[free] - coupling / lam)),
        ("You solve without the constraint: X_c = V_c is not used.", lambda: solve(A, V)),
        ("The free and the fixed are exchanged: `fixed` is True for those that must not move.",
         exchanged),
        ("The fixed vertices are left out of the mesh altogether: their neighbours must feel them.",
         alone),
    ]  # fmt: skip
    got = student.regularise_fixed(V, L, lam, fixed)
    expect.close(got, solved(V[free] - coupling), "X", mistakes=mistakes, nearly=0.5)


@check.part("restore_volume", 3, meshes)
def restore_volume_is_right(student, V, F):
    """The positions."""
    V = V + [0.5, -1.0, 2.0]
    now, centre = mesh.volume(V, F), V.mean(axis=0)
    ratio = 1.3

    def scaled(s, about=centre):
        return about + s * (V - about)

    middle = (V.max(axis=0) + V.min(axis=0)) / 2
    mistakes = [
        ("The cube root is missing: lengths times s make volumes times s^3.", scaled(ratio)),
        ("This is the square root; volumes go with the cube of the lengths.", scaled(ratio**0.5)),
        ("The ratio is upside down: wanted volume over present volume.", scaled(ratio ** (-1 / 3))),
        ("You scale about the origin, and the mesh wanders: scale about its mean.",
         scaled(ratio ** (1 / 3), np.zeros(3))),
        ("You scale about the middle of the bounding box; the mean of the vertices is wanted.",
         scaled(ratio ** (1 / 3), middle)),
        ("You scale about the centre of the surface; the mean of the vertices is wanted.",
         lambda: scaled(ratio ** (1 / 3), np.average(
             V[F].mean(axis=1), axis=0, weights=mesh.face_areas(V, F)))),
        ("You scale the vertices without putting them back: the centre must stay where it is.",
         ratio ** (1 / 3) * (V - centre)),
        ("You multiply by the volume that is wanted; the ratio to the present one counts.",
         lambda: scaled(np.cbrt(ratio * now))),
        ("The ratio is taken three times instead of its cube root.", scaled(ratio**3)),
        ("This is a third of the ratio, not its cube root: ratio ** (1 / 3).", scaled(ratio / 3)),
        ("ratio ** 1 / 3 is (ratio ** 1) / 3: write ratio ** (1 / 3) or np.cbrt.",
         scaled(ratio / 3)),
        ("You divide by the area of the surface; the present volume is wanted.",
         lambda: scaled(np.cbrt(ratio * now / mesh.area(V, F)))),
        ("Your present volume is 6 times the right one: a tetrahedron has a sixth of the product.",
         scaled((ratio / 6) ** (1 / 3))),
        ("Your present volume is half the right one: the factor is 1 / 6.",
         scaled((2 * ratio) ** (1 / 3))),
        ("Your present volume is twice the right one: the factor is 1 / 6.",
         scaled((ratio / 2) ** (1 / 3))),
        ("The part 1 - s of the centre is missing or twice: v -> c + s (v - c).",
         ratio ** (1 / 3) * V + centre),
        ("Nothing has moved.", V),
    ]  # fmt: skip
    got = student.restore_volume(V, F, ratio * now)
    expect.close(got, scaled(ratio ** (1 / 3)), "V", mistakes=mistakes)
