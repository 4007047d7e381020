"""The facts of a mesh; `inspect` and `cluster` are in test_inspect, `repair` in test_repair."""

from itertools import combinations

import igl
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from broken import TETRAHEDRON, bow_tie, hourglass, wild_meshes
from fast import both
from meshes import CLOSED, RIGHT_TRIANGLE, fan, grid, rigid_motions
from meshfair import MeshError, mesh, operators, shapes, weights
from meshfair.flow import heat
from meshfair.mesh.duplicates import first_equal


def edges_by_loop(F):
    """How many of the faces, each taken once, have each edge: the definition, slowly."""
    count = {}
    for face in {tuple(sorted(face)) for face in F.tolist()}:
        sides = [(i, j) for i, j in combinations(face, 2) if i != j]
        for side in sides:
            count[side] = count.get(side, 0) + 1
    return count


@given(wild_meshes())
def test_edges_are_those_of_the_definition(wild):
    _, F = wild
    expected = edges_by_loop(F)
    if not expected:
        F = np.concatenate([F, [[0, 1, 2]]])
        expected = edges_by_loop(F)
    edges = mesh.Edges(F)
    E, faces_of_edge = edges.ends, edges.faces_of_edge
    assert {
        tuple(e): k for e, k in zip(E.tolist(), faces_of_edge.tolist(), strict=True)
    } == expected
    assert np.all(E[:, 0] < E[:, 1])
    assert E.tolist() == sorted(E.tolist())


@given(wild_meshes())
def test_half_edges_are_grouped_by_the_edge_they_lie_on(wild):
    _, F = wild
    grouped = mesh.Edges.of_all(F, F.max() + 1)
    H = np.sort(mesh.half_edges(F), axis=1)
    assert np.array_equal(H[grouped.half_edges], grouped.ends[grouped.of_half_edge])
    assert sorted(grouped.half_edges) == np.flatnonzero(H[:, 0] != H[:, 1]).tolist()


@given(
    st.lists(st.tuples(*[st.sampled_from([0.0, -0.0, 1.0, 1e-300, -2.5])] * 3), max_size=20),
    st.booleans(),
)
def test_duplicate_rows_point_to_the_first_of_their_kind(rows, integers):
    expected = [rows.index(row) for row in rows]  # 0.0 == -0.0
    array = np.array(rows).reshape(-1, 3)
    if integers:
        array = (2 * array).astype(np.int64)
        expected = [array.tolist().index(row) for row in array.tolist()]
    assert first_equal(array).tolist() == expected


def test_duplicate_rows_are_found_where_only_the_high_bits_differ(rng):
    # Whole numbers have no low bits in float64, which a poor hash would multiply into ties.
    rows = rng.integers(0, 12, (5000, 3)).astype(float)
    _, first, group = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    assert np.array_equal(first_equal(rows), first[group])


def test_unique_faces_keeps_the_first_whatever_the_orientation():
    F = [[0, 1, 2], [3, 1, 2], [2, 1, 0], [1, 2, 0], [1, 3, 2], [0, 1, 3]]
    assert mesh.unique_faces(F).tolist() == [[0, 1, 2], [3, 1, 2], [0, 1, 3]]


@pytest.mark.parametrize("make", CLOSED.values(), ids=CLOSED)
def test_built_in_shapes_are_closed(make):
    _, F = make()
    assert mesh.is_closed(F)
    assert not mesh.is_closed(F[1:])
    assert len(mesh.boundary_edges(F)) == 0
    assert mesh.boundary_edges(F[1:]).tolist() == sorted(
        sorted(e) for e in (F[0, [0, 1]].tolist(), F[0, [1, 2]].tolist(), F[0, [2, 0]].tolist())
    )


def test_components_leave_unused_vertices_out():
    F = np.array([[5, 1, 0], [2, 6, 4]])
    count, labels = mesh.components(F, 8)
    assert count == 2
    assert labels.tolist() == [0, 0, 1, -1, 1, 0, 1, -1]


@given(wild_meshes())
def test_components_are_libigls(wild):
    V, F = wild
    count, labels = mesh.components(F, len(V))
    theirs = igl.vertex_components(F)
    used = np.unique(F)
    assert len(set(theirs[used])) == count == labels.max() + 1
    assert len({*zip(theirs[used], labels[used], strict=True)}) == count
    assert set(np.flatnonzero(labels < 0)) == set(range(len(V))) - set(used)


def test_tetrahedron_by_hand():
    V, F = TETRAHEDRON
    assert mesh.area(V, F) == pytest.approx(1.5 + np.sqrt(3) / 2)
    assert mesh.volume(V, F) == pytest.approx(1 / 6)
    assert mesh.volume(V, F[:, ::-1]) == pytest.approx(-1 / 6)
    np.testing.assert_allclose(mesh.face_normals(V, F)[3], np.full(3, 3**-0.5))
    assert mesh.mean_edge_length(V, F) == pytest.approx((3 + 3 * np.sqrt(2)) / 6)
    # At the origin the three right triangles' area vectors sum to -(1, 1, 1) / 2.
    np.testing.assert_allclose(mesh.vertex_normals(V, F)[0], np.full(3, -(3**-0.5)))


@pytest.mark.parametrize("make", CLOSED.values(), ids=CLOSED)
def test_areas_normals_and_volume_are_libigls(make):
    V, F = make()
    np.testing.assert_allclose(mesh.face_areas(V, F), igl.doublearea(V, F) / 2, rtol=1e-12)
    np.testing.assert_allclose(
        mesh.face_normals(V, F), igl.per_face_normals(V, F, np.zeros(3)), atol=1e-12
    )
    area_weighted = igl.per_vertex_normals(V, F, igl.PER_VERTEX_NORMALS_WEIGHTING_TYPE_AREA)
    np.testing.assert_allclose(mesh.vertex_normals(V, F), area_weighted, atol=1e-12)
    assert mesh.volume(V, F) == pytest.approx(igl.centroid(V, F)[1], rel=1e-10)


@given(rigid_motions())
def test_measures_do_not_depend_on_where_the_mesh_lies(motion):
    rotation, shift = motion
    V, F = shapes.box(size=(1, 2, 3), segments=2)
    X = V @ rotation.T + 1e3 * shift
    assert mesh.volume(X, F) == pytest.approx(6, rel=1e-9)
    assert mesh.area(X, F) == pytest.approx(22, rel=1e-9)
    np.testing.assert_allclose(
        mesh.face_normals(X, F), mesh.face_normals(V, F) @ rotation.T, atol=1e-9
    )


def test_scatter_sums_at_the_corners():
    F = np.array([[0, 1, 2], [0, 2, 3]])
    assert mesh.scatter(np.array([1.0, 10.0]), F, 5).tolist() == [11, 1, 11, 10, 0]


@pytest.mark.parametrize("unit", [1e-70, 1.0, 1e70])
def test_degenerate_faces_do_not_depend_on_the_unit(unit):
    V = unit * np.array(
        [[0.0, 0, 0], [1, 0, 0], [0, 1e-11, 0], [2, 0, 0], [1, 0, 0], [0, 1e-13, 0]]
    )
    F = [[0, 1, 2], [0, 1, 3], [1, 4, 2], [1, 1, 2], [0, 1, 5]]
    assert mesh.degenerate_faces(V, F).tolist() == [False, True, True, True, True]


PLACES = [(448250.0, 5411940.0, 212.0), (-4.4e8, 5.4e9, 2.1e5), (0.0, 0.0, 4.2e7)]


@given(
    st.sampled_from(PLACES),
    hnp.arrays(float, 3, elements=st.floats(-1, 1)),
    hnp.arrays(float, 3, elements=st.floats(-1, 1)),
    st.floats(0, 1),
)
def test_three_points_on_a_line_are_degenerate_wherever_they_lie(place, a, b, t):
    assume(np.linalg.norm(a - b) > 0.1)
    V = np.array([a, b, (1 - t) * a + t * b]) + place
    assert mesh.degenerate_faces(V, [[0, 1, 2]]).all()
    # ... and a triangle ten times as high as rounding at that place is none.
    side = np.linalg.norm(np.cross(b - a, [0.3, 0.5, 0.8]))
    assume(side > 0.1)
    up = np.cross(b - a, [0.3, 0.5, 0.8]) / side
    V[2] += up * 10 * 4 * np.finfo(float).eps * np.abs(V).max()
    assert not mesh.degenerate_faces(V, [[0, 1, 2]]).any()


def test_flatness_is_the_height_over_the_longest_edge():
    V = [[0.0, 0, 0], [4, 0, 0], [1, 1, 0], [1, 1, 0]]
    T = mesh.Triangles(V, [[0, 1, 2], [2, 2, 3], [0, 1, 1]])
    assert T.flatness.tolist() == [0.25, 0, 0]


def test_cotangents_of_a_right_triangle():
    V, F = RIGHT_TRIANGLE
    np.testing.assert_allclose(mesh.Triangles(V, F).cotangents, [[0.0], [1.0], [1.0]], atol=1e-15)


def test_a_mesh_without_edges_has_no_mean_edge_length():
    with pytest.raises(MeshError, match="no edge"):
        mesh.mean_edge_length(np.eye(3), [[1, 1, 1]])


def test_boundary_of_a_grid():
    _, F = grid(3)
    expected = [k for k in range(16) if k // 4 in (0, 3) or k % 4 in (0, 3)]
    assert mesh.boundary_vertices(F).tolist() == expected
    assert len(mesh.boundary_edges(F)) == 12
    theirs = {tuple(sorted(e)) for e in igl.boundary_facets(F)[0].tolist()}
    assert {tuple(e) for e in mesh.boundary_edges(F).tolist()} == theirs


def test_a_duplicate_face_does_not_hide_the_boundary():
    _, F = grid(2)
    twice = np.concatenate([F, F[:, [1, 0, 2]]])
    assert np.array_equal(mesh.boundary_edges(twice), mesh.boundary_edges(F))


def test_a_fixed_boundary_stays_and_the_rest_moves(rng):
    V, F = grid(5)
    V = V + 0.1 * rng.standard_normal(V.shape)
    rim = mesh.boundary_vertices(F)
    A = operators.averaging(weights.combinatorial(F, len(V)))
    *_, (_, X) = heat(V, A, 0.5, 2, fixed=rim)
    assert np.array_equal(X[rim], V[rim])
    inside = np.setdiff1d(np.arange(len(V)), rim)
    assert np.all(np.any(X[inside] != V[inside], axis=1))


@pytest.mark.parametrize("make", [bow_tie, hourglass, lambda: fan(3)])
def test_broken_meshes_have_finite_measures(make):
    V, F = make()
    assert np.isfinite(mesh.vertex_normals(V, F)).all()
    assert mesh.area(V, F) > 0


def test_interior_edges_by_hand():
    # Two right triangles on a diagonal, the second one folded up by 90 degrees, and a third
    # face on the edge (0, 1), which has one face otherwise.
    V = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]])
    F = np.array([[0, 1, 2], [0, 2, 3]])
    H = mesh.interior_edges(F)
    assert H.corners.tolist() == [[0, 1, 2, 3]]
    assert H.ends.tolist() == [[0, 2]]
    assert H.faces.tolist() == [[0, 1]]
    np.testing.assert_allclose(mesh.dihedral_angles(V, H), [np.pi / 2])
    # An edge with a third face is no interior edge any more.
    assert len(mesh.interior_edges(np.array([[0, 1, 2], [0, 2, 3], [2, 0, 4]])).faces) == 0


def test_dihedral_angles_of_a_box_are_flat_or_right():
    V, F = shapes.box(segments=(2, 3, 4))
    H = mesh.interior_edges(F)
    assert len(H.faces) == len(mesh.Edges(F))  # closed: each edge has two faces
    angles = np.degrees(mesh.dihedral_angles(V, H))
    on_rim = np.isclose(angles, 90)
    np.testing.assert_allclose(angles[~on_rim], 0, atol=1e-6)
    assert on_rim.sum() == 4 * (2 + 3 + 4)  # the segments of the box's twelve edges
    # Each quadruple's faces are the two triangles on their edge.
    p1, p2, p3, p4 = H.corners.T
    for tips, face in ((p2, H.faces[:, 0]), (p4, H.faces[:, 1])):
        np.testing.assert_array_equal(
            np.sort(F[face], axis=1), np.sort(np.stack([p1, p3, tips], axis=1), axis=1)
        )


# --- numbering ----------------------------------------------------------------------------


def mixed(V, F, rng):
    """The same mesh with its vertices in a random order."""
    order = rng.permutation(len(V))
    return V[order], np.argsort(order)[F]


def test_a_reordered_mesh_is_the_same_mesh(rng):
    V, F = mixed(*shapes.torus(sections=40, sides=20), rng)
    for V_near, F_near, order in both(lambda: mesh.reorder(V, F)):
        np.testing.assert_array_equal(V_near[F_near], V[F])  # corner by corner
        np.testing.assert_array_equal(np.sort(order), np.arange(len(V)))
        np.testing.assert_array_equal(mesh.restore_order(V_near, order), V)
        assert F_near.dtype == order.dtype == np.int64
        # Neighbours are near: breadth-first, an edge spans two levels at most. On a torus
        # around which a level is two circles of 20 to 40 vertices, that is far below the
        # third of all 800 by which two random vertices differ.
        span = np.abs(np.diff(mesh.Edges(F_near).ends, axis=1)).mean()
        assert span < 80 < np.abs(np.diff(mesh.Edges(F).ends, axis=1)).mean()


def test_every_component_is_numbered_from_its_lowest_vertex():
    V, F = np.zeros((11, 3)), [[3, 4, 5], [0, 1, 9]]
    for _, _, order in both(lambda: mesh.reorder(V, F)):
        assert order.tolist() == [0, 1, 9, 2, 3, 4, 5, 6, 7, 8, 10]


@given(wild_meshes())
def test_both_forms_number_alike(wild):
    plain, compiled = both(lambda: mesh.reorder(*wild))
    for one, other in zip(plain, compiled, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("columns", [(3,), (), (1, 2)])
def test_values_of_vertices_are_put_back(rng, columns):
    X = rng.standard_normal((500, *columns))
    order = rng.permutation(len(X))
    np.testing.assert_array_equal(mesh.restore_order(X[order], order), X)
    np.testing.assert_array_equal(mesh.restore_order(np.asfortranarray(X[order]), order), X)
    names = np.array(["a", "b", "c"])
    assert mesh.restore_order(names, [2, 0, 1]).tolist() == ["b", "c", "a"]


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
        mesh.restore_order(np.zeros((3, 3)), order)
