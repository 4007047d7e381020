from unittest import mock

import numpy as np
import pytest
from hypothesis import given, settings
from scipy.sparse import csr_array, diags_array, eye_array

from meshes import CLOSED, fan, grid, soups
from meshfair import MeshError, _fast, mesh, noise, operators, shapes, solve, weights
from meshfair._fast import multigrid

METHODS = ("direct", "iterative", "auto")


def system(V, F, steps=10.0):
    """Laplacian, mass and a time step of so many squared mean edges."""
    L = operators.laplacian(weights.cotangent(V, F))
    return L, operators.mass(V, F), steps * mesh.mean_edge_length(V, F) ** 2


@pytest.fixture(autouse=True, params=[False, True], ids=["plain", "compiled"], scope="module")
def compiled(request):
    """Everything is tested in both forms."""
    with mock.patch.object(_fast, "wanted", return_value=request.param):
        yield request.param


@pytest.fixture(scope="module")
def bumpy():
    """Large enough for two levels of multigrid, with negative weights."""
    V, F = shapes.icosphere(4)
    V = noise.gaussian(V, F, 0.4, np.random.default_rng(0))
    assert weights.cotangent(V, F).data.min() < 0
    return V, *system(V, F)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("columns", [(), (1,), (3,), (5,)])
def test_against_a_dense_solver(bumpy, method, columns, rng):
    _, L, M, t = bumpy
    A = csr_array(M + t * L)
    B = rng.standard_normal((A.shape[0], *columns))
    before = B.copy()
    X = solve.spd(A, B, method=method, tolerance=1e-12)
    assert X.shape == B.shape
    np.testing.assert_allclose(X, np.linalg.solve(A.toarray(), B), atol=1e-9 * np.abs(X).max())
    np.testing.assert_array_equal(B, before)


@pytest.mark.parametrize("steps", [0, 0.1, 10, 1e4])
@pytest.mark.parametrize("method", ["direct", "iterative"])
def test_the_residual_is_as_small_as_asked_for(steps, method):
    V, F = shapes.torus(sections=90, sides=60)
    L, M, t = system(V, F, steps)
    X = solve.implicit_step(V, L, M, t, method=method, tolerance=1e-10)
    residual = M @ X + t * (L @ X) - M @ V
    assert np.all(np.linalg.norm(residual, axis=0) <= 1e-10 * np.linalg.norm(M @ V, axis=0) + 1e-16)


def test_a_sphere_shrinks_to_the_radius_that_is_known():
    # L V = -M H with the curvature vector H, |H| = 2 / r: (1 + 2 t) r+ = r for the unit sphere.
    errors = []
    for subdivisions in (2, 3, 4):
        V, F = shapes.icosphere(subdivisions)
        L, M, _ = system(V, F)
        radius = np.linalg.norm(solve.implicit_step(V, L, M, 0.05), axis=1).mean()
        errors.append(abs(radius - 1 / 1.1))
    assert np.all(np.divide(errors[:-1], errors[1:]) > 3.5)  # second order, or better
    assert errors[-1] < 1e-4


def test_a_long_step_ends_at_the_centre_of_mass(rng):
    V, F = shapes.knot()
    V = noise.gaussian(V, F, 0.2, rng)
    L, M, t = system(V, F, 1e8)
    m = M.diagonal()
    centre = m @ V / m.sum()
    X = solve.implicit_step(V, L, M, t, method="direct", tolerance=1e-6)
    np.testing.assert_allclose(X, np.tile(centre, (len(V), 1)), atol=1e-3 * np.ptp(V))


@settings(max_examples=30)
@given(soups())
def test_any_mesh(soup):
    V, F = soup
    L, M, t = system(V, F, 1.0)
    for method in ("direct", "iterative"):
        X = solve.implicit_step(V, L, M, t, method=method)
        lonely = M.diagonal() == 0
        np.testing.assert_array_equal(X[lonely], V[lonely])
        residual = (M @ X + t * (L @ X) - M @ V)[~lonely]
        assert np.abs(residual).max() <= 1e-7 * M.diagonal().max() * np.abs(V).max()


@pytest.mark.parametrize("method", ["direct", "iterative"])
def test_fixed_vertices_stay_and_the_others_solve_their_equations(bumpy, method):
    V, L, M, t = bumpy
    fixed = [3, 77, 500]
    X = solve.implicit_step(V, L, M, t, fixed=fixed, method=method, tolerance=1e-12)
    np.testing.assert_array_equal(X[fixed], V[fixed])
    free = np.delete(np.arange(len(V)), fixed)
    residual = (M @ X + t * (L @ X) - M @ V)[free]
    assert np.abs(residual).max() <= 1e-10 * np.abs(M @ V).max()
    everywhere = solve.implicit_step(V, L, M, t, fixed=np.ones(len(V), dtype=bool))
    np.testing.assert_array_equal(everywhere, V)


def test_a_flat_square_with_a_fixed_rim_is_a_fixed_point(rng):
    V, F = grid(8, irregular=rng)
    rim = ~np.all((V[:, :2] > 0) & (V[:, :2] < 8), axis=1)
    L, M, t = system(V, F, 100)
    np.testing.assert_allclose(solve.implicit_step(V, L, M, t, fixed=rim), V, atol=1e-7)


def test_where_the_mesh_lies_does_not_matter(bumpy):
    V, L, M, t = bumpy
    here = solve.implicit_step(V, L, M, t, method="iterative")
    there = solve.implicit_step(V + 1e4, L, M, t, method="iterative")
    np.testing.assert_allclose(there - 1e4, here, atol=1e-7)


@pytest.mark.parametrize("scale", [1e-30, 1e30])
def test_units_do_not_matter(bumpy, scale):
    V, L, M, t = bumpy
    X = solve.implicit_step(scale * V, L, scale**2 * M, scale**2 * t, method="iterative")
    expected = solve.implicit_step(V, L, M, t, method="iterative")
    np.testing.assert_allclose(X / scale, expected, atol=1e-7)


def test_a_right_hand_side_of_zero(bumpy, rng):
    V, L, M, t = bumpy
    B = M @ V
    B[:, 1] = 0
    guess = rng.standard_normal(V.shape)
    X = solve.spd(M + t * L, B, guess=guess, method="iterative")
    np.testing.assert_array_equal(X[:, 1], 0)
    assert np.abs(X[:, 0]).max() > 0.1


def test_multigrid_is_symmetric_and_positive(bumpy, rng):
    _, L, M, t = bumpy
    cycles = multigrid.Multigrid(csr_array(M + t * L))
    assert len(cycles.levels) >= 1
    R = rng.standard_normal((2, L.shape[0], 3)).astype(np.float32)
    Z = [cycles.cycle(r)[0].copy() for r in R]
    np.testing.assert_allclose(np.sum(R[0] * Z[1], axis=0), np.sum(R[1] * Z[0], axis=0), rtol=1e-3)
    assert np.all(cycles.cycle(R[0])[1] > 0)


def test_multigrid_needs_few_steps_on_every_level(monkeypatch, compiled):
    if not compiled:
        pytest.skip("the form in SciPy has no multigrid")
    steps = []
    cycle = multigrid.Multigrid.cycle
    monkeypatch.setattr(
        multigrid.Multigrid, "cycle", lambda self, R: steps.append(1) or cycle(self, R)
    )
    V, F = shapes.torus(sections=200, sides=100)
    for length in (10, 1000):
        steps.clear()
        solve.implicit_step(V, *system(V, F, length), method="iterative")
        assert 5 <= len(steps) <= 60


def test_many_pieces_that_cannot_be_joined():
    V, F = fan(1)
    n = 400
    F = np.concatenate([F + 3 * k for k in range(n)])
    V = np.concatenate([V + [2 * k, 0, 0] for k in range(n)])
    L, M, t = system(V, F)
    one, other = (solve.implicit_step(V, L, M, t, method=m) for m in ("iterative", "direct"))
    np.testing.assert_allclose(one, other, atol=1e-6 * n)


@pytest.mark.parametrize("method", ["direct", "iterative"])
@pytest.mark.parametrize("sign", [0, -1])
def test_what_cannot_be_solved_says_so(bumpy, method, sign, rng):
    V, L, _, t = bumpy
    singular = csr_array(t * L)  # constants are lost
    A = singular if sign == 0 else csr_array(t * L - 5 * diags_array(L.diagonal()))
    if sign == -1 and method == "direct":
        solve.spd(A, V, method=method)  # indefinite, but it has a solution
        return
    with pytest.raises(solve.SolveError, match=r"positive definite|singular"):
        solve.spd(A, rng.standard_normal(V.shape) + 1, method=method)


def test_a_step_that_fails_is_named(bumpy):
    V, L, M, t = bumpy
    with pytest.raises(solve.SolveError, match=r"implicit step of t = 0\.\d+: A is not positive"):
        solve.implicit_step(V, csr_array(-10 * L), M, t, method="iterative")


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda A, B: solve.spd(A, B[:5]), MeshError, r"B \(5, 3\)"),
        (lambda A, B: solve.spd(A[:5], B[:5]), MeshError, "A has shape"),
        (lambda A, B: solve.spd(A, B * np.nan), MeshError, "B holds NaN"),
        (lambda A, B: solve.spd(A * np.inf, B), MeshError, "A holds NaN or infinite"),
        (lambda A, B: solve.spd(A, B, guess=B[:, :2]), MeshError, "guess has shape"),
        (lambda A, B: solve.spd(A, B, method="lucky"), ValueError, "method is 'lucky'"),
        (lambda A, B: solve.spd(A, B, tolerance=0), ValueError, "tolerance is 0"),
        (lambda A, B: solve.spd(A, B, fixed=[0]), ValueError, "fixed needs guess"),
        (lambda A, B: solve.spd(A, B, fixed=[99], guess=B), MeshError, "vertex index 99"),
        (lambda A, B: solve.implicit_step(B, A, A, -1), ValueError, "t is -1"),
        (lambda A, B: solve.implicit_step(B, A[:5], A, 1), MeshError, "L has shape"),
    ],
)
def test_bad_input_is_named(call, error, message):
    with pytest.raises(error, match=message):
        call(csr_array(eye_array(9)), np.ones((9, 3)))


@pytest.mark.parametrize("name", CLOSED)
def test_methods_agree(name):
    V, F = CLOSED[name]()
    L, M, t = system(V, F)
    X = [solve.implicit_step(V, L, M, t, method=method) for method in METHODS]
    np.testing.assert_allclose(X[0], X[1], atol=1e-6 * np.ptp(V))
    np.testing.assert_allclose(X[0], X[2], atol=1e-6 * np.ptp(V))
