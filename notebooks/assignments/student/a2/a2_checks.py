"""The checks of assignment 2. Reading them is allowed, changing them changes nothing."""

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array, triu

from meshfair import mesh, operators, shapes, weights
from meshfair_grading import expect
from meshfair_grading.assignment import Assignment

check = Assignment("a2", "Three weights", seed=2022)


def closed_meshes(seed):
    yield "a tetrahedron", *tetrahedron()
    yield "a sphere", *shapes.icosphere(1, 2.0)


def open_meshes(seed):
    yield "a single triangle", *triangle(0.5)
    V, F = shapes.icosphere(1)
    yield "a sphere with a hole", V, F[10:]


def tetrahedron():
    V = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    return V, np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])


def triangle(x):
    """The triangle (0, 0), (1, 0), (x, 1)."""
    return np.array([[0.0, 0, 0], [1, 0, 0], [x, 1, 0]]), np.array([[0, 1, 2]])


def check_symmetric(W, F):
    """Fail unless W is symmetric, zero on the diagonal and nonzero at most on the edges."""
    difference = abs(W - W.T).max()
    if difference > 1e-9 * abs(W).max():
        hint = "W is not symmetric: set w_ij and w_ji for every edge."
        if not abs(triu(W, 1)).nnz or not abs(triu(W.T, 1)).nnz:
            hint = "Only one half of W is filled: set w_ij and w_ji for every edge."
        raise expect.WrongAnswerError(hint, expected="W = W.T", got=f"{difference:.3g} off")
    diagonal = abs(W.diagonal()).max()
    expect.that(
        diagonal == 0,
        "No vertex is its own neighbour: the diagonal of W is zero. The sums d_i belong to "
        "D, not to W.",
        expected="zeros on the diagonal",
        got=f"up to {diagonal:.3g}",
    )
    allowed = weights.combinatorial(F, W.shape[0])
    outside = abs(W - W * allowed).max()
    expect.that(
        outside < 1e-12,
        "W has entries where there is no edge.",
        expected="entries on the edges only",
        got=f"another one of size {outside:.3g}",
    )


def check_edges(student, F):
    """Compare the rows as a set, with hints."""
    got = student.edges(F)
    expected = mesh.Edges(F).ends
    count = f"{len(expected)} rows (i, j), i < j"
    E = expect.array(got, "the array of edges")
    expect.that(
        E.ndim == 2 and E.shape[1] == 2,
        "An edge is a row of two vertices.",
        expected=count,
        got=f"shape {E.shape}",
    )
    low_first = np.sort(E, axis=1)
    distinct = np.unique(low_first, axis=0)
    complete = distinct.shape == expected.shape and np.array_equal(distinct, expected)
    hint = "Some edges are missing or do not exist: a triangle has the edges ab, bc and ca."
    if complete and len(E) > len(distinct):
        hint = (
            "Edges occur twice, as (i, j) and as (j, i): sort both indices within each row "
            "before np.unique, and give it axis=0."
        )
        if np.array_equal(low_first, E):
            hint = "Edges occur twice, once for each of their triangles: np.unique(..., axis=0)."
    elif complete and not np.array_equal(low_first, E):
        hint = "The edges are right, but not all rows have i < j."
    right = complete and len(E) == len(distinct) and np.array_equal(low_first, E)
    expect.that(right, hint, expected=count, got=f"{len(E)} rows, {len(distinct)} different edges")


@check.part("edges", 2, closed_meshes)
def edges_of_closed_meshes(student, V, F):
    """On closed meshes."""
    check_edges(student, F)


@check.part("edges", 1, open_meshes)
def edges_of_open_meshes(student, V, F):
    """On meshes with a boundary."""
    check_edges(student, F)


def half_edge_sums(V, F):
    """What adding a 1 for each half-edge of each triangle gives: no symmetry at a boundary."""
    H = mesh.half_edges(F)
    return coo_array((np.ones(len(H)), (H[:, 0], H[:, 1])), shape=(len(V), len(V)))


def check_combinatorial(student, V, F):
    """Compare, with hints."""
    n = len(V)
    W = expect.matrix(student.combinatorial_weights(F, n), "W", n)
    right = weights.combinatorial(F, n)
    H = half_edge_sums(V, F)
    doubled = "did you add both halves of an edge, or each edge once for each of its triangles?"
    mistakes = [
        (
            f"All weights are 2, and so are your rows' sums twice the right ones: {doubled}",
            2 * right,
        ),
        (f"Inner edges have weight 2 and boundary edges 1: {doubled}", H + H.T),
        ("The half-edges of the triangles are not symmetric at the boundary: use `edges`.", H),
        ("Only one half of W is filled: set w_ij and w_ji.", triu(right)),
        ("The degrees d_i do not belong into W.", right + diags_array(right.sum(axis=1))),
        ("This is the Laplacian D - W, not W.", operators.laplacian(right)),
    ]
    expect.close(W, right, "W", mistakes=mistakes)


@check.part("combinatorial_weights", 1, closed_meshes)
def combinatorial_is_symmetric(student, V, F):
    """Sparse, symmetric, zero on the diagonal, nothing outside the edges."""
    check_symmetric(expect.matrix(student.combinatorial_weights(F, len(V)), "W", len(V)), F)


@check.part("combinatorial_weights", 2, closed_meshes)
def combinatorial_on_closed_meshes(student, V, F):
    """On closed meshes."""
    check_combinatorial(student, V, F)


@check.part("combinatorial_weights", 1, open_meshes)
def combinatorial_on_open_meshes(student, V, F):
    """With a boundary, and with a vertex that no triangle uses."""
    check_combinatorial(student, np.concatenate([V, [[9.0, 9, 9]]]), F)


def on_entries(function, W):
    """The sparse matrix with a function applied to its entries."""
    return csr_array((function(W.data), W.indices, W.indptr), shape=W.shape)


@check.part("distance_weights", 1, closed_meshes)
def distance_is_symmetric(student, V, F):
    """Sparse, symmetric, zero on the diagonal, nothing outside the edges."""
    check_symmetric(expect.matrix(student.distance_weights(V, F), "W", len(V)), F)


@check.part("distance_weights", 2, closed_meshes)
def distance_is_right(student, V, F):
    """The values."""
    W = weights.distance(V, F)
    mistakes = [
        ("All weights are twice the distance: did you add both halves of an edge?", 2 * W),
        ("These are the squared distances: the root is missing.", on_entries(np.square, W)),
        (
            "These are the reciprocals: here a far neighbour pulls more.",
            on_entries(np.reciprocal, W),
        ),
        ("These are the combinatorial weights.", on_entries(np.ones_like, W)),
        ("Only one half of W is filled: set w_ij and w_ji.", triu(W)),
    ]
    got = expect.matrix(student.distance_weights(V, F), "W", len(V))
    expect.close(got, W, "W", mistakes=mistakes)


def corner_sums(V, F, function, shift=0):
    """Symmetric sums over the triangles of a function of an angle.

    With shift 0 the angle opposite to the edge, with 1 or 2 one beside it.
    """
    W = csr_array((len(V), len(V)))
    for corner in range(3):
        i, j = F[:, (corner + 1) % 3], F[:, (corner + 2) % 3]
        at, to, fro = (V[F[:, (corner + shift + step) % 3]] for step in range(3))
        u, v = to - at, fro - at
        sine = np.linalg.norm(np.cross(u, v), axis=1)
        w = function(np.arctan2(sine, (u * v).sum(axis=1)))
        W = W + coo_array((w, (i, j)), shape=W.shape) + coo_array((w, (j, i)), shape=W.shape)
    return W


def cotangent_mistakes(V, F):
    """Typical wrong values, up to a factor; each with its hint."""
    W = weights.cotangent(V, F)

    def cot(angle):
        return 1 / np.tan(angle)

    return [
        (
            "These are cotangents of degrees: np.tan takes radians. Better, compute no angle: "
            "cot = <u, v> / |u x v|.",
            lambda: corner_sums(V, F, lambda angle: cot(np.degrees(angle))),
        ),
        ("These are tangents: cot = cos / sin = <u, v> / |u x v|.",
         lambda: corner_sums(V, F, np.tan)),
        ("These are cosines: divide by |u x v|, not by |u| |v|.",
         lambda: corner_sums(V, F, np.cos)),
        ("These are the angles themselves; their cotangents are wanted.",
         lambda: corner_sums(V, F, np.asarray)),
        *(
            ("You take an angle beside the edge; the one opposite to it counts: the cotangent at "
             "corner k belongs to the edge between the other two.",
             lambda shift=shift: corner_sums(V, F, cot, shift))
            for shift in (1, 2)
        ),
        ("You cut negative weights off: they are right where alpha + beta > 180 degrees.",
         on_entries(lambda w: np.maximum(w, 0), W)),
        ("You took absolute values: weights are negative where alpha + beta > 180 degrees.",
         on_entries(np.abs, W)),
        ("You took absolute values: cotangents of obtuse angles are negative.",
         lambda: corner_sums(V, F, lambda angle: np.abs(cot(angle)))),
        ("The whole sign is wrong: L = D - W has the negative weights, W the positive ones.", -W),
        ("This is the Laplacian D - W (or libigl's, with the other sign), not W.",
         operators.laplacian(W)),
        ("This is the Laplacian D - W (or libigl's, with the other sign), not W.",
         -operators.laplacian(W)),
        ("Only one half of W is filled: set w_ij and w_ji.", triu(W)),
    ]  # fmt: skip


def acute_meshes(seed):
    """All weights positive: here only the formula counts, not the sign."""
    yield "a tetrahedron", *tetrahedron()
    V, F = shapes.icosphere(1)
    yield "a stretched sphere", V * [1.0, 1.2, 1.3], F


@check.part("cotangent_weights", 1, acute_meshes)
def cotangent_is_symmetric(student, V, F):
    """Sparse, symmetric, zero on the diagonal, nothing outside the edges."""
    check_symmetric(expect.matrix(student.cotangent_weights(V, F), "W", len(V)), F)


@check.part("cotangent_weights", 3, acute_meshes)
def cotangent_up_to_a_factor(student, V, F):
    """The cotangents of the right angles, up to one common factor."""
    W = weights.cotangent(V, F)
    got = expect.matrix(student.cotangent_weights(V, F), "W", len(V))
    expect.proportional(got, W, "W", mistakes=cotangent_mistakes(V, F))


@check.part("cotangent_weights", 2, acute_meshes)
def cotangent_has_its_half(student, V, F):
    """The factor one half."""
    W = weights.cotangent(V, F)
    mistakes = [
        (
            "All weights are twice the right ones: the half of (cot alpha + cot beta) / 2 is "
            "missing, or both halves of an edge were added.",
            2 * W,
        ),
        ("All weights are half the right ones: was the half taken twice?", W / 2),
    ]
    got = expect.matrix(student.cotangent_weights(V, F), "W", len(V))
    expect.close(got, W, "W", mistakes=[*mistakes, *cotangent_mistakes(V, F)])


def obtuse_meshes(seed):
    yield "a triangle with an obtuse angle", *triangle(2.0)
    V, F = shapes.icosphere(1)
    yield "a flat sphere with a hole", V * [1.0, 1.0, 0.3], F[10:]


@check.part("cotangent_weights", 1, obtuse_meshes)
def cotangent_of_obtuse_angles(student, V, F):
    """Obtuse angles keep their sign; boundary edges have one angle."""
    W = weights.cotangent(V, F)
    got = expect.matrix(student.cotangent_weights(V, F), "W", len(V))
    expect.proportional(got, W, "W", mistakes=cotangent_mistakes(V, F))


def weight_matrices(seed):
    V, F = shapes.icosphere(1)
    yield "combinatorial weights", weights.combinatorial(F, len(V))
    yield "distance weights", weights.distance(V * [1, 2, 3], F)


@check.part("averaging", 1, weight_matrices)
def averaging_has_rows_of_sum_one(student, W):
    """Each row sums to one."""
    n = W.shape[0]
    A = expect.matrix(student.averaging(W), "the operator", n)
    sums = A.sum(axis=1)
    worst = np.argmax(np.abs(sums - 1))
    hint = "The rows do not sum to one: divide each row by its own sum."
    if expect.alike(sums, np.full(n, sums[0])):
        hint = f"Your rows sum to {sums[0]:.4g}: divide by the full sum d_i of the row."
        if abs(sums[0] - 2) < 1e-9:
            hint = "Your rows sum to 2: did you add both halves of an edge?"
    elif expect.alike(A.sum(axis=0), np.ones(n)):
        hint = (
            "Your columns sum to one, the rows should: W / d divides the columns, "
            "diags_array(1 / d) @ W the rows."
        )
    elif expect.alike(A.toarray(), W.toarray()):
        hint = "This is W itself: the division by the row sums is missing."
    expect.that(
        abs(sums[worst] - 1) < 1e-9,
        hint,
        expected="1 for every row",
        got=f"row {worst} sums to {sums[worst]:.4g}",
    )


@check.part("averaging", 2, weight_matrices)
def averaging_is_right(student, W):
    """The values."""
    d = W.sum(axis=1)
    root = diags_array(np.sqrt(np.maximum(d, 0)) / np.maximum(np.abs(d), 1e-300))
    mistakes = [
        (
            "You divided the columns: diags_array(1 / d) @ W scales the rows.",
            W @ diags_array(1 / d),
        ),
        (
            "This is the symmetric normalisation D^(-1/2) W D^(-1/2); here it is D^-1 W.",
            root @ W @ root,
        ),
        (
            "These are equal weights for all neighbours: divide w_ij by d_i, not 1 by the degree.",
            lambda: operators.averaging(on_entries(np.ones_like, W)),
        ),
    ]
    got = expect.matrix(student.averaging(W), "the operator", W.shape[0])
    expect.close(got, operators.averaging(W), "the operator", mistakes=mistakes)
