import igl
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array

from meshes import CLOSED, RIGHT_TRIANGLE, fan, grid, rigid_motions, soups
from meshfair import (
    MeshError,
    MeshWarning,
    StabilityWarning,
    flow,
    mesh,
    noise,
    reference,
    shapes,
    weights,
)
from meshfair.operators import averaging

BUILDERS = {
    "combinatorial": lambda V, F: weights.combinatorial(F, len(V)),
    "distance": weights.distance,
    "cotangent": weights.cotangent,
}


def test_right_triangle_by_hand():
    V, F = RIGHT_TRIANGLE
    # Opposite the hypotenuse is 90 degrees (cot 0), opposite the legs 45 (cot 1).
    np.testing.assert_allclose(
        weights.cotangent(V, F).toarray(), [[0, 0.5, 0.5], [0.5, 0, 0], [0.5, 0, 0]], atol=1e-16
    )
    np.testing.assert_allclose(
        weights.distance(V, F).toarray(), [[0, 1, 1], [1, 0, 2**0.5], [1, 2**0.5, 0]]
    )
    np.testing.assert_array_equal(
        weights.combinatorial(F, 4).toarray(),
        [[0, 1, 1, 0], [1, 0, 1, 0], [1, 1, 0, 0], [0, 0, 0, 0]],
    )


@pytest.mark.parametrize("faces", [1, 2, 3, 5])
def test_equilateral_triangles_around_an_edge(faces):
    V, F = fan(faces)
    # Each face adds half of cot 60 degrees to the common edge, however many there are.
    assert weights.cotangent(V, F)[0, 1] == pytest.approx(faces / (2 * np.sqrt(3)), rel=1e-14)


def test_an_obtuse_pair_has_a_negative_weight():
    V = np.array([[-1.0, 0, 0], [1, 0, 0], [0, 0.5, 0], [0, -0.5, 0]])
    W = weights.cotangent(V, np.array([[0, 1, 2], [1, 0, 3]]))
    # tan of half the angle at the tips is 2, so cot of the angle is (1 - 4) / (2 * 2).
    assert W[0, 1] == pytest.approx(-0.75)


def test_duplicate_faces_count_once():
    V, F = fan(2)
    for build in BUILDERS.values():
        once, twice = build(V, F), build(V, np.concatenate([F, F[:, [1, 0, 2]]]))
        assert abs(once - twice).max() == 0


def test_degenerate_faces_give_zero_and_one_warning():
    V = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0], [1, 0, 0]])
    F = np.array([[0, 1, 2], [0, 1, 3], [1, 1, 2], [1, 4, 2]])  # collinear, collapsed, zero edge
    with pytest.warns(MeshWarning, match="3 of 4 faces are degenerate") as caught:
        W = weights.cotangent(V, F)
    assert len(caught) == 1
    expected = np.zeros((5, 5))
    expected[:3, :3] = [[0, 0.5, 0.5], [0.5, 0, 0], [0.5, 0, 0]]
    np.testing.assert_allclose(W.toarray(), expected, atol=1e-16)
    assert np.isfinite(W.data).all()


MESHES = {**CLOSED, "open": grid, "fan": lambda: fan(4)}


@pytest.mark.parametrize("build", MESHES.values(), ids=MESHES)
def test_equal_to_libigl(build, rng):
    V, F = build()
    V = V + 0.1 * mesh.mean_edge_length(V, F) * rng.standard_normal(V.shape)
    W, libigl = weights.cotangent(V, F), reference.cotangent(V, F)
    assert abs(W - libigl).max() <= 1e-10 * abs(libigl).max()
    adjacency = reference.adjacency(F, len(V))
    assert abs(weights.combinatorial(F, len(V)) - adjacency).max() == 0


@pytest.mark.parametrize("name", ["f16.ply", "stanford-bunny.obj", "KnotMesh.ply"])
def test_equal_to_libigl_on_real_meshes(mirror, name):
    V, F = igl.read_triangle_mesh(str(mirror / name))
    F = mesh.unique_faces(F)  # libigl counts duplicate faces twice
    W, libigl = weights.cotangent(V, F), reference.cotangent(V, F)
    assert abs(W - libigl).max() <= 1e-10 * abs(libigl).max()
    assert abs(weights.combinatorial(F, len(V)) - reference.adjacency(F, len(V))).max() == 0


@given(soups())
def test_symmetric_on_the_edges_and_finite(soup):
    V, F = soup
    E = mesh.Edges(F).ends
    pattern = csr_array((np.ones(len(E)), E.T), shape=(len(V),) * 2)
    pattern = (pattern + pattern.T).toarray() > 0
    for name, build in BUILDERS.items():
        W = build(V, F)
        assert isinstance(W, csr_array)
        assert np.isfinite(W.data).all()
        assert not (W.toarray() != 0)[~pattern].any()
        assert abs(W - W.T).max() <= 1e-15 * abs(W).max()
        if name != "cotangent":  # whose weights may be negative or zero
            assert np.all(W.toarray()[pattern] > 0)


@given(soups(), rigid_motions(), st.floats(0.01, 100))
def test_motion_and_scale(soup, motion, scale):
    V, F = soup
    Q, shift = motion
    moved = scale * V @ Q.T + shift
    for name, factor in (("combinatorial", 1), ("distance", scale), ("cotangent", 1)):
        before, after = BUILDERS[name](V, F), BUILDERS[name](moved, F)
        # Cotangents of slivers amplify rounding by up to their own size squared.
        tolerance = 1e-12 * (1 + abs(before).max()) ** 2 * (1 + 1 / scale) * factor
        assert abs(after - factor * before).max() <= tolerance


@given(soups(), st.integers(0, 2**32 - 1))
def test_relabelled_vertices(soup, seed):
    V, F = soup
    to = np.random.default_rng(seed).permutation(len(V))
    V_new = np.empty_like(V)
    V_new[to] = V
    for build in BUILDERS.values():
        W, W_new = build(V, F), build(V_new, to[F])
        assert abs(W_new[to][:, to] - W).max() <= 1e-12 * abs(W).max()


def test_cotangent_weights_reproduce_linear_functions(rng):
    V, F = grid(8, irregular=rng)
    W = weights.cotangent(V, F)
    inside = np.all((V[:, :2] > 0) & (V[:, :2] < 8), axis=1)
    # In a flat mesh each inner vertex is the weighted mean of its neighbours [PP93].
    residual = (W @ V - W.sum(axis=1)[:, None] * V)[inside]
    np.testing.assert_allclose(residual, 0, atol=1e-13 * 8)


def test_inputs_are_left_alone():
    V, F = shapes.icosphere(1)
    V.flags.writeable = F.flags.writeable = False
    for build in BUILDERS.values():
        build(V, F)


@given(soups())
def test_clamped_weights_are_those_that_are_not_negative(soup):
    V, F = soup
    W, clamped = weights.cotangent(V, F), weights.cotangent(V, F, negative="clamp")
    np.testing.assert_array_equal(clamped.toarray(), np.maximum(W.toarray(), 0))


def test_unknown_treatment_of_negative_weights():
    with pytest.raises(ValueError, match="negative is 'drop'; give one of keep, clamp"):
        weights.cotangent(*shapes.icosphere(0), negative="drop")


def test_clamped_weights_need_no_warning_of_the_step(rng):
    V, F = shapes.icosphere(2)
    V = noise.gaussian(V, F, 0.6, rng)
    with pytest.warns(StabilityWarning):
        flow.heat(V, averaging(weights.cotangent(V, F)), 1, 1)
    flow.heat(V, averaging(weights.cotangent(V, F, negative="clamp")), 1, 1)


def test_the_edges_of_another_mesh_are_refused():
    V, F = shapes.icosphere(1)
    with pytest.raises(MeshError, match="those of 43 vertices, but V has 42"):
        weights.distance(V, mesh.Edges(F, len(V) + 1))


def test_weights_by_name_are_the_builders():
    V, F = shapes.icosphere(1)
    assert list(weights.BY_NAME) == list(BUILDERS)
    for name, build in BUILDERS.items():
        assert abs(weights.BY_NAME[name](V, F) - build(V, F)).max() == 0
