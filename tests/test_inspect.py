import ast
import inspect
import json
import re
from collections import Counter
from html.parser import HTMLParser
from itertools import combinations

import igl
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import meshfair
from broken import TETRAHEDRON, bow_tie, hourglass, moebius_strip, wild_meshes
from meshes import CLOSED, RIGHT_TRIANGLE, fan, grid, soups
from meshfair import MeshError, io, mesh, shapes, weights
from meshfair.mesh.advice import ADVICE
from meshfair.mesh.findings import KINDS

NOTHING = dict.fromkeys(KINDS, 0)


def counts(V, F):
    """What is found, without zeros."""
    return {kind: count for kind, count in mesh.inspect(V, F).counts.items() if count}


def joined_groups(items, are_joined):
    """Number of groups that items fall into, by joining pairs: the definition, slowly."""
    group = {item: {item} for item in items}
    for a, b in combinations(items, 2):
        if are_joined(a, b) and group[a] is not group[b]:
            group[a] |= group[b]
            for item in group[b]:
                group[item] = group[a]
    return len({id(members) for members in group.values()})


def by_definition(V, F):
    """The findings that are combinatorial, each from its own definition."""
    found = {}
    keys = [tuple(sorted(face)) for face in F.tolist()]
    found["duplicate_faces"] = [k for k, key in enumerate(keys) if key in keys[:k]]
    places = [tuple(row) for row in V.tolist()]
    used = sorted(set(F.ravel().tolist()))
    found["unreferenced_vertices"] = sorted(set(range(len(V))) - set(used))
    found["duplicate_vertices"] = [
        v for k, v in enumerate(used) if places[v] in [places[u] for u in used[:k]]
    ]
    proper = [face for face in F.tolist() if len(set(face)) == 3]
    directed = Counter(side for a, b, c in proper for side in ((a, b), (b, c), (c, a)))
    sides = {tuple(sorted(side)) for side in directed}
    faces_of_edge = {(i, j): directed[i, j] + directed[j, i] for i, j in sides}
    found["boundary_edges"] = sorted(e for e, k in faces_of_edge.items() if k == 1)
    found["nonmanifold_edges"] = sorted(e for e, k in faces_of_edge.items() if k > 2)
    found["inconsistent_edges"] = sorted(
        (i, j) for (i, j), k in faces_of_edge.items() if k == 2 and directed[i, j] != 1
    )
    found["nonmanifold_vertices"] = [
        v
        for v in used
        if joined_groups(
            [k for k, face in enumerate(proper) if v in face],
            lambda a, b, v=v: len(({*proper[a]} & {*proper[b]}) - {v}) > 0,
        )
        > 1
    ]
    return found


@settings(max_examples=150)
@given(wild_meshes())
def test_findings_are_those_of_the_definitions(wild):
    V, F = wild
    found = {finding.kind: finding.where.tolist() for finding in mesh.inspect(V, F).findings}
    for kind, expected in by_definition(V, F).items():
        assert found.get(kind, []) == [list(x) if isinstance(x, tuple) else x for x in expected], (
            kind
        )


@settings(max_examples=100)
@given(wild_meshes())
def test_an_inspection_of_anything_can_be_shown_and_stored(wild):
    inspection = mesh.inspect(*wild)
    again = json.loads(json.dumps(inspection.as_dict(), allow_nan=False))
    assert again["counts"] == inspection.counts
    assert set(again["counts"]) == set(KINDS)
    assert [finding["count"] for finding in again["findings"]] == [
        len(finding.where) for finding in inspection.findings
    ]
    text = " ".join(str(inspection).split())  # however its lines are broken
    for finding in inspection.findings:
        assert str(finding) in text
        for words in ADVICE[finding.kind]:
            assert words in text
    assert inspection.ok == ("no problems found" in text)


@given(soups())
def test_negative_weights_are_those_of_the_weights(soup):
    V, F = soup
    inspection = mesh.inspect(V, F)
    W = weights.cotangent(V, F)
    assert inspection.counts["negative_weights"] == np.sum(W.data < -1e-10) / 2
    assert inspection.negative_weights == pytest.approx((W.data < -1e-10).mean())


def test_duplicate_faces_do_not_change_the_negative_weights():
    V, F = shapes.knot()
    twice = np.concatenate([F, F[::2, ::-1]])
    once = mesh.inspect(V, F)
    assert once.counts["negative_weights"] > 1000
    assert mesh.inspect(V, twice).negative_weights == once.negative_weights


@pytest.mark.parametrize(
    ("name", "genus", "pieces"), [("knot", 1, 1), ("sphere", 0, 1), ("torus", 1, 1), ("box", 0, 1)]
)
def test_closed_shapes(name, genus, pieces):
    V, F = CLOSED[name]()
    inspection = mesh.inspect(V, F)
    assert inspection.ok
    assert inspection.closed
    assert inspection.manifold
    assert inspection.orientable
    assert (inspection.genus, inspection.components) == (genus, pieces)
    assert inspection.boundary_loops == 0
    assert inspection.euler_characteristic == 2 - 2 * genus == igl.euler_characteristic(F)
    assert inspection.mean_edge_length == pytest.approx(mesh.mean_edge_length(V, F))
    assert inspection.area == pytest.approx(mesh.area(V, F))


def test_genus_and_loops_over_several_components():
    V, F = shapes.torus(sections=20, sides=10)
    X, T = shapes.icosphere(2)
    # A torus without one face, a whole one, and a sphere with two holes far apart.
    far = next(k for k in range(1, len(T)) if not set(T[k]) & set(T[0]))
    faces = np.concatenate([F[1:], F + len(V), np.delete(T, [0, far], axis=0) + 2 * len(V)])
    inspection = mesh.inspect(np.concatenate([V, V + 9, X - 9]), faces)
    assert inspection.components == 3
    assert inspection.boundary_loops == 3
    assert inspection.genus == 2
    assert not inspection.closed


def test_right_triangle_by_hand():
    inspection = mesh.inspect(*RIGHT_TRIANGLE)
    assert inspection.smallest_angle == pytest.approx(45)
    assert inspection.largest_angle == pytest.approx(90)
    assert inspection.size == (1, 1, 0)
    assert inspection.area == 0.5
    assert inspection.counts == NOTHING | {"boundary_edges": 3}
    assert inspection.boundary_loops == 1
    assert inspection.genus == 0


def test_angles_are_libigls(rng):
    V, F = shapes.icosphere(3)
    V = V + 0.02 * rng.standard_normal(V.shape)
    angles = np.degrees(igl.internal_angles(V, F))
    inspection = mesh.inspect(V, F)
    assert inspection.smallest_angle == pytest.approx(angles.min(), rel=1e-10)
    assert inspection.largest_angle == pytest.approx(angles.max(), rel=1e-10)


def test_a_book_of_three_pages():
    V, F = fan(3)
    assert counts(V, F) == {"nonmanifold_edges": 1, "boundary_edges": 6}
    inspection = mesh.inspect(V, F)
    assert not inspection.ok
    assert not inspection.manifold
    assert inspection.genus is None


def test_a_bow_tie():
    V, F = bow_tie()
    inspection = mesh.inspect(V, F)
    assert counts(V, F) == {"nonmanifold_vertices": 1, "boundary_edges": 6}
    assert inspection.findings[0].where.tolist() == [2]
    assert inspection.boundary_loops == 2  # the surface only touches itself there
    assert inspection.components == 1


def test_an_hourglass_is_closed_and_still_not_manifold():
    V, F = hourglass()
    inspection = mesh.inspect(V, F)
    assert inspection.closed
    assert not inspection.manifold
    assert inspection.counts == NOTHING | {"nonmanifold_vertices": 1}
    assert not igl.is_vertex_manifold(F)[0]


def test_a_moebius_strip():
    V, F = moebius_strip()
    inspection = mesh.inspect(V, F)
    assert not inspection.orientable
    assert inspection.manifold
    assert inspection.genus is None
    assert inspection.boundary_loops == 1
    assert inspection.counts["inconsistent_edges"] >= 1
    assert inspection.counts["nonorientable_faces"] == len(F)
    # Indices are those of the faces as they were given, whatever was left out before.
    shifted = mesh.inspect(V, np.concatenate([[[0, 0, 1]], F])).findings
    (found,) = (found.where for found in shifted if found.kind == "nonorientable_faces")
    assert found.tolist() == list(range(1, len(F) + 1))


def test_a_flipped_face():
    V, F = shapes.icosphere(1)
    F[7] = F[7, ::-1]
    inspection = mesh.inspect(V, F)
    assert inspection.orientable
    assert counts(V, F) == {"inconsistent_edges": 3}
    flipped = {tuple(sorted(pair)) for pair in combinations(F[7].tolist(), 2)}
    assert {tuple(edge) for edge in inspection.findings[0].where.tolist()} == flipped


def test_components_inside_out():
    V, F = shapes.icosphere(1)
    # The second sphere looks inwards; the third does too, but is open.
    faces = np.concatenate([F, F[:, ::-1] + len(V), F[1:, ::-1] + 2 * len(V)])
    inspection = mesh.inspect(np.concatenate([V, V + 5, V + 10]), faces)
    inward = [found for found in inspection.findings if found.kind == "inward_components"]
    assert [found.where.tolist() for found in inward] == [[1]]
    assert inspection.ok  # it could be a cavity
    # Where neighbours disagree there is no inside.
    F[0] = F[0, ::-1]
    assert counts(V, F[:, ::-1]) == {"inconsistent_edges": 3}


def test_vertices_and_faces_in_the_same_place():
    V, F = TETRAHEDRON
    soup = V[F].reshape(-1, 3)
    assert counts(soup, np.arange(12).reshape(4, 3)) == {
        "duplicate_vertices": 8,
        "boundary_edges": 12,
    }
    twice = np.concatenate([F, F[1:2, ::-1]])
    found = {finding.kind: finding.where for finding in mesh.inspect(V, twice).findings}
    assert found["duplicate_faces"].tolist() == [4]
    assert len(found["nonmanifold_edges"]) == 3


def test_degenerate_faces_and_slivers():
    V = np.array([[0.0, 0, 0], [1, 0, 0], [0.5, 1, 0], [2, 0, 0], [0.5, -0.005, 0]])
    F = np.array([[0, 1, 2], [0, 1, 3], [1, 1, 2], [1, 0, 4]])
    found = {finding.kind: finding.where.tolist() for finding in mesh.inspect(V, F).findings}
    assert found["degenerate_faces"] == [1, 2]
    assert found["sliver_faces"] == [3]  # atan(0.005 / 0.5) is 0.57 degrees
    # A sliver of just above one degree is none.
    V[4, 1] = -0.5 * np.tan(np.radians(1.001))
    assert "sliver_faces" not in counts(V, F)


def test_nothing_but_topologically_degenerate_faces():
    inspection = mesh.inspect(np.zeros((3, 3)), [[0, 0, 0], [1, 1, 2]])
    assert inspection.smallest_angle is None
    assert inspection.edges == 0
    assert "all faces are degenerate" in str(inspection)
    json.dumps(inspection.as_dict(), allow_nan=False)


@given(st.randoms(use_true_random=False))
def test_the_order_of_vertices_and_faces_does_not_matter(random):
    V, F = bow_tie()
    X, T = moebius_strip()
    V, F = np.concatenate([V, X + 3]), np.concatenate([F, F[:1], T + len(V)])
    order = random.sample(range(len(V)), len(V))
    new = np.argsort(order)
    shuffled = np.array(random.sample(new[F].tolist(), len(F)))
    one, other = mesh.inspect(V, F), mesh.inspect(V[order], shuffled)
    assert one.counts == other.counts
    for name in ("components", "boundary_loops", "euler_characteristic", "orientable", "edges"):
        assert getattr(one, name) == getattr(other, name)


@pytest.mark.parametrize(
    ("V", "F"), [(np.eye(3), [[0, 1, 3]]), (np.full((3, 3), np.nan), [[0, 1, 2]])]
)
def test_no_mesh_is_refused(V, F):
    with pytest.raises(MeshError):
        mesh.inspect(V, F)


def test_the_input_is_left_alone():
    V, F = moebius_strip()
    kept = V.copy(), F.copy()
    mesh.inspect(V, F)
    assert np.array_equal(V, kept[0])
    assert np.array_equal(F, kept[1])


class Tags(HTMLParser):
    """Collects texts, and checks that every tag that opens is closed in order."""

    def __init__(self):
        super().__init__()
        self.open, self.text, self.styles = [], "", []

    def handle_starttag(self, tag, attributes):
        self.open.append(tag)
        self.styles += [value for name, value in attributes if name == "style"]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


def test_html_is_whole_and_takes_the_colours_of_its_page():
    page = Tags()
    inspection = mesh.inspect(*moebius_strip())
    page.feed(inspection._repr_html_())
    assert page.open == []
    for finding in inspection.findings:
        assert str(finding) in page.text
        assert ADVICE[finding.kind].affects in page.text
        assert ADVICE[finding.kind].remedy in page.text
    # No colour of its own for text or ground, so it can be read in any theme.
    for style in page.styles:
        rules = dict(rule.split(":") for rule in style.replace(" ", "").split(";"))
        assert rules.get("color", "inherit") == "inherit"
        assert rules.get("background", "transparent") == "transparent"
        assert "background-color" not in rules


def test_there_is_advice_on_each_kind():
    assert list(ADVICE) == list(KINDS)


NAMED = sorted(
    {name for advice in ADVICE.values() for name in re.findall(r"\w+\.\w+", str(advice))}
)


@pytest.mark.parametrize("name", NAMED)
def test_what_the_advice_names_exists(name):
    module, function = name.split(".")
    assert module in meshfair.__all__
    assert callable(getattr(getattr(meshfair, module), function))


def test_the_calls_that_are_advised_fit_their_functions():
    texts = [text for advice in ADVICE.values() for text in advice]
    calls = [ast.parse(call).body[0].value for call in re.findall(r"\w+\.\w+\([^)]*\)", str(texts))]
    assert len(calls) >= 8  # of mesh.repair, weights.cotangent and mesh.boundary_vertices
    for call in calls:
        function = getattr(getattr(meshfair, call.func.value.id), call.func.attr)
        options = {word.arg: ast.literal_eval(word.value) for word in call.keywords}
        inspect.signature(function).bind(*call.args, **options)


REAL = {  # shared/data/README.md
    "KnotMesh.ply": (1440, 2880, {"boundary_edges": 0, "nonmanifold_edges": 0}),
    "f16.ply": (
        2537,
        4428,
        {"boundary_edges": 742, "nonmanifold_edges": 56, "duplicate_faces": 44},
    ),
    "stanford-bunny.obj": (35947, 69451, {"boundary_edges": 223, "unreferenced_vertices": 1113}),
}


@pytest.mark.parametrize(("file", "expected"), REAL.items(), ids=REAL)
def test_real_meshes_are_what_their_page_says(mirror, file, expected):
    V, F = io.read(mirror / file)
    vertices, faces, found = expected
    inspection = mesh.inspect(V, F)
    assert (inspection.vertices, inspection.faces) == (vertices, faces)
    assert found.items() <= inspection.counts.items()
    assert inspection.components == (9 if file == "f16.ply" else 1)


def test_a_mesh_reduced_by_clustering_is_broken_as_the_original_report_found(mirror):
    V, F = io.read(mirror / "stanford-bunny.obj")
    X, T = mesh.cluster(V, F, 1.49055)
    inspection = mesh.inspect(X, T)
    # Open3D's clustering: 13,572 vertices, 104 non-manifold edges, 57 duplicate faces.
    assert inspection.vertices == pytest.approx(13572, abs=5)
    assert inspection.counts["nonmanifold_edges"] == pytest.approx(104, abs=5)
    assert inspection.counts["duplicate_faces"] == pytest.approx(57, abs=5)


def test_cluster_by_hand():
    # A strip of two squares one wide; cells of two fuse the four left vertices.
    V, F = grid(2)
    cell = 1.9 / mesh.mean_edge_length(V, F)
    X, T = mesh.cluster(V, F, cell)
    # Cells start at -0.95: 0 falls into the first, 1 and 2 into the second.
    np.testing.assert_allclose(X, [[0, 0, 0], [0, 1.5, 0], [1.5, 0, 0], [1.5, 1.5, 0]])
    assert {tuple(sorted(face)) for face in T.tolist()} == {(0, 2, 3), (0, 1, 3)}


def test_cluster_with_small_cells_only_sorts_the_vertices():
    V, F = shapes.icosphere(2)
    X, T = mesh.cluster(V, F, 1e-3)
    assert len(X) == len(V)
    assert len(T) == len(F)
    assert mesh.inspect(X, T).ok
    assert mesh.volume(X, T) == pytest.approx(mesh.volume(V, F))


@pytest.mark.parametrize("cell", [0, -1, np.nan, 1e6])
def test_cluster_refuses_cells_that_leave_no_mesh(cell):
    with pytest.raises(ValueError, match="cell"):
        mesh.cluster(*shapes.icosphere(1), cell)
