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
    expect.that(beside == 0, "M is diagonal.", expected="0 beside the diagonal", got=f"{beside}")
    area, total = mesh.area(V, F), M.diagonal().sum()
    hint = "The masses do not add up to the area of the surface."
    if abs(total - 3 * area) < 1e-6 * area:
        hint += " Each triangle is counted three times: a third of it belongs to each vertex."
    elif abs(total - 2 * area) < 1e-6 * area:
        hint += " The cross product is twice the area: the half is missing."
    elif abs(total - 6 * area) < 1e-6 * area:
        hint += " The cross product is twice the area, and each vertex gets a third of it."
    expect.that(abs(total - area) < 1e-6 * area, hint, expected=f"{area:.6g}", got=f"{total:.6g}")


@check.part("mass_matrix", 3, meshes)
def mass_is_right(student, V, F):
    """The values."""
    M = operators.mass(V, F)
    valence = np.bincount(F.ravel(), minlength=len(V))
    mistakes = [
        ("This is the whole area around the vertex: a third of it is the vertex's own.", 3 * M),
        ("The cross product is twice the area: the half is missing.", 2 * M),
        ("The half of the cross product and the third are missing.", 6 * M),
        ("This is the mean area around the vertex: a third of the sum is wanted.",
         3 * diags_array(1 / valence) @ M),
        ("This is the inverse of M.", diags_array(1 / M.diagonal())),
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
        ("This is forward Euler, V - t M^-1 L V; backward Euler solves a system.",
         lambda: V - t * inverse_mass @ (L @ V)),
        ("This is forward Euler backwards, V + t M^-1 L V; backward Euler solves a system.",
         lambda: V + t * inverse_mass @ (L @ V)),
        ("t is not used.", lambda: solve(M + L, M @ V)),
        ("Nothing has moved.", V),
    ]  # fmt: skip
    got = student.implicit_step(V, M, L, t)
    expect.close(got, solve(M + t * L, M @ V), f"V+ (t = {t:g})", mistakes=mistakes)


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
    ]  # fmt: skip
    expect.close(student.regularise(V, L, lam), solve(unit + lam * L, V), "X", mistakes=mistakes)


@check.part("regularise", 1, meshes)
def regularise_at_both_ends(student, V, F):
    """Nothing moves for lam = 0; for a huge lam only the centre is left."""
    L = operators.laplacian(weights.cotangent(V, F))
    expect.close(student.regularise(V, L, 0.0), V, "X (lam = 0)")
    X = expect.array(student.regularise(V, L, 1e9), "X (lam = 1e9)", V.shape)
    off = np.abs(X - V.mean(axis=0)).max() / np.abs(V - V.mean(axis=0)).max()
    expect.that(
        off < 1e-3,
        "With a huge lam only smoothness counts, and a point is as smooth as it gets.",
        expected="all vertices at their mean",
        got=f"still {100 * off:.3g} % of the size",
    )


@check.part("regularise_fixed", 1, meshes)
def fixed_vertices_stay(student, V, F):
    """The fixed vertices stay, the others move."""
    L, fixed = operators.laplacian(weights.cotangent(V, F)), V[:, 2] > V[:, 2].mean()
    X = expect.array(student.regularise_fixed(V, L, 0.7, fixed), "X", V.shape)
    moved = np.linalg.norm(X - V, axis=1)
    hint = "Fixed vertices have moved."
    if not moved[~fixed].any():
        hint = "The free vertices stayed instead: `fixed` is True for those that must not move."
    expect.that(
        not moved[fixed].any() and moved[~fixed].all(),
        hint,
        expected=f"{fixed.sum()} vertices in place, {(~fixed).sum()} moved",
        got=f"{(moved == 0).sum()} in place",
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

    coupling = A[free][:, fixed] @ V[fixed]
    mistakes = [
        ("You solve without the constraint and put the fixed vertices back afterwards: their "
         "neighbours must feel them, as lam L_fc V_c on the right-hand side.", put_back),
        ("The term lam L_fc V_c is missing on the right-hand side.", lambda: solved(V[free])),
        ("The term lam L_fc V_c has the wrong sign on the right-hand side.",
         lambda: solved(V[free] + coupling)),
        ("lam is missing in front of L_fc V_c.", lambda: solved(V[free] - coupling / lam)),
    ]  # fmt: skip
    got = student.regularise_fixed(V, L, lam, fixed)
    expect.close(got, solved(V[free] - coupling), "X", mistakes=mistakes)


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
    ]  # fmt: skip
    got = student.restore_volume(V, F, ratio * now)
    expect.close(got, scaled(ratio ** (1 / 3)), "V", mistakes=mistakes)
