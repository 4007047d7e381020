"""Explorers: what they show is what the package computes, and only the newest counts."""

import re
import threading

import numpy as np
import pytest

from drive import drive
from meshfair import (
    denoising,
    explorers,
    flow,
    metrics,
    noise,
    operators,
    shapes,
    viewer,
    weights,
)
from meshfair.explorers import worker
from meshfair.explorers.worker import LatestWins
from meshfair.mesh import mean_edge_length
from meshfair.viewer import coloring

V, F = shapes.knot(40, 6)
MESHES = {"box": shapes.box(segments=4), "knot": (V, F)}


@pytest.fixture(autouse=True)
def quick_pictures(monkeypatch):
    """No page listens, so nothing is drawn; k3d would build its widgets, too."""
    monkeypatch.setattr(viewer.live, "has_egl", lambda: True)


@pytest.mark.parametrize(
    "make",
    [
        lambda: explorers.NoiseExplorer(V, F),
        lambda: explorers.AveragingExplorer(V, F, iterations=5),
        lambda: explorers.HeatExplorer(V, F, iterations=5),
        lambda: explorers.ComparisonExplorer(V, F, iterations=5),
        lambda: explorers.StabilityExplorer(V, F, iterations=5),
        lambda: explorers.JetExplorer(detail=0.5, iterations=3),
        lambda: explorers.DenoisingExplorer(V, F, iterations=5),
        lambda: explorers.FilterExplorer(MESHES),
    ],
)
def test_every_control_works_at_both_ends(make):
    explorer = make()
    assert drive(explorer) == []
    menus = [control for control in explorer.controls.values() if hasattr(control, "options")]
    assert menus
    for menu in menus:  # names that a reader knows, and no two alike
        labels = [label for label, _ in menu.options]
        assert len(set(labels)) > 1
        assert all(re.fullmatch(r"[\w() -]+", label) for label in labels), labels


def test_the_noise_explorer_shows_the_snr():
    explorer = explorers.NoiseExplorer(V, F, size=0.3)
    explorer.wait()
    noisy = noise.along_normals(V, F, 0.3, np.random.default_rng(1))
    assert explorer.snr == metrics.snr(V, noisy)
    assert explorer.view.titles[1] == f"noisy: {explorer.snr:.2f} dB"
    (curve,) = explorer.plots[0].series
    assert np.interp(0.3, curve["x"], curve["y"]) == pytest.approx(explorer.snr, abs=0.05)
    explorer.controls["shift"].value = 2.0
    explorer.wait()
    np.testing.assert_array_equal(explorer.view.panels[1].V, noisy)  # the picture stays


@pytest.mark.parametrize(
    ("model", "expected"),
    [
        ("gaussian", lambda rng: noise.gaussian(V, F, 0.3, rng)),
        ("uniform", lambda rng: noise.uniform(V, 0.3 * mean_edge_length(V, F), rng)),
        ("impulsive", lambda rng: noise.impulsive(V, F, 0.3, 0.1, rng)),
    ],
)
def test_every_noise_model_has_its_size_in_mean_edge_lengths(model, expected):
    explorer = explorers.NoiseExplorer(V, F, size=0.3)
    explorer.controls["seed"].value = 5
    explorer.controls["model"].value = model
    explorer.wait()
    V_noisy = expected(np.random.default_rng(5))
    np.testing.assert_array_equal(explorer.view.panels[1].V, V_noisy)
    assert explorer.snr == metrics.snr(V, V_noisy)


def test_the_heat_explorer_shows_the_flow():
    explorer = explorers.HeatExplorer(V, F, size=0.3, tau=0.5, iterations=6)
    explorer.controls["weights"].value = "cotangent"
    explorer.controls["iteration"].value = 4
    explorer.wait()
    V_noisy = noise.along_normals(V, F, 0.3, np.random.default_rng(1))
    expected = list(flow.heat(V_noisy, operators.averaging(weights.cotangent(V_noisy, F)), 0.5, 3))
    np.testing.assert_array_equal(explorer.view.panels[1].V, V_noisy)
    np.testing.assert_array_equal(explorer.view.panels[2].V, expected[4][1])
    decibels = [metrics.snr(V, X) for _, X in expected]
    assert explorer.view.titles[2] == f"cotangent, t = 2.00, SNR {decibels[4]:.2f} dB"
    (curve,) = explorer.plots[0].series
    np.testing.assert_allclose(curve["y"], decibels)
    np.testing.assert_allclose(curve["x"], [t for t, _ in expected])
    assert explorer.plots[0].marker == 2.0


def test_a_click_into_the_plot_goes_to_that_iteration():
    explorer = explorers.HeatExplorer(V, F, tau=0.2, iterations=10)
    explorer.wait()
    explorer.plots[0].picked = 0.83
    assert explorer.controls["iteration"].value == 4
    explorer.plots[0].picked = 99.0
    assert explorer.controls["iteration"].value == 10


def test_the_iteration_slider_computes_nothing_anew():
    explorer = explorers.HeatExplorer(V, F, iterations=5)
    explorer.wait()
    run = explorer._run
    for iteration in range(6):
        explorer.controls["iteration"].value = iteration
    explorer.wait()
    assert explorer._run is run
    assert "t = 1.00" in explorer.view.titles[2]


def test_twenty_fast_moves_end_at_the_last():
    explorer = explorers.HeatExplorer(V, F, iterations=5)
    explorer.controls["iteration"].value = 5
    for tau in np.linspace(0.05, 1, 20):
        explorer.controls["tau"].value = tau
    explorer.wait()
    assert "t = 5.00" in explorer.view.titles[2]


def test_the_averaging_explorer_counts_iterations():
    explorer = explorers.AveragingExplorer(V, F, size=0.2, iterations=5)
    explorer.controls["iteration"].value = 3
    explorer.wait()
    V_noisy = noise.along_normals(V, F, 0.2, np.random.default_rng(1))
    A = operators.averaging(weights.combinatorial(F, len(V)))
    np.testing.assert_allclose(explorer.view.panels[2].V, flow.average(V_noisy, A, 3))
    assert explorer.view.titles[2].startswith("combinatorial, s = 3, SNR")


def test_the_comparison_has_one_noise_for_all_weights():
    explorer = explorers.ComparisonExplorer(V, F, iterations=3)
    explorer.wait()
    explorer.controls["iteration"].value = 0
    first, *others = (panel.V for panel in explorer.view.panels)
    for other in others:
        np.testing.assert_array_equal(other, first)
    assert [curve["name"] for curve in explorer.plots[0].series] == [
        "combinatorial",
        "distance",
        "cotangent",
    ]


def test_the_stability_explorer_says_how_many_eigenmodes_grow():
    explorer = explorers.StabilityExplorer(V, F, iterations=30)
    explorer.controls["weights"].value = "combinatorial"
    explorer.controls["tau"].value = 1.0
    explorer.wait()
    assert explorer._note.value.startswith("0 of 240 eigenmodes grow")
    (factors,) = explorer.plots[1].series
    assert max(factors["y"]) <= 1 + 1e-12
    explorer.controls["tau"].value = 2.0
    explorer.controls["iteration"].value = 30
    explorer.wait()
    assert not explorer._note.value.startswith("0 of")
    (states,) = explorer._run.states.values()
    moved = np.linalg.norm(states[30] - V, axis=1).max()
    assert moved > 100 * np.ptp(V, axis=0).max()


def test_the_jet_loses_its_missiles_and_the_camera_follows():
    explorer = explorers.JetExplorer(detail=0.5, iterations=2)
    explorer.wait()
    whole = explorer.view.camera
    explorer.controls["look"].value = explorer.closer
    explorer.wait()
    assert explorer.view.camera != whole
    explorer.controls["missiles"].value = False
    explorer.wait()
    assert len(explorer.view.panels[0].V) == len(shapes.jet(missiles=False, detail=0.5)[0])
    assert explorer.view.camera != whole


def test_the_denoising_explorer_hands_out_what_it_shows():
    explorer = explorers.DenoisingExplorer(V, F, iterations=5)
    explorer.controls["iteration"].value = 3
    V_shown, F_shown = explorer.mesh()
    np.testing.assert_array_equal(V_shown, explorer.view.panels[1].V)
    np.testing.assert_array_equal(F_shown, F)
    change = metrics.volume_change(V_shown, V, F)
    assert explorer.view.titles[1] == f"cotangent, t = 0.60, volume {100 * (1 + change):.2f} %"


def test_the_filter_explorer_shows_what_denoise_makes_of_the_mesh():
    explorer = explorers.FilterExplorer(MESHES, method="taubin", size=0.3, seed=2)
    explorer.controls["mesh"].value = "knot"
    explorer.controls["parameters"].value = "auto"
    explorer.wait()
    V_noisy = noise.along_normals(V, F, 0.3, np.random.default_rng(2))
    expected = denoising.denoise(V_noisy, F, "taubin", parameters="auto", ground_truth=V)
    noisy, denoised, coloured = explorer.view.panels
    np.testing.assert_array_equal(noisy.V, V_noisy)
    np.testing.assert_array_equal(denoised.V, expected.V)
    np.testing.assert_array_equal(coloured.V, expected.V)
    np.testing.assert_array_equal(coloured.values, coloring.normal_angle(V, F)(expected.V))
    assert explorer.result.parameters == expected.parameters
    angle, decibels = metrics.normal_angle(expected.V, V, F), metrics.snr(V, expected.V)
    assert explorer.view.titles[1] == f"taubin: {decibels:.2f} dB, {angle:.2f}°"
    for plot, column in zip(explorer.plots, ("normal_angle", "snr"), strict=True):
        (curve,) = plot.series
        np.testing.assert_allclose(curve["y"], expected.history[column])
        assert plot.marker == len(expected.history) - 1
    found = metrics.compare(expected.V, F, V, F)
    for reported in (f"{decibels:.2f} dB", f"{found['hausdorff'].value:.3f} edges"):
        assert reported in explorer.table.value
    assert f"iterations = {expected.parameters['iterations']};" in explorer._note.value


def test_the_filter_explorer_points_the_camera_at_another_mesh():
    explorer = explorers.FilterExplorer(MESHES)
    explorer.wait()
    whole = explorer.view.camera
    explorer.controls["method"].value = "heat"
    explorer.wait()
    assert explorer.view.camera == whole
    explorer.controls["mesh"].value = "knot"
    explorer.wait()
    assert explorer.view.camera != whole
    assert explorer.error is None


@pytest.fixture
def endless(monkeypatch):
    """A method that yields until it is ended; tells that it is at work, and how often it began."""
    monkeypatch.setattr(denoising, "_METHODS", dict(denoising._METHODS))
    at_work, begun = threading.Event(), []

    @denoising.register("endless")
    def endless(V, F):
        begun.append(len(V))
        while True:
            V = V * 0.999
            yield 0.5, V
            at_work.set()

    return at_work, begun


def test_a_new_choice_cancels_the_running_filter(endless):
    at_work, begun = endless
    explorer = explorers.FilterExplorer(MESHES, method="endless")
    assert at_work.wait(20)
    explorer.controls["method"].value = "heat"
    explorer.wait(20)
    assert begun == [len(MESHES["box"][0])]
    assert explorer.result.method == "heat"
    assert explorer.result.finished
    assert explorer.view.titles[1].startswith("heat: ")
    assert explorer.error is None


def test_slow_work_shows_its_noisy_mesh_and_cancel_keeps_what_there_is(endless, monkeypatch):
    monkeypatch.setattr(worker, "DELAY", 0.0)
    at_work, _ = endless
    explorer = explorers.FilterExplorer(MESHES, method="endless", size=0.3)
    assert at_work.wait(20)
    V_box, F_box = MESHES["box"]
    V_noisy = noise.along_normals(V_box, F_box, 0.3, np.random.default_rng(1))
    np.testing.assert_array_equal(explorer.view.panels[0].V, V_noisy)
    assert explorer.view.titles[1] == "endless: at work"
    assert f"{metrics.snr(V_box, V_noisy):.2f} dB" in explorer.table.value
    assert "denoised" not in explorer.table.value
    explorer._cancel.click()
    explorer.wait(20)
    assert not explorer.result.finished
    np.testing.assert_array_equal(explorer.view.panels[1].V, explorer.result.V)
    assert explorer.view.titles[1].startswith("endless, cancelled: ")
    assert "denoised" in explorer.table.value


def test_a_failure_is_shown_in_one_line(monkeypatch):
    explorer = explorers.HeatExplorer(V, F, iterations=3)
    explorer.wait()

    def broken(settings):
        raise ValueError("no <such> mesh")

    monkeypatch.setattr(explorer, "_start", broken)
    explorer.controls["size"].value = 0.7
    explorer.wait()
    assert isinstance(explorer.error, ValueError)
    assert explorer._note.value == "ValueError: no &lt;such&gt; mesh"
    monkeypatch.undo()
    explorer.controls["size"].value = 0.6
    explorer.wait()
    assert explorer.error is None


def test_cancel_keeps_what_there_is(monkeypatch):
    explorer = explorers.HeatExplorer(V, F, iterations=40)
    explorer.wait()
    measured, seen = explorer._measured, []

    def cancel_after_ten(X, start):
        seen.append(X)
        if len(seen) == 10:
            explorer._cancel.click()
        return measured(X, start)

    monkeypatch.setattr(explorer, "_measured", cancel_after_ten)
    explorer.controls["tau"].value = 0.5
    explorer.wait()
    assert explorer._run.iterations == 9
    explorer.controls["iteration"].value = 40
    assert "t = 4.50" in explorer.view.titles[2]


# The work in the background


def test_only_the_newest_request_is_worked_on():
    began, go_on, done = threading.Event(), threading.Event(), []

    def work(job, number):
        began.set()
        go_on.wait(10)
        job.check()
        done.append(number)

    latest = LatestWins(work, report=lambda part: None, failed=done.append)
    latest.request(0)
    began.wait(10)
    for number in range(1, 20):
        latest.request(number)
    go_on.set()
    latest.wait()
    assert done == [19]


def test_progress_is_reported_only_of_long_work(monkeypatch):
    reported = []
    quick = LatestWins(lambda job: job.progress(0.5), reported.append, reported.append)
    quick.request()
    quick.wait()
    assert 0.5 not in reported
    monkeypatch.setattr(worker, "DELAY", 0.0)
    slow = LatestWins(lambda job: job.progress(0.5), reported.append, reported.append)
    slow.request()
    slow.wait()
    assert reported[-2:] == [0.5, 1.0]
