import numpy as np
import pytest

from meshes import grid
from meshfair import MeshError, mesh, metrics, noise, shapes


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
    with pytest.raises(MeshError, match="no volume"):
        metrics.volume_change(*[grid(2)[0]] * 2, grid(2)[1])


def test_surface_distance_of_a_lifted_plane():
    V, F = grid(6)
    mean_edge = (2 * 42 + 36 * np.sqrt(2)) / (2 * 42 + 36)  # straight edges and diagonals
    assert metrics.surface_distance(V + [0, 0, 0.3], V, F) == pytest.approx(0.3 / mean_edge)
    # Sliding along the surface costs SNR, but no distance.
    inside = V[(V[:, 0] < 5) & (V[:, 1] < 5)] + [0.37, 0.21, 0]
    assert metrics.surface_distance(inside, V, F) == pytest.approx(0, abs=1e-12)


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
    assert metrics.hausdorff(spiked, F, V, F) == pytest.approx(2.5 / unit)
    assert metrics.hausdorff(V, F, V, F) == 0


def test_compare_has_every_metric(rng):
    V, F = shapes.icosphere(2)
    V_noisy = noise.gaussian(V, F, 0.2, rng)
    found = metrics.compare(V_noisy, F, V, F)
    assert found == {
        "snr": metrics.snr(V, V_noisy),
        "normal_angle": metrics.normal_angle(V_noisy, V, F),
        "surface_distance": metrics.surface_distance(V_noisy, V, F),
        "hausdorff": metrics.hausdorff(V_noisy, F, V, F),
        "volume_change": pytest.approx(metrics.volume_change(V_noisy, V, F), rel=1e-12),
        "area_change": metrics.area_change(V_noisy, V, F),
    }


def test_compare_meshes_of_other_faces():
    found = metrics.compare(*shapes.icosphere(3), *shapes.icosphere(2))
    assert found["snr"] is found["normal_angle"] is None
    assert 0 < found["surface_distance"] < found["hausdorff"]
    assert found["volume_change"] > 0  # the finer one fills more of the sphere
    assert metrics.compare(*grid(3), *grid(2))["volume_change"] is None


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
    assert metrics.surface_distance(V + [0, 0, 0.25], V, F) == pytest.approx(0.25)
    assert metrics.hausdorff((V + [0, 0, 0.25]).tolist(), F, V.tolist(), F) == pytest.approx(0.25)
    with pytest.raises(MeshError, match="all its vertices in one place"):
        metrics.surface_distance(V, 0 * V, F)


def test_changes_of_a_mesh_that_is_inside_out():
    V, F = shapes.icosphere(1)
    inside_out = F[:, ::-1]
    # The volume goes from -v to -2 v: it has changed by -1 of its size.
    change = metrics.volume_change(2 ** (1 / 3) * V, V, inside_out)
    assert change == pytest.approx(-1, rel=1e-12)
    assert metrics.volume_change((2 * V).tolist(), V.tolist(), F) == pytest.approx(7, rel=1e-12)
    assert metrics.area_change((2 * V).tolist(), V.tolist(), F) == pytest.approx(3, rel=1e-12)


def test_compare_goes_vertex_by_vertex_only_where_all_agrees():
    V, F = shapes.icosphere(1)
    assert metrics.compare(V.tolist(), F.tolist(), V.tolist(), F.tolist())["snr"] == np.inf
    other_faces = metrics.compare(V, F[::-1], V, F)
    assert other_faces["snr"] is other_faces["normal_angle"] is None
    more_vertices = metrics.compare(np.concatenate([V, V[:1]]), F, V, F)
    assert more_vertices["snr"] is more_vertices["normal_angle"] is None
    assert more_vertices["surface_distance"] == pytest.approx(0, abs=1e-7)


def test_positions_that_are_none_are_refused_in_either_mesh():
    V, F = shapes.icosphere(1)
    bad = V.copy()
    bad[3, 2] = np.inf
    for call in (
        lambda: metrics.surface_distance(bad, V, F),
        lambda: metrics.surface_distance(V, bad, F),
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
