"""The compiled loops' surroundings: processes, threads, layouts, long indices, when numba loads."""

import subprocess
import sys
import threading
from unittest import mock

import numpy as np
import pytest
from hypothesis import given
from scipy.sparse import csr_array

from meshes import fan
from meshfair import MeshError, _fast, flow, mesh, operators, shapes, weights
from meshfair._fast import kernels, ordering
from meshfair._fast import pattern as pattern_module
from test_fast_equals_plain import flows, ragged_soups, same_matrix, torus


@pytest.fixture(autouse=True, scope="module")
def compiled_loops():
    """Compiled loops for all sizes."""
    with mock.patch.object(_fast, "wanted", return_value=True):
        yield


@given(ragged_soups())
def test_a_pattern_lists_each_edge_with_the_vertices_opposite(soup):
    V, F = soup
    P = pattern_module.Pattern(F, len(V))
    i, j = P.indices[P.at_ji], P.indices[P.at_ij]
    np.testing.assert_array_equal(np.repeat(np.arange(len(V)), np.diff(P.edge_ptr)), i)
    listed = np.column_stack(
        [np.repeat(np.stack([i, j]), np.diff(P.opposite_ptr), axis=1).T, P.opposite]
    )
    corners = {tuple(sorted(face)) for face in F.tolist()}
    expected = {t for a, b, c in corners for t in ((a, b, c), (a, c, b), (b, c, a))}
    assert listed.tolist() == sorted([i, j, k] for i, j, k in expected if i != j)


def test_index_type():
    assert pattern_module.index_type(2**31 - 1, 5) is np.int32
    assert pattern_module.index_type(5, 2**31) is np.int64


def test_long_indices(monkeypatch):
    V, F = fan(5)
    W = weights.cotangent(V, F)
    monkeypatch.setattr(pattern_module, "index_type", lambda *largest: np.int64)
    E = mesh.Edges(F, len(V))
    assert E.sparsity.indices.dtype == E.sparsity.opposite.dtype == np.int64
    same_matrix(weights.cotangent(V, E), W)


def test_flows_with_long_indices(monkeypatch):
    V, F = torus()
    A = operators.averaging(weights.distance(V, F))
    long = A.copy()
    long.indptr, long.indices = A.indptr.astype(np.int64), A.indices.astype(np.int64)
    monkeypatch.setattr(_fast.flow, "VERTICES_WORTH_ORDERING", 0)
    for found, wanted in zip(flows(V, long, V + 1), flows(V, A, V + 1), strict=True):
        np.testing.assert_array_equal(found, wanted)
    assert ordering.nearby(long)[1].indptr.dtype == np.int64


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
    monkeypatch.setattr(_fast.flow, "VERTICES_WORTH_ORDERING", 0)
    nearby = ordering.nearby
    monkeypatch.setattr(ordering, "nearby", lambda A: calls.append(A) or nearby(A))
    flow.average(V, operators.averaging(W), _fast.flow.ITERATIONS_WORTH_ORDERING)
    assert not calls
    flow.average(V, operators.averaging(mixed), _fast.flow.ITERATIONS_WORTH_ORDERING)
    assert len(calls) == 1


def test_rows_are_taken_and_put_back(rng):
    X = rng.standard_normal((40_000, 3))
    order = rng.permutation(len(X)).astype(np.int32)
    taken = ordering.take(X, order)
    np.testing.assert_array_equal(taken, X[order])
    np.testing.assert_array_equal(ordering.put_back(taken, order, np.empty_like(X)), X)


def test_nearby_is_the_same_matrix_in_another_order(rng):
    V, F = torus()
    mixed = rng.permutation(len(V))
    A = operators.averaging(weights.distance(V[np.argsort(mixed)], mixed[F]))
    order, near = ordering.nearby(A)
    np.testing.assert_array_equal(np.sort(order), np.arange(len(V)))
    np.testing.assert_array_equal(near @ V[order], (A @ V)[order])
    rows = np.repeat(np.arange(len(V)), np.diff(A.indptr))
    assert np.abs(near.indices - rows).mean() < 0.1 * np.abs(A.indices - rows).mean()


def everything(V, F):
    """Each kernel's results, as one list of arrays."""
    W = weights.cotangent(V, F)
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


def run(script):
    return subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)


def test_numba_is_loaded_with_the_first_large_mesh():
    done = run(
        "import sys, meshfair\n"
        "from meshfair import _fast, filters, flow, mesh, operators, shapes, solve, weights\n"
        "V, F = shapes.icosphere(3)\n"
        "flow.average(V, operators.averaging(weights.cotangent(V, F)), 3)\n"
        "*_, (_, V) = filters.bilateral_normal(V, F, normal_iterations=1, vertex_iterations=1)\n"
        "assert 'numba' not in sys.modules\n"
        "V, F = shapes.torus(sections=300, sides=100)\n"
        "assert len(V) >= _fast.ROWS\n"
        "weights.distance(V, F)\n"
        "assert 'numba' in sys.modules\n"
    )
    assert done.returncode == 0, done.stderr


def test_an_operator_that_was_changed_is_refused():
    """Whatever the loops read without a pass of its own to check it first."""
    V, F = torus()
    A = operators.averaging(weights.combinatorial(F, len(V)))
    for iterations in (1, 12):
        broken = A.copy()
        broken.indices[-3] = 10**6
        with pytest.raises(MeshError, match="a column that it does not have"):
            flow.average(V, broken, iterations)
        broken = A.copy()
        broken.data[-3] = np.nan
        with pytest.raises(MeshError, match="NaN or infinite"):
            flow.average(V, broken, iterations)


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
