import copy

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshfair import MeshError, denoising, mesh, metrics, noise, shapes

V, F = shapes.icosphere(4)
N = len(V)


def test_along_normals_is_white_and_along_the_normals(rng):
    moved = noise.along_normals(V, F, 0.3, rng) - V
    n = mesh.vertex_normals(V, F)
    height = np.einsum("ij,ij->i", moved, n)
    np.testing.assert_allclose(moved, height[:, None] * n, atol=1e-15)
    R = height / (0.3 * mesh.mean_edge_length(V, F))
    # Mean and variance of N standard normal draws, within four standard errors.
    assert abs(R.mean()) < 4 / np.sqrt(N)
    assert abs(R.var() - 1) < 4 * np.sqrt(2 / N)


def test_gaussian_has_its_size_in_each_coordinate(rng):
    moved = (noise.gaussian(V, F, 0.2, rng) - V) / (0.2 * mesh.mean_edge_length(V, F))
    assert np.all(np.abs(moved.mean(axis=0)) < 4 / np.sqrt(N))
    assert np.all(np.abs(moved.var(axis=0) - 1) < 4 * np.sqrt(2 / N))


def test_uniform_fills_its_interval(rng):
    moved = noise.uniform(V, 0.5, rng) - V
    assert moved.min() >= -1e-15  # what is left of the rounding of V + draw
    assert moved.max() < 0.5 + 1e-15
    assert np.all(np.abs(moved.mean(axis=0) - 0.25) < 4 * 0.5 / np.sqrt(12 * N))


def test_impulsive_moves_its_share(rng):
    moved = np.any(noise.impulsive(V, F, 0.5, 0.1, rng) != V, axis=1)
    assert moved.sum() == round(0.1 * N)


def test_correlated_noise_by_hand_on_one_triangle():
    # Each corner's neighbours are the two others, so that all three draws are mixed by
    # S = (2, 1, 1) / 4 and its turns; |S_i| is sqrt(6) / 4.
    triangle = np.array([[0.0, 0, 0], [1, 0, 0], [0.5, np.sqrt(0.75), 0]])  # edges of length 1
    found = noise.correlated(triangle, [[0, 1, 2]], 0.3, np.random.default_rng(8), steps=1)
    R = np.random.default_rng(8).standard_normal(3)
    np.testing.assert_allclose((found - triangle)[:, 2], 0.3 * (R + R.sum()) / np.sqrt(6))
    assert np.array_equal(found[:, :2], triangle[:, :2])


def test_correlated_noise_has_its_size_and_near_vertices_are_alike(rng):
    draws = copy.deepcopy(rng)
    moved = noise.correlated(V, F, 0.2, rng) - V
    n = mesh.vertex_normals(V, F)
    height = np.einsum("ij,ij->i", moved, n)
    np.testing.assert_allclose(moved, height[:, None] * n, atol=1e-15)
    i, j = mesh.Edges(F, N).ends.T
    A = np.zeros((N, N))
    A[i, j] = A[j, i] = 1
    S = np.linalg.matrix_power((np.eye(N) + A / A.sum(axis=1, keepdims=True)) / 2, 3)
    S /= np.linalg.norm(S, axis=1, keepdims=True)  # the same standard deviation everywhere
    R = height / (0.2 * mesh.mean_edge_length(V, F))
    np.testing.assert_allclose(R, S @ draws.standard_normal(N), atol=1e-12)
    assert np.mean(R[i] * R[j]) > 0.6 * R.var()  # near ones are alike
    one = noise.correlated(V, F, 0.2, np.random.default_rng(2), steps=0)
    np.testing.assert_allclose(one, noise.along_normals(V, F, 0.2, np.random.default_rng(2)))


def test_correlated_noise_leaves_vertices_without_faces():
    W, G = np.vstack([V, [9.0, 9, 9]]), F
    found = noise.correlated(W, G, 0.2, np.random.default_rng(1))
    assert np.array_equal(found[-1], W[-1])
    assert np.isfinite(found).all()


def test_correlated_noise_that_memory_does_not_hold_is_refused(monkeypatch):
    # A vertex has 6 neighbours, and within 4 edges 3 * 4 * 5 others: about 48.
    monkeypatch.setattr(noise, "MOST_PAIRS", 50 * N)
    noise.correlated(V, F, 0.2, np.random.default_rng(1), steps=4)
    with pytest.raises(ValueError, match=r"^steps is 5: with 2,562 vertices, .* give up to 4$"):
        noise.correlated(V, F, 0.2, np.random.default_rng(1), steps=5)
    monkeypatch.setattr(noise, "MOST_PAIRS", N**2)  # all around all
    with_all = noise.correlated(*shapes.icosphere(0), 0.2, np.random.default_rng(1), steps=10**9)
    assert np.isfinite(with_all).all()


def test_correlated_noise_of_many_steps_moves_all_alike():
    # The averages of a thousand steps are those of all vertices: one draw for all of them,
    # also beside a vertex whose own weight would be 2^-1100 by then.
    S, G = shapes.icosphere(0)
    W = np.vstack([S, [9.0, 9, 9]])
    found = noise.correlated(W, G, 0.2, np.random.default_rng(1), steps=1100)
    height = np.sum((found[:-1] - S) * mesh.vertex_normals(S, G), axis=1)
    np.testing.assert_allclose(height, height[0], rtol=1e-9)
    assert np.array_equal(found[-1], W[-1])


@given(st.floats(-20, 120), st.integers(0, 2**32 - 1))
def test_at_snr_meets_the_snr(decibels, seed):
    displacement = np.random.default_rng(seed).standard_normal(V.shape)
    noisy = noise.at_snr(V, displacement, decibels)
    # V + d rounds each coordinate to 1e-16 of its size: at 120 dB, 1e-10 of d.
    assert metrics.snr(V, noisy) == pytest.approx(decibels, abs=1e-8)


def test_snr_by_hand():
    clean = np.array([[3.0, 4, 0], [0, 0, 5]])
    noisy = clean + [[0, 0, 1.0], [0, 0, 0]]
    assert metrics.snr(clean, noisy) == pytest.approx(20)  # 1 / 10 is 20 dB
    assert metrics.snr(clean, clean) == np.inf


def test_the_same_seed_gives_the_same_noise_and_leaves_the_mesh_alone():
    before = V.copy()
    for make in (
        lambda rng: noise.along_normals(V, F, 0.1, rng),
        lambda rng: noise.gaussian(V, F, 0.1, rng),
        lambda rng: noise.uniform(V, 0.1, rng),
        lambda rng: noise.impulsive(V, F, 0.1, 0.3, rng),
        lambda rng: noise.correlated(V, F, 0.1, rng),
    ):
        a, b = (make(np.random.default_rng(5)) for _ in range(2))
        assert np.array_equal(a, b)
        assert not np.array_equal(a, make(np.random.default_rng(6)))
    assert np.array_equal(V, before)


def test_size_follows_the_scale_of_the_mesh():
    a = noise.along_normals(V, F, 0.1, np.random.default_rng(1))
    b = noise.along_normals(1000 * V, F, 0.1, np.random.default_rng(1))
    np.testing.assert_allclose(b, 1000 * a, atol=1e-12 * 1000)


@pytest.mark.parametrize(
    ("model", "directly"),
    [
        ("normals", lambda rng: noise.along_normals(V, F, 0.2, rng)),
        ("gaussian", lambda rng: noise.gaussian(V, F, 0.2, rng)),
        ("uniform", lambda rng: noise.uniform(V, 0.2, rng)),
        ("correlated", lambda rng: noise.correlated(V, F, 0.2, rng)),
    ],
)
def test_add_takes_a_model_by_name_and_a_size_or_an_snr(model, directly):
    expected = directly(np.random.default_rng(5))
    assert np.array_equal(noise.add(V, F, model, np.random.default_rng(5), size=0.2), expected)
    louder = noise.add(V, F, model, np.random.default_rng(5), decibels=20)
    assert metrics.snr(V, louder) == pytest.approx(20)
    moved, direction = louder - V, expected - V  # the same draw, on another scale
    scale = np.sum(moved * direction) / np.sum(direction**2)
    np.testing.assert_allclose(moved, scale * direction, atol=1e-14)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda r: noise.gaussian(V, F, -1, r), ValueError, "sigma is -1"),
        (lambda r: noise.uniform(V, np.nan, r), ValueError, "amplitude is nan"),
        (lambda r: noise.impulsive(V, F, 0.1, 1.5, r), ValueError, "fraction is 1.5"),
        (lambda r: noise.gaussian(V, F, 0.1, 7), TypeError, "rng is 7"),
        (lambda r: noise.correlated(V, F, 0.1, r, steps=-1), ValueError, "steps is -1"),
        (
            lambda r: noise.add(V, F, "laser", r, size=1),
            ValueError,
            "give one of normals, gaussian",
        ),
        (lambda r: noise.add(V, F, "normals", r), ValueError, "either a size or its decibels"),
        (
            lambda r: noise.add(V, F, "normals", r, size=0.1, decibels=20),
            ValueError,
            "either a size or its decibels",
        ),
        (lambda r: noise.at_snr(V, 0 * V, 20), MeshError, "zero everywhere"),
        (lambda r: noise.at_snr(V, V[:5], 20), MeshError, "has 2562 vertices but"),
        (lambda r: metrics.snr(0 * V, V), MeshError, "at the origin"),
    ],
)
def test_bad_input(call, error, message, rng):
    with pytest.raises(error, match=message):
        call(rng)


def test_the_estimate_by_differences_on_built_in_shapes():
    # The median of |N(0, 1)| among n values is known to 1.17 / sqrt(n); with neighbours'
    # values correlated, four such errors and the curvature left by K stay below 12 %.
    for (V, F), size in (
        (shapes.torus(sections=80, sides=32), 0.1),
        (shapes.torus(sections=80, sides=32), 0.3),
        (shapes.knot(), 0.2),
        (shapes.box(segments=20), 0.2),
    ):
        noisy = noise.along_normals(V, F, size, np.random.default_rng(5))
        true = size * mesh.mean_edge_length(V, F) / mesh.mean_edge_length(noisy, F)
        assert denoising.estimate_noise(noisy, F, by="differences") == pytest.approx(true, rel=0.12)


def test_the_estimates_know_no_scale_and_no_place():
    V, F = shapes.torus(sections=30, sides=12)
    noisy = noise.along_normals(V, F, 0.2, np.random.default_rng(5))
    for by in ("lengths", "differences"):
        found = denoising.estimate_noise(noisy, F, by=by)
        assert denoising.estimate_noise(50 * noisy + 3, F, by=by) == pytest.approx(found, rel=1e-9)


def test_an_unknown_estimate_is_named():
    with pytest.raises(ValueError, match="by is 'eye'; give one of lengths, differences"):
        denoising.estimate_noise(*shapes.box(segments=2), by="eye")


def test_the_estimate_of_nothing_is_zero():
    V = np.array([[0.0, 0, 0], [0, 0, 0], [0, 0, 0]])
    assert denoising.estimate_noise(V, np.array([[0, 1, 2]]), by="differences") == 0


@pytest.mark.parametrize("seed", [3, 4])
def test_the_formulas_with_the_same_draws(seed):
    def draws():
        return np.random.default_rng(seed)

    eps = 0.2 * mesh.mean_edge_length(V, F)
    n = mesh.vertex_normals(V, F)
    expected = {
        "normals": V + eps * draws().standard_normal((N, 1)) * n,
        "gaussian": V + eps * draws().standard_normal((N, 3)),
        "uniform": V + 0.2 * draws().random((N, 3)),
    }
    for model, positions in expected.items():
        found = noise.add(V.tolist(), F.tolist(), model, draws(), size=0.2)
        np.testing.assert_allclose(found, positions, atol=1e-15)
    rng = draws()
    moved = rng.permutation(N)[: round(0.3 * N)]
    expected = V.copy()
    expected[moved] = noise.along_normals(V, F, 0.2, rng)[moved]
    assert np.array_equal(noise.impulsive(V, F, 0.2, 0.3, draws()), expected)


def test_at_snr_keeps_the_direction():
    displacement = np.random.default_rng(0).standard_normal(V.shape)
    noisy = noise.at_snr(V.tolist(), displacement.tolist(), 10)
    scale = (noisy - V) / displacement
    assert scale.min() > 0
    np.testing.assert_allclose(scale, scale.mean(), rtol=1e-9)


@pytest.mark.parametrize(
    "make",
    [
        lambda sigma, rng: noise.along_normals(V, F, sigma, rng),
        lambda sigma, rng: noise.gaussian(V, F, sigma, rng),
        lambda sigma, rng: noise.uniform(V, sigma, rng),
        lambda sigma, rng: noise.impulsive(V, F, sigma, 0.5, rng),
        lambda sigma, rng: noise.correlated(V, F, sigma, rng),
    ],
)
def test_every_model_checks_its_size_and_its_generator(make, rng):
    for bad in (-0.1, np.nan, np.inf, "x", None):
        with pytest.raises(ValueError, match=r"is .*; give a number of at least 0"):
            make(bad, rng)
    with pytest.raises(TypeError, match="default_rng"):
        make(0.1, np.random.RandomState(1))
    assert np.array_equal(make(0, rng), V)


def test_uniform_takes_positions_alone():
    found = noise.uniform(V.tolist(), 0.2, np.random.default_rng(3))
    np.testing.assert_allclose(found, V + 0.2 * np.random.default_rng(3).random(V.shape))
    with pytest.raises(MeshError, match="V has no vertices"):
        noise.uniform(np.zeros((0, 3)), 0.2, np.random.default_rng(3))


@pytest.mark.parametrize("decibels", [np.nan, np.inf, "loud", -20_000, -301, 301])
def test_an_snr_that_no_mesh_can_have_is_refused(decibels):
    with pytest.raises(ValueError, match="decibels is"):
        noise.at_snr(V, V + 1, decibels)
