"""Copies of vertices along seams, and faces turned against each other: filters undo neither."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from broken import hourglass, moebius_strip, wild_meshes
from meshfair import MeshWarning, denoise, denoising, filters, mesh, metrics, noise, shapes

V, F = shapes.icosphere(2)
V_NOISY = noise.along_normals(V, F, 0.2, np.random.default_rng(3))
# Joined vertices are numbered anew, so that sums run in another order.
ROUNDING = 1e-12

joins = pytest.mark.filterwarnings("ignore:.*copies of others:meshfair.MeshWarning")


def soup(V, F):
    """Each triangle with three vertices of its own."""
    return V[F].reshape(-1, 3), np.arange(F.size).reshape(-1, 3)


def seamed(V, F):
    """The sphere cut in two along its equator, each half with its own vertices there."""
    upper = V[F].mean(axis=1)[:, 2] > 0
    shared = np.intersect1d(F[upper], F[~upper])
    number = np.arange(len(V))
    number[shared] = len(V) + np.arange(len(shared))
    F = F.copy()
    F[upper] = number[F[upper]]
    return np.concatenate([V, V[shared]]), F


def test_a_soup_is_joined_into_the_mesh_it_came_from():
    joined = mesh.join(*soup(V, F))
    assert len(joined.V) == len(V)
    np.testing.assert_array_equal(joined.V[joined.copies], V[F].reshape(-1, 3))
    np.testing.assert_array_equal(joined.V[joined.F], V[F])
    assert mesh.inspect(joined.V, joined.F).ok


def test_a_seam_is_closed_and_what_lies_elsewhere_keeps_its_order():
    W, G = seamed(V, F)
    joined = mesh.join(W, G)
    np.testing.assert_array_equal(joined.V, V)  # the copies come last
    np.testing.assert_array_equal(joined.F, F)


def test_without_seams_nothing_changes():
    joined = mesh.join(V, F)
    assert joined.V is V
    assert joined.F is F
    np.testing.assert_array_equal(joined.copies, np.arange(len(V)))


def test_surfaces_that_only_touch_stay_apart():
    touching, _ = hourglass()
    W, G = hourglass()
    W = np.concatenate([W, W[:1]])
    G = np.where((G == 0) & (np.arange(len(G))[:, None] >= 4), len(W) - 1, G)
    joined = mesh.join(W, G)  # two closed tetrahedra with a corner in one place
    assert len(joined.V) == len(W) == len(touching) + 1
    two_balls = np.concatenate([V, V]), np.concatenate([F, F + len(V)])
    assert len(mesh.join(*two_balls).V) == 2 * len(V)  # even in all places


def test_the_zero_of_either_sign_is_one_place():
    W, G = soup(V, F)
    W[::2][W[::2] == 0] = -0.0
    assert len(mesh.join(W, G).V) == len(V)


@given(wild_meshes())
def test_joining_keeps_every_place_and_joins_once(random):
    W, G = random
    joined = mesh.join(W, G)
    np.testing.assert_array_equal(joined.V[joined.copies], W)
    np.testing.assert_array_equal(joined.copies[G], joined.F)
    assert len(mesh.join(joined.V, joined.F).V) == len(joined.V)
    # No more than welding merges, and where a boundary is left, nothing lies along it.
    assert len(joined.V) >= len(np.unique(W + 0.0, axis=0))


@pytest.mark.parametrize("cut", [soup, seamed])
@pytest.mark.parametrize("method", denoising.methods())
def test_each_method_denoises_a_cut_mesh_as_the_whole_one(method, cut):
    whole = denoise(V_NOISY, F, method)
    W, G = cut(V_NOISY, F)
    with pytest.warns(MeshWarning, match=r"^\d+ of \d+ vertices are copies of others"):
        result = denoise(W, G, method)
    np.testing.assert_allclose(result.V[G], whole.V[F], atol=ROUNDING)


@joins
@pytest.mark.parametrize("method", ["taubin", "bilateral-normal"])
def test_automatic_parameters_see_the_joined_mesh(method):
    W, G = soup(V_NOISY, F)
    ground_truth = V[F].reshape(-1, 3)
    order = mesh.join(W, G).V  # the same numbers for the same probe
    whole = denoise(order, mesh.join(W, G).F, method, parameters="auto")
    result = denoise(W, G, method, parameters="auto", ground_truth=ground_truth)
    np.testing.assert_array_equal(result.V[G], whole.V[mesh.join(W, G).F])
    assert result.parameters == whole.parameters
    assert result.history["normal_angle"].iloc[-1] == metrics.normal_angle(
        result.V, ground_truth, G
    )
    tuned = denoising.tune(W, G, method, ground_truth)
    assert metrics.normal_angle(tuned.V, ground_truth, G) <= result.history["normal_angle"].iloc[-1]


@joins
def test_a_fixed_copy_fixes_the_place():
    W, G = soup(V_NOISY, F)
    fixed = np.array([0, 10])
    result = denoise(W, G, "taubin", fixed=fixed)
    for vertex in fixed:
        copies = (W == W[vertex]).all(axis=1)
        assert copies.sum() > 3
        np.testing.assert_array_equal(result.V[copies], W[copies])
    assert result.parameters["fixed"] is fixed
    assert not np.array_equal(result.V, W)


@joins
def test_a_filter_of_the_module_joins_too_and_yields_what_it_was_given_at_first():
    W, G = soup(V_NOISY, F)
    states = [X for _, X in filters.sun(W, G, normal_iterations=2, vertex_iterations=2)]
    assert states[0] is states[1]
    np.testing.assert_array_equal(states[0], W)
    *_, (_, whole) = filters.sun(V_NOISY, F, normal_iterations=2, vertex_iterations=2)
    np.testing.assert_allclose(states[-1][G], whole[F], atol=ROUNDING)


@joins
@pytest.mark.parametrize("model", ["normals", "gaussian", "uniform", "correlated", "impulsive"])
def test_noise_moves_all_copies_as_one(model):
    W, G = soup(V, F)
    rng = np.random.default_rng(5)
    if model == "impulsive":
        moved = noise.impulsive(W, G, 0.3, 0.5, rng)
    else:
        moved = noise.add(W, G, model, rng, size=0.3)
    assert not np.array_equal(moved, W)
    assert len(np.unique(moved, axis=0)) == len(V)
    assert len(mesh.join(moved, G).V) == len(V)


def flipped(share, rng):
    G = F.copy()
    turned = rng.random(len(F)) < share
    G[turned] = G[turned][:, [0, 2, 1]]
    return G


@pytest.mark.parametrize("parameters", ["default", "auto"])
@pytest.mark.parametrize(
    "method", ["bilateral", "sun", "bilateral-normal", "guided-normal", "feature-convinced"]
)
def test_faces_turned_against_each_other_cost_nothing_but_a_warning(method, parameters, rng):
    with pytest.warns(MeshWarning, match=r"^\d+ of 320 faces were turned to agree"):
        result = denoise(V_NOISY, flipped(0.3, rng), method, parameters=parameters)
    whole = denoise(V_NOISY, F, method, parameters=parameters)
    np.testing.assert_allclose(result.V, whole.V, atol=ROUNDING)


@pytest.mark.filterwarnings("error")
def test_methods_without_normals_do_not_ask_for_orientation(rng):
    G = flipped(0.3, rng)
    for method in ("averaging", "heat", "taubin", "implicit", "regularised", "l0"):
        np.testing.assert_allclose(
            denoise(V_NOISY, G, method).V, denoise(V_NOISY, F, method).V, atol=1e-9
        )  # (the solvers' tolerance is 1e-8 of the residual)


def test_a_surface_of_one_side_is_told():
    W, G = moebius_strip()
    with pytest.warns(MeshWarning, match=r"normals turn over at \d edges, as on a surface of one"):
        denoise(W, G, "bilateral-normal")


def test_normals_that_cancel_are_zero():
    # A vertex of two faces that are turned against each other, at right angles to nothing nice.
    W = np.array([[0.0, 0, 0], [1, 0.1, 0.3], [0.2, 1, 0.7], [0.3, 0.3, 1]])
    G = np.array([[0, 1, 2], [0, 2, 1], [1, 2, 3]])
    normals = mesh.vertex_normals(W * 0.1, G)
    np.testing.assert_array_equal(normals[0], 0)
    np.testing.assert_allclose(normals[3], mesh.face_normals(W, G)[2], atol=1e-15)
    with pytest.warns(MeshWarning, match=r"normals cancel at 1 vertices \(the first is 0\)"):
        moved = noise.along_normals(W, G, 0.1, np.random.default_rng(1))
    np.testing.assert_array_equal(moved[0], W[0])


@given(st.integers(3, 40), st.floats(0, 6))
def test_a_fan_and_its_mirror_image_cancel_wherever_rounding_falls(corners, turn):
    angle = turn + 2 * np.pi * np.arange(corners) / corners
    W = np.column_stack([np.cos(angle), np.sin(angle), 0.3 * np.cos(3 * angle)])
    W = np.concatenate([[[0.0, 0, 0.1]], W]) * 1.7
    k = np.arange(corners)
    G = np.column_stack([0 * k, 1 + k, 1 + (k + 1) % corners])
    both_sides = np.concatenate([G, G[::-1][:, [0, 2, 1]]])
    assert not mesh.vertex_normals(W, both_sides)[0].any()
    assert mesh.vertex_normals(W, G)[0].any()
