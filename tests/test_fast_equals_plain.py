"""Every compiled loop of the weights, operators, flows and solvers against its form in NumPy.

What the forms themselves are held to stands in the tests named after their modules.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fast import both
from meshes import soups
from meshfair import MeshWarning, flow, mesh, noise, operators, shapes, solve, stability, weights
from meshfair._fast import kernels


@st.composite
def ragged_soups(draw):
    """Soups with duplicate faces, either way around, and with faces that name a vertex twice."""
    V, F = draw(soups())
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    duplicates = rng.permuted(F[rng.integers(0, len(F), 5)], axis=1)
    collapsed = F[rng.integers(0, len(F), draw(st.integers(0, 2)))].copy()
    collapsed[:, rng.integers(0, 3)] = collapsed[:, rng.integers(0, 3)]
    return V, rng.permutation(np.concatenate([F, duplicates, collapsed]))


def torus(seed=0):
    """A noisy mesh of more than one block of rows."""
    V, F = shapes.torus(sections=200, sides=100)
    assert len(V) > kernels.BLOCK
    return noise.gaussian(V, F, 0.3, np.random.default_rng(seed)), F


def same_matrix(A, B, tolerance=0.0):
    """Same pattern, stored in the same order, and values up to a part of the largest."""
    np.testing.assert_array_equal(A.indptr, B.indptr)
    np.testing.assert_array_equal(A.indices, B.indices)
    np.testing.assert_allclose(A.data, B.data, rtol=tolerance, atol=tolerance * abs(B).max())


def up_to_rounding(X, iterations):
    """What rounding a product and a sum together may change: six neighbours and the mixing."""
    roundings = 2 * (6 + 2) * iterations
    return {"rtol": 0, "atol": roundings * np.finfo(float).eps / 2 * np.abs(X).max()}


@given(ragged_soups())
@pytest.mark.filterwarnings("ignore:.*degenerate")
def test_weights(soup):
    V, F = soup
    same_matrix(*both(lambda: weights.combinatorial(F, len(V))))
    same_matrix(*both(lambda: weights.distance(V, F)), 1e-15)
    for negative in ("keep", "clamp"):
        # Cotangents of soups' thin triangles grow like 1 / height, and so does their rounding.
        same_matrix(*both(lambda n=negative: weights.cotangent(V, F, negative=n)), 1e-12)


@pytest.mark.parametrize("place", [(0.0, 0, 0), (448250.0, 5411940, 212), (0.0, 0, 4.2e7)])
def test_both_see_a_t_junction_wherever_it_lies(place):
    V = np.array([[0.1, 0.2, 0], [1.2, 0.9, 0.3], [0.4, 1.3, 0.7]])
    V = np.concatenate([V, [0.3 * V[0] + 0.7 * V[1]]]) + place
    F = np.array([[0, 1, 2], [0, 3, 1]])

    def warned():
        with pytest.warns(MeshWarning, match=r"^1 of 2 faces are degenerate .* \[0, 3, 1\]"):
            return weights.cotangent(V, F)

    same_matrix(*both(warned), 1e-12)


@given(ragged_soups())
@pytest.mark.filterwarnings("ignore:.*degenerate")
def test_operators(soup):
    V, F = soup
    for W in (weights.combinatorial(F, len(V)), weights.distance(V, F)):
        same_matrix(*both(lambda W=W: operators.averaging(W)), 1e-15)
    plain, fast = both(lambda: operators.mass(V, F))
    assert abs(plain - fast).max() <= 1e-15 * plain.max()


@given(ragged_soups())
def test_face_shapes(soup):
    V, F = soup
    plain, fast = both(lambda: mesh.face_shapes(V, F))
    for a, b in zip(plain, fast, strict=True):
        np.testing.assert_allclose(a, b, rtol=0, atol=1e-13 * np.abs(V).max())


@given(ragged_soups())
def test_breadth_first_order(soup):
    V, F = soup
    for a, b in zip(*both(lambda: mesh.reorder(V, F)), strict=True):
        np.testing.assert_array_equal(a, b)


def test_more_than_one_block(rng):
    V, F = torus()
    same_matrix(*both(lambda: weights.distance(V, F)), 1e-15)
    same_matrix(*both(lambda: weights.cotangent(V, F)), 1e-13)
    W = weights.cotangent(V, F)
    same_matrix(*both(lambda: operators.averaging(W)), 1e-13)
    # One vertex in more faces than a block has rows: the rim of a wheel around it.
    k = kernels.BLOCK + 7
    rim = rng.permutation(k) + 1
    wheel = np.column_stack([np.zeros(k, dtype=int), rim, np.roll(rim, 1)])
    same_matrix(*both(lambda: weights.combinatorial(wheel, k + 1)))


def test_edges_serve_again_and_again():
    (V, F), (V_moved, _) = torus(0), torus(1)
    for build in (weights.distance, weights.cotangent):
        for X in (V, V_moved, V):
            E = mesh.Edges(F, len(V))
            same_matrix(*both(lambda build=build, X=X: build(X, F)), 1e-13)
            again, fast = both(lambda build=build, X=X, E=E: build(X, E))
            same_matrix(again, fast, 1e-13)


def flows(V, A, V_true, **options):
    return [
        flow.average(V, A, 12, **options),
        flow.average(V, A, 1, **options),
        list(flow.heat(V, A, 0.4, 2, **options))[-1][1],
        flow.snr_curve(V, V_true, A, 0.4, 4, **options),
    ]


@pytest.mark.parametrize("fixed", [None, [0, 17, 19_999]])
def test_flows(fixed):
    V, F = torus()
    V_true = shapes.torus(sections=200, sides=100)[0]
    A = operators.averaging(weights.distance(V, F))
    plain, fast = both(lambda: flows(V, A, V_true, fixed=fixed))
    for a, b in zip(plain[:3], fast[:3], strict=True):
        np.testing.assert_allclose(a, b, **up_to_rounding(V, 12))
        if fixed:
            np.testing.assert_array_equal(b[fixed], V[fixed])
    np.testing.assert_array_equal(plain[3][:, 0], fast[3][:, 0])
    np.testing.assert_allclose(plain[3], fast[3], rtol=1e-11)  # ten steps' rounding


def test_flows_whose_operator_is_rebuilt():
    V, F = torus()
    E = mesh.Edges(F, len(V))

    def build(X):
        return operators.averaging(weights.distance(X, E))

    plain, fast = both(lambda: list(flow.heat(V, build, 0.5, 2))[-1][1])
    # The weights of a step carry the rounding of the step before.
    np.testing.assert_allclose(plain, fast, rtol=0, atol=1e-12)


def test_long_flows_in_another_order_round_alike(monkeypatch, rng):
    V, F = torus()
    mixed = rng.permutation(len(V))
    V, F = V[np.argsort(mixed)], mixed[F]
    A = operators.averaging(weights.distance(V, F))
    V_true = V + 0.01
    as_given = both(lambda: flows(V, A, V_true, fixed=[5]))[1]
    from meshfair import _fast

    monkeypatch.setattr(_fast.flow, "VERTICES_WORTH_ORDERING", 0)
    ordered = both(lambda: flows(V, A, V_true, fixed=[5]))[1]
    np.testing.assert_array_equal(ordered[0], as_given[0])
    np.testing.assert_allclose(ordered[3], as_given[3], rtol=1e-11)


@pytest.mark.parametrize("negative", ["keep", "clamp"])
def test_stability(negative):
    V, F = shapes.icosphere(4)
    V = noise.gaussian(V, F, 0.5, np.random.default_rng(3))
    A = operators.averaging(weights.cotangent(V, F, negative=negative))
    plain, fast = both(lambda: stability.stable_step(A))
    assert plain == pytest.approx(fast, rel=1e-4)  # eigenvalues to 1e-3, products to 1e-7
    bound = stability.stable_step(A)
    for tau in (0.3 * bound, 0.7 * bound, bound, 1.1 * bound):
        plain, fast = both(lambda tau=tau: stability.surely_stable(A, tau))
        assert plain == fast


def test_iterative_solver(rng):
    V, F = shapes.torus(sections=40, sides=20)
    V = noise.gaussian(V, F, 0.2, rng)
    L, M = operators.laplacian(weights.cotangent(V, F)), operators.mass(V, F)
    t = 10 * mesh.mean_edge_length(V, F) ** 2
    for fixed in (None, [3, 4]):
        plain, fast = both(
            lambda f=fixed: solve.implicit_step(
                V, L, M, t, fixed=f, method="iterative", tolerance=1e-10
            )
        )
        # Residuals of 1e-10, times the condition of M + t L in the norm of M, about 100.
        np.testing.assert_allclose(plain, fast, rtol=0, atol=1e-8 * np.abs(V).max())
