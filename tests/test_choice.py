"""The choice of a method and its parameters: traits by hand, trees by hand, and what is chosen."""

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import shortest_path

import meshfair
from meshes import grid
from meshfair import denoising, mesh, metrics, noise, shapes
from meshfair.denoising import registry
from meshfair.denoising.choice import ALL, INNER, PATCH, PATCHES, USUAL, WHOLE, Chooser, sample
from meshfair.denoising.forecast import Forecast, Forest, Part, forests
from meshfair.denoising.rules import (
    CHOSEN,
    LEFT_ALONE,
    NAMED,
    Caution,
    Results,
    Rule,
    ranking,
    strength,
    weighed,
)
from meshfair.denoising.traits import AROUND, Traits, _spread, at_distances, mean_around
from meshfair.experiments import choices
from meshfair.mesh import Edges
from meshfair.solve import SolveError


def noisy_torus(size=0.2, seed=0):
    V, F = shapes.torus(sections=48, sides=20)
    return noise.along_normals(V, F, size, np.random.default_rng(seed)), V, F


def forest():
    """Two trees: one asks for trait 0, and then for trait 1; the other is a leaf."""
    return Forest(
        start=10.0,
        roots=np.array([0, 5]),
        feature=np.array([0, -1, 1, -1, -1, -1]),
        threshold=np.array([0.5, 0, 2.0, 0, 0, 0]),
        left=np.array([1, 0, 3, 0, 0, 0]),
        right=np.array([2, 0, 4, 0, 0, 0]),
        unknown_left=np.array([0, 0, 1, 0, 0, 0]),
        value=np.array([0, 1.0, 0, 2.0, 3.0, 0.25]),
    )


def test_trees_by_hand():
    rows = np.array([[0.5, 9.0], [0.6, 2.0], [0.6, 2.1], [np.nan, 5.0], [0.6, np.nan], [0, np.nan]])
    np.testing.assert_allclose(forest()(rows), 10.25 + np.array([1.0, 2, 3, 3, 2, 1]))


def test_the_trees_are_those_that_were_trained():
    with np.load(Path(__file__).parent / "forecast.npz") as file:
        assert set(file) == {"rows", *forests()}
        for name, tree in forests().items():
            # Leaves are single numbers here and double ones there: each is off by 6e-8 of at most
            # 0.5, and up to 800 add up.
            np.testing.assert_allclose(tree(file["rows"]), file[name], rtol=1e-5, atol=1e-5)


def test_traits_of_a_plane_by_hand():
    V, F = grid(40)
    rng = np.random.default_rng(0)
    lifted = V + np.array([0, 0, 1e-3]) * rng.standard_normal((len(V), 1))
    traits = Traits(lifted, F)
    along, across = traits.residual(V)
    np.testing.assert_allclose(along, lifted[:, 2] / traits.length, atol=1e-12)
    np.testing.assert_allclose(across, 0, atol=1e-12)
    # White noise of 1e-3: each power of I - W~, by its rows' norms, has that standard deviation,
    # to four standard errors of 1,681 squares that are up to half dependent.
    for power in range(4):
        heights, _ = traits._high_frequencies(lifted, np.array([[0.0, 0, 1]]), power)
        size = np.sqrt(np.mean(heights**2)) * traits.length
        assert size == pytest.approx(1e-3, rel=4 * np.sqrt(2 / 1681))


def test_vertices_so_many_edges_apart_are_those_of_shortest_paths():
    V, F = shapes.torus(sections=11, sides=6)
    edges = Edges.of_all(F, len(V))
    i, j = edges.ends.T
    graph = csr_array((np.ones(len(i)), (i, j)), shape=(len(V), len(V)))
    steps = shortest_path(graph, directed=False, unweighted=True)
    for k, D in enumerate(at_distances(edges, 5), start=1):
        np.testing.assert_array_equal(D.toarray(), steps == k)


def test_how_far_opposite_vertices_have_moved_alike():
    # Opposite vertices of an octahedron are two edges apart, and none is further away.
    V = np.concatenate([np.eye(3), -np.eye(3)])
    F = [[x, y, z] for x in (0, 3) for y in (1, 4) for z in (2, 5)]
    traits = Traits(V, np.array(F))
    np.testing.assert_allclose(traits.alike(V[:, 0]), [0, -1, 0, 0, 0, 0], atol=1e-7)
    np.testing.assert_allclose(traits.alike(3 * V[:, 0] ** 2 - 1), [-0.5, 1, 0, 0, 0, 0], atol=1e-7)


def test_coherence_is_that_of_the_structure_tensor():
    # Gradients from the differences along two sides, tensors and means face by face, and the
    # eigenvalues themselves; in the plane the third one is 0.
    V, F = grid(7)
    x, traits = np.random.default_rng(0).standard_normal(len(V)), Traits(V, F)
    N, area = np.tile([0.0, 0, 1], (len(F), 1)), mesh.face_areas(V, F)
    tensors = np.zeros((len(V), 2, 2))
    for face, A in zip(F, area, strict=True):
        i, j, k = face
        g = np.linalg.solve(V[[j, k], :2] - V[i, :2], x[[j, k]] - x[i])
        tensors[face] += A * np.outer(g, g)
    near = sum(D.toarray() for D in at_distances(Edges.of_all(F, len(V)), AROUND)) + np.eye(len(V))
    low, high = np.linalg.eigvalsh(np.einsum("ij,jkl->ikl", near, tensors)).T
    expected = (high - low) / (high + low)
    np.testing.assert_allclose(traits._coherence(x, V, N, area), expected, atol=1e-7)
    np.testing.assert_allclose(traits._coherence(V @ [1, 2, 0], V, N, area), 1, atol=1e-7)


def test_local_means_and_their_spread_by_hand():
    # All are beside all on an octahedron but opposite ones; a mean is over itself and these four.
    F = np.array([[x, y, z] for x in (0, 3) for y in (1, 4) for z in (2, 5)])
    M = mean_around(at_distances(Edges.of_all(F, 6), 1))
    np.testing.assert_allclose(M @ [6.0, 0, 0, 0, 0, 0], [1.2, 1.2, 1.2, 0, 1.2, 1.2])
    squares = np.repeat([1.0, 4.0, 32.0], [30, 40, 30])
    np.testing.assert_allclose(_spread(squares), np.log([1 / 4, 8]), rtol=1e-6)


def test_traits_do_not_depend_on_place_scale_and_order():
    V_noisy, V, F = noisy_torus()
    rng = np.random.default_rng(1)
    Q, order = np.linalg.qr(rng.normal(size=(3, 3)))[0], rng.permutation(len(V))
    Q *= np.sign(np.linalg.det(Q))
    place = np.argsort(order)

    def seen(move, faces):
        traits = Traits(move(V_noisy), faces, sigma=0.2)
        traits.add_reference(move(V))
        middle = move((V + V_noisy) / 2)
        found = traits.of_mesh(), traits.of_result(middle), traits.of_noise_size(middle)
        return np.concatenate(found)

    here = seen(lambda X: X, F)
    there = seen(lambda X: (7 * X @ Q.T + [3.0, -2, 1])[order], place[F][rng.permutation(len(F))])
    # Logarithms and ratios of sums over a thousand vertices: rounding grows by the condition
    # of the smallest of them, 1e-8 of a squared edge.
    np.testing.assert_allclose(there, here, rtol=1e-6, atol=1e-6)
    assert np.isfinite(here).all()


def ranked(log_ratio, gain, rule, relief=False):
    """Of results: the first is the usual one, the third the noisy mesh, the fourth goes farther."""
    k = np.arange(len(log_ratio))
    expected = Forecast(np.array(log_ratio), np.array(gain, float))
    moved = np.where(k == 2, 0.0, 1 + k % 4 / 3 - (k == 1))
    return ranking(expected, Results(k == 2, k == 0, moved, relief), rule)


def test_ranking_by_hand():
    # Margins for all but the usual one: 0.03 for the second, which moves the vertices less, 0.05
    # for the noisy mesh, 0.1 for the last, which moves them more; a decibel is worth 0.5.
    rule = Rule(0.03, 0.05, 0.1, worth=0.5)
    said = [-1.0, -1.01, 5.0, -1.2], [0, 0, 0, -2]
    score = ranked(*said, rule)
    np.testing.assert_allclose(score, [-1, -0.98, 0.05, -0.1])
    # On relief the usual one is as far as a filter may go, or nothing is done at all.
    np.testing.assert_allclose(ranked(*said, rule, relief=True), [-1, -0.98, 0.05, np.inf])
    score = ranked(*said, rule._replace(leaves_relief=True), relief=True)
    np.testing.assert_allclose(score, [-1, -0.98, -np.inf, -0.1])


def test_without_a_usual_one_nothing_is_farther_than_it():
    k = np.arange(2)  # the defaults could not be solved
    expected = Forecast(np.array([-1.0, -2]), np.zeros(2))
    results = Results(k < 0, k < 0, np.array([1.0, 9]), relief=True)
    np.testing.assert_allclose(ranking(expected, results, Rule(0.1, 0.2, 0.3)), [-0.9, -1.9])


def test_the_less_the_gain_in_decibels_the_less_are_good_normals_believed():
    rule = Rule(0, 0, 0, doubt=0.2, sure_gain=3)
    score = ranked([-2.0, -1.0, 5.0, -1.0, -2.0], [-9, 5, -9, 2, 3], rule)
    np.testing.assert_allclose(score, [-2 + 12 * 0.2, -1, 0, -0.8, -2])


def test_changes_are_added_to_what_they_start_from():
    expected = Forecast(np.array([-1.0, -2.0]), np.array([0.0, 4.0]))
    # A decibel is worth 0.1, and each that is short of 3 counts 0.5 against a result.
    rule = Rule(0, 0, 0, worth=0.1, doubt=0.5, sure_gain=3)
    found = expected.changed(1, Forecast(np.array([-0.3, 0.1]), np.array([-2.0, 1.0])))
    np.testing.assert_allclose(found.log_ratio, [-2, -2.3, -1.9])
    np.testing.assert_allclose(found.gain, [4, 2, 5])
    np.testing.assert_allclose(weighed(found, rule), [-2.4, -2.3 - 0.2 + 0.5, -1.9 - 0.5])


def test_strengths_by_hand():
    # From 0.8 on all of the way; of what a part is short of that, twice as much is not gone.
    caution = Caution(0.8, 2)
    said = [1.2, 0.8, 0.7, 0.55, 0.31, 0.3, -0.2]
    wanted = [1, 1, 0.75, 0.5, 0, 0, 0]
    assert [strength(Part(part, 0.0), caution) for part in said] == wanted
    of_both = caution._replace(of_both=True)
    assert [strength(Part(part, 0.7), of_both) for part in said] == [0.75, 0.75, *wanted[2:]]
    assert [strength(Part(0.7, part), of_both) for part in said] == [0.75, 0.75, *wanted[2:]]


@pytest.fixture(scope="module")
def tried():
    """What a torus's chooser has tried: the candidates of all methods, and of the learned one."""
    V_noisy, _, F = noisy_torus()
    chooser = Chooser(V_noisy, F, {}, None, lambda part: None)
    candidates = {len(names): chooser.candidates(names) for names in (ALL, (USUAL,))}
    return chooser, candidates, chooser.further()


@pytest.fixture
def chosen_where(tried, monkeypatch):
    """The first choice on that torus where the best part is told to be this."""
    chooser, candidates, further = tried

    def choose(part, names=ALL):
        monkeypatch.setattr(chooser, "candidates", lambda names: candidates[len(names)])
        monkeypatch.setattr(chooser, "further", lambda: further)
        monkeypatch.setattr("meshfair.denoising.choice.best_part", lambda x: part)
        return chooser.ranked(names)[0]

    return choose


@pytest.mark.parametrize(
    ("angle", "decibels", "moves"),
    [
        ([-0.1, -0.2], [0, 0], 160),
        ([-0.1, -0.1], [0, -1], 40),
        ([-0.02, -0.03], [-1, -2], 20),  # what a decibel is worth is more than these
    ],
)
def test_the_learned_filter_goes_on_for_longer_where_that_promises_more(
    chosen_where, monkeypatch, angle, decibels, moves
):
    told = Forecast(np.array(angle), np.array(decibels, float))
    monkeypatch.setattr("meshfair.denoising.choice.change", lambda rows: told)
    for names in (ALL, (USUAL,)):
        assert chosen_where(Part(1.0, 1.0), names).parameters["vertex_iterations"] == moves


@pytest.mark.parametrize(
    ("names", "caution", "normals"), [(ALL, CHOSEN, 0.6), ((USUAL,), NAMED, 0.3)]
)
def test_where_the_best_part_is_short_of_all_a_part_is_gone(chosen_where, names, caution, normals):
    wanted = strength(Part(normals, 0.0), caution)
    assert 0 < wanted < 1
    found = chosen_where(Part(normals, 0.0), names)
    assert (found.method, found.parameters["strength"]) == (USUAL, wanted)
    assert f", {wanted:g} of the way: beyond, detail would go" in found.reason
    assert "strength" not in chosen_where(Part(1.1, 0.0), names).parameters


def test_a_part_of_nothing_is_the_mesh_as_it_is(chosen_where):
    found = chosen_where(Part(0.2, 1.0))
    assert found.parameters["strength"] == 0
    assert found.ratio == 1
    assert found.reason == "left as it is: filters would take away more detail than noise"


def test_a_part_may_be_gone_where_the_mesh_would_be_left(tried, chosen_where, monkeypatch):
    chooser, *_ = tried
    monkeypatch.setattr(
        "meshfair.denoising.choice.forecast",
        lambda X, alone=False: Forecast(np.full(len(X), -1.0), np.full(len(X), -9.0)),
    )
    low = strength(Part(0.7, 0.9), LEFT_ALONE)
    assert 0 < low < 1
    for part, wanted in ((Part(0.7, 0.9), low), (Part(0.9, 0.7), low), (Part(0.9, 0.9), None)):
        found = chosen_where(part)
        assert (found.method, found.parameters.get("strength")) == (USUAL, wanted)
    monkeypatch.setattr(chooser, "strength", 0.3)  # a given one does not change whether it is left
    assert chosen_where(Part(0.7, 0.9)).parameters["strength"] == 0.3
    assert np.array_equal(chosen_where(Part(0.1, 0.9)).X, chooser.V)
    monkeypatch.setattr(chooser, "strength", None)
    monkeypatch.setattr(Chooser, "takes_relief", lambda chooser: True)
    assert chosen_where(Part(0.7, 0.9)).ratio == 1


@pytest.mark.parametrize(
    ("part", "refined"),
    [(0.3, {"strength": strength(Part(0.3, 0.3), NAMED)}), (1.0, {"vertex_iterations": 160})],
)
def test_the_front_does_what_is_chosen(monkeypatch, part, refined):
    V_noisy, _, F = noisy_torus()
    told = Forecast(np.array([-0.1, -0.2]), np.zeros(2))
    monkeypatch.setattr("meshfair.denoising.choice.change", lambda rows: told)
    monkeypatch.setattr("meshfair.denoising.choice.best_part", lambda x: Part(part, part))
    result = meshfair.denoise(V_noisy, F, USUAL, parameters="auto")
    assert result.parameters == denoising.defaults(USUAL) | refined
    again = meshfair.denoise(V_noisy, F, USUAL, **refined)
    np.testing.assert_array_equal(result.V, again.V)
    # What is given is not refined.
    found = meshfair.denoise(V_noisy, F, USUAL, parameters="auto", **refined | {"stages": 1})
    assert found.parameters == denoising.defaults(USUAL) | refined | {"stages": 1}


@pytest.mark.parametrize("fixed", [None, np.arange(960) % 7 == 0])
def test_what_the_longest_run_passes_by_is_what_the_filter_gives_then(fixed):
    V_noisy, _, F = noisy_torus()
    chooser = Chooser(V_noisy, F, {"fixed": fixed}, None, lambda part: None)
    assert [c.parameters["vertex_iterations"] for c in chooser.further()] == [40, 160]
    tried = chooser.candidates([USUAL]) + chooser.further()
    assert len(tried) == 4
    for c in tried:
        X = meshfair.denoise(V_noisy, F, USUAL, **c.parameters).V
        np.testing.assert_array_equal(c.X, X)


@pytest.mark.parametrize("subdivisions", [2, 5])
@pytest.mark.parametrize("method", ["taubin", "sun"])
def test_what_was_tried_is_what_would_come_of_it_again(method, subdivisions):
    V, F = shapes.icosphere(subdivisions)  # tried whole, and in patches
    assert (len(F) > WHOLE) == (subdivisions == 5)
    V_noisy = noise.along_normals(V, F, 0.2, np.random.default_rng(0))
    seen = []
    for given in ({"callback": seen.append}, {"ground_truth": V}):
        result = meshfair.denoise(V_noisy, F, method, parameters="auto", **given)
        again = meshfair.denoise(V_noisy, F, method, **result.parameters)
        np.testing.assert_array_equal(result.V, again.V)
    assert seen == sorted(seen)
    assert (seen[0] > 0, seen[-1]) == (True, 1)


def test_tuning_looks_at_what_goes_on_for_longer():
    # On a torus under noise in all directions, each move turns faces closer to the truth.
    V, F = shapes.torus(sections=48, sides=20)
    V_noisy = noise.gaussian(V, F, 0.2, np.random.default_rng(0))
    tuned = denoising.tune(V_noisy, F, "learned", V)
    assert tuned.parameters["vertex_iterations"] == 160


def test_tuning_looks_at_parts_of_the_way():
    # Ripples as small as noise: all of the way takes them away with it.
    V, F = grid(24)
    V = V + 0.3 * mesh.mean_edge_length(V, F) * np.sin(2 * np.pi * V[:, :1] / 3.5) * [0, 0, 1]
    V_noisy = noise.along_normals(V, F, 0.1, np.random.default_rng(0))
    tuned = denoising.tune(V_noisy, F, USUAL, V)
    assert 0 < tuned.parameters["strength"] < 1
    whole = meshfair.denoise(V_noisy, F, USUAL).V
    angles = [metrics.normal_angle(X, V, F) for X in (tuned.V, V_noisy, whole)]
    assert angles == sorted(angles)


def test_a_large_mesh_is_tried_in_patches():
    V, F = shapes.icosphere(5)
    assert len(F) > WHOLE
    found = sample(V, F)
    original = {tuple(sorted(face)) for face in F.tolist()}
    parts = {PATCH: (found.vertices, found.F), INNER: (found.vertices[found.inner], found.F_inner)}
    for faces, (vertices, small) in parts.items():
        assert faces < len(small) <= PATCHES * faces
        assert all(tuple(sorted(face)) in original for face in vertices[small].tolist())
        assert np.array_equal(np.unique(small), np.arange(len(vertices)))
    all_of_it = sample(*shapes.icosphere(2))
    assert len(all_of_it.F) == len(all_of_it.F_inner) == 320
    assert len(all_of_it.vertices) == len(all_of_it.inner) == 162


@pytest.mark.parametrize(("method", "iterations"), [("averaging", 2), ("taubin", 1)])
def test_what_is_looked_at_of_a_patch_is_what_becomes_of_it_in_the_mesh(method, iterations):
    # Two averagings, or there and back once, reach two rings; so many lie around what is inside.
    V, F = shapes.icosphere(5)
    V_noisy = noise.along_normals(V, F, 0.2, np.random.default_rng(0))
    given = {"iterations": iterations}
    chooser = Chooser(V_noisy, F, given, None, lambda part: None)
    X = denoising.denoise(V_noisy, F, method, **given).V[chooser.vertices]
    last = chooser.candidates([method])[-1]
    np.testing.assert_allclose(last.X, X, atol=1e-12)


def test_the_front_chooses_and_says_why():
    V_noisy, V, F = noisy_torus()
    result = meshfair.denoise(V_noisy, F, ground_truth=V)
    again = meshfair.denoise(V_noisy, F, result.method, **result.parameters)
    np.testing.assert_array_equal(result.V, again.V)
    assert result.method in denoising.methods()
    before = metrics.normal_angle(V_noisy, V, F)
    # A torus under white noise of a fifth of an edge is not hard: every filter's default halves
    # the angle there.
    assert metrics.normal_angle(result.V, V, F) < before / 2
    assert result.ratio < 1 / 2
    assert result.reason.startswith("noise of 0.")
    assert len(result.reason) < 100
    assert result.history["normal_angle"].iloc[-1] == metrics.normal_angle(result.V, V, F)


def egg_crate():
    """Waves of four edges, half an edge high, which filters flatten to a plane."""
    V, F = grid(40)
    x, y = 2 * np.pi / (4 * V[:, 0].max() / 40) * V[:, :2].T
    length = mesh.mean_edge_length(V, F)
    V = V + np.outer(0.5 * length * np.sin(x) * np.sin(y), [0, 0, 1])
    return noise.along_normals(V, F, 0.05, np.random.default_rng(0)), V, F


@pytest.mark.parametrize(
    ("alike", "relief"),
    [
        ([0.0, -0.1, 0.03, 0, 0, 0], True),  # three edges apart 0.13 more alike than two
        ([0.35, -0.1, 0.03, 0, 0, 0], False),  # but so alike at neighbours that it may be noise,
        ([0.35, -0.1, 0.0, -0.05, 0, 0], True),  # unless four edges apart are opposite, too
        ([0.3, -0.05, -0.03, -0.05, 0, 0], False),  # and three edges apart are not
        ([0.6, 0.1, -0.1, -0.1, 0, 0], False),  # correlated noise on a torus: falls, and stays low
        ([0.0, 0.0, 0.0, 0.0, 0, 0], False),
    ],
)
def test_what_repeats_along_the_surface(monkeypatch, alike, relief):
    V, F = shapes.icosphere(2)
    chooser = Chooser(V, F, {}, None, lambda part: None)
    monkeypatch.setattr(Traits, "alike", lambda self, x: alike)
    assert chooser.takes_relief() is relief


def test_the_reason_names_relief_only_where_it_decides(monkeypatch):
    V_noisy, _, F = egg_crate()
    monkeypatch.setattr(Chooser, "takes_relief", lambda self: True)
    alone = meshfair.denoise(V_noisy, F, "averaging", parameters="auto")
    np.testing.assert_array_equal(alone.V, V_noisy)
    assert alone.reason.startswith("left as it is: nothing promises")


@pytest.mark.parametrize("method", ["heat", "implicit"])
def test_on_relief_that_repeats_one_methods_parameters_change_no_more_than_its_defaults(method):
    V_noisy, V, F = egg_crate()
    usual = metrics.normal_angle(meshfair.denoise(V_noisy, F, method).V, V, F)
    chosen = metrics.normal_angle(meshfair.denoise(V_noisy, F, method, parameters="auto").V, V, F)
    assert chosen <= 1.05 * usual  # what is promised of automatic parameters


def test_relief_that_repeats_is_not_taken_for_noise():
    V_noisy, V, F = egg_crate()
    result = meshfair.denoise(V_noisy, F)
    np.testing.assert_array_equal(result.V, V_noisy)
    assert result.reason.startswith("left as it is: what filters would take away repeats")
    flattened = meshfair.denoise(V_noisy, F, "learned")
    assert metrics.snr(V, flattened.V) < metrics.snr(V, V_noisy)


@pytest.mark.parametrize("size", [0.1, 0.2, 0.3])
def test_the_knot_gains_six_decibels(size):
    # Normal filters take the coarse tube for features: feature-convinced lost 3.6 dB at 0.2.
    V, F = shapes.knot()
    V_noisy = noise.along_normals(V, F, size, np.random.default_rng(5))
    result = meshfair.denoise(V_noisy, F)
    assert metrics.snr(V, result.V) > metrics.snr(V, V_noisy) + 6


def test_what_nothing_helps_is_left_as_it_is(monkeypatch):
    V_noisy, _, F = noisy_torus()
    rows = []

    def hopeless(X, alone):
        rows.append(X)
        return meshfair.denoising.forecast.Forecast(np.full(len(X), 0.5), np.zeros(len(X)))

    monkeypatch.setattr("meshfair.denoising.choice.forecast", hopeless)
    monkeypatch.setattr("meshfair.denoising.choice.best_part", lambda x: Part(0.5, 0.5))
    result = meshfair.denoise(V_noisy, F)
    np.testing.assert_array_equal(result.V, V_noisy)
    assert result.ratio == 1
    assert result.reason.startswith("left as it is")
    again = meshfair.denoise(V_noisy, F, result.method, **result.parameters)
    np.testing.assert_array_equal(again.V, V_noisy)
    assert np.isfinite(rows[0][:, :-2]).all()  # but for the noise size, which is not known


@pytest.mark.parametrize(("method", "left"), [("auto", True), ("averaging", False)])
def test_the_front_leaves_what_would_lose_decibels(monkeypatch, method, left):
    # Who names averaging wants it, though it shrinks; who names nothing shall not lose by it.
    V_noisy, _, F = noisy_torus()
    flattened = Forecast(np.full(200, -1.0), np.full(200, -5.0))
    monkeypatch.setattr(
        "meshfair.denoising.choice.forecast",
        lambda X, alone: Forecast(*(a[: len(X)] for a in flattened)),
    )
    monkeypatch.setattr("meshfair.denoising.choice.best_part", lambda x: Part(1.0, 0.4))
    result = meshfair.denoise(V_noisy, F, method, parameters="auto")
    assert np.array_equal(result.V, V_noisy) == left


def test_a_known_noise_size_is_among_the_traits():
    V_noisy, _, F = noisy_torus()
    chooser = Chooser(V_noisy, F, {}, 0.2, lambda part: None)
    rows = chooser.rows(chooser.candidates(["taubin"]))
    assert np.isfinite(rows).all()
    noise_parameter = {c.parameters["noise"] for c in chooser.candidates(["feature-convinced"])}
    assert noise_parameter == {0.2}


def test_parameters_without_a_method_are_refused():
    V_noisy, _, F = noisy_torus()
    with pytest.raises(ValueError, match=r"iterations is given, but method=\"auto\" chooses all"):
        meshfair.denoise(V_noisy, F, iterations=3)


def test_fixed_vertices_stay_whatever_is_chosen():
    V, F = shapes.icosphere(5)  # large enough for patches
    V_noisy = noise.along_normals(V, F, 0.2, np.random.default_rng(0))
    fixed = np.arange(0, len(V), 3)
    result = meshfair.denoise(V_noisy, F, fixed=fixed)
    np.testing.assert_array_equal(result.V[fixed], V_noisy[fixed])
    assert not np.allclose(result.V, V_noisy)


def test_progress_and_cancelling_of_the_choice():
    V_noisy, _, F = noisy_torus()
    seen = []
    meshfair.denoise(V_noisy, F, callback=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1
    early = meshfair.denoise(V_noisy, F, callback=lambda part: part < 0.3)
    assert not early.finished
    np.testing.assert_array_equal(early.V, V_noisy)


@pytest.mark.parametrize(
    ("add", "named"),
    [
        (noise.correlated, "alike at neighbours"),
        (lambda V, F, size, rng: noise.impulsive(V, F, size, 0.2, rng), "mostly at some vertices"),
        (noise.gaussian, "edges; "),
    ],
)
def test_the_kind_of_noise_is_named(add, named):
    V, F = shapes.torus(sections=80, sides=32)
    V_noisy = add(V, F, 0.2, np.random.default_rng(0))
    assert named in meshfair.denoise(V_noisy, F, "averaging", parameters="auto").reason


def test_the_front_of_the_grid_is_the_front():
    V_noisy, _, F = noisy_torus()
    front = choices.by_front(V_noisy, F, "auto", "default")
    np.testing.assert_array_equal(front.V, meshfair.denoise(V_noisy, F).V)


def test_a_filter_of_ones_own_is_not_chosen_by_the_front(monkeypatch):
    monkeypatch.setattr(registry, "_METHODS", dict(registry._METHODS))

    @denoising.register("never")
    def never(V, F, *, fixed=None):
        raise AssertionError("the front has no business here")
        yield

    V_noisy, _, F = noisy_torus()
    assert meshfair.denoise(V_noisy, F).method in denoising.BUILT_IN


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("auto", "name is 'auto', which chooses among all methods; give another one"),
        ("taubin", "name is 'taubin', which comes with the package, and 'auto' chooses by what"),
    ],
)
def test_some_names_are_not_for_filters_of_ones_own(name, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        denoising.register(name)
    assert "auto" not in denoising.methods()


def test_vertices_without_faces_do_not_matter():
    V_noisy, _, F = noisy_torus()
    rng = np.random.default_rng(3)
    far = rng.standard_normal((100, 3))
    alone, together = (
        meshfair.denoise(V_noisy, F),
        meshfair.denoise(np.concatenate([far[:50], V_noisy, far[50:]]), F + 50),
    )
    assert together.parameters == alone.parameters
    assert together.reason == alone.reason
    np.testing.assert_array_equal(together.V[50:-50], alone.V)
    np.testing.assert_array_equal(together.V[:50], far[:50])
    np.testing.assert_array_equal(together.V[-50:], far[50:])


def test_a_reference_that_cannot_be_solved_is_no_candidate(monkeypatch):
    def fails(V, F, *, lam=0.1, fixed=None):
        raise SolveError("no way")
        yield

    monkeypatch.setattr(registry, "_METHODS", dict(registry._METHODS))
    l0 = registry.find_method("l0")
    monkeypatch.setitem(registry._METHODS, "l0", dataclasses.replace(l0, function=fails))
    V_noisy, _, F = noisy_torus()
    with pytest.raises(SolveError, match="no way"):
        meshfair.denoise(V_noisy, F, "l0", parameters="auto")
    assert meshfair.denoise(V_noisy, F).method != "l0"


def test_a_mesh_all_of_which_is_fixed_is_left_and_says_so():
    V_noisy, V, F = noisy_torus()
    for method in ("auto", "sun"):
        result = meshfair.denoise(
            V_noisy, F, method, parameters="auto", fixed=np.arange(len(V)), ground_truth=V
        )
        np.testing.assert_array_equal(result.V, V_noisy)
        assert result.reason == "left as it is: all of its vertices are fixed"
        assert result.ratio == 1
        assert len(result.history)


def test_patches_lie_where_vertices_are_free():
    V, F = shapes.icosphere(5)
    free = V[:, 2] > 0.9  # a cap of as many faces as a patch looks at, about

    def share(found):
        return np.mean(free[found.vertices[found.inner]])

    anywhere = sample(V, F)
    assert share(sample(V, F, ~free)) > 0.5 > 0.2 > share(anywhere)
    for fixed in (np.zeros(len(V), bool), np.ones(len(V), bool)):
        np.testing.assert_array_equal(sample(V, F, fixed).vertices, anywhere.vertices)


def test_where_there_is_no_noise_no_error_is_said_to_be_left():
    V, F = np.eye(3), np.array([[0, 1, 2]])
    for method in ("auto", "l0"):
        result = meshfair.denoise(V, F, method, parameters="auto")
        assert result.reason == "left as it is: hardly any noise, less than 0.001 edges"
        assert result.ratio == 1
        np.testing.assert_array_equal(result.V, V)


@pytest.mark.parametrize("method", ["auto", "averaging"])
@pytest.mark.parametrize("segments", [None, 4])
def test_a_choice_warns_of_what_is_chosen_alone(recwarn, method, segments):
    V_noisy, V, F = noisy_torus()
    if segments:  # more than are tried whole
        V, F = shapes.torus(sections=100, sides=40)
        V_noisy = noise.along_normals(V, F, 0.2, np.random.default_rng(0))
    V_noisy[F[5, 0]] = V_noisy[F[5, 1]]  # two faces without area
    given = {} if method == "auto" else {"weights": "cotangent"}
    found = meshfair.denoise(V_noisy, F, method, parameters="auto", **given)
    told = sorted(str(w.message) for w in recwarn)
    recwarn.clear()
    again = meshfair.denoise(V_noisy, F, found.method, **found.parameters)
    np.testing.assert_array_equal(again.V, found.V)
    assert told == sorted(str(w.message) for w in recwarn)
    assert bool(told) == bool(given)


def test_no_result_is_looked_at_twice():
    V_noisy, _, F = noisy_torus()
    candidates = Chooser(V_noisy, F, {}, None, lambda part: None).candidates(ALL)
    stopped = [(c.method, c.X.tobytes()) for c in candidates if c.stop is not None]
    assert len(set(stopped)) == len(stopped)
    assert {c.method for c in candidates if c.stop is None} == set(ALL)
