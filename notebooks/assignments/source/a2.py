# Instructor's file of assignment 2; `make assignments` makes the students' files from it.
# Its cells are explained in meshfair_grading.source. Each kind of cell becomes a file of
# its own, so names are imported once for each:
# ruff: noqa: F811

# %% [markdown]
# # Assignment 2: three weights
#
# To smooth a mesh, every vertex looks at its neighbours. *How much* it listens to each of
# them is written in a sparse matrix $W$: one weight $w_{ij}$ for each edge. You will build
# three such matrices, derive the famous one with the cotangents, and turn weights into means.
#
# **20 points, about 4 hours.** Write your functions into the file `a2.py` beside this
# notebook. Run the cells here; after you save `a2.py` the notebook uses the new version at once.
# `check("...")` shows what is right and explains what is not. You hand in `a2.py` and
# nothing else; it will also be tried on meshes that you have not seen.
#
# **Allowed:** `numpy`, `scipy` (above all `scipy.sparse.coo_array`), Python's own modules.
# **Forbidden:** mesh libraries (`meshfair`, `igl`, `open3d`, `trimesh`, ...) inside
# `a2.py`: they hold the answers. Matrices are sparse: no $n \times n$ array anywhere.

# %%
# %load_ext autoreload
# %autoreload 2
# %load_ext meshfair_grading.notebook
import a2
import matplotlib.pyplot as plt
import numpy as np
from a2_checks import check

from meshfair import noise, reference, shapes
from meshfair_grading.notebook import show

# %% [markdown]
# ## Background
#
# The mesh is `V`, shape $(n, 3)$, and `F`, shape $(m, 3)$, with triangles counter-clockwise
# seen from outside. $E$ is the set of its edges *without orientation*: $(i, j)$ and $(j, i)$ are
# one edge. Weights are a **symmetric** matrix with zeros on the diagonal,
#
# $$ w_{ij} = w_{ji} \ \text{for } (i, j) \in E, \qquad w_{ij} = 0 \ \text{otherwise}, $$
#
# and we compare three choices:
#
# | weights | $w_{ij}$ on an edge | idea |
# |---|---|---|
# | combinatorial | $1$ | all neighbours count the same |
# | distance | $\lVert v_i - v_j \rVert$ | far neighbours pull more |
# | cotangent | $\tfrac12 (\cot\alpha_{ij} + \cot\beta_{ij})$ | the surface's own Laplacian |
#
# A vertex has about six neighbours, so $W$ has about $6n$ entries that are not zero.
# `scipy.sparse.coo_array((values, (rows, columns)), shape=(n, n)).tocsr()` builds it, and
# **adds up** values that fall on the same entry. That is the most useful and the most
# treacherous property of this lesson.

# %% module
"""Assignment 2: three weights.

Fill in the functions; the notebook a2.ipynb explains and checks them.
V: positions, shape (n, 3). F: triangles, shape (m, 3), indices of vertices.
"""

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array

# %% checks
"""The checks of assignment 2. Reading them is allowed, changing them changes nothing."""

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array, triu

from meshfair import mesh, operators, shapes, weights
from meshfair_grading import expect
from meshfair_grading.answers import Other
from meshfair_grading.assignment import Assignment

### BEGIN HIDDEN TESTS
from meshfair_grading.meshes import tower, unseen

### END HIDDEN TESTS

check = Assignment("a2", "Three weights", seed=2022)


def closed_meshes(seed):
    yield "a tetrahedron", *tetrahedron()
    yield "a sphere", *shapes.icosphere(1, 2.0)
    ### BEGIN HIDDEN TESTS
    yield "an unseen mesh", *unseen(seed)
    yield "an unseen ring", *unseen(seed, ring=True)
    ### END HIDDEN TESTS


def open_meshes(seed):
    yield "a single triangle", *triangle(0.5)
    V, F = shapes.icosphere(1)
    yield "a sphere with a hole", V, F[10:]
    ### BEGIN HIDDEN TESTS
    yield "an unseen mesh with a boundary", *unseen(seed, opened=True)
    ### END HIDDEN TESTS


def tetrahedron():
    V = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    return V, np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])


def triangle(x):
    """The triangle (0, 0), (1, 0), (x, 1)."""
    return np.array([[0.0, 0, 0], [1, 0, 0], [x, 1, 0]]), np.array([[0, 1, 2]])


def check_symmetric(W, F):
    """Fail unless W is symmetric, zero on the diagonal and nonzero at most on the edges."""
    difference = abs(W - W.T).max()
    rounded = max(1e-9, 100 * expect.rounding(W)) * abs(W).max()
    if difference > rounded:
        hint = "W is not symmetric: set w_ij and w_ji for every edge."
        if not abs(triu(W, 1)).nnz or not abs(triu(W.T, 1)).nnz:
            hint = "Only one half of W is filled: set w_ij and w_ji for every edge."
        raise expect.WrongAnswerError(hint, expected="W = W.T", got=f"{difference:.3g} off")
    diagonal = abs(W.diagonal()).max()
    expect.that(
        diagonal <= rounded,
        "No vertex is its own neighbour: the diagonal of W is zero. The sums d_i belong to "
        "D, not to W.",
        expected="zeros on the diagonal",
        got=f"up to {diagonal:.3g}",
    )
    allowed = weights.combinatorial(F, W.shape[0])
    outside = abs(W - W * allowed).max()
    expect.that(
        outside <= rounded,
        "W has entries where there is no edge.",
        expected="entries on the edges only",
        got=f"another one of size {outside:.3g}",
    )


# %% [markdown]
# ## Task 1: `edges` (3 points)
#
# Each edge once, as a row $(i, j)$ with $i < j$; the order of the rows is up to you.
#
# *Hint.* Three `F[:, [a, b]]` stacked give $3m$ rows, in which every inner edge occurs twice,
# once in each direction. Sort within the rows, then `np.unique(..., axis=0)`. On a closed
# mesh $3m/2$ rows must be left: every triangle has three edges, every edge two triangles.


# %% module
def edges(F):
    """Edges without orientation, each once.

    Returns
    -------
    array of integers, shape (k, 2), rows (i, j) with i < j
    """
    ### BEGIN SOLUTION
    E = np.concatenate([F[:, [0, 1]], F[:, [1, 2]], F[:, [2, 0]]])
    return np.unique(np.sort(E, axis=1), axis=0)
    ### END SOLUTION


# %% checks
def check_edges(student, F):
    """Compare the rows as a set, with hints."""
    answer = student.edges(F)
    kind = answer.type if isinstance(answer, Other) else ""
    if isinstance(answer, list) and all(isinstance(edge, Other) for edge in answer):
        kind = f"list of {answer[0].type}" if answer else "list"
    if kind:
        raise expect.WrongAnswerError(
            "Return one array of integers, np.array(list of (i, j)): sets have no order.",
            expected="an array of shape (k, 2)",
            got=f"a {kind}",
        )
    E = expect.array(answer, "the array of edges")
    expected = mesh.Edges(F).ends
    count = f"{len(expected)} rows (i, j), i < j"
    if E.ndim != 2 or E.shape[1] != 2:
        hint = "An edge is a row of two vertices."
        if E.ndim == 2 and same_rows(E.T, expected):
            hint = "These are the right edges, as columns: return the transpose, one edge a row."
        elif E.ndim == 1 and np.array_equal(E, np.unique(F)):
            hint = "np.unique without axis=0 gives the different numbers, not the different rows."
        raise expect.WrongAnswerError(hint, expected=count, got=f"shape {E.shape}")
    low_first = np.sort(E, axis=1)
    distinct = np.unique(low_first, axis=0)
    complete = same_rows(distinct, expected)
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
    if complete and len(E) == len(distinct) and np.array_equal(low_first, E):
        return
    got = f"{len(E)} rows, {len(distinct)} different edges" + example(E, expected)
    explanations = None
    if not complete:
        explanations = [h for h, rows in edge_mistakes(F) if same_rows(low_first, rows)]
    raise expect.WrongAnswerError(hint, expected=count, got=got, explanations=explanations)


def example(E, expected):
    """A row that should not be there, or one that should."""
    right = {tuple(row) for row in expected.tolist()}
    rows = [tuple(int(x) if x == int(x) else x for x in row) for row in E.tolist()]
    wrong = next((row for row in rows if row not in right), None)
    missing = next((row for row in sorted(right) if row not in set(rows)), None)
    if wrong:
        return f", one of the rows {wrong}"
    return f", without {missing}" if missing else ""


def same_rows(rows, expected):
    """Whether two arrays hold the same rows, in any order and direction."""
    rows, expected = (np.unique(np.sort(x, axis=1), axis=0) for x in (rows, expected))
    return np.array_equal(rows, expected)


def edge_mistakes(F):
    """Hints, and the rows that the mistakes give."""
    E = mesh.Edges(F).ends
    stacked = np.concatenate([F[:, [0, 1]], F[:, [1, 2]], F[:, [2, 0]]])
    names = ("ab", "bc", "ca")
    thirds = np.split(stacked, 3)
    for left, name in enumerate(names):
        others = [third for k, third in enumerate(thirds) if k != left]
        yield f"The edges {name} of the triangles are missing.", np.concatenate(others)
        yield (
            f"Only the edges {name} of the triangles are there: a triangle has three.",
            (thirds[left]),
        )
    yield "The vertices are counted from 1: indices into V begin with 0.", E + 1
    yield (
        "Sort within each row, axis=1; axis=0 sorts the columns, and tears the edges apart.",
        (np.sort(stacked, axis=0)),
    )
    yield (
        "These are all pairs of vertices; edges are the sides of triangles.",
        (np.column_stack(np.triu_indices(F.max() + 1, 1))),
    )
    _, count = np.unique(np.sort(stacked, axis=1), axis=0, return_counts=True)
    yield "The boundary edges are missing: they belong to one triangle only.", E[count > 1]
    yield "Only the boundary edges are there.", E[count == 1]


@check.part("edges", 2, closed_meshes)
def edges_of_closed_meshes(student, V, F):
    """On closed meshes."""
    check_edges(student, F)


@check.part("edges", 1, open_meshes)
def edges_of_open_meshes(student, V, F):
    """On meshes with a boundary."""
    check_edges(student, F)


# %%
check("edges")

# %% [markdown]
# ## Task 2: `combinatorial_weights` (4 points)
#
# $w_{ij} = 1$ on every edge: the adjacency matrix of the mesh. The number of vertices is an
# argument, since a vertex may be in no triangle.
#
# *Hint.* From `edges` the symmetric matrix comes in one step: rows $[i, j]$, columns $[j, i]$,
# values $[1, 1]$. If you add up half-edges of the *triangles* instead, inner edges get 2.


# %% module
def combinatorial_weights(F, n):
    """Weight 1 on every edge.

    Returns
    -------
    csr_array, shape (n, n)
    """
    ### BEGIN SOLUTION
    E = edges(F)
    rows, columns = np.concatenate([E, E[:, ::-1]]).T
    return coo_array((np.ones(len(rows)), (rows, columns)), shape=(n, n)).tocsr()
    ### END SOLUTION


# %% checks
def half_edge_sums(V, F):
    """What adding a 1 for each half-edge of each triangle gives: no symmetry at a boundary."""
    H = mesh.half_edges(F)
    return coo_array((np.ones(len(H)), (H[:, 0], H[:, 1])), shape=(len(V), len(V)))


def sized(W, n, F):
    """The matrix W, whose size is not in the triangles."""
    used = int(F.max()) + 1
    if used < n and getattr(W, "shape", None) == (used, used):
        raise expect.WrongAnswerError(
            "A vertex may be in no triangle: the size of W is n, which is an argument, not the "
            "largest index plus one.",
            expected=f"shape ({n}, {n})",
            got=f"shape ({used}, {used})",
        )
    return expect.matrix(W, "W", n)


def check_combinatorial(student, V, F):
    """Compare, with hints."""
    n = len(V)
    W = sized(student.combinatorial_weights(F, n), n, F)
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
        ("Only one half of W is filled: set w_ij and w_ji.", triu(right).T),
        ("These are the edges' lengths; every edge has weight 1 here.",
         lambda: weights.distance(V, F)),
        ("Every weight is divided by the number of neighbours: that is task 5.",
         lambda: operators.averaging(right)),
        ("Each vertex is its own neighbour here: the diagonal of W is zero.",
         right + diags_array(np.ones(n))),
        ("The degrees d_i do not belong into W.", right + diags_array(right.sum(axis=1))),
        ("This is the Laplacian D - W, not W.", operators.laplacian(right)),
    ]  # fmt: skip
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


# %%
check("combinatorial_weights")

# %% [markdown]
# ## Task 3: `distance_weights` (3 points)
#
# $w_{ij} = \lVert v_i - v_j \rVert$. Not the reciprocal: a far neighbour pulls *more*.


# %% module
def distance_weights(V, F):
    """The length of each edge as its weight.

    Returns
    -------
    csr_array, shape (n, n)
    """
    ### BEGIN SOLUTION
    W = combinatorial_weights(F, len(V)).tocoo()
    lengths = np.linalg.norm(V[W.row] - V[W.col], axis=1)
    return coo_array((lengths, (W.row, W.col)), shape=W.shape).tocsr()
    ### END SOLUTION


# %% checks
def on_entries(function, W):
    """The sparse matrix with a function applied to its entries."""
    return csr_array((function(W.data), W.indices, W.indptr), shape=W.shape)


def on_edges(function, V, W):
    """The sparse matrix with a function of the positions of both ends."""
    edges = W.tocoo()
    values = function(V[edges.row], V[edges.col])
    return coo_array((values, (edges.row, edges.col)), shape=W.shape)


def length(u):
    return np.linalg.norm(u, axis=1)


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
        ("These are the reciprocals of the squares: here a far neighbour pulls more, d itself.",
         on_entries(lambda d: d**-2, W)),
        *(("This is an exponential that falls with the distance: here a far neighbour pulls more, "
           "d itself.", on_entries(function, W)) for function in (
            lambda d: np.exp(-d), lambda d: np.exp(-(d**2)), lambda d: np.exp(-(d**2) / 2))),
        *((f"{hint}: the distance is the root of the sum of the squares.",
           lambda norm=norm: on_edges(lambda u, v: np.linalg.norm(u - v, norm, axis=1), V, W))
          for hint, norm in (("You add up |dx| + |dy| + |dz|", 1),
                             ("You take the largest of |dx|, |dy|, |dz|", np.inf))),
        ("You use x and y only: the distance is one in space.",
         lambda: on_edges(lambda u, v: np.linalg.norm((u - v)[:, :2], axis=1), V, W)),
        ("You subtract norms: take the norm of the difference, |v_i - v_j|.",
         lambda: on_edges(lambda u, v: np.abs(length(u) - length(v)), V, W)),
        ("This is the scalar product of the positions, not their distance.",
         lambda: on_edges(lambda u, v: (u * v).sum(axis=1), V, W)),
        ("These are the combinatorial weights.", on_entries(np.ones_like, W)),
        ("Only one half of W is filled: set w_ij and w_ji.", triu(W)),
    ]  # fmt: skip
    got = expect.matrix(student.distance_weights(V, F), "W", len(V), finite=False)
    expect.close(got, W, "W", mistakes=mistakes)


# %%
check("distance_weights")

# %% [markdown]
# ## Where the cotangents come from
#
# The smoothest function with given values somewhere is the one with the least **Dirichlet
# energy** $\frac12 \int \|\nabla u\|^2$. Take $u$ linear on each triangle, with value $u_i$ at
# vertex $i$: $u = \sum_i u_i \varphi_i$, where the *hat function* $\varphi_i$ is 1 at vertex
# $i$, 0 at all others.
#
# **One triangle.** Let $A$ be its area, $h_i$ its height over the side opposite corner $i$, and
# $\ell_i$ the length of that side, so $A = \frac12 \ell_i h_i$. Going from that side to the
# corner, $\varphi_i$ rises from 0 to 1 over the distance $h_i$, so
#
# $$ \|\nabla \varphi_i\| = \frac1{h_i} = \frac{\ell_i}{2A}, \qquad
#    \nabla \varphi_i \perp \text{side opposite } i . $$
#
# The gradients of $\varphi_i$ and $\varphi_j$ are perpendicular to two sides that meet at the
# third corner $k$ with angle $\theta_k$. Both gradients point into the triangle, so the angle
# between *them* is $180° - \theta_k$, and
#
# $$ \int_T \langle \nabla\varphi_i, \nabla\varphi_j \rangle
#    = A \cdot \frac{\ell_i}{2A} \frac{\ell_j}{2A} \cdot (-\cos\theta_k)
#    = - \frac{\ell_i \ell_j \cos\theta_k}{4A}
#    = - \frac{\ell_i \ell_j \cos\theta_k}{2\, \ell_i \ell_j \sin\theta_k}
#    = - \tfrac12 \cot\theta_k , $$
#
# since the area is also $A = \frac12 \ell_i \ell_j \sin\theta_k$. The edge is $(i, j)$, the
# angle is the one **opposite** to it.
#
# **The whole mesh.** An inner edge has two triangles, with the angles $\alpha_{ij}$ and
# $\beta_{ij}$ across. Both contribute:
#
# $$ \int \langle \nabla\varphi_i, \nabla\varphi_j \rangle = - w_{ij}, \qquad
#    \boxed{\, w_{ij} = \tfrac12 \left( \cot\alpha_{ij} + \cot\beta_{ij} \right) \,} $$
#
# The $\varphi_i$ add up to 1, whose gradient is 0, so
# $\int \|\nabla\varphi_i\|^2 = \sum_j w_{ij} = d_i$, and the energy is
# $\frac12 u^\top (D - W)\, u$. The matrix $L = D - W$ is the Laplacian of assignment 3.
#
# Two things follow at once. A weight is **negative** exactly where
# $\alpha_{ij} + \beta_{ij} > 180°$; that is right, and no error to repair. And scaling the mesh
# changes no angle, so the weights have no unit.

# %%
quad = np.array([[0.0, 0], [2, 0.3], [0.8, 1.5], [1.2, -1.3]])  # i, j, and the corners across
figure, axes = plt.subplots(figsize=(4.5, 4))
for corner, name in ((2, r"$\alpha_{ij}$"), (3, r"$\beta_{ij}$")):
    axes.fill(*quad[[0, 1, corner]].T, facecolor="#dbe7f6", edgecolor="#23415f")
    towards = quad[[0, 1]].mean(axis=0) - quad[corner]
    axes.annotate(name, quad[corner] + 0.25 * towards, ha="center", va="center", fontsize=14)
axes.plot(*quad[[0, 1]].T, color="#c0392b", linewidth=3)
axes.annotate("$i$", quad[0] + (-0.1, 0), fontsize=14)
axes.annotate("$j$", quad[1] + (0.05, 0), fontsize=14)
axes.set(aspect="equal", title="The edge (i, j) and the two angles opposite to it")
axes.axis("off")
plt.show()

# %% [markdown]
# ## Task 4: `cotangent_weights` (7 points)
#
# $w_{ij} = \frac12 (\cot\alpha_{ij} + \cot\beta_{ij})$; a boundary edge has one angle only.
#
# *Hint.* No angle has to be computed. With $u$ and $v$ the two sides that leave a corner,
#
# $$ \cot\theta = \frac{\cos\theta}{\sin\theta} = \frac{\langle u, v \rangle}{\|u \times v\|} .
# $$
#
# Go through the three corners: the cotangent at corner `F[:, k]` belongs to the edge between
# the *other* two. Here adding up is what you want: both triangles of an edge add their half.


# %% module
def cotangent_weights(V, F):
    """Half the sum of the cotangents opposite to each edge.

    Returns
    -------
    csr_array, shape (n, n)
    """
    ### BEGIN SOLUTION
    W = csr_array((len(V), len(V)))
    for corner in range(3):
        k, i, j = (F[:, (corner + step) % 3] for step in range(3))
        u, v = V[i] - V[k], V[j] - V[k]
        cotangent = (u * v).sum(axis=1) / np.linalg.norm(np.cross(u, v), axis=1)
        W = W + coo_array((cotangent / 2, (i, j)), shape=W.shape)
    return csr_array(W + W.T)
    ### END SOLUTION


# %% checks
def corner_sums(V, F, function, shift=0, corners=(0, 1, 2)):
    """Symmetric sums over the triangles of a function of the two sides that leave a corner.

    With shift 0 the corner opposite to the edge, with 1 or 2 one beside it.
    """
    W = csr_array((len(V), len(V)))
    for corner in corners:
        i, j = F[:, (corner + 1) % 3], F[:, (corner + 2) % 3]
        at, to, fro = (V[F[:, (corner + shift + step) % 3]] for step in range(3))
        w = function(to - at, fro - at)
        W = W + coo_array((w, (i, j)), shape=W.shape) + coo_array((w, (j, i)), shape=W.shape)
    return W


def one_direction(V, F):
    """The cotangents at (i, j) alone, without (j, i)."""
    k, i, j = np.concatenate([np.roll(F, -corner, axis=1) for corner in range(3)]).T
    return coo_array((of_angle(cot)(V[i] - V[k], V[j] - V[k]), (i, j)), shape=(len(V), len(V)))


def of_angle(function):
    """A function of an angle as one of the two sides that form it."""
    return lambda u, v: function(np.arctan2(length(np.cross(u, v)), dot(u, v)))


def dot(u, v):
    return (u * v).sum(axis=1)


def cot(angle):
    return 1 / np.tan(angle)


def assigned(V, F):
    """Recognises weights that hold one of the two cotangents of each edge, not their sum.

    Which one depends on the order of a loop, and is any.
    """
    first, second = {}, {}
    for corner in range(3):
        i, j, k = (F[:, (corner + step) % 3] for step in (1, 2, 0))
        cotangents = of_angle(cot)(V[i] - V[k], V[j] - V[k])
        for a, b, value in zip(i, j, cotangents, strict=True):
            edge = min(a, b), max(a, b)
            (second if edge in first else first)[edge] = value
    inner = sorted(second)
    one, other = (np.array([of[edge] for edge in inner]) for of in (first, second))

    def is_one_of_them(W):
        got = np.array([W[edge] for edge in inner])
        sum_of_both = (one + other) / 2
        return (
            bool(inner)
            and any(
                (np.isclose(got, f * one, 1e-5) | np.isclose(got, f * other, 1e-5)).all()
                for f in (0.5, 1.0)
            )
            and not expect.alike(got, sum_of_both)
        )

    return expect.Recognised(is_one_of_them)


def cotangent_mistakes(V, F):
    """Typical wrong values, up to a factor; each with its hint."""
    W = weights.cotangent(V, F)
    minus = "The whole sign is wrong: L = D - W has the negative weights, W the positive ones."
    return [
        (
            "These are cotangents of degrees: np.tan takes radians. Better, compute no angle: "
            "cot = <u, v> / |u x v|.",
            lambda: corner_sums(V, F, of_angle(lambda angle: cot(np.degrees(angle)))),
        ),
        ("These are tangents: cot = cos / sin = <u, v> / |u x v|.",
         lambda: corner_sums(V, F, of_angle(np.tan))),
        ("These are cosines: divide by |u x v|, not by |u| |v|.",
         lambda: corner_sums(V, F, of_angle(np.cos))),
        ("These are sines: cot = cos / sin = <u, v> / |u x v|.",
         lambda: corner_sums(V, F, of_angle(np.sin))),
        ("These are scalar products <u, v>: divide each by |u x v|.",
         lambda: corner_sums(V, F, dot)),
        ("These are the angles themselves; their cotangents are wanted.",
         lambda: corner_sums(V, F, of_angle(np.asarray))),
        ("You take the cotangent of the cosine: <u, v> / (|u| |v|) is the cosine already. "
         "cot = <u, v> / |u x v|.",
         lambda: corner_sums(V, F, of_angle(lambda angle: cot(np.cos(angle))))),
        *(("You divide by one component of u x v; divide by its length, "
           "np.linalg.norm(..., axis=1).",
           lambda axis=axis, of=of: corner_sums(
               V, F, lambda u, v: dot(u, v) / of(np.cross(u, v)[:, axis])))
          for axis in (2, 1, 0) for of in (np.asarray, np.abs)),
        ("You take the arccos of the scalar product: divide it by |u| |v| first. Better, compute "
         "no angle: cot = <u, v> / |u x v|.",
         lambda: corner_sums(V, F, lambda u, v: cot(np.arccos(dot(u, v))))),
        ("You divide by |u x v| squared: the root is missing.",
         lambda: corner_sums(V, F, lambda u, v: dot(u, v) / length(np.cross(u, v)) ** 2)),
        ("You add the angles first: add the cotangents, cot alpha + cot beta.",
         lambda: on_entries(cot, corner_sums(V, F, of_angle(np.asarray)))),
        ("You take the cotangent of the mean angle; take the mean of the cotangents.",
         lambda: on_entries(lambda angle: cot(angle / 2),
                            corner_sums(V, F, of_angle(np.asarray)))),
        ("Each direction has the cotangent of one triangle only: add the transpose, W + W.T.",
         lambda: one_direction(V, F)),
        ("Each direction has the cotangent of one triangle only: add the transpose, W + W.T.",
         lambda: one_direction(V, F).T),
        ("Each edge has one of its two cotangents, the last: W[i, j] = ... forgets the first. Add "
         "them up, with += or coo_array.", assigned(V, F)),
        *((f"Only {3 - len(left_out)} of the three corners of each triangle {verb} counted.",
           lambda left_out=left_out: corner_sums(
               V, F, of_angle(cot), corners=sorted({0, 1, 2} - set(left_out))))
          for left_out, verb in (((0,), "are"), ((1,), "are"), ((2,), "are"),
                                 ((0, 1), "is"), ((0, 2), "is"), ((1, 2), "is"))),
        *(
            ("You take an angle beside the edge; the one opposite to it counts: the cotangent at "
             "corner k belongs to the edge between the other two.",
             lambda shift=shift: corner_sums(V, F, of_angle(cot), shift))
            for shift in (1, 2)
        ),
        ("You cut negative weights off: they are right where alpha + beta > 180 degrees.",
         on_entries(lambda w: np.maximum(w, 0), W)),
        ("You took absolute values: weights are negative where alpha + beta > 180 degrees.",
         on_entries(np.abs, W)),
        ("You took absolute values: cotangents of obtuse angles are negative.",
         lambda: corner_sums(V, F, of_angle(lambda angle: np.abs(cot(angle))))),
        ("You cut negative cotangents off: those of obtuse angles are negative.",
         lambda: corner_sums(V, F, of_angle(lambda angle: np.maximum(cot(angle), 0)))),
        (minus, -W),
        ("This is the Laplacian D - W (or libigl's, with the other sign), not W.",
         operators.laplacian(W)),
        ("This is the Laplacian D - W (or libigl's, with the other sign), not W.",
         -operators.laplacian(W)),
        ("Only one half of W is filled: set w_ij and w_ji.", triu(W)),
    ]  # fmt: skip


def acute_meshes(seed):
    """All weights positive: here only the formula counts, not the sign."""
    V, F = shapes.icosphere(1)
    yield "a stretched sphere", V * [1.0, 1.2, 1.3], F
    yield "a tetrahedron", *tetrahedron()
    ### BEGIN HIDDEN TESTS
    rng = np.random.default_rng(seed)
    V, F = tower(rng)
    yield "an unseen tower", rng.uniform(1, 4) * V, F
    ### END HIDDEN TESTS


@check.part("cotangent_weights", 1, acute_meshes)
def cotangent_is_symmetric(student, V, F):
    """Sparse, symmetric, zero on the diagonal, nothing outside the edges."""
    check_symmetric(expect.matrix(student.cotangent_weights(V, F), "W", len(V)), F)


@check.part("cotangent_weights", 3, acute_meshes)
def cotangent_up_to_a_factor(student, V, F):
    """The cotangents of the right angles, up to one common factor."""
    W = weights.cotangent(V, F)
    got = expect.matrix(student.cotangent_weights(V, F), "W", len(V), finite=False)
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
        ("All weights are half the right ones: w_ij = (cot alpha + cot beta) / 2, with one half.",
         W / 2),
    ]  # fmt: skip
    got = expect.matrix(student.cotangent_weights(V, F), "W", len(V), finite=False)
    try:
        expect.proportional(got, W, "W", mistakes=mistakes)
    except expect.WrongAnswerError as wrong:
        hint = "The cotangents themselves are not right yet; see the check above."
        raise expect.WrongAnswerError(hint, expected=wrong.expected, got=wrong.got) from None
    expect.close(got, W, "W", mistakes=mistakes)


def obtuse_meshes(seed):
    yield "a triangle with an obtuse angle", *triangle(2.0)
    V, F = shapes.icosphere(1)
    yield "a flat sphere with a hole", V * [1.0, 1.0, 0.3], F[10:]
    ### BEGIN HIDDEN TESTS
    yield "an unseen mesh", *unseen(seed)
    yield "an unseen ring with a boundary", *unseen(seed, ring=True, opened=True)
    ### END HIDDEN TESTS


@check.part("cotangent_weights", 1, obtuse_meshes)
def cotangent_of_obtuse_angles(student, V, F):
    """Obtuse angles keep their sign; boundary edges have one angle."""
    W = weights.cotangent(V, F)
    got = expect.matrix(student.cotangent_weights(V, F), "W", len(V), finite=False)
    expect.proportional(got, W, "W", mistakes=cotangent_mistakes(V, F))


# %%
check("cotangent_weights")

# %% [markdown]
# libigl is the library that researchers use. Its `cotmatrix` is $-L$; meshfair's `reference`
# reads the weights off it. Rounding is all that may differ:

# %% result
V, F = shapes.knot()
difference = abs(a2.cotangent_weights(V, F) - reference.cotangent(V, F)).max()
print(f"largest difference from libigl on the knot: {difference:.1e}")

# %% [markdown]
# ## Task 5: `averaging` (3 points)
#
# From weights to weighted means: divide every row by its sum $d_i = \sum_k w_{ik}$,
#
# $$ \tilde W = D^{-1} W, \qquad \tilde w_{ij} = \frac{w_{ij}}{d_i} . $$
#
# Each row of $\tilde W$ sums to 1, and $\tilde W V$ puts each vertex at the weighted mean of
# its neighbours. $\tilde W$ is *not* symmetric.
#
# *Hint.* A diagonal matrix times $W$ scales the **rows**: `diags_array(1 / d) @ W`. Write
# `W / d` and NumPy's broadcasting divides the columns instead.


# %% module
def averaging(W):
    """The averaging operator: W with every row divided by its sum.

    Returns
    -------
    csr_array, shape (n, n)
    """
    ### BEGIN SOLUTION
    return csr_array(diags_array(1 / W.sum(axis=1)) @ W)
    ### END SOLUTION


# %% checks
def weight_matrices(seed):
    V, F = shapes.icosphere(1)
    yield "combinatorial weights", weights.combinatorial(F, len(V))
    yield "distance weights", weights.distance(V * [1, 2, 3], F)
    ### BEGIN HIDDEN TESTS
    yield "unseen cotangent weights", weights.cotangent(*unseen(seed))
    ### END HIDDEN TESTS


@check.part("averaging", 1, weight_matrices)
def averaging_has_rows_of_sum_one(student, W):
    """Each row sums to one."""
    n = W.shape[0]
    A = expect.matrix(student.averaging(W), "the operator", n)
    sums = A.sum(axis=1)
    worst = np.argmax(np.abs(sums - 1))
    off = abs(sums[worst] - 1)
    if off < 1e-9:
        return
    explanations = [hint for hint, B in averaging_mistakes(W) if expect.alike(A.toarray(), B)]
    if hint := added_to_sums(sums, W):
        explanations = [hint]
    elif off < 100 * np.finfo(np.float32).eps:
        return  # the rounding of single precision
    hint = "The rows do not sum to one: divide each row by its own sum."
    if expect.alike(sums, np.full(n, sums[0])):
        hint = f"Your rows sum to {sums[0]:.4g}: divide by the full sum d_i of the row."
    one, got = expect.differing(1.0, sums[worst])
    raise expect.WrongAnswerError(
        hint,
        expected=f"{one} for every row",
        got=f"row {worst} sums to {got}",
        explanations=explanations,
    )


def added_to_sums(sums, W):
    """The hint where something was added to each d_i."""
    added = (1 / sums - 1) * W.sum(axis=1)
    small = abs(added.mean()) < 0.1 * abs(W.sum(axis=1)).min()
    if small and np.ptp(added) < 0.01 * abs(added.mean()):
        return f"You divide by d_i + {added.mean():.1g}: divide by d_i itself."
    return ""


def averaging_mistakes(W):
    """Hints, and what the mistakes give: rows that do not sum to one."""
    d, n = W.sum(axis=1), W.shape[0]
    neighbours = np.diff(csr_array(W).indptr)
    A = operators.averaging(W).toarray()
    dense = W.toarray()
    with np.errstate(all="ignore"):
        yield "Your rows sum to 2: did you add both halves of an edge?", 2 * A
        yield (
            (
                "Your columns sum to one, the rows should: W / d divides the columns, "
                "diags_array(1 / d) @ W the rows."
            ),
            dense / d,
        )
        yield "This is W itself: the division by the row sums is missing.", dense
        yield (
            ("You divide by the number of neighbours; divide by the sum of the weights, d_i."),
            dense / neighbours[:, None],
        )
        yield (
            (
                "You divide by the sum of the absolute values: where a weight is negative that is "
                "not d_i. The signs count."
            ),
            dense / np.abs(dense).sum(axis=1, keepdims=True),
        )
        yield "You divide by the root of d_i.", dense / np.sqrt(d)[:, None]
        yield (
            ("This is the symmetric normalisation D^(-1/2) W D^(-1/2); here it is D^-1 W."),
            dense / np.sqrt(np.outer(d, d)),
        )
        yield (
            "You divide by the largest weight of each row; divide by the sum.",
            (dense / dense.max(axis=1, keepdims=True)),
        )
        yield (
            "You divide by the length of each row, its root of squares; divide by the sum.",
            (dense / np.linalg.norm(dense, axis=1, keepdims=True)),
        )
        yield "You divide all rows by one number; each has a sum of its own.", dense / d.sum()
        yield "You divide all rows by one number; each has a sum of its own.", dense / d.max()
        yield "You divide all rows by one number; each has a sum of its own.", dense / d.mean()
        yield "You divide by the mean of each row; divide by its sum.", n * A
        yield "You multiply by d_i: divide by it.", dense * d[:, None]
        yield (
            "This is I - W~, the Laplacian divided by D: here W~ itself is wanted.",
            (np.eye(n) - A),
        )
        yield (
            "You added the vertex itself after dividing: W~ has zeros on the diagonal.",
            (np.eye(n) + A),
        )


@check.part("averaging", 2, weight_matrices)
def averaging_is_right(student, W):
    """The values."""
    n = W.shape[0]
    got = expect.matrix(student.averaging(W), "the operator", n)
    with_itself = W + diags_array(np.ones(n))
    mistakes = [
        *averaging_mistakes(W),
        ("You added the vertex to its own neighbours (W + I): only the neighbours count.",
         diags_array(1 / with_itself.sum(axis=1)) @ with_itself),
        ("This is (I + W~) / 2, half a step: here W~ itself is wanted.",
         lambda: (diags_array(np.ones(n)) + operators.averaging(W)) / 2),
        (
            "These are equal weights for all neighbours: divide w_ij by d_i, not 1 by the degree.",
            lambda: operators.averaging(on_entries(np.ones_like, W)),
        ),
        ("This is W~ transposed.", lambda: operators.averaging(W).T),
        ("You take the absolute values of the weights: the signs count.",
         lambda: operators.averaging(abs(W))),
    ]  # fmt: skip
    if hint := added_to_sums(got.sum(axis=1), W):
        mistakes = [(hint, expect.Recognised(lambda values: True))]
    expect.close(got, operators.averaging(W), "the operator", mistakes=mistakes)


# %%
check("averaging")

# %% [markdown]
# One step of averaging, $\tilde W V$, with each of your weights. Which one smooths most,
# which one keeps the triangles where they are?

# %% result
V, F = shapes.torus(sections=48, sides=20)
V_noisy = noise.along_normals(V, F, 0.25, np.random.default_rng(3))
yours = {
    "combinatorial": a2.combinatorial_weights(F, len(V)),
    "distance": a2.distance_weights(V_noisy, F),
    "cotangent": a2.cotangent_weights(V_noisy, F),
}
smoothed = {name: a2.averaging(W) @ V_noisy for name, W in yours.items()}
show({"noisy": V_noisy, **smoothed}, F)

# %% [markdown]
# ## All together

# %%
check()

# %% [markdown]
# ## To think about (no points)
#
# 1. On a mesh of equilateral triangles, what do the three operators $\tilde W$ have in common?
# 2. Take a flat mesh, with irregular triangles. For which weights is $\tilde W V = V$ at inner
#    vertices? (Put a linear function into the derivation above.)
# 3. Where on the knot are cotangent weights negative, and what does a mean with negative
#    weights do?
