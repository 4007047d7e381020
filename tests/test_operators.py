import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import eigh
from scipy.sparse import csr_array, eye_array

from meshes import CLOSED, RIGHT_TRIANGLE, grid, soups
from meshfair import MeshError, flow, mesh, noise, operators, reference, shapes, weights


def all_weights(V, F):
    return {
        "combinatorial": weights.combinatorial(F, len(V)),
        "distance": weights.distance(V, F),
        "cotangent": weights.cotangent(V, F),
    }


def test_right_triangle_by_hand():
    V, F = RIGHT_TRIANGLE
    W = weights.cotangent(V, F)
    np.testing.assert_allclose(
        operators.averaging(W).toarray(), [[0, 0.5, 0.5], [1, 0, 0], [1, 0, 0]], atol=1e-15
    )
    np.testing.assert_allclose(
        operators.laplacian(W).toarray(),
        [[1, -0.5, -0.5], [-0.5, 0.5, 0], [-0.5, 0, 0.5]],
        atol=1e-15,
    )
    np.testing.assert_allclose(operators.mass(V, F).toarray(), np.eye(3) / 6, rtol=1e-15)


@given(soups())
def test_rows_sum_to_one_and_isolated_vertices_stay(soup):
    V, F = soup
    V, n = np.concatenate([V, [[5.0, 5, 5]]]), len(V) + 1  # the last vertex has no face
    for W in all_weights(V, F).values():
        A = operators.averaging(W)
        # Negative weights can cancel in the sum d, and rounding grows by |W| / |d|.
        d = operators.degrees(W)
        growth = np.divide(abs(W).sum(axis=1), abs(d), out=np.ones(n), where=d != 0)
        assert np.all(np.abs(A.sum(axis=1) - 1) <= 1e-14 * growth)
        np.testing.assert_array_equal((A @ V)[-1], V[-1])


@given(soups())
def test_laplacian(soup):
    V, F = soup
    for W in all_weights(V, F).values():
        L = operators.laplacian(W)
        size = abs(L).max()
        assert abs(L - L.T).max() <= 1e-14 * size
        assert np.abs(L.sum(axis=1)).max() <= 1e-13 * size
        # Positive semidefinite, for negative cotangent weights too (Dirichlet energy).
        assert np.linalg.eigvalsh(L.toarray()).min() >= -1e-12 * size


@pytest.mark.parametrize("build", CLOSED.values(), ids=CLOSED)
def test_mass_is_libigls_and_sums_to_the_area(build):
    V, F = build()
    M = operators.mass(V, F)
    assert abs(M - reference.mass(V, F)).max() <= 1e-12 * M.max()
    a, b, c = V[F[:, 0]], V[F[:, 1]], V[F[:, 2]]
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    assert M.sum() == pytest.approx(area, rel=1e-13)


def test_mass_of_a_trailing_unreferenced_vertex():
    V, F = RIGHT_TRIANGLE
    M = operators.mass(np.concatenate([V, V[:1]]), F)
    assert M.shape == (4, 4)
    assert M[3, 3] == 0


def generalised(W):
    """Eigenvalues of I - D^-1 W by a dense solver for the pair (L, D)."""
    D = np.diag(operators.degrees(W))
    return eigh(operators.laplacian(W).toarray(), D, eigvals_only=True)


@given(st.integers(0, 2**32 - 1), st.floats(0, 2))
def test_the_bounds_on_the_eigenvalues(seed, size):
    # Slivers of all kinds: a sphere whose vertices are moved by up to many edge lengths.
    V, F = shapes.icosphere(1)
    V = noise.gaussian(V, F, size, np.random.default_rng(seed))
    for name, W in all_weights(V, F).items():
        mu = generalised(W)
        assert mu.min() > -1e-9
        assert mu.max() <= (3 if name == "cotangent" else 2) + 1e-9


def test_the_bound_of_three_is_approached():
    # Two needles: the eigenvalues of one go to 0, 0 and 3 as its angles go to 0 and 180 degrees.
    V = np.array([[0.0, 0, 0], [1, 0, 0], [0.5, 1e-3, 0]])
    assert generalised(weights.cotangent(V, np.array([[0, 1, 2]]))).max() > 2.999


def test_diffusion_of_a_flat_mesh_moves_no_inner_vertex(rng):
    V, F = grid(6, irregular=rng)
    A = operators.diffusion(weights.cotangent(V, F), operators.mass(V, F))
    inside = np.all((V[:, :2] > 0) & (V[:, :2] < 6), axis=1)
    np.testing.assert_allclose((A @ V)[inside], V[inside], atol=1e-13 * 6)


@pytest.mark.parametrize("build", CLOSED.values(), ids=CLOSED)
def test_the_energy_of_the_positions_is_twice_the_area(build, rng):
    # tr(V' L V) = 2 area for cotangent weights: the identity map is conformal [PP93].
    V, F = build()
    V = noise.gaussian(V, F, 0.3, rng)
    L = operators.laplacian(weights.cotangent(V, F))
    assert np.trace(V.T @ (L @ V)) == pytest.approx(2 * operators.mass(V, F).sum(), rel=1e-12)


def test_curvature_of_the_sphere():
    # M^-1 L V is the mean curvature vector, -2 n on the unit sphere [MD99]: exactly so on
    # the mean, by the identity above, up to the area that the inscribed surface lacks.
    V, F = shapes.icosphere(4)
    A = operators.diffusion(weights.cotangent(V, F), operators.mass(V, F))
    curvature = V - A @ V
    sideways = curvature - np.einsum("ij,ij->i", curvature, V)[:, None] * V
    assert np.linalg.norm(sideways, axis=1).max() < 0.02 * 2
    m = operators.mass(V, F).diagonal()
    assert m @ np.einsum("ij,ij->i", curvature, V) / m.sum() == pytest.approx(2, rel=1e-12)


@pytest.mark.parametrize("function", [operators.averaging, operators.laplacian])
def test_bad_matrices(function):
    with pytest.raises(MeshError, match="W has shape"):
        function(csr_array((2, 3)))
    with pytest.raises(MeshError, match="NaN"):
        function(csr_array([[0, np.nan], [1, 0]]))


def test_weights_whose_squares_overflow():
    W = csr_array([[0, 1e200], [1e200, 0]])
    np.testing.assert_array_equal(operators.averaging(W).toarray(), [[0, 1], [1, 0]])


def test_sizes_that_do_not_fit():
    V, F = shapes.icosphere(1)
    with pytest.raises(MeshError, match="build both from one mesh"):
        operators.diffusion(weights.cotangent(V, F), operators.mass(V[:5], [[0, 1, 2]]))


def test_the_boundary_flows_as_a_curve():
    V, F = grid(4)
    rim = mesh.boundary_vertices(F)
    A = operators.averaging(weights.combinatorial(F, len(V)))
    curved = operators.boundary_as_curve(A, F)
    np.testing.assert_allclose(curved.sum(axis=1), 1)
    inside = np.setdiff1d(np.arange(len(V)), rim)
    assert abs(curved[inside] - A[inside]).max() == 0
    # A corner of the square goes to the middle of its two neighbours on the rim, and
    # a point between two of its like stays where it is.
    moved = curved @ V
    np.testing.assert_allclose(moved[0], [0.5, 0.5, 0])
    np.testing.assert_allclose(moved[2], V[2])


def test_a_regular_polygon_shrinks_by_the_cosine_of_half_its_step():
    # A disc: n vertices around a centre. Averaging neighbours on a circle multiplies
    # the radius by cos(2 pi / n); the centre stays by symmetry.
    n = 12
    t = 2 * np.pi * np.arange(n) / n
    V = np.vstack([np.column_stack([np.cos(t), np.sin(t), 0 * t]), np.zeros(3)])
    F = np.array([[k, (k + 1) % n, n] for k in range(n)])
    A = operators.boundary_as_curve(operators.averaging(weights.combinatorial(F, n + 1)), F)
    X = flow.average(V, A, 3)
    np.testing.assert_allclose(np.linalg.norm(X[:n], axis=1), np.cos(2 * np.pi / n) ** 3)
    np.testing.assert_allclose(X[n], 0, atol=1e-15)


def test_smoothing_the_boundary_alone_leaves_the_surface():
    V, F = grid(4)
    curve = operators.boundary_as_curve(eye_array(len(V)), F)
    moved = np.flatnonzero(np.any(curve @ V != V, axis=1))
    assert moved.tolist() == [0, 4, 20, 24]  # the corners; all else is straight


@pytest.mark.parametrize("A", [np.eye(3), np.ones((3, 4)), np.ones(3)])
def test_a_boundary_curve_of_the_wrong_size_is_refused(A):
    with pytest.raises(MeshError):
        operators.boundary_as_curve(A, grid(2)[1])


# Not symmetric, and its second row sums to 0 with entries that are not.
SKEW = csr_array([[0.0, 1, 3], [2, 0, -2], [1, 1, 0]])


def test_rows_not_columns_are_summed():
    np.testing.assert_array_equal(operators.degrees(SKEW), [4, 0, 2])
    np.testing.assert_array_equal(
        operators.averaging(SKEW).toarray(), [[0, 0.25, 0.75], [0, 1, 0], [0.5, 0.5, 0]]
    )
    np.testing.assert_array_equal(
        operators.laplacian(SKEW).toarray(), [[4, -1, -3], [-2, 0, 2], [-1, -1, 2]]
    )


def test_diffusion_by_hand():
    W = csr_array([[0.0, 1, 3], [1, 0, 0], [3, 0, 0]])
    M = csr_array(np.diag([2.0, 4, 0]))  # the last vertex has no mass, and stays
    expected = [[1 - 4 / 2, 1 / 2, 3 / 2], [1 / 4, 1 - 1 / 4, 0], [0, 0, 1]]
    np.testing.assert_allclose(operators.diffusion(W, M).toarray(), expected, atol=1e-15)


NOT_FINITE = csr_array([[0, np.nan, 0], [1, 0, 0], [0, 0, 0]])


@pytest.mark.parametrize(
    "call",
    [
        operators.degrees,
        lambda A: operators.diffusion(SKEW, A),
        lambda A: operators.diffusion(A, SKEW),
        lambda A: operators.boundary_as_curve(A, [[0, 1, 2]]),
    ],
)
def test_matrices_that_are_not_finite_are_refused(call):
    with pytest.raises(MeshError, match="NaN or infinite"):
        call(NOT_FINITE)
    with pytest.raises(MeshError, match="give a square sparse matrix"):
        call(csr_array((2, 3)))
