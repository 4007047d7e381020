"""The compiled loops against their plain forms, on every kind of mesh and in every surrounding."""

import subprocess
import sys
import threading

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import block_diag, csr_array

import plain
from meshes import fan, soups
from meshfair import (
    MeshError,
    StabilityWarning,
    flow,
    kernels,
    metrics,
    noise,
    operators,
    ordering,
    shapes,
    weights,
)
from meshfair import pattern as pattern_module


@st.composite
def ragged_soups(draw):
    """Soups with repeated faces, either way around, and with faces that are collapsed."""
    V, F = draw(soups())
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    repeated = rng.permuted(F[rng.integers(0, len(F), 5)], axis=1)
    collapsed = F[rng.integers(0, len(F), draw(st.integers(0, 2)))].copy()
    collapsed[:, rng.integers(0, 3)] = collapsed[:, rng.integers(0, 3)]
    return V, rng.permutation(np.concatenate([F, repeated, collapsed]))


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


@given(ragged_soups())
@pytest.mark.filterwarnings("ignore:.*degenerate")
def test_weights_are_the_plain_forms(soup):
    V, F = soup
    same_matrix(weights.combinatorial(F, len(V)), plain.combinatorial(F, len(V)))
    same_matrix(weights.distance(V, F), plain.distance(V, F), 1e-15)
    W = weights.cotangent(V, F)
    same_matrix(W, plain.cotangent(V, F), 1e-12)
    assert (W != W.T).nnz == 0
    clamped = weights.cotangent(V, F, negative="clamp")
    np.testing.assert_array_equal(clamped.data, np.maximum(W.data, 0))


@given(ragged_soups())
@pytest.mark.filterwarnings("ignore:.*degenerate")
def test_operators_are_the_plain_forms(soup):
    V, F = soup
    for W in (weights.combinatorial(F, len(V)), weights.distance(V, F)):
        assert abs(operators.averaging(W) - plain.averaging(W)).max() <= 1e-15
    M = operators.mass(V, F)
    assert abs(M - plain.mass(V, F)).max() <= 1e-15 * M.max()
    W = weights.cotangent(V, F)
    A = plain.diffusion(W, M)
    assert abs(operators.diffusion(W, M) - A).max() <= 1e-12 * abs(A).max()


def test_more_than_one_block(rng):
    V, F = torus()
    same_matrix(weights.distance(V, F), plain.distance(V, F), 1e-15)
    W = weights.cotangent(V, F)
    same_matrix(W, plain.cotangent(V, F), 1e-13)
    same_matrix(operators.averaging(W), plain.averaging(W), 1e-13)
    # One vertex in more faces than a block has rows: the rim of a wheel around it.
    k = kernels.BLOCK + 7
    rim = rng.permutation(k) + 1
    wheel = np.column_stack([np.zeros(k, dtype=int), rim, np.roll(rim, 1)])
    same_matrix(weights.combinatorial(wheel, k + 1), plain.combinatorial(wheel, k + 1))


@given(ragged_soups())
def test_a_pattern_lists_each_edge_with_the_vertices_opposite(soup):
    V, F = soup
    P = weights.Pattern(F, len(V))
    i, j = P.indices[P.lower], P.indices[P.upper]
    np.testing.assert_array_equal(np.repeat(np.arange(len(V)), np.diff(P.start)), i)
    listed = np.column_stack([np.repeat(np.stack([i, j]), np.diff(P.first), axis=1).T, P.opposite])
    corners = {tuple(sorted(face)) for face in F.tolist()}
    expected = {t for a, b, c in corners for t in ((a, b, c), (a, c, b), (b, c, a))}
    assert listed.tolist() == sorted([i, j, k] for i, j, k in expected if i != j)


def test_a_pattern_is_filled_again_and_again():
    (V, F), (V_moved, _) = torus(0), torus(1)
    P = weights.Pattern(F, len(V))
    for X in (V, V_moved, V):
        same_matrix(weights.cotangent(X, P), weights.cotangent(X, F))
        same_matrix(weights.distance(X, P), weights.distance(X, F))
    W = weights.combinatorial(P, len(V))
    W.data[:] = 0
    W.eliminate_zeros()  # works in place, on the matrix' own arrays
    same_matrix(weights.combinatorial(P, len(V)), weights.combinatorial(F, len(V)))


def test_a_pattern_of_another_mesh_is_refused():
    V, F = shapes.icosphere(1)
    with pytest.raises(MeshError, match="the pattern has 43 vertices, but V has 42"):
        weights.distance(V, weights.Pattern(F, len(V) + 1))


def test_unknown_treatment_of_negative_weights():
    with pytest.raises(ValueError, match="negative is 'drop'"):
        weights.cotangent(*shapes.icosphere(0), negative="drop")


def test_clamped_weights_need_no_warning_of_the_step(rng):
    V, F = shapes.icosphere(2)
    V = noise.gaussian(V, F, 0.6, rng)
    with pytest.warns(StabilityWarning):
        flow.heat(V, operators.averaging(weights.cotangent(V, F)), 1, 1)
    flow.heat(V, operators.averaging(weights.cotangent(V, F, negative="clamp")), 1, 1)


def test_index_type():
    assert pattern_module.index_type(2**31 - 1, 5) is np.int32
    assert pattern_module.index_type(5, 2**31) is np.int64


def test_long_indices(monkeypatch):
    V, F = fan(5)
    W = weights.cotangent(V, F)
    monkeypatch.setattr(pattern_module, "index_type", lambda *largest: np.int64)
    P = weights.Pattern(F, len(V))
    assert P.indices.dtype == P.opposite.dtype == np.int64
    same_matrix(weights.cotangent(V, P), W)


def test_flows_with_long_indices(monkeypatch):
    V, F = torus()
    A = operators.averaging(weights.distance(V, F))
    long = A.copy()
    long.indptr, long.indices = A.indptr.astype(np.int64), A.indices.astype(np.int64)
    monkeypatch.setattr(flow, "VERTICES_WORTH_ORDERING", 0)
    for found, wanted in zip(flows(V, long, V + 1), flows(V, A, V + 1), strict=True):
        np.testing.assert_array_equal(found, wanted)
    assert ordering.nearby(long)[1].indptr.dtype == np.int64


def flows(V, A, V_true, **options):
    return [
        flow.average(V, A, 12, **options),
        list(flow.heat(V, A, 0.4, 2, **options))[-1][1],
        flow.snr_curve(V, V_true, A, 0.4, 4, **options),
    ]


def up_to_rounding(X, steps):
    """What rounding a product and a sum together may change: six neighbours and the mixing."""
    roundings = 2 * (6 + 2) * steps
    return {"rtol": 0, "atol": roundings * np.finfo(float).eps / 2 * np.abs(X).max()}


def test_flows_are_the_plain_forms():
    V, F = torus()
    V_true = shapes.torus(sections=200, sides=100)[0]
    A = operators.averaging(weights.distance(V, F))
    averaged, heated, curve = flows(V, A, V_true)
    np.testing.assert_allclose(averaged, plain.heat(V, A, 1.0, 12), **up_to_rounding(V, 12))
    np.testing.assert_allclose(heated, plain.heat(V, A, 0.4, 5), **up_to_rounding(V, 5))
    expected = [metrics.snr(V_true, plain.heat(V, A, 0.4, s)) for s in range(11)]
    np.testing.assert_allclose(curve[:, 1], expected, rtol=1e-11)


@pytest.mark.parametrize("as_mask", [False, True])
def test_fixed_vertices_stay(as_mask):
    V, F = torus()
    A = operators.averaging(weights.combinatorial(F, len(V)))
    fixed = np.array([0, 17, len(V) - 1])
    mask = np.isin(np.arange(len(V)), fixed)
    averaged, heated, curve = flows(V, A, V, fixed=mask if as_mask else fixed)
    np.testing.assert_allclose(averaged, plain.heat(V, A, 1.0, 12, fixed), **up_to_rounding(V, 12))
    np.testing.assert_allclose(heated, plain.heat(V, A, 0.4, 5, fixed), **up_to_rounding(V, 5))
    for moved in (averaged, heated):
        np.testing.assert_array_equal(moved[fixed], V[fixed])
    assert curve[-1, 1] == pytest.approx(
        metrics.snr(V, plain.heat(V, A, 0.4, 10, fixed)), rel=1e-11
    )
    V_true = V + 1
    every = flow.best_stopping(V, V_true, A, 0.4, 2, fixed=np.ones(len(V), dtype=bool))
    assert every == (0.0, pytest.approx(metrics.snr(V_true, V), rel=1e-11), 0.0)


@pytest.mark.parametrize(
    ("fixed", "message"),
    [
        (np.zeros(7, dtype=bool), "a mask needs"),
        ([0, 42], "vertex index 42, but there are 42"),
        ([-1], "vertex index -1"),
        ([0.5], "boolean mask or vertex indices"),
    ],
)
def test_fixed_vertices_that_are_none(fixed, message):
    V, F = shapes.icosphere(1)
    A = operators.averaging(weights.combinatorial(F, len(V)))
    for call in (
        lambda: flow.average(V, A, 1, fixed=fixed),
        lambda: flow.heat(V, A, 0.5, 1, fixed=fixed),
        lambda: flow.snr_curve(V, V, A, 0.5, 1, fixed=fixed),
    ):
        with pytest.raises(MeshError, match=message):
            call()


def test_rebuilt_flow_in_place_is_the_one_with_new_arrays():
    V, F = torus()
    P = weights.Pattern(F, len(V))

    def build(V):
        return operators.averaging(weights.distance(V, P))

    states = [X for _, X in flow.heat(V, build, 0.5, 2, rebuild=True)]
    curve = flow.snr_curve(V, V + 1, build, 0.5, 2, rebuild=True)
    np.testing.assert_allclose(curve[:, 1], [metrics.snr(V + 1, X) for X in states], rtol=1e-11)


def test_a_flow_that_explodes_is_stopped():
    V, F = shapes.icosphere(1)
    A = operators.averaging(weights.combinatorial(F, len(V)))
    with (
        pytest.warns(StabilityWarning),
        pytest.raises(MeshError, match=r"outgrown all numbers at time .* take a smaller"),
    ):
        flow.snr_curve(noise.uniform(V, 1, np.random.default_rng(0)), V, A, 1e3, 1e6)


def test_an_operator_with_columns_that_do_not_exist_is_refused():
    V, F = shapes.icosphere(1)
    A = operators.averaging(weights.combinatorial(F, len(V)))
    A.indices[3] = 10**6
    with pytest.raises(MeshError, match="a column that it does not have"):
        flow.average(V, A, 1)


def test_order_for_locality(monkeypatch, rng):
    V, F = torus()
    mixed = rng.permutation(len(V))
    V, F = V[mixed], ordering.rank(mixed)[F]
    V_true = V + noise.gaussian(V, F, 0.1, rng) - V
    A = operators.averaging(weights.distance(V, F))
    order, near = ordering.nearby(A)
    np.testing.assert_array_equal(np.sort(order), np.arange(len(V)))
    np.testing.assert_array_equal(ordering.rank(order)[order], np.arange(len(V)))
    np.testing.assert_array_equal(near @ V[order], (A @ V)[order])
    rows = np.repeat(np.arange(len(V)), np.diff(A.indptr))
    assert np.abs(near.indices - rows).mean() < 0.1 * np.abs(A.indices - rows).mean()
    # Flows order large meshes by themselves: nobody can tell from their results.
    as_given = flows(V, A, V_true, fixed=[5])
    monkeypatch.setattr(flow, "VERTICES_WORTH_ORDERING", 0)
    ordered = flows(V, A, V_true, fixed=[5])
    np.testing.assert_array_equal(ordered[0], as_given[0])
    np.testing.assert_allclose(ordered[2], as_given[2], rtol=1e-11)


@pytest.mark.parametrize("columns", [(3,), (), (1, 2)])
def test_rows_are_taken_and_put_back(rng, columns):
    X = rng.standard_normal((40_000, *columns))
    order = rng.permutation(len(X)).astype(np.int32)
    taken = ordering.take(X, order)
    np.testing.assert_array_equal(taken, X[order])
    np.testing.assert_array_equal(ordering.put_back(taken, order), X)
    out = np.empty_like(X)
    assert ordering.put_back(taken, order, out) is out
    np.testing.assert_array_equal(out, X)
    np.testing.assert_array_equal(ordering.put_back(np.asfortranarray(taken), order), X)


@pytest.mark.parametrize(
    ("order", "message"),
    [
        ([0, 1], r"int64 of shape \(2,\), but X has 3 rows"),
        ([0.0, 1.0, 2.0], "float64"),
        ([0, 1, 3], r"outside 0 \.\. 2"),
        ([0, -1, 2], r"outside 0 \.\. 2"),
    ],
)
def test_an_order_of_another_mesh_is_refused(order, message):
    with pytest.raises(MeshError, match=message):
        ordering.put_back(np.zeros((3, 3)), order)


def test_a_reordered_mesh_is_the_same_mesh(rng):
    V, F = torus()
    mixed = rng.permutation(len(V))
    V, F = V[mixed], ordering.rank(mixed)[F]
    V_near, F_near, order = ordering.reorder(V, F)
    np.testing.assert_array_equal(V_near[F_near], V[F])  # corner by corner
    np.testing.assert_array_equal(ordering.put_back(V_near, order), V)
    assert ordering.is_near(weights.combinatorial(F_near, len(V)))
    assert F_near.dtype == np.int64
    with pytest.raises(MeshError, match="vertex index 7"):
        ordering.reorder(V[:3], [[0, 1, 7]])


def test_a_mesh_that_is_in_order_is_known(monkeypatch, rng):
    V, F = shapes.torus(sections=150, sides=80)
    W = weights.combinatorial(F, len(V))
    mixed = weights.combinatorial(rng.permutation(len(V))[F], len(V))
    assert not ordering.is_near(mixed)
    assert ordering.is_near(ordering.nearby(mixed)[1])
    assert ordering.is_near(W)  # ring by ring, as the torus is made
    assert ordering.is_near(csr_array((5, 5)))
    # A flow orders the one and not the other.
    calls = []
    monkeypatch.setattr(flow, "VERTICES_WORTH_ORDERING", 0)
    nearby = ordering.nearby
    monkeypatch.setattr(ordering, "nearby", lambda A: calls.append(A) or nearby(A))
    flow.average(V, operators.averaging(W), flow.STEPS_WORTH_ORDERING)
    assert not calls
    flow.average(V, operators.averaging(mixed), flow.STEPS_WORTH_ORDERING)
    assert len(calls) == 1


def test_averaging_with_and_without_held_vertices():
    V, F = torus()
    A = operators.averaging(weights.distance(V, F))
    A = csr_array(block_diag([A, [[1.0]]]))
    V = np.vstack([V, [[1.0, 2.0, 3.0]]])  # without edges: stays, whether it is held or not
    averaged, held = flow.average(V, A, 3), flow.average(V, A, 3, fixed=[len(V) - 1])
    np.testing.assert_allclose(averaged, held, **up_to_rounding(V, 3))
    np.testing.assert_array_equal(averaged[-1], V[-1])


def test_every_component_is_ordered():
    F = np.array([[3, 4, 5], [0, 1, 9]])
    order, _ = ordering.nearby(weights.combinatorial(F, 11))
    assert order.tolist() == [0, 1, 9, 2, 3, 4, 5, 6, 7, 8, 10]


def everything(V, F):
    """Each kernel's results, as one list of arrays."""
    P = weights.Pattern(F, len(V))
    W = weights.cotangent(V, P)
    A = operators.averaging(weights.distance(V, F))
    return [W.indptr, W.indices, W.data, operators.mass(V, F).data, *flows(V, A, V + 1)]


def test_the_number_of_cores_changes_no_digit(monkeypatch):
    V, F = torus()
    expected = everything(V, F)
    for count in (1, 3):
        monkeypatch.setattr(kernels, "threads", lambda count=count: count)
        monkeypatch.setattr(pattern_module, "threads", lambda count=count: count)
        for found, wanted in zip(everything(V, F), expected, strict=True):
            np.testing.assert_array_equal(found, wanted)


def test_calls_from_several_threads():
    V, F = torus()
    expected = everything(V, F)
    found = [None] * 6

    def call(k):
        found[k] = everything(V, F)

    threads = [threading.Thread(target=call, args=(k,)) for k in range(len(found))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for results in found:
        for one, wanted in zip(results, expected, strict=True):
            np.testing.assert_array_equal(one, wanted)


@pytest.mark.parametrize(
    "kept",
    [
        lambda V, F: (V.astype(np.float32).astype(np.float64), F.astype(np.int32)),
        lambda V, F: (np.asfortranarray(V), F[:, ::-1]),
        lambda V, F: (np.repeat(V, 2, axis=0)[::2], np.repeat(F, 2, axis=1)[:, ::2]),
        lambda V, F: (V.tolist(), F.tolist()),
    ],
    ids=["int32", "columns", "strided", "lists"],
)
def test_arrays_of_any_layout(kept):
    V, F = shapes.torus(sections=6, sides=5)
    V = V.astype(np.float32).astype(np.float64)
    X, G = kept(V, F)
    for found, wanted in zip(everything(np.asarray(X), G), everything(V, F), strict=True):
        np.testing.assert_allclose(found, wanted, rtol=1e-12)


def test_read_only_input_is_read_only():
    V, F = shapes.torus(sections=6, sides=5)
    expected = everything(V, F)
    V.flags.writeable = F.flags.writeable = False
    for found, wanted in zip(everything(V, F), expected, strict=True):
        np.testing.assert_array_equal(found, wanted)


@pytest.mark.parametrize("steps", [0, 1, 2, 3])
def test_averaging_gives_a_new_array(steps):
    V, F = shapes.icosphere(1)
    before = V.copy()
    X = flow.average(V, operators.averaging(weights.combinatorial(F, len(V))), steps)
    X[:] = 7
    np.testing.assert_array_equal(V, before)


def run(script):
    return subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)


def test_numba_is_loaded_with_the_first_kernel():
    done = run(
        "import sys, meshfair\n"
        "from meshfair import flow, mesh, operators, shapes, solve, weights\n"
        "V, F = shapes.icosphere(1)\n"
        "assert 'numba' not in sys.modules\n"
        "weights.distance(V, F)\n"
        "assert 'numba' in sys.modules\n"
    )
    assert done.returncode == 0, done.stderr


def test_forked_and_spawned_processes():
    done = run(
        "import multiprocessing\n"
        "import numpy as np\n"
        "from meshfair import flow, operators, shapes, weights\n"
        "if __name__ == '__main__':\n"
        "    V, F = shapes.torus(sections=400, sides=100)\n"
        "    A = operators.averaging(weights.distance(V, F))\n"
        "    expected = flow.average(V, A, 3)  # the threads are running now\n"
        "    ways = {'fork', 'spawn'} & set(multiprocessing.get_all_start_methods())\n"
        "    for way in ways:\n"
        "        with multiprocessing.get_context(way).Pool(2) as pool:\n"
        "            for X in pool.starmap(flow.average, 3 * [(V, A, 3)]):\n"
        "                assert np.array_equal(X, expected), way\n"
    )
    assert done.returncode == 0, done.stderr
