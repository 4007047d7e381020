"""The notebooks in JupyterLab, in a real browser: sliders, pointer, frames, errors.

Leaves pictures of what a reader sees in ``screenshots/``: look at them.
"""

import statistics
import time

import numpy as np
import pytest

from lab import Lab, Student, missing

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(missing() is not None, reason=f"no browser test: {missing()}"),
    # One lab and one browser at a time: they share two cores with the kernel.
    pytest.mark.xdist_group("browser"),
]

# Runs in the page: notes when each frame of a panel arrives, and what its caption says then.
WATCH = """panel => {
    window.seen = [];
    const caption = panel.parentElement.querySelector("figcaption");
    new MutationObserver(() => window.seen.push({
        time: performance.now(), caption: caption.textContent,
        draft: panel.dataset.draft === "true",
    })).observe(panel, { attributeFilter: ["data-frame"] });
    for (const name of ["keydown", "pointermove", "change"]) {
        document.addEventListener(name, () => (window.moved = performance.now()), true);
    }
}"""


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    lab = Lab(tmp_path_factory.mktemp("lab"))
    lab.set_parameters("03-heat-flow.ipynb", "SECTIONS, SIDES = 360, 42")
    lab.set_parameters("05-the-jet.ipynb", "DETAIL = 1.4")
    yield lab
    lab.stop()


@pytest.fixture
def say(capsys):
    """Print a line on the terminal: times are for people to read, and never asserted."""

    def say(text):
        with capsys.disabled():
            print(f"\n  {text}", end="")

    return say


def difference(picture, other):
    """Mean difference of two pictures of one size, in levels of 255."""
    return np.abs(picture.astype(float) - other).mean()


def summary(times):
    return f"median {statistics.median(times):.0f} ms, longest {max(times):.0f} ms"


def test_heat_flow_of_30000_triangles(page, say):
    student = Student(*page, "03-heat-flow.ipynb")
    seconds = student.run_cells(
        "imports", "parameters", "opening", "start", "heat-explorer", "modes", "stability-explorer"
    )
    cell = student.go_to("heat-explorer")
    stages, captions = cell.locator(".stage"), cell.locator("figcaption")
    student.settle(cell)
    assert stages.count() == 3
    assert captions.all_inner_texts()[0] == "ground truth"
    before = student.frames(cell)
    student.picture("03-heat-light-wide")
    stages.nth(2).evaluate(WATCH)
    keyboard = student.page.keyboard

    # The iteration slider chooses among computed meshes, the time step computes the flow anew.
    iteration = student.slider(cell, "iteration")
    iteration.focus()
    assert int(iteration.get_attribute("aria-valuenow").split(".")[0]) > 0  # the best one
    student.frame_times([lambda: keyboard.press("Home")], ["t = 0.00,"])
    right = [lambda: keyboard.press("ArrowRight")] * 8
    shown = student.frame_times(right, [f"t = {0.2 * k:.2f}," for k in range(1, 9)])
    student.slider(cell, "time step τ").focus()
    left, right = [lambda: keyboard.press("ArrowLeft")] * 2, [lambda: keyboard.press("ArrowRight")]
    taus = [0.15, 0.10, 0.15]
    computed = student.frame_times(left + right, [f"t = {8 * tau:.2f}," for tau in taus])

    # Eight moves as fast as they can be made: the last is what stays on the screen.
    iteration.focus()
    for _ in range(8):
        keyboard.press("ArrowLeft")
    student.wait_for("window.seen.at(-1).caption.includes('t = 0.00,')")
    student.settle(cell)
    assert "t = 0.00," in captions.nth(2).inner_text()

    drags = student.drag(stages.nth(0))
    student.settle(cell)
    after = student.frames(cell)
    assert min(map(difference, after, before)) > 1, "the cameras are not linked"

    # The reset button brings the first picture back, play moves the slider, a click the curve.
    student.redrawn(cell, lambda: cell.get_by_text("Reset view").click())
    assert difference(student.frames(cell)[0], before[0]) < 0.1
    play = cell.locator(".widget-play button").first
    play.click()
    student.wait_for("parseFloat(window.seen.at(-1).caption.match(/t = ([\\d.]+)/)[1]) > 0.5")
    play.click()
    plot = cell.locator(".meshfair-curves svg.ground")
    box = plot.bounding_box()
    plot.click(position={"x": box["width"] - 20, "y": 50})
    student.wait_for("parseFloat(window.seen.at(-1).caption.match(/t = ([\\d.]+)/)[1]) > 5")

    cell = student.go_to("stability-explorer")
    student.settle(cell)
    assert "eigenmodes grow" in cell.inner_text()
    student.picture("03-stability-light-wide")
    assert student.output_errors() == []
    assert student.complaints == []
    say(f"03 with 30,240 triangles: cells in {seconds:.1f} s")
    say(f"iteration slider to frame: {summary(shown)}")
    say(f"time-step slider to frame (a new flow): {summary(computed)}")
    say(f"drag to frame (three panels): {summary(drags)}")


def test_jet_in_both_themes_and_on_a_narrow_page(page, say):
    student = Student(*page, "05-the-jet.ipynb")
    seconds = student.run_cells("imports", "parameters", "explorer")
    cell = student.go_to("explorer")
    student.settle(cell)
    stages = cell.locator(".stage")
    stages.nth(1).evaluate(WATCH)
    before = student.frames(cell)

    student.slider(cell, "iteration").focus()
    student.frame_times([lambda: student.page.keyboard.press("Home")], ["t = 0.00,"])
    right = [lambda: student.page.keyboard.press("ArrowRight")] * 5
    shown = student.frame_times(right, [f"t = {0.2 * k:.2f}," for k in range(1, 6)])
    for _ in range(5):
        student.page.keyboard.press("ArrowLeft")
        student.page.keyboard.press("ArrowRight")
    student.settle(cell)
    assert "t = 1.00," in cell.locator("figcaption").nth(1).inner_text()
    drags = student.drag(stages.nth(1))
    student.settle(cell)
    after = student.frames(cell)
    assert min(map(difference, after, before)) > 1, "the cameras are not linked"
    student.picture("05-jet-light-wide")

    look = cell.get_by_role("combobox").first
    student.redrawn(cell, lambda: look.select_option("a wing-tip missile"))
    student.theme(cell, "Dark")
    student.picture("05-missile-dark-wide")
    student.narrow(cell)
    cell = student.go_to("explorer")
    student.settle(cell)
    student.picture("05-missile-dark-narrow")
    student.theme(cell, "Light")
    student.picture("05-missile-light-narrow")

    assert student.output_errors() == []
    assert student.complaints == []
    say(f"05 with 29,020 triangles in each panel: cells in {seconds:.1f} s")
    say(f"iteration slider to frame (three panels): {summary(shown)}")
    say(f"drag to frame (three panels): {summary(drags)}")


def test_filters_by_name_and_cancelled_by_the_next_choice(page, say):
    student = Student(*page, "07-which-filter.ipynb")
    student.run_cells("imports", "parameters", "meshes", "explorer")
    cell = student.go_to("explorer")
    student.settle(cell)
    stages, captions = cell.locator(".stage"), cell.locator("figcaption")
    assert stages.count() == 3
    student.picture("07-box-light-wide")
    stages.nth(1).evaluate(WATCH)

    def choose(menu, entry, caption):
        began = time.monotonic()
        student.page.evaluate("window.seen.length = 0")
        cell.get_by_role("combobox").nth(menu).select_option(entry)
        student.wait_for("text => window.seen.some(f => f.caption.startsWith(text))", caption)
        return time.monotonic() - began

    mesh, method = 0, 1
    heat = choose(method, "heat", "heat: ")
    torus = choose(mesh, "torus", "heat: ")

    # l0 on the jet takes seconds: the noisy jet is there meanwhile, and the bar; heat ends it.
    cell.get_by_role("combobox").nth(method).select_option("l0")
    choose(mesh, "jet", "l0: at work")
    cell.get_by_role("button", name="Cancel").wait_for(timeout=10_000)
    student.picture("07-at-work-light-wide")
    jet = choose(method, "heat", "heat: ")
    student.settle(cell)
    assert "noisy: " in captions.nth(0).inner_text()
    assert "mean normal angle" in cell.inner_text()
    student.theme(cell, "Dark")
    student.picture("07-jet-dark-wide")
    student.narrow(cell)
    cell = student.go_to("explorer")
    student.settle(cell)
    student.picture("07-jet-dark-narrow")

    assert student.output_errors() == []
    assert student.complaints == []
    say(f"07: another method, mesh, and one that cancels: {heat:.1f}, {torus:.1f}, {jet:.1f} s")
