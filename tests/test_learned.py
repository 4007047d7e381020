"""The learned filter: torch's own figures, the formula in loops, its symmetries, odd meshes."""

import importlib
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import meshfair
from fast import both
from meshes import grid, pair, soups
from meshfair import denoising, filters, mesh, metrics, noise, operators, shapes, weights
from meshfair.filters import face_network
from meshfair.filters.face_network import Rings
from meshfair.filters.guided_normal import Patches
from meshfair.filters.learned import learned, move_and_unfold, record, trained
from meshfair.filters.neighbourhoods import face_rings
from meshfair.filters.normal_bank import COUNT, filtered_normals, surfaces
from meshfair.filters.normal_filtering import (
    joint_bilateral,
    mean_distance,
    move_vertices,
    spatial_weights,
)
from meshfair.mesh.geometry import incidence
from test_fast_filters import MESHES, same

FIGURES = Path(__file__).with_name("learned.npz")


def result(V, F, **parameters):
    *_, (progress, X) = learned(V, F, **parameters)
    assert progress == 1
    return X


def noisy_torus(sections=16, sides=8):
    V, F = shapes.torus(sections=sections, sides=sides)
    return noise.gaussian(V, F, 0.2, np.random.default_rng(4)), F


def test_torch_finds_the_same():
    # Positions after each stage, by the networks in torch as training left them. It computes in
    # single precision: normals with errors of some 1e-7 each, added up over the layers.
    with np.load(FIGURES) as figures:
        V, F = figures["V"], figures["F"]
        scale = mesh.mean_edge_length(V, F)
        for stages, name in ((1, "first"), (2, "second")):
            found = result(V, F, stages=stages)
            assert np.abs(found - V).max() > 0.1 * scale
            np.testing.assert_allclose(found, figures[name], rtol=0, atol=1e-4 * scale)


def test_the_weights_say_how_they_came_about():
    facts = record()
    assert list(facts) == ["commit", "seed", "data", "loss", "steps", "seconds", "torch"]
    assert len(facts["commit"]) == 40
    assert "procedural" in facts["data"]
    path = files("meshfair.filters") / "learned.npz"
    with path.open("rb") as file:
        assert len(file.read()) < 2_000_000
    assert len(trained()) == 2
    for w in trained():
        assert all(x.dtype == np.float64 and np.isfinite(x).all() for x in w.values())


# --- The formula.


def made(V, F, rng):
    """What a layer is given: rings, scalars and vectors of random size."""
    _, area, C = mesh.face_shapes(V, F)
    smooth = mesh.face_shapes(surfaces(V, F)[0], F)[2]
    R = face_rings(incidence(F, len(V)))
    h = rng.normal(size=(len(F), face_network.SCALARS))
    v = rng.normal(size=(len(F), 3, face_network.CHANNELS))
    return (R, C, smooth, area), h, v


def layer(k=1):
    prefix = f"layers.{k}."
    w = trained()[0]
    return {name.removeprefix(prefix): x for name, x in w.items() if name.startswith(prefix)}


def bend(x):
    """torch's hardswish: x relu6(x + 3) / 6."""
    return x * min(max(x + 3, 0), 6) / 6


def test_messages_are_their_formula(rng):
    V, F = noisy_torus(6, 4)
    arrays, h, v = made(V, F, rng)
    _, C, smooth, area = arrays
    w = layer()
    s, u = face_network.message_sums(w, h, v, Rings(*arrays))
    for i in (0, 17, 40):
        ring = [j for j in range(len(F)) if {*F[i].tolist()} & {*F[j].tolist()}]
        share = {j: area[j] / sum(area[k] for k in ring) for j in ring}
        size = sum(share[j] * np.linalg.norm(C[j] - C[i]) for j in ring)
        total_s, total_u = 0, 0
        for j in ring:
            d, t = (C[j] - C[i]) / size, (smooth[j] - smooth[i]) / size
            apart = ((v[i] - v[j]) ** 2).sum(0)
            x = [*(apart / (apart + 0.1)), *d @ v[i], *d @ v[j], *t @ v[i], *t @ v[j]]
            x += [np.linalg.norm(d), np.log(area[j] / area[i])]
            z = w["own.weight"] @ [*h[i], *(v[i] ** 2).sum(0)] + w["own.bias"]
            z = z + w["other.weight"] @ [*h[j], *(v[j] ** 2).sum(0)] + w["edge.weight"] @ x
            z = np.array([bend(a) for a in z])
            total_s = total_s + share[j] * z
            total_u = total_u + share[j] * (w["along.weight"] @ z + w["along.bias"]) * v[j]
        np.testing.assert_allclose(s[i], total_s, atol=1e-12)
        np.testing.assert_allclose(u[i], total_u, atol=1e-12)


def test_invariants_are_distances(rng):
    G = mesh.normalised(rng.normal(size=(5 * 16, 3))).reshape(5, 16, 3)
    G[2, 3] = G[2, 4]  # as near as can be
    G[3, 14:] = 0  # what a first stage has of the one before
    found = face_network.invariants(G, np.zeros((5, 2)))
    for i in range(5):
        apart = [np.linalg.norm(G[i, a] - G[i, b]) for a in range(16) for b in range(a + 1, 16)]
        expected = [*(np.log(0.01 + np.array(apart)) + 2), 0, 0]
        np.testing.assert_allclose(found[i], expected, atol=1e-12)


def test_folded_faces_are_unfolded():
    V, F = grid(4)  # 5 x 5 vertices
    folded = V.copy()
    folded[12, :2] += [1.4, 0.1]  # the middle one, over the far edge of its ring
    N = np.tile([0.0, 0, 1], (len(F), 1))
    B = incidence(F, len(V))
    A = operators.averaging(weights.combinatorial(F, len(V)))
    over = mesh.face_normals(folded, F)[:, 2] < 0
    assert 0 < over.sum() < len(F)
    fixed = np.arange(len(V)) == F[over].ravel()[F[over].ravel() != 12][0]
    found = move_and_unfold(folded, F, B, A, N, fixed)
    for i in range(len(V)):
        expected = folded[i]
        if i in F[over] and not fixed[i]:  # in a plane, all of the shift is along the surface
            around = np.unique(F[(F == i).any(axis=1)])
            expected = (folded[i] + folded[around[around != i]].mean(axis=0)) / 2
        np.testing.assert_allclose(found[i], expected, atol=1e-12)
    X = folded
    for _ in range(20):
        X = move_and_unfold(X, F, B, A, N, fixed)
    assert (mesh.face_normals(X, F)[:, 2] > 0.8).all()


def test_vertices_stay_where_unfolding_does_not_help(rng):
    # No move within a plane turns a face over: a normal that cannot be had is no reason to move.
    V, F = grid(4)
    V[:, :2] += rng.uniform(-0.2, 0.2, (len(V), 2))
    N = np.tile([0.0, 0, 1], (len(F), 1))
    N[10] *= -1
    B = incidence(F, len(V))
    A = operators.averaging(weights.combinatorial(F, len(V)))
    found = move_and_unfold(V, F, B, A, N, np.zeros(len(V), dtype=bool))
    np.testing.assert_allclose(found, V, atol=1e-12)


def test_a_face_that_is_not_turned_over_only_moves_to_its_plane(rng):
    V, F = noisy_torus()
    B, N = incidence(F, len(V)), mesh.face_normals(V, F)
    A = operators.averaging(weights.combinatorial(F, len(V)))
    fixed = np.zeros(len(V), dtype=bool)
    found = move_and_unfold(V, F, B, A, N, fixed)
    np.testing.assert_array_equal(found, move_vertices(V, F, B, N, fixed))


def test_the_bank_is_what_it_says():
    V, F = noisy_torus()
    patches = Patches(face_rings(incidence(F, len(V))))
    smoothed = surfaces(V, F)
    states = [X for _, X in filters.taubin(V, F, iterations=30)]
    for found, step in zip(smoothed, (3, 10, 30), strict=True):
        np.testing.assert_array_equal(found, states[step - 1])
    bank = list(filtered_normals(V, F, smoothed, patches))
    assert len(bank) == COUNT
    N, area, C = mesh.face_shapes(V, F)
    np.testing.assert_array_equal(bank[1], mesh.face_normals(states[9], F))
    np.testing.assert_array_equal(bank[4], N)
    S = spatial_weights(patches.rings, C, area, mean_distance(C, patches.adjacent))
    mean = S @ N  # the weights of normals that differ at all are those of space
    np.testing.assert_allclose(bank[5], mesh.normalised(mean), atol=1e-6)
    X = N
    for _ in range(4):
        X = joint_bilateral(S, X, X, 0.3)
    np.testing.assert_array_equal(bank[7], X)
    for X in bank:
        np.testing.assert_allclose(np.linalg.norm(X, axis=1), 1, rtol=1e-12)


# --- Compiled loops.


@pytest.mark.parametrize("make", MESHES.values(), ids=MESHES)
def test_loops_are_the_formula(make, rng):
    V, F = make()
    arrays, h, v = made(V, F, rng)
    same(both(lambda: Rings(*arrays).size))
    for part in (0, 1):
        same(both(lambda p=part: face_network.message_sums(layer(), h, v, Rings(*arrays))[p]))


@pytest.mark.parametrize("make", MESHES.values(), ids=MESHES)
def test_whole_filter(make):
    V, F = make()
    # Normals that are means of some that nearly cancel lose digits, in each of 60 iterations.
    same(both(lambda: np.array([X for _, X in learned(V, F)])), 1e-8)


def test_the_number_of_cores_changes_no_digit(monkeypatch):
    from meshfair._fast import kernels

    V, F = noisy_torus(60, 40)  # more faces than a block of the loops has
    monkeypatch.setattr("meshfair._fast.wanted", lambda *_: True)
    expected = result(V, F)
    monkeypatch.setattr(kernels, "threads", lambda: 3)
    np.testing.assert_array_equal(result(V, F), expected)


def test_blocks_change_no_more_than_rounding(monkeypatch):
    V, F = noisy_torus()
    expected = result(V, F)
    monkeypatch.setattr(face_network, "BLOCK", 37)
    np.testing.assert_allclose(result(V, F), expected, atol=1e-10)


# --- Symmetries.

# Rounding of 1e-16, in 60 iterations over normals that may be the mean of some that nearly cancel.
CLOSE = 1e-8


@settings(max_examples=10)  # a tenth of a second each
@given(st.integers(0, 2**32 - 1))
def test_motions_mirrors_scales_and_labels_carry_over(seed):
    rng = np.random.default_rng(seed)
    V, F = noisy_torus(12, 6)
    expected = result(V, F)
    Q, _ = np.linalg.qr(rng.standard_normal((3, 3)))  # a mirror image, as often as not
    faces = F if np.linalg.det(Q) > 0 else F[:, ::-1]
    scale, shift = 10 ** rng.uniform(-6, 6), rng.standard_normal(3)
    to = rng.permutation(len(V))
    moved = np.empty_like(V)
    moved[to] = scale * (V @ Q.T + shift)
    faces = to[rng.permutation(faces)]
    found = result(moved, np.roll(faces, 1, axis=1))[to] / scale - shift
    np.testing.assert_allclose(found, expected @ Q.T, atol=CLOSE)


def test_pieces_far_apart_do_not_exchange_messages():
    # Only the mean of all faces' first scalars is shared: with a second copy it is the same.
    V, F = noisy_torus()
    found = result(np.concatenate([V, V + [50, 0, 0]]), np.concatenate([F, F + len(V)]))
    expected = result(V, F)
    np.testing.assert_allclose(found[: len(V)], expected, atol=CLOSE)
    np.testing.assert_allclose(found[len(V) :] - [50, 0, 0], expected, atol=CLOSE)


def test_a_clean_plane_stays(rng):
    V, F = grid(8, irregular=rng)
    np.testing.assert_allclose(result(V, F)[:, 2], 0, atol=1e-12)


# --- Meshes that are not nice.


@settings(max_examples=40)
@given(soups())
def test_soups_stay_finite(soup):
    V, F = soup
    assert np.isfinite(result(V, F)).all()


@pytest.mark.parametrize(
    "V", [np.zeros((3, 3)), [[0, 0, 0], [1, 0, 0], [2, 0, 0]], 1e-200 * np.eye(3), 1e70 * np.eye(3)]
)
def test_one_face_stays(V):
    found = result(V, [[0, 1, 2]])
    np.testing.assert_allclose(found, V, rtol=0, atol=1e-12 * np.abs(V).max())


def test_what_has_no_area_hardly_moves_anything_else():
    V, F = noisy_torus()
    expected = result(V, F)
    more = np.concatenate([V, [[7.0, 7, 7], [9, 9, 9]]])  # a vertex alone, and a face of no size
    found = result(more, np.concatenate([F, [[len(V), len(V), len(V)]]]))
    np.testing.assert_array_equal(found[len(V) :], more[len(V) :])
    # It is one of 257 faces in the mean of all.
    assert np.abs(found[: len(V)] - expected).max() < 0.05 * mesh.mean_edge_length(V, F)


# --- The front.


def test_fixed_vertices_stay_and_others_do_not():
    V, F = noisy_torus()
    fixed = np.arange(len(V)) % 3 == 0
    found = result(V, F, fixed=fixed)
    np.testing.assert_array_equal(found[fixed], V[fixed])
    assert (np.abs(found - V).max(axis=1) > 0)[~fixed].all()


def test_progress_is_in_small_steps_and_cancels():
    V, F = noisy_torus()
    progress = [p for p, _ in learned(V, F)]
    np.testing.assert_allclose(np.diff(progress), progress[0])
    assert progress[0] < 0.02
    calls = []
    halted = meshfair.denoise(V, F, "learned", callback=lambda p: bool(calls.append(p)) or p < 0.6)
    assert not halted.finished
    assert max(calls) < 0.65
    assert (halted.V != V).any()


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"stages": 0}, "stages is 0; give"),
        ({"stages": 3}, "stages is 3; give 1 or 2"),
        ({"vertex_iterations": -1}, "vertex_iterations is -1; give"),
    ],
)
def test_parameters_outside_their_range(parameters, message):
    with pytest.raises(ValueError, match=message):
        list(learned(*noisy_torus(), **parameters))


def test_without_vertex_iterations_nothing_moves():
    V, F = noisy_torus()
    np.testing.assert_array_equal(result(V, F, vertex_iterations=0), V)


def test_more_vertex_iterations_go_on_from_where_fewer_end():
    # The second stage has learned from what the first leaves after 20 moves, however many follow.
    V, F = noisy_torus()
    usual = [X for _, X in learned(V, F)]
    longer = [X for _, X in learned(V, F, vertex_iterations=23)]
    for X, Y in zip(usual, longer[:-3], strict=True):
        np.testing.assert_array_equal(X, Y)
    assert (longer[-1] != longer[-2]).any()


def test_its_name_in_the_front():
    V, F = noisy_torus()
    assert denoising.defaults("learned") == {"stages": 2, "vertex_iterations": 20, "fixed": None}
    found = meshfair.denoise(V, F, "learned", stages=1)
    np.testing.assert_array_equal(found.V, result(V, F, stages=1))


# In degrees: what was asked of it before it was trained. The best other defaults: 2.20, 5.65.
@pytest.mark.parametrize(("name", "at_most"), [("Fandisk0.3", 2.1), ("Bunny0.2", 5.0)])
def test_public_pairs_that_it_has_not_seen(mirror, name, at_most):
    V, clean, F = pair(mirror, name)
    assert metrics.normal_angle(meshfair.denoise(V, F, "learned").V, clean, F) <= at_most


# What training learns by: the normals of the mesh that comes of those that were wanted.


@pytest.fixture
def moves(monkeypatch):
    """`data_scripts/train/moves.py`."""
    monkeypatch.syspath_prepend(FIGURES.parents[1] / "data_scripts" / "train")
    return importlib.import_module("moves")


def test_training_moves_vertices_as_often_as_the_filter(moves):
    assert moves.MOVES == denoising.defaults("learned")["vertex_iterations"]


def test_training_follows_slopes_that_differences_have(moves):
    V, F = noisy_torus()
    B, rng = incidence(F, len(V)), np.random.default_rng(0)
    wanted = mesh.face_normals(*shapes.torus(sections=16, sides=8))
    g, way = rng.normal(size=(2, *wanted.shape))

    def places(step):
        return moves.places(V, wanted + step * way, F, B)

    def value(step):
        return np.sum(g * mesh.face_normals(places(step)[-1], F))

    area = mesh.face_areas(places(0)[-1], F)
    assert area.min() > moves.SMALLEST * area.mean()  # no slope is held down
    slope = moves.slopes(places(0), wanted, F, B.indptr, B.indices, g)
    # Central differences err by the square of the step, and by rounding over the step.
    difference = (value(1e-5) - value(-1e-5)) / 2e-5
    assert np.sum(slope * way) == pytest.approx(difference, rel=1e-6)
