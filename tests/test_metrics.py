from types import SimpleNamespace

import igl
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshes import grid
from meshfair import MeshError, mesh, metrics, noise, shapes
from meshfair.metrics.triangles import squared_distances

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
SIDES = np.array([
    [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5],
    [0, 5, 4], [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2],
])  # fmt: skip
LID = np.array([[1, 3, 7], [1, 7, 5]])


@pytest.mark.parametrize("degrees", [1e-6, 0.1, 30, 90, 179])
def test_normal_angle_of_a_turned_plane(degrees):
    V, F = grid(4)
    angle = np.radians(degrees)
    turn = np.array(
        [[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]]
    )
    assert metrics.normal_angle(V @ turn.T, V, F) == pytest.approx(degrees, rel=1e-8)


def test_normal_angle_of_faces_without_area():
    V, F = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]), [[0, 1, 2], [0, 1, 3]]
    flat = V.copy()
    flat[3] = [2, 0, 0]
    assert metrics.normal_angle(flat, V, F) == pytest.approx(45)  # 0 and 90 degrees
    assert metrics.normal_angle(V, flat, F) == 0  # nothing to compare the second face with
    with pytest.raises(MeshError, match="no face with an area"):
        metrics.normal_angle(V, 0 * V, F)


def test_volume_change_of_a_scaled_mesh():
    V, F = shapes.knot()
    assert metrics.volume_change(1.1 * V, V, F) == pytest.approx(1.1**3 - 1, rel=1e-12)
    flat = V * [1, 1, 0]
    with pytest.raises(MeshError, match="encloses no volume"):
        metrics.volume_change(V, flat, F)


def test_what_is_open_or_turned_against_itself_has_no_volume():
    V, F = grid(2)
    with pytest.raises(MeshError, match="the mesh is open: 8 edges are on its boundary"):
        metrics.volume_change(V, V, F)
    V, F = shapes.icosphere(1)
    F[5] = F[5, ::-1]
    with pytest.raises(MeshError, match="turned against each other at 3 edges"):
        metrics.volume_change(V, V, F)
    # An edge with four faces, run along as often one way as the other, is no boundary.
    V, F = shapes.icosphere(1)
    i, j = F[0, :2]
    ends = np.concatenate([V, V + 10])
    two = np.concatenate([F, F + len(V)])
    two[two == i + len(V)], two[two == j + len(V)] = i, j
    assert metrics.volume_change(2 * ends, ends, two) == pytest.approx(7)


def test_vertex_distance_of_a_lifted_plane():
    V, F = grid(6)
    mean_edge = (2 * 42 + 36 * np.sqrt(2)) / (2 * 42 + 36)  # straight edges and diagonals
    assert metrics.vertex_distance(V + [0, 0, 0.3], V, F) == pytest.approx(0.3 / mean_edge)
    # Sliding along the surface costs SNR, but no distance.
    inside = V[(V[:, 0] < 5) & (V[:, 1] < 5)] + [0.37, 0.21, 0]
    assert metrics.vertex_distance(inside, V, F) == pytest.approx(0, abs=1e-12)


def test_snr_by_hand():
    V = np.array([[3.0, 4, 0], [0, 0, 5]])
    V_noisy = V + [[0, 0, 1.0], [0, 0, 0]]
    assert metrics.snr(V.tolist(), V_noisy.tolist()) == pytest.approx(20)  # 1 / 10 is 20 dB
    assert metrics.snr(V, V) == np.inf
    decibels = metrics.snr_of_distances(V, [1.0, 0.1, 0.0])
    np.testing.assert_allclose(decibels, [20, 40, np.inf])


def test_snr_depends_on_the_origin_and_the_others_do_not(rng):
    V, F = shapes.icosphere(2)
    V_noisy, shift = noise.gaussian(V, F, 0.2, rng), np.array([5.0, 0, 0])
    assert metrics.snr(V + shift, V_noisy + shift) > metrics.snr(V, V_noisy) + 10
    for metric in (metrics.normal_angle, metrics.volume_change):
        moved = metric(V_noisy + shift, V + shift, F)
        assert moved == pytest.approx(metric(V_noisy, V, F), rel=1e-10)


def test_different_numbers_of_vertices():
    V, F = shapes.icosphere(1)
    with pytest.raises(MeshError, match="has 42 vertices but V_true has 41"):
        metrics.normal_angle(V, V[:-1], F)


def test_area_change_of_a_scaled_mesh():
    V, F = shapes.box()
    assert metrics.area_change(1.1 * V, V, F) == pytest.approx(1.1**2 - 1, rel=1e-12)
    with pytest.raises(MeshError, match="no area"):
        metrics.area_change(V, 0 * V, F)


def test_hausdorff_distance_of_a_spike():
    V, F = grid(6)
    spiked = V.copy()
    spiked[24, 2] = 2.5  # one vertex far out
    unit = mesh.mean_edge_length(V, F)
    found = metrics.hausdorff(spiked, F, V, F)
    assert found.value == pytest.approx(2.5 / unit)
    assert found.bound <= 0.01 * found.value
    same = metrics.hausdorff(V, F, V, F)
    assert same.value == 0
    assert same.bound == pytest.approx(0, abs=1e-15 * 6)  # rounding of its coordinates


def test_compare_has_every_metric(rng):
    V, F = shapes.icosphere(2)
    V_noisy = noise.gaussian(V, F, 0.2, rng)
    found = metrics.compare(V_noisy, F, V, F)
    assert found == {
        "snr": metrics.Measure(metrics.snr(V, V_noisy)),
        "normal_angle": metrics.Measure(metrics.normal_angle(V_noisy, V, F)),
        "vertex_distance": metrics.Measure(metrics.vertex_distance(V_noisy, V, F)),
        "surface_distance": metrics.surface_distance(V_noisy, F, V, F),
        "hausdorff": metrics.hausdorff(V_noisy, F, V, F),
        "volume_change": metrics.Measure(metrics.volume_change(V_noisy, V, F)),
        "area_change": metrics.Measure(metrics.area_change(V_noisy, V, F)),
    }


def test_compare_meshes_of_other_faces():
    found = metrics.compare(*shapes.icosphere(3), *shapes.icosphere(2))
    for name in ("snr", "normal_angle"):
        assert found[name].value is None
        assert found[name].reason.startswith("the meshes have 642 and 162 vertices")
    assert 0 < found["surface_distance"].value < found["hausdorff"].value
    assert found["volume_change"].value > 0  # the finer one fills more of the sphere
    volume = metrics.compare(*grid(3), *grid(2))["volume_change"]
    assert volume.value is None
    assert volume.reason.startswith("the mesh is open: 12 edges")


def test_an_angle_for_each_face_that_has_a_true_normal():
    V = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    F = [[0, 1, 2], [0, 1, 3], [0, 2, 3]]
    V_true = V.copy()
    V_true[3] = [2, 0, 0]  # the second face has lost its area, the third lies in the plane
    angles = metrics.normal_angles(V, V_true, F)
    np.testing.assert_allclose(angles, [0, 90], atol=1e-12)


def test_lengths_of_one_are_lengths():
    V = np.array([[0.0, 0, 0], [1, 0, 0], [0.5, np.sqrt(3) / 2, 0]])
    F = [[0, 1, 2]]
    assert metrics.vertex_distance(V + [0, 0, 0.25], V, F) == pytest.approx(0.25)
    lifted = (V + [0, 0, 0.25]).tolist()
    for metric in (metrics.hausdorff, metrics.surface_distance):
        found = metric(lifted, F, V.tolist(), F)
        assert found.value == pytest.approx(0.25)
        assert found.bound == pytest.approx(0, abs=1e-12)
    with pytest.raises(MeshError, match="all its vertices in one place"):
        metrics.vertex_distance(V, 0 * V, F)


def test_changes_of_a_mesh_that_is_inside_out():
    V, F = shapes.icosphere(1)
    inside_out = F[:, ::-1]
    # The volume goes from -v to -2 v: it has changed by -1 of its size.
    change = metrics.volume_change(2 ** (1 / 3) * V, V, inside_out)
    assert change == pytest.approx(-1, rel=1e-12)
    assert metrics.volume_change((2 * V).tolist(), V.tolist(), F) == pytest.approx(7, rel=1e-12)
    assert metrics.area_change((2 * V).tolist(), V.tolist(), F) == pytest.approx(3, rel=1e-12)


def test_the_same_faces_in_another_order_are_the_same_mesh(rng):
    V, F = shapes.icosphere(2)
    V_noisy = noise.gaussian(V, F, 0.2, rng)
    expected = metrics.compare(V_noisy, F, V, F)
    shuffled = np.stack([np.roll(face, k % 3) for k, face in enumerate(rng.permutation(F))])
    order = rng.permutation(len(V))
    place = np.argsort(order)
    # Faces in another order, from another corner on; vertices that no face uses; renumbered.
    stray = np.concatenate([[[1e6, 0, 0]], V, [[0, -1e6, 0]]])
    for V_true, F_true in ((V, shuffled), (stray, shuffled + 1), (V[order], place[shuffled])):
        found = metrics.compare(V_noisy, F, V_true, F_true)
        for name in ("snr", "normal_angle", "vertex_distance", "volume_change", "area_change"):
            assert found[name].value == pytest.approx(expected[name].value, rel=1e-9), name
        np.testing.assert_array_equal(metrics.matched(V_noisy, F, V_true, F_true), V)
    found = metrics.compare(V, F, V[order], place[F])
    assert found["snr"].value == np.inf
    assert found["normal_angle"].value == 0


def test_unused_vertices_stay_where_they_are_in_a_matched_ground_truth():
    V, F = shapes.icosphere(1)
    stray = np.concatenate([V, [[7.0, 8, 9]]])
    np.testing.assert_array_equal(metrics.matched(stray, F, 2 * V, F), [*(2 * V), stray[-1]])


def test_other_faces_are_not_compared_by_row_and_the_reason_is_given(rng):
    V, F = shapes.icosphere(2)
    flipped = F.copy()
    flipped[0] = flipped[0, ::-1]
    found = metrics.compare(V, flipped, 2 * V, F)
    assert found["snr"].value == pytest.approx(20 * np.log10(2))
    assert "turned the other way round" in found["normal_angle"].reason
    # Renumbered, and so noisy that nobody can say which vertex is which.
    order = rng.permutation(len(V))
    V_noisy = noise.gaussian(V, F, 3.0, rng)
    found = metrics.compare(V_noisy[order], np.argsort(order)[F], V, F)
    for name in ("snr", "normal_angle"):
        assert found[name].value is None
        assert "number the vertices of both alike" in found[name].reason
    with pytest.raises(MeshError, match="the meshes have 320 and 319 faces"):
        metrics.matched(V, F, V, F[1:])


# The distance of two surfaces


def test_a_box_without_its_lid_is_half_a_side_away_from_the_box():
    closed = np.concatenate([SIDES, LID])
    found = metrics.hausdorff(CUBE, SIDES, CUBE, closed)
    unit = mesh.mean_edge_length(CUBE, closed)
    assert found.value * unit == pytest.approx(0.5)  # the lid's centre from the four sides
    assert found.bound == pytest.approx(0, abs=1e-12)
    assert metrics.hausdorff(CUBE, closed, CUBE, SIDES).value > 0  # either way round
    # From the lid to the sides: 1/6 on average, on one of six sides; nothing the way back.
    mean = metrics.surface_distance(CUBE, SIDES, CUBE, closed)
    assert mean.value * unit == pytest.approx(1 / 6 / 6 / 2, abs=mean.bound * unit)
    assert 0 < mean.bound < 0.05 * mean.value
    assert metrics.vertex_distance(CUBE, CUBE, SIDES) == 0  # which is why its name says vertex


def points_on(V, F, k):
    """Points all over the faces: the corners of the k * k parts of each."""
    weights = [(i / k, j / k, (k - i - j) / k) for i in range(k + 1) for j in range(k + 1 - i)]
    return np.einsum("wc,fcx->fwx", weights, V[F]).reshape(-1, 3)


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.03, 0.3, 3.0]))
def test_the_hausdorff_distance_lies_within_its_bounds(seed, size):
    rng = np.random.default_rng(seed)
    V, F = rng.normal(size=(9, 3)), rng.permuted(np.tile(np.arange(9), (6, 1)), axis=1)[:, :3]
    X = V + size * rng.normal(size=V.shape)
    unit = mesh.mean_edge_length(V, F)
    found, k = metrics.hausdorff(X, F, V, F), 24
    there = igl.point_mesh_squared_distance(points_on(X, F, k), V, F)[0]
    back = igl.point_mesh_squared_distance(points_on(V, F, k), X, F)[0]
    least = np.sqrt(max(there.max(), back.max())) / unit
    # Each point of a face is this close to one that was looked at: half a part's longest edge
    # and a bit, as 1 / sqrt(3) of it is what three circles around a triangle's corners need.
    edges = max(mesh.edge_lengths(X, F).max(), mesh.edge_lengths(V, F).max())
    gap = edges / k / np.sqrt(3) / unit
    assert least <= (found.value + found.bound) * (1 + 1e-9)
    assert found.value <= least + gap
    assert found.bound <= max(0.01 * found.value, 1e-3) * (1 + 1e-9)


def test_the_search_for_the_hausdorff_distance_ends_with_a_wider_bound(monkeypatch):
    monkeypatch.setattr(metrics.surfaces, "MOST", 0)
    V, F = shapes.icosphere(1)
    V_true, F_true = shapes.icosphere(3)
    quick = metrics.hausdorff(V, F, V_true, F_true)
    monkeypatch.undo()
    slow = metrics.hausdorff(V, F, V_true, F_true)
    assert quick.value <= slow.value <= quick.value + quick.bound
    assert slow.bound < quick.bound


def test_distances_from_triangles_are_those_of_libigl(rng):
    X, T = 2 * rng.normal(size=(200, 3)), rng.normal(size=(200, 3, 3))
    T[0, 2], T[1] = T[0, 1], T[1, :1]  # without area: an edge, and a point
    T[2, 2] = (T[2, 0] + T[2, 1]) / 2
    found = squared_distances(X, T)
    face = np.array([[0, 1, 2]])
    expected = [
        igl.point_mesh_squared_distance(x[None], t, face)[0][0] for x, t in zip(X, T, strict=True)
    ]
    np.testing.assert_allclose(found[3:], expected[3:], rtol=1e-10)
    points = T[:3, :1] + np.linspace(0, 1, 2001)[:, None] * (T[:3, 1:2] - T[:3, :1])
    by_hand = ((points - X[:3, None]) ** 2).sum(axis=2).min(axis=1)
    np.testing.assert_allclose(found[:3], by_hand, rtol=1e-3)


@pytest.mark.parametrize("unit", [1e-60, 1e-9, 1e6, 1e60])
@pytest.mark.parametrize("offset", [[0, 0, 0], [448250.0, 5411940.0, 212.0]])
def test_no_distance_depends_on_place_or_unit(unit, offset, rng):
    V, F = shapes.icosphere(2)
    V_noisy = noise.gaussian(V, F, 0.2, rng)
    here = metrics.compare(V_noisy, F, V, F)
    there = metrics.compare((V_noisy + offset) * unit, F, (V + offset) * unit, F)
    for name in set(here) - {"snr"}:
        assert there[name].value == pytest.approx(here[name].value, rel=1e-6), name
        assert there[name].bound == pytest.approx(here[name].bound, rel=1e-3, abs=1e-9), name


def test_seams_are_no_boundary_and_meshes_of_other_libraries_are_meshes(rng):
    V, F = shapes.icosphere(1)
    V_noisy = noise.gaussian(V, F, 0.1, rng)
    soup = np.arange(F.size).reshape(F.shape)
    change = metrics.volume_change(V_noisy, V, F)
    torn = metrics.volume_change(V_noisy[F].reshape(-1, 3), V[F].reshape(-1, 3), soup)
    assert torn == pytest.approx(change, rel=1e-12)
    noisy, true = (SimpleNamespace(vertices=X, faces=F) for X in (V_noisy, V))
    assert metrics.compare(noisy, true) == metrics.compare(V_noisy, F, V, F)
    assert metrics.volume_change(noisy, true) == change
    assert metrics.hausdorff(noisy, V, F) == metrics.hausdorff(V_noisy, F, V, F)


def test_vertices_that_no_face_uses_count_nowhere(rng):
    V, F = shapes.icosphere(1)
    V_noisy = noise.gaussian(V, F, 0.2, rng)
    bowl = F[V[F][:, :, 2].mean(axis=1) < 0.5]
    for faces in (F, bowl):
        expected = metrics.compare(V_noisy, faces, V, faces)
        found = metrics.compare([*V_noisy, [0, 0, 50.0]], faces, [*V, [9, 9, 9.0]], faces)
        assert found == expected
    assert expected["volume_change"].value is None
    stray = np.concatenate([V, [[0, 0, 50.0]]])
    assert mesh.volume(stray, bowl) == mesh.volume(V, bowl)


def test_positions_that_are_none_are_refused_in_either_mesh():
    V, F = shapes.icosphere(1)
    bad = V.copy()
    bad[3, 2] = np.inf
    for call in (
        lambda: metrics.vertex_distance(bad, V, F),
        lambda: metrics.vertex_distance(V, bad, F),
        lambda: metrics.surface_distance(bad, F, V, F),
        lambda: metrics.surface_distance(V, F, bad, F),
        lambda: metrics.matched(bad, F, V, F),
        lambda: metrics.hausdorff(bad, F, V, F),
        lambda: metrics.hausdorff(V, F, bad, F),
        lambda: metrics.compare(bad, F, V, F),
        lambda: metrics.compare(V, F, bad, F),
    ):
        with pytest.raises(MeshError, match="vertex 3 has z = inf"):
            call()


@pytest.mark.parametrize("metric", [metrics.volume_change, metrics.area_change])
def test_changes_need_the_same_vertices(metric):
    V, F = shapes.icosphere(1)
    with pytest.raises(MeshError, match="has 43 vertices but V_true has 42"):
        metric(np.concatenate([V, V[:1]]), V, F)
