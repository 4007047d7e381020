import numpy as np
import pytest
from scipy.spatial import cKDTree

from meshfair import mesh
from meshfair.shapes.jet import EDGE, airfoil, jet, jet_labels, jet_parts, loft, superellipse

DETAILS = [0.5, 0.8, 1.0, 1.7, 3.0]


def split(V, F):
    """The connected components of a mesh, each as a mesh of its own."""
    count, label = mesh.components(F, len(V))
    for k in range(count):
        vertices = np.flatnonzero(label == k)
        yield V[vertices], np.searchsorted(vertices, F[label[F[:, 0]] == k])


def aspect(V, F):
    """Longest edge over its height, so that an equilateral triangle has 1."""
    H = mesh.half_edges(F)
    longest = np.linalg.norm(V[H[:, 0]] - V[H[:, 1]], axis=1).reshape(3, -1).max(axis=0)
    return longest**2 * np.sqrt(3) / 4 / mesh.face_areas(V, F)


def test_loft_with_one_ring_is_a_bipyramid_over_a_hexagon():
    stations = [
        [[0, 0, -1], [0, 0, 0], [0, 0, 0]],
        [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
        [[0, 0, 1], [0, 0, 0], [0, 0, 0]],
    ]
    V, F = loft(stations, superellipse(2), edge=2)
    hexagon = [(np.cos(a), np.sin(a), 0) for a in np.pi / 3 * np.arange(6)]
    np.testing.assert_allclose(V, [(0, 0, -1), *hexagon, (0, 0, 1)], atol=1e-4)
    assert len(F) == 12
    # Two pyramids of height 1 over a hexagon with sides of 1, which has the area 3 sqrt(3) / 2.
    assert mesh.volume(V, F) == pytest.approx(np.sqrt(3), rel=1e-4)


def test_loft_through_two_flat_ends_converges_to_the_cylinder():
    """Volume pi and area 4 pi; the error of a polygon falls with the square of its edge."""
    stations = [[[0, 0, z], [1, 0, 0], [0, 1, 0]] for z in (0, 1)]
    errors = []
    for edge in (0.2, 0.1):
        V, F = loft(stations, superellipse(2), edge)
        assert mesh.is_closed(F)
        errors.append([np.pi - mesh.volume(V, F), 4 * np.pi - mesh.area(V, F)])
    rate = np.log2(np.divide(*errors))
    assert np.all(rate > 1.8)
    assert np.all(rate < 2.2)


def test_airfoil_is_sharp_behind_thickest_in_front_and_symmetric():
    curve = airfoil()
    np.testing.assert_allclose(curve[[0, 256]], [[1, 0], [-1, 0]], atol=1e-12)
    np.testing.assert_allclose(curve[1:], curve[:0:-1] * [1, -1], atol=1e-12)
    assert curve[curve[:, 1].argmax(), 0] == pytest.approx(1 - 2 * 0.3, abs=0.02)  # 30 % of chord


@pytest.mark.parametrize("missiles", [True, False])
def test_size_at_detail_1(missiles):
    V, F = jet(missiles)
    assert V.dtype == np.float64
    assert F.dtype == np.int64
    assert 4000 <= len(V) <= 8000
    np.testing.assert_allclose(np.ptp(V, axis=0), [15, 10, 5], rtol=0.1)
    centre = jet_parts(missiles)["fuselage"][0].mean(axis=0)
    np.testing.assert_allclose(centre, 0, atol=0.5)


@pytest.mark.parametrize("missiles", [True, False])
def test_vertices_grow_with_the_square_of_detail(missiles):
    n = {detail: len(jet(missiles, detail)[0]) for detail in (0.5, 1, 2, 4)}
    assert 2.5 < n[1] / n[0.5] < 4.5  # the thinnest rings cannot get coarser
    assert 3.5 < n[2] / n[1] < 4.5
    assert 3.5 < n[4] / n[2] < 4.5


@pytest.mark.parametrize("detail", DETAILS)
@pytest.mark.parametrize("missiles", [True, False])
def test_every_component_is_a_closed_oriented_sphere(missiles, detail):
    V, F = jet(missiles, detail)
    assert len(mesh.unique_faces(F)) == len(F)
    assert not mesh.degenerate_faces(V, F).any()
    assert np.array_equal(np.unique(F), np.arange(len(V)))
    components = list(split(V, F))
    assert len(components) == (73 if missiles else 13)
    for X, G in components:
        H = mesh.half_edges(G)
        assert mesh.is_closed(G)
        assert len(np.unique(H, axis=0)) == len(H)  # each direction of an edge once: oriented
        assert len(X) - len(H) // 2 + len(G) == 2
        assert mesh.volume(X, G) > 0


def test_largest_detail_is_closed_too():
    V, F = jet(detail=8)
    assert mesh.is_closed(F)
    assert not mesh.degenerate_faces(V, F).any()


@pytest.mark.parametrize("detail", [0.5, 1.0, 2.0])
def test_without_missiles_is_with_missiles_less_their_parts(detail):
    armed, plain = jet_parts(True, detail), jet_parts(False, detail)
    assert list(plain) == list(armed)[: len(plain)]
    assert all(
        any(word in name for word in ("missile", "rail", "pylon"))
        for name in list(armed)[len(plain) :]
    )
    for name, (V, F) in plain.items():
        np.testing.assert_array_equal(V, armed[name][0])
        np.testing.assert_array_equal(F, armed[name][1])
    (V, F), (X, G) = jet(True, detail), jet(False, detail)
    np.testing.assert_array_equal(V[: len(X)], X)
    np.testing.assert_array_equal(F[: len(G)], G)


@pytest.mark.parametrize("missiles", [True, False])
def test_labels_cut_the_jet_into_its_parts(missiles):
    V, F = jet(missiles)
    labels, names = jet_labels(missiles)
    parts = jet_parts(missiles)
    assert names == list(parts)
    assert labels.shape == (len(V),)
    assert np.all(labels[F] == labels[F[:, :1]])  # no face spans two parts
    for k, name in enumerate(names):
        np.testing.assert_array_equal(V[labels == k], parts[name][0])


@pytest.mark.parametrize("detail", [0.5, 1.0, 1.7])
def test_left_and_right_mirror_each_other(detail):
    V, _ = jet(detail=detail)
    assert cKDTree(V).query(V * [1, -1, 1])[0].max() < 1e-9
    parts = jet_parts(detail=detail)
    for name in ("fuselage", "canopy", "intake", "nozzle"):  # the fin's flat caps have diagonals
        V, F = parts[name]
        _, twin = cKDTree(V).query(V * [1, -1, 1])
        faces, mirrored = np.sort(F, axis=1), np.sort(twin[F], axis=1)
        np.testing.assert_array_equal(np.unique(faces, axis=0), np.unique(mirrored, axis=0))
    for name in (name for name in parts if name.endswith("left")):
        (V, F), (X, G) = parts[name], parts[name.replace("left", "right")]
        np.testing.assert_array_equal(V * [1, -1, 1], X)
        np.testing.assert_array_equal(F[:, ::-1], G)


def test_missiles_are_a_few_edges_thick_and_their_fins_less():
    V, F = jet()
    edge = mesh.mean_edge_length(V, F)
    missiles = [part for name, part in jet_parts().items() if "missile" in name]
    assert len(missiles) == 6
    for part in missiles:
        tube, *fins = split(*part)
        length, _, diameter = np.ptp(tube[0], axis=0)
        assert 1.5 * edge < diameter < 4 * edge
        assert length > 10 * edge
        assert len(fins) == 8
        for X, _ in fins:
            thickness = 2 * np.linalg.svd(X - X.mean(axis=0))[1][-1] / np.sqrt(len(X))
            assert 0.05 * edge < thickness < 0.5 * edge


@pytest.mark.parametrize("missiles", [True, False])
def test_triangles_are_of_one_size_and_none_is_a_needle(missiles):
    V, F = jet(missiles)
    assert mesh.mean_edge_length(V, F) == pytest.approx(EDGE, rel=0.15)
    quality = aspect(V, F)
    assert np.median(quality) < 1.8  # half of a square has 1.73
    assert np.quantile(quality, 0.95) < 3
    assert quality.max() < 12
    for name in ("fuselage", "intake", "canopy", "wing left", "tailplane left"):
        assert mesh.mean_edge_length(*jet_parts(missiles)[name]) == pytest.approx(EDGE, rel=0.15)


def test_it_is_the_same_every_time():
    for first, second in zip(jet(), jet(), strict=True):
        np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize("function", [jet, jet_parts, jet_labels])
@pytest.mark.parametrize("detail", [0, -1, 0.49, 8.01, np.nan, np.inf, None, "fine"])
def test_bad_detail_is_refused(function, detail):
    with pytest.raises(ValueError, match=r"^detail is .*; give a number of at least 0\.5"):
        function(detail=detail)
