"""The explorers of weights and waves: they show what the package computes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshfair import explorers, metrics, noise, operators, shapes, spectrum, viewer, weights
from meshfair.explorers import explorer as explorer_module
from meshfair.explorers.transfer import RIVALS, by_hand, transfer
from meshfair.mesh import mean_edge_length

V, F = shapes.knot(40, 6)


@pytest.fixture(autouse=True)
def quick_pictures(monkeypatch):
    """No page listens, so nothing is drawn."""
    monkeypatch.setattr(viewer.live, "has_egl", lambda: True)


# One vertex


def test_the_neighbourhood_shows_the_rows_of_the_averaging_operators():
    explorer = explorers.NeighbourhoodExplorer(V, F, size=0.3, vertex=17)
    explorer.wait()
    V_noisy = noise.along_normals(V, F, 0.3, np.random.default_rng(1))
    edges = {(a, b) for face in F for a in face for b in face if a != b}
    neighbours = sorted(b for a, b in edges if a == 17)
    assert sorted(explorer.neighbours) == neighbours
    for panel, (name, build) in enumerate(weights.BY_NAME.items()):
        row = operators.averaging(build(V_noisy, F)).toarray()[17]
        np.testing.assert_allclose(explorer.weights[name], row[explorer.neighbours])
        assert explorer.weights[name].sum() == pytest.approx(1)
        away = np.linalg.norm(row @ V_noisy - V_noisy[17]) / mean_edge_length(V, F)
        assert explorer.view.titles[panel].startswith(f"{name}: mean {away:.2f} edges away")


def test_neighbours_are_counter_clockwise_seen_from_outside():
    explorer = explorers.NeighbourhoodExplorer(V, F, size=0.0, vertex=17)
    explorer.wait()
    # A face (17, a, b) is counter-clockwise itself: b comes right after a.
    after = {}
    for face in F:
        if 17 in face:
            _, a, b = np.roll(face, -list(face).index(17))
            after[int(a)] = int(b)
    around = [int(j) for j in explorer.neighbours]
    assert [after[j] for j in around] == [*around[1:], around[0]]


def solids(explorer, panel, value):
    """Vertices of what is drawn in a panel with a value; NaN for the arrow and its ends."""
    shown = explorer.view.panels[panel]
    same = np.isnan(shown.values) if np.isnan(value) else np.isclose(shown.values, value)
    return shown.V[np.unique(shown.F[same])]


def test_the_vertex_goes_to_the_weighted_mean():
    explorer = explorers.NeighbourhoodExplorer(V, F, size=0.3, vertex=17)
    explorer.move_button.click()
    explorer.wait()
    assert explorer.controls["part"].value == 1
    V_noisy = noise.along_normals(V, F, 0.3, np.random.default_rng(1))
    for panel, build in enumerate(weights.BY_NAME.values()):
        mean = (operators.averaging(build(V_noisy, F)) @ V_noisy)[17]
        green = solids(explorer, panel, np.nan)  # two balls around it, and no arrow any more
        np.testing.assert_allclose((green.min(axis=0) + green.max(axis=0)) / 2, mean, atol=1e-9)
    explorer.move_button.click()
    assert explorer.controls["part"].value == 0


def test_negative_weights_are_on_the_other_side_of_the_scale():
    explorer = explorers.NeighbourhoodExplorer(V, F, size=0.4)
    explorer.wait()
    w = explorer.weights["cotangent"]
    assert w.min() < 0
    assert "w < 0" in explorer.view.titles[2]
    low, high = explorer.view.limits
    assert low == -high == -max(np.abs(row).max() for row in explorer.weights.values())
    for weight in w:
        assert len(solids(explorer, 2, weight))


def test_a_click_on_a_bar_chooses_the_neighbour_at_its_end():
    explorer = explorers.NeighbourhoodExplorer(V, F, vertex=17)
    explorer.wait()
    j = int(explorer.neighbours[2])
    shown = explorer.view.panels[1]
    end = np.flatnonzero(explorer._owner == j)[-1]  # of the ball there, behind all of V
    assert end >= len(V)
    explorer.view._on_pick(1, int(end))
    assert explorer.controls["vertex"].value == j
    assert len(shown.V) > len(V)


def test_a_vertex_that_is_none_is_refused():
    with pytest.raises(ValueError, match="vertex"):
        explorers.NeighbourhoodExplorer(V, F, vertex=len(V))


# One edge

corner = st.tuples(st.floats(0.2, 2.5), st.floats(-1.0, 3.0))


@given(left=corner, right=corner)
def test_the_weight_of_an_edge_is_that_of_its_angles(left, right):
    explorer = explorers.CotangentExplorer()
    explorer.points = [[0, 0], [0, 2], [-left[0], left[1]], list(right)]
    i, j, *apexes = np.array(explorer.points, dtype=float)
    angles = []
    for apex in apexes:
        u, v = i - apex, j - apex
        angles.append(np.arccos(u @ v / np.linalg.norm(u) / np.linalg.norm(v)))
    np.testing.assert_allclose(explorer.angles, np.degrees(angles), atol=1e-5)
    a, b = angles
    expected = np.sin(a + b) / (2 * np.sin(a) * np.sin(b))
    assert explorer.weight == pytest.approx(expected, rel=1e-6, abs=1e-6)


def test_an_obtuse_corner_makes_the_weight_negative_and_a_flat_one_none():
    explorer = explorers.CotangentExplorer()
    assert explorer.weight > 0
    explorer.move("a", (-0.1, 1.0))
    assert sum(explorer.angles) > 180
    assert explorer.weight < 0
    explorer.move("a", (0.0, 1.0))
    assert explorer.weight is None
    with pytest.raises(ValueError, match="there is no corner 'c'; choose one of v_i, v_j, a, b"):
        explorer.move("c", (0, 0))


# Waves


def test_an_eigenmode_and_what_the_flow_leaves_of_it():
    explorer = explorers.EigenmodeExplorer(V, F, tau=0.4, iterations=8)
    explorer.controls["mode"].value = 30
    explorer.controls["iteration"].value = 5
    explorer.wait()
    W = weights.cotangent(V, F)
    A = operators.averaging(W)
    wave, relief = (panel.values for panel in explorer.view.panels)
    assert np.abs(wave).max() == pytest.approx(1)
    # It is an eigenvector of W~ with the eigenvalue of the title; five steps leave the relief.
    (eigenvalue,) = {round(float(x), 9) for x in [(wave @ (A @ wave)) / (wave @ wave)]}
    np.testing.assert_allclose(A @ wave, eigenvalue * wave, atol=1e-7)
    assert f"λ = {eigenvalue:.3f}" in explorer.view.titles[0]
    X = wave
    for _ in range(5):
        X = 0.6 * X + 0.4 * (A @ X)
    np.testing.assert_allclose(relief, X, atol=1e-7)
    height = 0.5 * mean_edge_length(V, F)
    moved = np.linalg.norm(explorer.view.panels[1].V - V, axis=1)
    np.testing.assert_allclose(moved, height * np.abs(X), atol=1e-9)
    (decay,) = explorer.plots[1].series
    assert decay["y"][5] == pytest.approx(np.abs(X).max())


def test_a_click_into_the_transfer_function_goes_to_the_nearest_eigenmode():
    explorer = explorers.EigenmodeExplorer(V, F)
    explorer.wait()
    eigenvalues = spectrum.eigenvalues(weights.cotangent(V, F))
    explorer.plots[0].picked = float(eigenvalues[77]) + 1e-9
    assert explorer.controls["mode"].value == 77
    explorer.plots[1].picked = 6.6
    assert explorer.controls["iteration"].value == 7


@pytest.mark.parametrize("name", weights.BY_NAME)
@pytest.mark.parametrize("rival", RIVALS)
def test_each_filter_has_the_transfer_function_that_is_drawn(name, rival):
    explorer = explorers.LowPassExplorer(V, F, size=0.2)
    explorer.controls["weights"].value = name
    explorer.wait()
    found = explorer._found[1]
    for steps in (0, 1, 7):
        factors = transfer(rival, found.eigenvalues, steps)
        through_modes = spectrum.filtered(found.V_noisy, found.W, found.Phi, factors)
        np.testing.assert_allclose(found.states[rival][steps], through_modes, atol=1e-5)


def test_the_filter_by_hand_is_a_projection_and_begins_at_the_best():
    explorer = explorers.LowPassExplorer(V, F, size=0.3)
    explorer.wait()
    found, count = explorer._found[1], explorer.controls["modes"].value
    shown = explorer.view.panels[1].V
    Phi = found.Phi[:, :count]
    D = np.diag(operators.degrees(found.W))
    np.testing.assert_allclose(Phi @ (Phi.T @ (D @ found.V_noisy)), shown, atol=1e-9)
    best = max(explorer.plots[1].series[0]["y"])
    assert metrics.snr(V, shown) == pytest.approx(best)
    assert f"{best:.2f} dB" in explorer.view.titles[1]
    explorer.controls["modes"].value = 100
    explorer.controls["size"].value = 0.5
    explorer.wait()
    assert explorer.controls["modes"].value == 100  # the reader's
    explorer.best_button.click()
    assert explorer.controls["modes"].value != 100


def test_the_other_filters_steps_are_remembered():
    explorer = explorers.LowPassExplorer(V, F)
    explorer.wait()
    explorer.controls["steps"].value = 9
    explorer.controls["rival"].value = "taubin"
    explorer.controls["steps"].value = 4
    explorer.controls["rival"].value = "heat"
    assert explorer.controls["steps"].value == 9
    assert explorer.view.titles[2].startswith("9 heat steps")


@given(count=st.integers(0, 50), width=st.just(0.0) | st.floats(0.02, 0.5))
def test_a_filter_by_hand_falls_from_one_to_zero(count, width):
    eigenvalues = np.linspace(1, -1, 50)
    factors = by_hand(eigenvalues, count, width)
    assert np.all(np.diff(factors) <= 0)
    assert np.all((factors >= 0) & (factors <= 1))
    if width == 0:
        assert factors.sum() == count


def test_all_factors_one_leave_a_mesh_as_it_is():
    W = weights.distance(V, F)
    _, Phi = spectrum.eigenmodes(W)
    np.testing.assert_allclose(spectrum.filtered(V, W, Phi, np.ones(len(V))), V, atol=1e-9)


@pytest.mark.parametrize(
    "kind",
    [explorers.EigenmodeExplorer, explorers.LowPassExplorer, explorers.StabilityExplorer],
    ids=lambda kind: kind.__name__,
)
def test_what_takes_seconds_says_how_many(kind, monkeypatch):
    said = []
    monkeypatch.setattr(explorer_module, "EIGENMODES", 7 / len(V) ** 3)
    monkeypatch.setattr(kind, "say", lambda self, text: said.append(text))
    kind(V, F).wait()
    assert "computing 240 eigenmodes, which takes about 7 s …" in said
    assert "computing" not in said[-1]
