import itertools
import warnings

import numpy as np
import pytest
from scipy.sparse import csr_array

from meshes import fan
from meshfair import (
    MeshError,
    StabilityWarning,
    _fast,
    flow,
    metrics,
    noise,
    operators,
    shapes,
    stability,
    weights,
)

SECTIONS, SIDES = 20, 10


def torus_and_average():
    V, F = shapes.torus(sections=SECTIONS, sides=SIDES)
    return V, F, operators.averaging(weights.combinatorial(F, len(V)))


@pytest.mark.parametrize("waves", [(0, 0), (1, 0), (0, 1), (3, 2), (10, 5)])
def test_waves_on_a_torus_decay_by_their_known_factor(waves):
    # On the regular torus vertex (i, j) has the neighbours (+-1, 0), (0, +-1), +-(1, 1), so a
    # plane wave is an eigenvector with eigenvalue (cos p + cos q + cos(p + q)) / 3.
    _, _, A = torus_and_average()
    p, q = 2 * np.pi * waves[0] / SECTIONS, 2 * np.pi * waves[1] / SIDES
    i, j = np.divmod(np.arange(SECTIONS * SIDES), SIDES)
    wave = np.column_stack([np.cos(p * i + q * j), np.sin(p * i + q * j), 0 * i])
    eigenvalue = (np.cos(p) + np.cos(q) + np.cos(p + q)) / 3
    np.testing.assert_allclose(flow.average(wave, A, 5), eigenvalue**5 * wave, atol=1e-14)
    ((_, last),) = itertools.islice(flow.heat(wave, A, 0.3, 1.5), 5, None)
    np.testing.assert_allclose(last, (1 - 0.3 * (1 - eigenvalue)) ** 5 * wave, atol=1e-14)


def test_a_step_of_one_is_averaging(rng):
    V, F, A = torus_and_average()
    V = noise.gaussian(V, F, 0.3, rng)
    times, states = zip(*flow.heat(V, A, 1.0, 4), strict=True)
    assert times == (0, 1, 2, 3, 4)
    for s, state in enumerate(states):
        np.testing.assert_allclose(state, flow.average(V, A, s), atol=1e-14)
        np.testing.assert_allclose(state, np.linalg.matrix_power(A.toarray(), s) @ V, atol=1e-13)


def test_heat_converges_to_the_matrix_exponential_with_first_order(rng):
    from scipy.linalg import expm

    V, _, A = torus_and_average()
    exact = expm(-(np.eye(len(V)) - A.toarray())) @ V
    errors = []
    for tau in (0.1, 0.05, 0.025):
        *_, (time, state) = flow.heat(V, A, tau, 1.0)
        assert time == 1.0
        errors.append(np.abs(state - exact).max())
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 2, rtol=0.1)


def test_times_are_whole_steps():
    V, _, A = torus_and_average()
    times = [t for t, _ in flow.heat(V, A, 0.2, 0.7)]
    assert times == [0, 0.2, 0.4, 0.6]
    assert [t for t, _ in flow.heat(V, A, 0.1, 0.3)][-1] == 0.3  # 0.3 / 0.1 is below 3


def test_a_sphere_shrinks_by_the_law_of_mean_curvature_flow():
    # dr/dt = -2 / r, so r^2 = r0^2 - 4 t; weights and mass follow the surface.
    errors = []
    for subdivisions, tau in ((1, 0.016), (2, 0.004), (3, 0.001)):
        V, F = shapes.icosphere(subdivisions)

        def build(V, F=F):
            return operators.diffusion(weights.cotangent(V, F), operators.mass(V, F))

        *_, (time, last) = flow.heat(V, build, tau, 0.096)
        radius = np.linalg.norm(last, axis=1).mean()
        errors.append(abs(radius**2 - (1 - 4 * time)))
    # tau goes down with the square of the edge length, so all is of second order.
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 4, rtol=0.25)


def test_rebuilding_follows_the_surface(rng):
    V, F = shapes.icosphere(2)
    V = noise.gaussian(V, F, 0.2, rng)

    def build(V):
        return operators.averaging(weights.distance(V, F))

    by_hand = V
    for _ in range(3):
        by_hand = 0.5 * by_hand + 0.5 * (build(by_hand) @ by_hand)
    *_, (_, rebuilt) = flow.heat(V, build, 0.5, 1.5)
    *_, (_, once) = flow.heat(V, build(V), 0.5, 1.5)
    np.testing.assert_allclose(rebuilt, by_hand, atol=1e-14)
    assert np.abs(rebuilt - once).max() > 1e-6


def test_best_stopping_is_the_best_of_all(rng):
    V, F = shapes.knot()
    V_noisy = noise.along_normals(V, F, 0.3, rng)
    A = operators.averaging(weights.combinatorial(F, len(V)))
    all_snr = {t: metrics.snr(V, state) for t, state in flow.heat(V_noisy, A, 0.2, 3)}
    best = flow.best_stopping(V_noisy, V, A, 0.2, 3)
    assert best.time == max(all_snr, key=all_snr.get)
    assert best.snr == pytest.approx(all_snr[best.time], rel=1e-12)
    assert best.gain == pytest.approx(100 * (best.snr / all_snr[0.0] - 1), rel=1e-9)
    curve = flow.snr_curve(V_noisy, V, A, 0.2, 3)
    np.testing.assert_allclose(curve, list(all_snr.items()), rtol=1e-12)


def test_a_clean_mesh_is_best_left_alone():
    V, _, A = torus_and_average()
    assert flow.best_stopping(V, V, A, 0.2, 1) == (0.0, np.inf, 0.0)


def test_averaging_keeps_the_centre_on_an_even_mesh(rng):
    V, F, A = torus_and_average()  # every vertex has six neighbours: W~ is symmetric
    V = noise.gaussian(V, F, 0.3, rng)
    np.testing.assert_allclose(flow.average(V, A, 50).mean(axis=0), V.mean(axis=0), atol=1e-13)


def test_the_input_is_left_alone_and_states_are_new_arrays():
    V, _, A = torus_and_average()
    before = V.copy()
    states = [state for _, state in flow.heat(V, A, 0.5, 2)]
    states[0][:] = 7
    flow.average(V, A, 0)[:] = 7
    assert np.array_equal(V, before)
    assert len({id(state) for state in states}) == len(states)


def negative_weights():
    """A mesh on which averaging with cotangent weights is unstable."""
    V, F = shapes.icosphere(2)
    V = noise.gaussian(V, F, 0.6, np.random.default_rng(0))
    return V, operators.averaging(weights.cotangent(V, F))


@pytest.mark.parametrize("tau", [1.5, -0.1])
def test_steps_outside_the_interval_are_warned_of(tau):
    V, _, A = torus_and_average()
    p, q = np.meshgrid(*(2 * np.pi * np.arange(k) / k for k in (SECTIONS, SIDES)))
    bound = 2 / (1 - ((np.cos(p) + np.cos(q) + np.cos(p + q)) / 3).min())
    with pytest.warns(StabilityWarning, match=rf"outside \(0, 1\].*this mesh is tau = {bound:.3g}"):
        list(flow.heat(V, A, tau, 0.1))


def test_unstable_cotangent_steps_are_warned_of_with_the_bound():
    V, A = negative_weights()
    bound = stability.stable_step(A)
    assert 2 / 3 <= bound < 1
    for call in (
        lambda: list(flow.heat(V, A, 1.0, 1)),
        lambda: flow.snr_curve(V, V + 1, A, 1.0, 1),
        lambda: flow.best_stopping(V, V + 1, A, 1.0, 1),
    ):
        with pytest.warns(StabilityWarning, match=rf"negative weights.*tau = {bound:.3g}"):
            call()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        list(flow.heat(V, A, 2 / 3, 1))


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda V, A: flow.heat(V, A, 0, 1), ValueError, "tau is 0"),
        (lambda V, A: flow.heat(V, A, np.nan, 1), ValueError, "tau is nan"),
        (lambda V, A: flow.heat(V, A, 0.2, -1), ValueError, "time is -1"),
        (lambda V, A: flow.heat(V, A, 0.2, np.inf), ValueError, "time is inf"),
        (lambda V, A: flow.heat(V[:5], A, 0.2, 1), MeshError, "V has 5 vertices"),
        (lambda V, A: flow.average(V, A, -1), ValueError, "iterations is -1"),
        (lambda V, A: flow.average(V, A, 1.5), ValueError, "iterations is 1.5"),
        (lambda V, A: flow.best_stopping(V, V[:5], A, 0.2, 1), MeshError, "vertices"),
    ],
)
def test_bad_input_is_named_at_the_call(call, error, message):
    V, _, A = torus_and_average()
    with pytest.raises(error, match=message):
        call(V, A)


def test_a_non_manifold_mesh_flows_to_finite_places(rng):
    V, F = fan(5)
    V = np.concatenate([V, [[9.0, 9, 9]]])
    for W in (weights.combinatorial(F, len(V)), weights.distance(V, F), weights.cotangent(V, F)):
        *_, (_, last) = flow.heat(V, operators.averaging(W), 0.5, 10)
        assert np.isfinite(last).all()
        np.testing.assert_array_equal(last[-1], [9, 9, 9])


@pytest.mark.parametrize("as_mask", [False, True])
def test_fixed_vertices_stay(as_mask, rng):
    V, F, A = torus_and_average()
    V = noise.gaussian(V, F, 0.3, rng)
    fixed = np.array([0, 17, len(V) - 1])
    mask = np.isin(np.arange(len(V)), fixed)
    chosen = mask if as_mask else fixed
    by_hand = V
    for _ in range(10):
        by_hand = np.where(mask[:, None], V, 0.6 * by_hand + 0.4 * (A @ by_hand))
    states = [X for _, X in flow.heat(V, A, 0.4, 4, fixed=chosen)]
    np.testing.assert_allclose(states[-1], by_hand, atol=1e-13)
    np.testing.assert_array_equal(states[-1][fixed], V[fixed])
    curve = flow.snr_curve(V, V + 1, A, 0.4, 4, fixed=chosen)
    np.testing.assert_allclose(curve[:, 1], [metrics.snr(V + 1, X) for X in states], rtol=1e-12)
    once = flow.average(V, A, 1, fixed=chosen)
    np.testing.assert_allclose(once, np.where(mask[:, None], V, A @ V), atol=1e-14)
    nothing_moves = flow.best_stopping(V, V + 1, A, 0.4, 2, fixed=np.ones(len(V), dtype=bool))
    assert nothing_moves == (0.0, pytest.approx(metrics.snr(V + 1, V), rel=1e-12), 0.0)


@pytest.mark.parametrize(
    ("fixed", "message"),
    [
        (np.zeros(7, dtype=bool), "a mask needs"),
        ([0, 200], "vertex index 200, but there are 200"),
        ([-1], "vertex index -1"),
        ([0.5], "boolean mask or vertex indices"),
    ],
)
def test_fixed_vertices_that_are_none(fixed, message):
    V, _, A = torus_and_average()
    for call in (
        lambda: flow.average(V, A, 1, fixed=fixed),
        lambda: flow.heat(V, A, 0.5, 1, fixed=fixed),
        lambda: flow.snr_curve(V, V, A, 0.5, 1, fixed=fixed),
    ):
        with pytest.raises(MeshError, match=message):
            call()


@pytest.mark.filterwarnings("ignore::meshfair.StabilityWarning")
@pytest.mark.parametrize("compiled", [False, True])
def test_a_flow_that_explodes_is_stopped(compiled, rng, monkeypatch):
    V, F, A = torus_and_average()
    V = noise.gaussian(V, F, 0.3, rng)
    monkeypatch.setattr(_fast, "wanted", lambda *rows: compiled)
    for call in (
        lambda: flow.snr_curve(V, V + 1, A, 1e3, 1e6),
        lambda: list(flow.heat(V, A, 1e3, 1e6)),
    ):
        with pytest.raises(MeshError, match=r"outgrown all numbers at time .* take a smaller"):
            call()


@pytest.mark.parametrize("iterations", [0, 1, 2, 3])
@pytest.mark.parametrize("compiled", [False, True])
def test_averaging_gives_a_new_array(iterations, compiled, monkeypatch):
    monkeypatch.setattr(_fast, "wanted", lambda *rows: compiled)
    V, _, A = torus_and_average()
    before = V.copy()
    X = flow.average(V, A, iterations)
    X[:] = 7
    np.testing.assert_array_equal(V, before)


def test_an_operator_with_columns_that_do_not_exist_is_refused():
    V, _, A = torus_and_average()
    A.indices[3] = 10**6
    with pytest.raises(MeshError, match="a column that it does not have"):
        flow.average(V, A, 1)


@pytest.mark.parametrize("compiled", [False, True])
def test_lists_are_positions_and_other_things_are_not(compiled, monkeypatch):
    monkeypatch.setattr(_fast, "wanted", lambda *rows: compiled)
    V, _, A = torus_and_average()
    np.testing.assert_array_equal(flow.average(V.tolist(), A, 2), flow.average(V, A, 2))
    np.testing.assert_array_equal(
        flow.snr_curve(V.tolist(), (V + 1).tolist(), A, 0.5, 1),
        flow.snr_curve(V, V + 1, A, 0.5, 1),
    )
    bad = V.copy()
    bad[7, 1] = np.nan
    for call in (
        lambda X: flow.average(X, A, 1),
        lambda X: flow.heat(X, A, 0.5, 1),
        lambda X: flow.best_stopping(X, V, A, 0.5, 1),
        lambda X: flow.best_stopping(V, X, A, 0.5, 1),
        lambda X: flow.average(X, A, 0),
        lambda X: flow.average(X, A, 1, fixed=[0]),
    ):
        with pytest.raises(MeshError, match="vertex 7 has y = nan"):
            call(bad)


def test_an_operator_is_built_before_each_step():
    V, _, A = torus_and_average()
    seen = []

    def build(X):
        seen.append(X.copy())
        return A

    states = [X for _, X in flow.heat(V, build, 0.5, 2)]
    assert len(states) == 5
    assert len(seen) == 4  # once a step, from the positions before it
    for X, state in zip(seen, states, strict=False):
        np.testing.assert_array_equal(X, state)


def test_an_operator_that_becomes_another_ones_is_refused():
    V, _, A = torus_and_average()
    operators_in_turn = iter([A, csr_array(np.eye(5))])
    states = flow.heat(V, lambda X: next(operators_in_turn), 0.5, 2)
    with pytest.raises(MeshError, match=r"the operator has shape \(5, 5\), but V has 200"):
        list(states)


@pytest.mark.filterwarnings("ignore::meshfair.StabilityWarning")
def test_a_backward_flow_has_as_many_steps_and_undoes_the_forward_one():
    V, _, A = torus_and_average()
    times, states = zip(*flow.heat(V, A, -0.25, 1), strict=True)
    assert times == (0, -0.25, -0.5, -0.75, -1)
    np.testing.assert_allclose(states[1], 1.25 * V - 0.25 * (A @ V), atol=1e-14)


@pytest.mark.parametrize("tau", [1e-10, -1e-10, 1e-160, 5e-324])
def test_more_steps_than_anyone_waits_for_are_refused(tau):
    V, _, A = torus_and_average()
    for call in (flow.heat, lambda *args: flow.snr_curve(V, *args)):
        with pytest.raises(ValueError, match=rf"^time is 1, which .* of tau = {tau:g}, more than"):
            call(V, A, tau, 1)


@pytest.mark.filterwarnings("ignore::meshfair.StabilityWarning")
def test_one_vertex_that_outgrows_all_numbers_is_enough():
    V = np.eye(3)
    for factor in (1e80, -1e80):
        A = csr_array(np.diag([1.0, 1, factor]))
        with pytest.raises(MeshError, match="outgrown all numbers at time 1"):
            list(flow.heat(V, A, 1, 1))


def test_the_gain_is_relative_to_the_size_of_a_negative_snr():
    # One mesh of one vertex at distance 1: noise of 10 is -20 dB, of 5 it is -14 dB.
    V_true, V = np.array([[1.0, 0, 0]]), np.array([[11.0, 0, 0]])
    best = flow.best_stopping(V, V_true, csr_array([[6 / 11]]), 1, 1)
    assert best.time == 1
    assert best.snr == pytest.approx(-20 * np.log10(5))
    assert best.gain == pytest.approx(100 * np.log10(2))
