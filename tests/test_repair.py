import igl
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from broken import TETRAHEDRON, bow_tie, hourglass, moebius_strip, wild_meshes
from meshes import CLOSED, fan, grid
from meshfair import MeshError, io, mesh, shapes

EVERYTHING = {
    "weld": 0,
    "degenerate": True,
    "duplicates": True,
    "split": True,
    "orient": "outward",
    "unreferenced": True,
}


def soup_of(V, F):
    """Every triangle with three vertices of its own, as an STL file has them."""
    return V[F].reshape(-1, 3), np.arange(3 * len(F)).reshape(-1, 3)


def as_set(F):
    """Faces whatever their order and where they start, but with their orientation."""
    return {tuple(np.roll(face, -face.argmin()).tolist()) for face in np.asarray(F)}


@given(wild_meshes())
def test_nothing_is_done_unasked(wild):
    V, F = wild
    repaired = mesh.repair(V, F)
    assert np.array_equal(repaired.V, V)
    assert np.array_equal(repaired.F, F)
    assert np.array_equal(repaired.vertex_map, np.arange(len(V)))
    assert repaired.report == ()


wishes = st.fixed_dictionaries(
    {
        "weld": st.sampled_from([None, 0, 0.1]),
        "degenerate": st.booleans(),
        "duplicates": st.booleans(),
        "split": st.booleans(),
        "orient": st.sampled_from([None, "consistent", "outward"]),
        "unreferenced": st.booleans(),
    }
)


@settings(max_examples=200)
@given(wild_meshes(), wishes)
def test_what_was_asked_for_holds_and_positions_carry_over(wild, wish):
    V, F = wild
    kept = V.copy(), F.copy()
    # With a distance to measure, or with faces to drop, there must be a face left.
    edgeless = wish["weld"] and np.all(F == F[:, :1])
    if edgeless or (wish["degenerate"] and mesh.degenerate_faces(V, F).all()):
        with pytest.raises(MeshError, match=r"would leave no mesh|no edge at all"):
            mesh.repair(V, F, **wish)
        return
    try:
        repaired = mesh.repair(V, F, **wish)
    except MeshError:
        assume(not wish["weld"] or not wish["degenerate"])  # welding made the last faces collapse
        raise
    assert np.array_equal(V, kept[0])  # the input is never written to
    assert np.array_equal(F, kept[1])
    assert np.array_equal(repaired.V, V[repaired.vertex_map])
    assert repaired.F.min() >= 0
    assert repaired.F.max() < len(repaired.V)
    asked = [name for name in EVERYTHING if wish[name] is not None and wish[name] is not False]
    assert [step.name for step in repaired.report] == asked

    found = mesh.inspect(repaired.V, repaired.F).counts
    if wish["degenerate"]:
        assert found["degenerate_faces"] == 0
    if wish["duplicates"]:
        assert found["duplicate_faces"] == 0
    if wish["orient"]:
        assert (found["inconsistent_edges"] > 0) <= (found["nonorientable_faces"] > 0)
    if wish["split"]:
        proper = repaired.F[[len(set(face)) == 3 for face in repaired.F.tolist()]]
        if len(proper):
            assert igl.is_edge_manifold(proper)[0]
            assert np.all(igl.is_vertex_manifold(proper)[np.unique(proper)])
        assert found["nonmanifold_edges"] == found["nonmanifold_vertices"] == 0
    elif wish["weld"] is not None:
        used = np.unique(repaired.F)
        assert len(np.unique(repaired.V[used], axis=0)) == len(used)
    if wish["unreferenced"]:
        assert found["unreferenced_vertices"] == 0
    # Faces are dropped or flipped, never moved or made.
    ours = {tuple(sorted(map(tuple, (repaired.V + 0)[face].tolist()))) for face in repaired.F}
    theirs = {tuple(sorted(map(tuple, (V + 0)[face].tolist()))) for face in F}
    if wish["weld"] in (None, 0):
        assert ours <= theirs


@settings(max_examples=100)
@given(wild_meshes())
def test_repairing_twice_is_repairing_once(wild):
    try:
        once = mesh.repair(*wild, **EVERYTHING | {"weld": None})
    except MeshError:
        return
    twice = mesh.repair(once.V, once.F, **EVERYTHING | {"weld": None})
    assert np.array_equal(twice.F, once.F)
    assert all(step.changed == 0 for step in twice.report)


def test_what_is_closed_once_a_fin_is_cut_off_is_oriented_outward():
    V, F = TETRAHEDRON
    V = np.concatenate([V, [[9.0, 9, 9]]])
    inside_out = F if mesh.volume(V[:4], F) < 0 else F[:, ::-1]
    fin = [[F[0, 0], F[0, 1], 4]]  # a third face on an edge of it
    repaired = mesh.repair(V, np.concatenate([inside_out, fin]), split=True, orient="outward")
    body = repaired.F[:4]
    assert mesh.is_closed(body)
    assert mesh.volume(repaired.V, body) > 0


@pytest.mark.parametrize("make", CLOSED.values(), ids=CLOSED)
def test_a_sound_mesh_is_left_as_it_is(make):
    V, F = make()
    repaired = mesh.repair(V, F, **EVERYTHING)
    assert np.array_equal(repaired.V, V)
    assert np.array_equal(repaired.F, F)
    assert [step.changed for step in repaired.report] == [0] * 6


@pytest.mark.parametrize("make", CLOSED.values(), ids=CLOSED)
@pytest.mark.parametrize("weld", [0, 1e-3])
def test_welding_gives_a_soup_its_mesh_back(make, weld):
    V, F = make()
    repaired = mesh.repair(*soup_of(V, F), weld=weld)
    assert len(repaired.V) == len(V)
    assert mesh.is_closed(repaired.F)
    np.testing.assert_array_equal(repaired.V[repaired.F], V[F])
    assert repaired.report[0].changed == 3 * len(F) - len(V)


def test_welding_within_a_distance_by_hand():
    # Edges of length 1 on a line; vertices 4 and 5 are 0.01 from 0 and from 4.
    V = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0.01, 0, 0], [0.02, 0, 0]])
    F = np.array([[0, 1, 2], [4, 3, 1], [5, 2, 3]])
    unit = mesh.mean_edge_length(V, F)
    apart = mesh.repair(V, F, weld=0.009 / unit)
    assert np.array_equal(apart.F, F)
    near = mesh.repair(V, F, weld=0.011 / unit)
    assert near.vertex_map.tolist() == [0, 1, 2, 3]  # the chain 0, 4, 5 becomes 0, in its place
    assert near.F.tolist() == [[0, 1, 2], [0, 3, 1], [0, 2, 3]]
    assert near.report[0].message.startswith("welded 2 vertices")


@given(st.randoms(use_true_random=False))
def test_welding_is_libigls(random):
    rng = np.random.default_rng(random.getrandbits(32))
    V = rng.integers(0, 3, (30, 3)) / 2 + 1.0
    F = rng.integers(0, 30, (10, 3))
    F[0] = [0, 1, 2]
    _, index, _, _ = igl.remove_duplicate_vertices(V, F, 1e-7)
    repaired = mesh.repair(V, F, weld=0)
    assert len(repaired.V) == len(index)
    assert {*map(tuple, repaired.V)} == {*map(tuple, V[index])}


def test_a_welding_distance_that_joins_everything_is_refused(rng):
    V = np.concatenate([0.001 * rng.random((500, 3)), [[0, 0, 0], [9, 0, 0], [0, 9, 0]]])
    with pytest.raises(MeshError, match="smaller weld"):
        mesh.repair(V, [[500, 501, 502]], weld=0.1)


def test_degenerate_and_duplicate_faces_are_dropped():
    V = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]])
    F = np.array([[0, 1, 2], [0, 1, 3], [1, 1, 2], [2, 1, 0], [1, 3, 2]])
    repaired = mesh.repair(V, F, degenerate=True, duplicates=True)
    assert repaired.F.tolist() == [[0, 1, 2], [1, 3, 2]]
    assert [(step.name, step.changed) for step in repaired.report] == [
        ("degenerate", 2),
        ("duplicates", 1),
    ]
    with pytest.raises(MeshError, match="would leave no mesh"):
        mesh.repair(V, F[1:3], degenerate=True)


def test_the_majority_keeps_its_orientation(rng):
    V, F = shapes.icosphere(2)
    flipped = rng.random(len(F)) < 0.3
    mixed = np.where(flipped[:, None], F[:, [0, 2, 1]], F)
    repaired = mesh.repair(V, mixed, orient="consistent")
    assert as_set(repaired.F) == as_set(F)
    assert repaired.report[0].changed == flipped.sum()
    # Of a sphere that is mostly inwards, "consistent" keeps that and "outward" does not.
    inwards = mesh.repair(V, mixed[:, [0, 2, 1]], orient="consistent")
    assert mesh.volume(inwards.V, inwards.F) < 0
    outwards = mesh.repair(V, mixed[:, [0, 2, 1]], orient="outward")
    assert as_set(outwards.F) == as_set(F)


def test_outward_is_decided_after_neighbours_agree():
    # A spike holds most of the volume; its few faces are flipped, but the majority is right.
    V, F = shapes.icosphere(2)
    spike = np.any(F == 0, axis=1)
    V[0] *= 1000
    mixed = np.where(spike[:, None], F[:, [0, 2, 1]], F)
    assert mesh.volume(V, mixed) < 0
    assert as_set(mesh.repair(V, mixed, orient="outward").F) == as_set(F)


@pytest.mark.parametrize("make", CLOSED.values(), ids=CLOSED)
def test_outward_is_decided_where_the_welded_vertices_are(make):
    V, F = make()
    soup, T = soup_of(V, F[:, [0, 2, 1]])
    repaired = mesh.repair(soup, T, weld=0, orient="outward")
    assert mesh.volume(repaired.V, repaired.F) == pytest.approx(mesh.volume(V, F))


def test_open_surfaces_keep_the_majority_even_outward():
    V, F = grid(4)
    F[3] = F[3, ::-1]
    for how in ("consistent", "outward"):
        repaired = mesh.repair(V, F, orient=how)
        assert np.all(mesh.face_normals(repaired.V, repaired.F)[:, 2] == 1)


def test_a_nonorientable_surface_is_left_and_reported():
    V, F = moebius_strip()
    repaired = mesh.repair(V, F, orient="outward")
    assert np.array_equal(repaired.F, F)
    assert "non-orientable" in repaired.report[0].message


def test_splitting_by_hand():
    V, F = bow_tie()
    repaired = mesh.repair(V, F, split=True)
    assert repaired.F.tolist() == [[0, 2, 1], [5, 3, 4]]  # the first fan keeps vertex 2
    assert repaired.vertex_map.tolist() == [0, 1, 2, 3, 4, 2]
    V, F = fan(3)
    repaired = mesh.repair(V, F, split=True)
    assert repaired.F.tolist() == [[0, 1, 2], [5, 6, 3], [7, 8, 4]]
    assert repaired.vertex_map[5:].tolist() == [0, 1, 0, 1]


def test_splitting_an_hourglass_gives_two_tetrahedra():
    repaired = mesh.repair(*hourglass(), split=True)
    inspection = mesh.inspect(repaired.V, repaired.F)
    assert inspection.components == 2
    assert inspection.closed
    assert inspection.manifold


def test_a_sheet_that_leaves_through_a_cut_edge_is_sewn_on():
    # Two tetrahedra that share an edge: four faces there, two of each body. Around
    # each end the faces of one body are connected, so both bodies stay closed.
    V, F = TETRAHEDRON
    other = np.array([0, 1, 4, 5])[F]
    V = np.concatenate([V, V[2:] - [0, 1, 1]])
    V[4:] = [[0, -1, 0], [0, 0, -1]]
    repaired = mesh.repair(V, np.concatenate([F, other[:, [0, 2, 1]]]), split=True)
    inspection = mesh.inspect(repaired.V, repaired.F)
    assert inspection.closed
    assert inspection.components == 2
    assert len(repaired.V) == 8


def test_unreferenced_vertices_are_dropped_in_order():
    V, F = TETRAHEDRON
    X = np.concatenate([[[9.0, 9, 9]], V[:2], [[8, 8, 8]], V[2:]])
    repaired = mesh.repair(X, np.array([1, 2, 4, 5])[F], unreferenced=True)
    assert repaired.vertex_map.tolist() == [1, 2, 4, 5]
    assert np.array_equal(repaired.F, F)
    assert repaired.report == (("unreferenced", 2, "dropped 2 vertices without faces"),)


def test_a_box_with_everything_wrong_is_repaired(rng):
    V, F = shapes.box(segments=4)
    X, T = soup_of(V, F)
    flipped = rng.random(len(T)) < 0.2
    T[flipped] = T[flipped][:, ::-1]
    T = np.concatenate([T, T[:9], [[0, 0, 1], [3, 4, 4]]])
    X = np.concatenate([X, rng.random((5, 3))])
    repaired = mesh.repair(X, T, **EVERYTHING)
    inspection = mesh.inspect(repaired.V, repaired.F)
    assert inspection.ok
    assert inspection.closed
    assert (inspection.vertices, inspection.faces) == (len(V), len(F))
    assert mesh.volume(repaired.V, repaired.F) == pytest.approx(1)
    assert [step.changed for step in repaired.report] == [
        3 * len(F) - len(V), 2, 9, 0, flipped.sum(), 5,
    ]  # fmt: skip


@pytest.mark.parametrize(
    "wrong", [{"weld": -1}, {"weld": 2}, {"weld": np.nan}, {"orient": "inward"}, {"orient": True}]
)
def test_wrong_wishes_are_refused(wrong):
    with pytest.raises(ValueError, match=f"^{next(iter(wrong))} is"):
        mesh.repair(*TETRAHEDRON, **wrong)


def test_the_f16_becomes_a_manifold(mirror):
    V, F = io.read(mirror / "f16.ply")
    repaired = mesh.repair(V, F, duplicates=True, orient="consistent", split=True)
    assert len(repaired.F) == 4428 - 44
    assert igl.is_edge_manifold(repaired.F)[0]
    assert np.all(igl.is_vertex_manifold(repaired.F))
    # No face is lost, and none moves.
    corners = {tuple(sorted(map(tuple, V[face].tolist()))) for face in F}
    assert {tuple(sorted(map(tuple, repaired.V[face].tolist()))) for face in repaired.F} == corners
    found = mesh.inspect(repaired.V, repaired.F)
    assert found.manifold
    assert found.counts["inconsistent_edges"] == 0


def test_the_definition_of_oriented_neighbours():
    # After the repair, no directed side is used twice: the definition of orientation.
    V, F = shapes.torus(sections=8, sides=6)
    F[::3] = F[::3, ::-1]
    repaired = mesh.repair(V, F, orient="consistent")
    sides = [(f[a], f[b]) for f in repaired.F.tolist() for a, b in ((0, 1), (1, 2), (2, 0))]
    assert len(set(sides)) == len(sides)
