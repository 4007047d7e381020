"""The kernel as a table: its formula by loops, and what it learns."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshfair import MeshError, experiments, metrics, noise, shapes
from meshfair.filters import kernel_table
from meshfair.filters.kernel_table import ANGLES, DISTANCES
from meshfair.mesh import face_normals, face_shapes

V, F = shapes.box(segments=3)
NOISY = noise.along_normals(V, F, 0.3, np.random.default_rng(1))


@given(st.lists(st.floats(-1, 200), min_size=1, max_size=20), st.floats(-3, 3), st.floats(-3, 3))
def test_hats_share_each_number_between_its_neighbours(numbers, slope, start):
    x = np.array(numbers)
    H = kernel_table.hats(x, ANGLES)
    assert H.min() >= 0
    assert (np.count_nonzero(H, axis=1) <= 2).all()
    # A straight line, given at the nodes, is read exactly; past the ends it is constant.
    line = slope * np.clip(x, 0, 180) + start
    np.testing.assert_allclose(H @ (slope * ANGLES + start), line, atol=1e-12 * 600)
    np.testing.assert_allclose(H.sum(axis=1), 1, rtol=1e-14)


def test_hats_are_one_at_their_node():
    np.testing.assert_array_equal(kernel_table.hats(ANGLES, ANGLES), np.eye(len(ANGLES)))


def by_loops(V, F):
    """g_i,ab as its formula says it, from nothing but V and F."""
    N, area, C = face_shapes(V, F)
    corners = [set(face) for face in F.tolist()]
    adjacent = [
        np.linalg.norm(C[f] - C[g])
        for f in range(len(F))
        for g in range(f)
        if len(corners[f] & corners[g]) == 2
    ]
    G = np.zeros((len(F), len(ANGLES), len(DISTANCES), 3))
    for f in range(len(F)):
        ring = [g for g in range(len(F)) if corners[f] & corners[g]]
        for g in ring:
            angle = np.degrees(np.arctan2(np.linalg.norm(np.cross(N[f], N[g])), N[f] @ N[g]))
            distance = np.linalg.norm(C[f] - C[g]) / np.mean(adjacent)
            for a in range(len(ANGLES)):
                for b in range(len(DISTANCES)):
                    hats = (np.interp(x, nodes, np.arange(len(nodes)) == k) for x, nodes, k in (
                        (angle, ANGLES, a), (distance, DISTANCES, b)))  # fmt: skip
                    G[f, a, b] += area[g] / area[ring].sum() * np.prod(list(hats)) * N[g]
    return G.reshape(len(F), -1, 3)


def test_partial_sums_are_those_of_the_formula():
    G = kernel_table.partial_sums(face_normals(NOISY, F), kernel_table.face_pairs(NOISY, F))
    np.testing.assert_allclose(G, by_loops(NOISY, F), atol=1e-13)


def test_a_known_table_is_found_again(rng, monkeypatch):
    monkeypatch.setattr(kernel_table, "RIDGE", 0.0)
    G, table = rng.standard_normal((200, 12, 3)), rng.standard_normal(12)
    np.testing.assert_allclose(
        kernel_table.fitted(G, np.einsum("mkx,k->mx", G, table)), table, rtol=1e-10
    )


def test_the_table_is_that_of_least_squares_with_a_ridge(rng):
    G, N = rng.standard_normal((30, 5, 3)), rng.standard_normal((30, 3))
    G[:, 3] = 0  # an entry that no pair asks for
    X = np.concatenate([G[:, :, axis] for axis in range(3)])
    ridge = kernel_table.RIDGE * (X**2).sum() / 5
    rows = np.concatenate([X, np.sqrt(ridge) * np.eye(5)])
    expected = np.linalg.lstsq(rows, np.concatenate([*N.T, np.zeros(5)]), rcond=None)[0]
    np.testing.assert_allclose(kernel_table.fitted(G, N), expected, atol=1e-12)
    assert expected[3] == 0


def test_where_a_mesh_lies_and_how_large_it_is_does_not_matter(rng):
    Q, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    Q *= np.sign(np.linalg.det(Q))
    (table,) = kernel_table.cascade([(NOISY, V, F)], 1)
    moved = [100 * X @ Q.T + [5, -3, 2] for X in (NOISY, V)]
    (again,) = kernel_table.cascade([(*moved, F)], 1)
    np.testing.assert_allclose(again, table, atol=1e-10)  # rounding, times the condition
    found, turned = (kernel_table.normals_by_tables(X, F, [table])[-1] for X in (NOISY, moved[0]))
    np.testing.assert_allclose(turned, found @ Q.T, atol=1e-10)


def test_a_mesh_with_its_own_normals_stays_as_it_is():
    np.testing.assert_allclose(
        kernel_table.fit_vertices(NOISY, F, face_normals(NOISY, F)), NOISY, atol=1e-14
    )


def test_faces_without_area_have_no_say_and_get_a_direction():
    flat = np.append(F, [[0, 0, 1]], axis=0)
    pairs = kernel_table.face_pairs(NOISY, flat)
    assert np.isfinite(pairs.share).all()
    G = kernel_table.partial_sums(face_normals(NOISY, flat), pairs)
    N = kernel_table.filtered(G, np.ones(G.shape[1]))
    np.testing.assert_allclose(np.linalg.norm(N, axis=1), 1)


@pytest.mark.parametrize(
    "corners",
    [[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 0], [1, 0, 0], [2, 0, 0]]],
    ids=["a single triangle", "without area"],
)
def test_a_mesh_without_neighbours_is_left_alone(corners):
    face = [[0, 1, 2]]
    pairs = kernel_table.face_pairs(corners, face)
    assert list(pairs.i) == list(pairs.j) == [0]
    assert list(pairs.distance) == [0]
    assert pairs.share[0] == (1 if corners[2][1] else 0)
    (table,) = kernel_table.cascade([(corners, corners, face)], 1)
    N = kernel_table.normals_by_tables(corners, face, [table])[-1]
    np.testing.assert_allclose(N, face_normals(corners, face), atol=1e-12)
    np.testing.assert_allclose(kernel_table.fit_vertices(corners, face, N), corners, atol=1e-12)


def test_faulty_vertices_and_counts_are_refused():
    N = face_normals(V, F)
    with pytest.raises(MeshError, match="V"):
        kernel_table.fit_vertices(V[:, :2], F, N)
    with pytest.raises(ValueError, match="iterations"):
        kernel_table.fit_vertices(V, F, N, -1)


def angle(name, learned_from, passes=5):
    """Mean normal angle on a shape, with tables learned from others under other noise."""
    meshes = {"box": shapes.box(segments=8), "torus": shapes.torus(sections=40, sides=16)}
    draw = noise.along_normals
    examples = [
        (draw(*meshes[one], 0.3, np.random.default_rng(1)), *meshes[one]) for one in learned_from
    ]
    tables = list(kernel_table.cascade(examples, passes))
    X, (V, F) = draw(*meshes[name], 0.3, np.random.default_rng(2)), meshes[name]
    N = kernel_table.normals_by_tables(X, F, tables)[-1]
    return metrics.normal_angle(kernel_table.fit_vertices(X, F, N), V, F)


def test_what_it_has_learned_from_decides():
    of_box, of_torus, of_both = (angle("box", x) for x in (["box"], ["torus"], ["box", "torus"]))
    assert of_box < of_torus / 2
    assert of_box < of_both < of_torus
    assert angle("torus", ["torus"]) < angle("torus", ["box"])


def test_each_pass_learns_from_what_is_left():
    assert angle("box", ["box"], 5) < angle("box", ["box"], 2) < angle("box", ["box"], 1)


@pytest.mark.parametrize(
    ("examples", "passes", "error", "message"),
    [
        ([], 1, ValueError, "there are no examples to learn from"),
        ([(V, V, F)], -1, ValueError, "passes"),
        ([(V[:5], V, F)], 1, MeshError, "F"),
    ],
)
def test_faulty_examples_are_refused(examples, passes, error, message):
    with pytest.raises(error, match=message):
        list(kernel_table.cascade(examples, passes))


def test_the_experiment_tries_each_kernel_on_each_mesh():
    table = experiments.kernel_transfer(("sphere", "box"), 0.2, 3, passes=1)
    assert list(table["learned_from"]) == ["none", "none", "sphere", "sphere", "box", "box"]
    assert list(table["tried_on"]) == ["sphere", "box"] * 3
    V, F = shapes.box()
    draws = [noise.along_normals(V, F, 0.2, np.random.default_rng(seed)) for seed in (3, 4)]
    (kernel,) = kernel_table.cascade([(draws[0], V, F)], 1)
    N = kernel_table.normals_by_tables(draws[1], F, [kernel])[-1]
    expected = metrics.normal_angle(kernel_table.fit_vertices(draws[1], F, N), V, F)
    assert table["normal_angle"].iloc[-1] == pytest.approx(expected)
    assert table["normal_angle"].iloc[1] == pytest.approx(metrics.normal_angle(draws[1], V, F))
