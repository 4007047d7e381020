"""Every explorer in JupyterLab: each control at both ends, in both themes, on two screens.

Leaves pictures of what a reader sees in ``screenshots/``: look at them.
"""

import io
import json
import time

import numpy as np
import pytest
from PIL import Image

from lab import Lab, Student, browser_at, missing

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(missing() is not None, reason=f"no browser test: {missing()}"),
    pytest.mark.xdist_group("browser"),
]

IMPORTS = """
import numpy as np
from meshfair import explorers, noise, shapes, viewer
V, F = shapes.knot(60, 8)
V_noisy = noise.along_normals(V, F, 0.3, np.random.default_rng(1))
meshes = {"box": shapes.box(segments=4), "knot": (V, F)}
"""
EXPLORERS = {
    "noise": "explorers.NoiseExplorer(V, F)",
    "averaging": "explorers.AveragingExplorer(V, F, iterations=8)",
    "heat": "explorers.HeatExplorer(V, F, iterations=8)",
    "comparison": "explorers.ComparisonExplorer(V, F, iterations=8)",
    "stability": "explorers.StabilityExplorer(V, F)",
    "iterations": "explorers.IterationExplorer([V_noisy, V], F, ground_truth=V)",
    "jet": "explorers.JetExplorer(detail=0.5, iterations=10)",
    "own-mesh": "explorers.DenoisingExplorer(V_noisy, F, iterations=8)",
    "filters": "explorers.FilterExplorer(meshes)",
    "kernels": "explorers.KernelExplorer(meshes)",
    "neighbourhood": "explorers.NeighbourhoodExplorer(V, F)",
    "eigenmodes": "explorers.EigenmodeExplorer(V, F)",
    "low-pass": "explorers.LowPassExplorer(V, F)",
}
# Without EGL the page draws by itself; one view is shown twice.
WITHOUT_EGL = """
from IPython.display import display
viewer.live.has_egl = lambda: False
flow = explorers.HeatExplorer(V, F, iterations=8)
display(flow.view, flow)
"""
SCREENS = ((1440, 900), (1024, 768))
# Milliseconds without a new frame after which an explorer has come to rest: where work takes
# long, the bar that tells of it appears only after 300.
QUIET = dict.fromkeys(EXPLORERS, 150) | {"filters": 500, "kernels": 1500}

# The places of an explorer's parts, and of the part of the notebook that is in sight.
PLACES = """explorer => {
    explorer.scrollIntoView({ block: "start" });
    const place = node => {
        const box = node.getBoundingClientRect();
        return [box.left, box.top, box.right, box.bottom];
    };
    const all = query => [...explorer.querySelectorAll(query)].map(place);
    const outer = explorer.closest(".jp-WindowedPanel-outer, .jp-Notebook");
    return {
        sight: place(outer),
        stages: all(".stage"),
        curves: all(".meshfair-curves"),
        first: all(".noUi-base, select")[0],
        drawn: [...explorer.querySelectorAll(".meshfair-curves .plot")].map(plot => ({
            plot: place(plot),
            marks: [...plot.querySelectorAll(".curve, circle")].map(place),
        })),
    };
}"""


@pytest.fixture(scope="module")
def student(tmp_path_factory):
    """Someone at a notebook with one explorer in each cell."""

    def cell(name, source):
        return {
            **{"cell_type": "code", "id": name, "source": source},
            **{"metadata": {}, "outputs": [], "execution_count": None},
        }

    cells = [cell("imports", IMPORTS), cell("edge", "explorers.CotangentExplorer()")]
    cells += [cell(name, source) for name, source in EXPLORERS.items()]
    cells += [cell("without-egl", WITHOUT_EGL)]
    kernel = {"name": "python3", "display_name": "Python 3"}
    notebook = {"cells": cells, "metadata": {"kernelspec": kernel}}
    lab = Lab(tmp_path_factory.mktemp("lab"))
    path = lab.notebooks / "explorers.ipynb"
    path.write_text(json.dumps(notebook | {"nbformat": 4, "nbformat_minor": 5}))
    try:
        with browser_at(lab) as both:
            student = Student(*both, path.name)
            student.run_cells("imports", "edge", *EXPLORERS)
            yield student
    finally:
        lab.stop()


def come_to_rest(student, explorer, quiet=150):
    """Wait until an explorer's panels have shown the same frames for a while."""
    student.page.evaluate(
        """async ([explorer, quiet]) => {
            const frames = () => [...explorer.querySelectorAll(".stage")]
                .map(stage => stage.dataset.frame).join();
            const busy = () => [...explorer.querySelectorAll(".meshfair-status-part > .widget-box")]
                .some(box => getComputedStyle(box).visibility === "visible");
            let [last, since] = ["", performance.now()];
            while (performance.now() - since < quiet) {
                await new Promise(resolve => setTimeout(resolve, 20));
                if (frames() !== last || busy()) [last, since] = [frames(), performance.now()];
            }
        }""",
        [explorer.element_handle(), quiet],
    )


def move_all(explorer, end):
    """Put each control of an explorer to one of its ends, as with the keyboard."""
    for handle in explorer.locator(".noUi-handle").all():
        handle.focus()
        handle.press(end)
    for menu in explorer.locator("select").all():
        menu.select_option(index=0 if end == "Home" else menu.locator("option").count() - 1)
    for box in explorer.locator("input[type=checkbox]").all():
        box.set_checked(end == "Home")


def drawn_places(explorer, patience=30.0):
    """Where everything is, once each curve is drawn: a slow filter's come only with its end."""
    deadline = time.monotonic() + patience
    while True:
        places = explorer.evaluate(PLACES)
        if all(drawn["marks"] for drawn in places["drawn"]) or time.monotonic() > deadline:
            return places
        time.sleep(0.1)


def check_places(places, where):
    """Meshes, the first control and the first curve are in sight together, and curves are drawn."""
    left, top, right, bottom = places["sight"]
    for a, b, c, d in [*places["stages"], places["first"], places["curves"][0]]:
        assert left - 1 <= a < c <= right + 1, where
        assert top - 1 <= b < d <= bottom + 1, where
    for drawn in places["drawn"]:
        a, b, c, d = drawn["plot"]
        assert c - a > 150, where
        assert d - b > 100, where
        assert drawn["marks"], where
        for x0, y0, x1, y1 in drawn["marks"]:  # five pixels: half a mark
            assert a - 5 <= x0 <= x1 <= c + 5, where
            assert b - 5 <= y0 <= y1 <= d + 5, where


def check_frame(frame, where, whole=True):
    """A picture shows a mesh, in more than one colour, and all of it."""
    background = frame[0, 0].astype(float)
    mesh = np.abs(frame - background).max(axis=2) > 30  # far more than what JPEG blurs
    assert 0.002 < mesh.mean() < 0.95, where
    assert frame[mesh].std(axis=0).max() > 5, where
    border = np.concatenate([mesh[0], mesh[-1], mesh[:, 0], mesh[:, -1]])
    if whole:
        assert border.mean() < 0.005, where


@pytest.mark.parametrize("theme", ["Light", "Dark"])
@pytest.mark.parametrize("screen", SCREENS, ids=lambda screen: f"{screen[0]}x{screen[1]}")
def test_every_control_of_every_explorer_at_both_ends(student, theme, screen):
    page = student.page
    page.set_viewport_size({"width": screen[0], "height": screen[1]})
    change = "theme => window.jupyterapp.commands.execute('apputils:change-theme', { theme })"
    page.evaluate(change, f"JupyterLab {theme}")
    dark = theme == "Dark"
    for name in EXPLORERS:
        explorer = student.go_to(name).locator(".meshfair-explorer")
        for end in ("Home", "End"):
            move_all(explorer, end)
            come_to_rest(student, explorer, QUIET[name])
            where = f"{name}, {theme}, {screen}, {end}"
            check_places(drawn_places(explorer), where)
            closer = name == "jet" and end == "End" and "missile" in explorer.inner_text()
            for frame in student.frames(explorer):
                assert (frame[0, 0].mean() < 60) == dark, where
                check_frame(frame, where, whole=not closer)
            student.picture(f"explorer-{name}-{theme.lower()}-{screen[0]}-{end.lower()}")
    assert student.output_errors() == []
    assert student.complaints == []


def test_a_corner_is_dragged_until_the_weight_is_negative(student):
    student.go_to_output("edge")
    plot = student.page.locator(".meshfair-cotangents")
    box = plot.locator(".handle.h2").bounding_box()
    edge = plot.locator(".edge").bounding_box()
    mouse = student.page.mouse
    mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    mouse.down()
    mouse.move(edge["x"] - 12, box["y"] + box["height"] / 2, steps=5)
    mouse.up()
    plot.get_by_text("more than 180°, so the weight is negative").wait_for(timeout=5000)
    assert plot.locator(".edge.negative").count() == 1
    student.picture("explorer-edge-negative")
    handle = plot.locator(".handle.h2")
    for _ in range(12):  # and with the keyboard back again
        handle.press("ArrowLeft")
    plot.get_by_text("not more than 180°").wait_for(timeout=5000)
    assert student.complaints == []


def test_a_click_on_a_mesh_chooses_the_vertex(student):
    explorer = student.go_to("neighbourhood").locator(".meshfair-explorer")
    explorer.get_by_role("combobox").select_option("the whole mesh")
    come_to_rest(student, explorer)
    vertex = explorer.locator(".meshfair-status-part")
    before = vertex.inner_text()
    stage = explorer.locator(".stage").nth(2)
    (*_, frame) = student.frames(explorer)
    mesh = np.abs(frame - frame[0, 0].astype(float)).max(axis=2) > 30
    rows, columns = np.nonzero(mesh)
    at = len(rows) // 3
    box = stage.bounding_box()
    x = columns[at] / mesh.shape[1] * box["width"]
    y = rows[at] / mesh.shape[0] * box["height"]
    stage.click(position={"x": float(x), "y": float(y)})
    student.wait_for(
        "([node, old]) => node.innerText !== old", [vertex.element_handle(), before], timeout=5000
    )
    assert student.complaints == []


def test_without_egl_the_page_draws_and_all_that_show_a_view_turn_with_it(student):
    student.run_cells("without-egl")
    page = student.page
    page.set_viewport_size({"width": 1440, "height": 1400})
    cell = student.go_to("without-egl")
    come_to_rest(student, cell, 1000)  # until the flow is there, and drawn well
    student.settle(cell)
    stages = cell.locator(".stage")
    assert stages.count() == 6

    def pictures():
        page.evaluate("document.activeElement.blur()")
        taken = [canvas.screenshot() for canvas in cell.locator(".stage canvas").all()]
        return [np.array(Image.open(io.BytesIO(png)), dtype=float) for png in taken]

    def same(pictures, others):
        # A border that falls between two pixels is not always mixed alike.
        pairs = zip(pictures, others, strict=True)
        return [bool(np.abs(one - other).max() <= 1) for one, other in pairs]

    def turn():
        box = stages.nth(1).bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 40, y + 10, steps=4)
        page.mouse.up()

    first = pictures()
    student.redrawn(cell, turn)
    assert same(pictures(), first) == [False] * 6
    student.picture("explorer-without-egl")
    student.redrawn(cell, cell.get_by_text("Reset view").first.click)
    assert same(pictures(), first) == [True] * 6
    caption = cell.locator("figcaption").nth(2)
    handle = student.slider(cell, "iteration")
    handle.focus()
    handle.press("End")
    student.wait_for("node => node.innerText.includes('t = 1.60')", caption.element_handle())
    student.settle(cell)
    truth, _, flown = np.reshape(same(pictures(), first), (2, 3)).T
    assert truth.all()
    assert not flown.any()
    assert student.output_errors() == []
    assert student.complaints == []


def test_the_page_says_that_python_is_silent(student):
    explorer = student.go_to("noise").locator(".meshfair-explorer")
    assert "Python does not answer" not in explorer.inner_text()
    student.page.evaluate(
        "window.jupyterapp.shell.currentWidget.sessionContext.session.kernel.shutdown()"
    )
    time.sleep(0.5)
    handle = explorer.locator(".noUi-handle").first
    handle.focus()
    handle.press("ArrowRight")
    explorer.get_by_text("Python does not answer").wait_for(timeout=15_000)
    student.picture("explorer-noise-without-kernel")
