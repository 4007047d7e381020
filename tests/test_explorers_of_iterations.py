"""The iterations of any filter: kept as they are, and measured as the package measures."""

import numpy as np
import pytest

from meshfair import explorers, filters, metrics, noise, shapes
from meshfair.checks import MeshError

V, F = shapes.knot(30, 5)
V_noisy = noise.along_normals(V, F, 0.2, np.random.default_rng(1))


def test_the_slider_goes_through_what_a_filter_yields():
    # Normals are filtered before any vertex moves: those steps show nothing new.
    yielded = [X for _, X in filters.bilateral_normal(V_noisy, F, vertex_iterations=4)]
    explorer = explorers.IterationExplorer([V_noisy, *yielded], F, ground_truth=V)
    explorer.wait()
    assert len(explorer.states) == 5
    assert explorer.settings() == {"iteration": 4}
    np.testing.assert_array_equal(explorer.view.panels[0].V, yielded[-1])
    (curve,) = explorer.plots[0].series
    assert curve["x"] == [0, 1, 2, 3, 4]
    assert curve["y"] == [metrics.normal_angle(V, X, F) for X in explorer.states]
    explorer.controls["iteration"].value = 0
    explorer.wait()
    np.testing.assert_array_equal(explorer.view.panels[0].V, V_noisy)
    assert explorer.plots[0].marker == 0
    assert explorer.view.titles == [f"iteration 0: {curve['y'][0]:.1f}°"]
    explorer.plots[0].picked = 2.4
    explorer.wait()
    np.testing.assert_array_equal(explorer.view.panels[0].V, explorer.states[2])


def test_an_array_that_a_filter_writes_to_again_is_kept_as_it_was():
    def halving():
        X = V.copy()
        for _ in range(3):
            yield X
            X *= 0.5

    explorer = explorers.IterationExplorer(halving(), F)
    explorer.wait()
    np.testing.assert_array_equal(explorer.states, [V, V / 2, V / 4])
    assert explorer.plots == []
    assert explorer.view.titles == ["iteration 2"]


@pytest.mark.parametrize(
    ("states", "said"),
    [
        ([], "states is empty; give"),
        ([V, V[:-1]], f"state 1 has {len(V) - 1} vertices, state 0 has {len(V)}; give"),
        ([V, V * np.nan], "state 1"),
        ([V[:10]], "vertices"),
        (V, "state 0"),
    ],
)
def test_states_that_are_none_are_named(states, said):
    with pytest.raises(MeshError, match=said):
        explorers.IterationExplorer(states, F)


def test_one_state_is_shown_as_it_is():
    explorer = explorers.IterationExplorer([V], F, ground_truth=V)
    explorer.wait()
    assert explorer.error is None
    assert explorer.view.titles == ["iteration 0: 0.0°"]
