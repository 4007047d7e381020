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
    sure,
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
    """No page listens, so nothing is drawn."""
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
        lambda: explorers.KernelExplorer(MESHES),
        lambda: explorers.NeighbourhoodExplorer(V, F),
        lambda: explorers.EigenmodeExplorer(V, F, iterations=5),
        lambda: explorers.LowPassExplorer(V, F),
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
        assert all(re.fullmatch(r"[\w() =.-]+", label) for label in labels), labels


def test_the_noise_explorer_shows_the_snr():
    explorer = explorers.NoiseExplorer(V, F, size=0.3)
    explorer.wait()
    noisy = noise.along_normals(V, F, 0.3, np.random.default_rng(1))
    assert explorer.snr == metrics.snr(V, noisy)
    assert explorer.view.titles[1] == f"noisy: {explorer.snr:.2f} dB"
    (curve,) = explorer.plots[0].series
    assert curve["y"][curve["x"].index(0.3)] == explorer.snr  # the same number in both places
    explorer.controls["shift"].value = 2.0
    explorer.wait()
    np.testing.assert_array_equal(explorer.view.panels[1].V, noisy)  # the picture stays


@pytest.mark.parametrize(
    ("model", "expected"),
    [
        ("gaussian", lambda rng: noise.gaussian(V, F, 0.3, rng)),
        ("uniform", lambda rng: noise.uniform(V, 0.3 * mean_edge_length(V, F), rng)),
        ("correlated", lambda rng: noise.correlated(V, F, 0.3, rng)),
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


FLOWS = [explorers.HeatExplorer, explorers.AveragingExplorer, explorers.ComparisonExplorer]


@pytest.mark.parametrize("kind", FLOWS, ids=lambda kind: kind.__name__)
def test_a_flow_begins_at_its_best_iteration_and_marks_it(kind):
    explorer = kind(V, F, size=0.9, iterations=12)
    explorer.wait()
    series = explorer.plots[0].series
    peaks = {curve["name"]: int(np.argmax(curve["y"])) for curve in series}
    highest = max(series, key=lambda curve: max(curve["y"]))
    assert explorer.controls["iteration"].value == peaks[highest["name"]] > 0
    assert explorer.plots[0].marker == highest["best"][0]
    for curve in series:
        assert curve["best"] == [curve["x"][peaks[curve["name"]]], max(curve["y"])]
        assert f"best {max(curve['y']):.2f} dB at" in curve["legend"]
    assert len({curve["mark"] for curve in series}) == len(series)


def test_the_best_is_followed_until_the_reader_chooses_and_again_by_the_button():
    explorer = explorers.HeatExplorer(V, F, size=0.9, tau=0.2, iterations=30)
    explorer.wait()

    def best():
        return int(np.argmax(explorer.plots[0].series[0]["y"]))

    first = best()
    explorer.controls["tau"].value = 0.05
    explorer.wait()
    assert explorer.controls["iteration"].value == best() > first
    explorer.controls["iteration"].value = 3
    explorer.controls["tau"].value = 0.1
    explorer.wait()
    assert explorer.controls["iteration"].value == 3
    explorer.best_button.click()
    assert explorer.controls["iteration"].value == best() != 3
    assert f"t = {best() * 0.1:.2f}," in explorer.view.titles[2]
    explorer.controls["tau"].value = 0.2
    explorer.wait()
    assert explorer.controls["iteration"].value == best() == first


def test_without_a_ground_truth_the_estimated_risk_says_where_to_begin():
    rng = np.random.default_rng(1)
    V_fine, F_fine = shapes.knot(120, 16)
    V_noisy = noise.along_normals(V_fine, F_fine, 0.2, rng)
    explorer = explorers.DenoisingExplorer(V_noisy, F_fine, iterations=30)
    explorer.controls["weights"].value = "combinatorial"
    explorer.wait()
    iteration = explorer.controls["iteration"].value
    assert 0 < iteration < 30
    (states,) = explorer._run.states.values()
    risks = [sure.true_risk(X, V_fine, F_fine) for X in states]
    assert risks[iteration] < 1.2 * min(risks) < 0.5 * risks[0]  # near the best of all


def test_shrinking_is_one_colour_and_the_scale_has_zero_in_its_middle():
    explorer = explorers.HeatExplorer(V, F, size=0.0, iterations=5)
    explorer.controls["color"].value = "signed displacement"
    explorer.controls["iteration"].value = 5
    explorer.wait()
    view = explorer.view
    assert view.cmap == "coolwarm"
    assert view.limits[0] == -view.limits[1] < 0
    assert view.panels[2].values.mean() < 0  # a tube shrinks
    explorer.controls["color"].value = "displacement"
    assert (view.cmap, view.limits[0]) == ("viridis", 0)
    np.testing.assert_allclose(
        view.panels[2].values * mean_edge_length(V, F),
        np.linalg.norm(view.panels[2].V - V, axis=1),
    )


@pytest.mark.parametrize("name", coloring.COLORINGS)
def test_a_mesh_without_any_error_has_a_scale_that_means_something(name):
    explorer = explorers.DenoisingExplorer(V, F, iterations=3)
    explorer.wait()
    explorer.controls["color"].value = name
    explorer.controls["iteration"].value = 0
    assert explorer.view.limits[1] >= coloring.COLORINGS[name].least >= 0.01


def test_at_late_iterations_the_scale_grows_with_what_is_shown():
    explorer = explorers.AveragingExplorer(V, F, size=0.1, iterations=30)
    explorer.wait()
    explorer.controls["iteration"].value = 0
    before = explorer.view.limits
    explorer.controls["iteration"].value = 30
    values, (low, high) = explorer.view.panels[2].values, explorer.view.limits
    assert high > 3 * before[1]
    assert np.mean(values > high) <= 0.02
    assert low == 0


def seen(view, k):
    """How far from the middle of a view's picture a panel's mesh reaches; 1 is its edge."""
    camera, X = view.camera, view.panels[k].V
    across, up, towards = ((X - camera.position) @ camera.axes.T).T
    half = np.tan(np.radians(viewer.camera.FIELD_OF_VIEW) / 2) * -towards
    assert np.all(half > 0)
    return max(np.abs(across / half).max() / view.aspect, np.abs(up / half).max())


@pytest.mark.parametrize("size", [0.2, 1.2])
def test_no_mesh_is_cut_off_however_strong_the_noise_or_the_growth(size):
    explorer = explorers.StabilityExplorer(V, F, size=size, iterations=30)
    explorer.controls["tau"].value = 2.0
    explorer.wait()
    for iteration in (0, 3, 10, 30):
        explorer.controls["iteration"].value = iteration
        assert seen(explorer.view, 0) <= 1 + 1e-9
    assert re.search(r", drawn 1 : [\d.,e+]+$", explorer.view.titles[0])
    heat = explorers.HeatExplorer(V, F, size=size, iterations=3)
    heat.wait()
    for k in range(3):
        assert seen(heat.view, k) <= 1 + 1e-9
    drawn = explorer.view.panels[0].V
    (states,) = explorer._run.states.values()
    # It is drawn smaller, and has the same shape.
    small, large = (X - X.mean(axis=0) for X in (drawn, states[30]))
    np.testing.assert_allclose(small / np.ptp(small), large / np.ptp(large), atol=1e-9)


def test_a_turned_camera_stays_turned_when_the_noise_grows():
    explorer = explorers.NoiseExplorer(V, F, size=0.1)
    explorer.wait()
    view = explorer.view
    view.camera = view.camera.orbit(0.5, 0.2, view.up)
    axes = view.camera.axes
    distance = np.linalg.norm(np.subtract(view.camera.position, view.camera.target))
    explorer.controls["size"].value = 1.0
    explorer.wait()
    np.testing.assert_allclose(view.camera.axes, axes, atol=1e-12)
    assert np.linalg.norm(np.subtract(view.camera.position, view.camera.target)) > distance


def test_a_mesh_that_became_a_wire_is_drawn_thicker():
    explorer = explorers.AveragingExplorer(V, F, size=0.0, iterations=40)
    explorer.wait()
    explorer.controls["iteration"].value = 40
    (states,) = explorer._run.states.values()
    drawn = explorer.view.panels[2].V
    assert explorer.view.titles[2].endswith(", drawn thicker")
    hair = np.linalg.norm(drawn - states[40], axis=1) / np.ptp(V, axis=0).max()
    assert 0.002 < hair.min() <= hair.max() < 0.01


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


def test_the_filter_explorer_goes_a_part_of_the_way_with_any_noise():
    explorer = explorers.FilterExplorer(MESHES, method="taubin", size=0.3, seed=2)
    explorer.controls["noise"].value = "impulsive"
    explorer.controls["strength"].value = 0.25
    explorer.controls["mesh"].value = "knot"
    explorer.wait()
    V_noisy = noise.impulsive(V, F, 0.3, 0.1, np.random.default_rng(2))
    X = denoising.denoise(V_noisy, F, "taubin").V
    np.testing.assert_array_equal(explorer.view.panels[0].V, V_noisy)
    np.testing.assert_allclose(explorer.view.panels[1].V, V_noisy + 0.25 * (X - V_noisy))
    assert "strength = 0.25;" in explorer._note.value


def test_the_filter_explorer_says_what_auto_chose_and_why():
    explorer = explorers.FilterExplorer(MESHES, method="auto", size=0.0)
    explorer.wait(120)
    assert explorer.view.titles[1].startswith("auto, left as it is: ")
    assert "left as it is: nothing promises" in explorer._note.value
    explorer.controls["size"].value = 0.3
    explorer.wait(120)
    chosen = explorer.result.method
    assert explorer.view.titles[1].startswith(f"auto, {chosen}: ")
    assert explorer._note.value.startswith(f"{chosen} with ")
    assert explorer._note.value.endswith("of the error should be left")


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
    monkeypatch.setattr(denoising.registry, "_METHODS", dict(denoising.registry._METHODS))
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
