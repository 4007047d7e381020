"""Notebooks that are saved and opened again, in JupyterLab: stills in place of live widgets."""

import base64
import io
import json

import numpy as np
import pytest
from PIL import Image

from lab import Lab, Student, missing

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(missing() is not None, reason=f"no browser test: {missing()}"),
    pytest.mark.xdist_group("browser"),
]

CELLS = {
    "imports": "from meshfair import explorers, shapes, viewer\nV, F = shapes.knot(60, 8)",
    "view": "viewer.View([V, V], F, titles=['one', 'two'])",
    "webgl": "viewer.View(V, F, backend='webgl')",
    "heat": "explorers.HeatExplorer(V, F, iterations=6)",
    "edge": "explorers.CotangentExplorer()",
    "guess": "explorers.Prediction('How many?', (0, 30))",
}
SHOWN = [name for name in CELLS if name != "imports"]
STILLS = SHOWN[:-1]

# What is seen of a cell's outputs: how many take room, what they say, their stills and widgets.
SEEN = """cell => {
    const area = cell.querySelector(".jp-OutputArea");
    const outputs = [...area.querySelectorAll(":scope > .jp-OutputArea-child")]
        .filter(output => output.offsetHeight > 1);
    const shown = query => outputs.flatMap(output => [...output.querySelectorAll(query)]);
    return {
        outputs: outputs.length,
        text: outputs.map(output => output.innerText).join(" "),
        stills: shown("[class^=meshfair-saved] img, .jp-RenderedHTML img").map(still => still.alt),
        widgets: shown(".jp-OutputArea-output > [class*=meshfair-live]").length,
        room: area.clientWidth - Math.max(...outputs.map(output => output.scrollWidth)),
    };
}"""
ERRORS = ("Error", "not found", "Loading widget")


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    lab = Lab(tmp_path_factory.mktemp("lab"))
    cells = [
        {
            **{"cell_type": "code", "id": name, "source": source},
            **{"metadata": {}, "outputs": [], "execution_count": None},
        }
        for name, source in CELLS.items()
    ]
    kernel = {"name": "python3", "display_name": "Python 3"}
    notebook = {"cells": cells, "metadata": {"kernelspec": kernel}}
    text = json.dumps(notebook | {"nbformat": 4, "nbformat_minor": 5})
    (lab.notebooks / "saved.ipynb").write_text(text)
    yield lab
    lab.stop()


def seen(student, name):
    """What a cell shows."""
    return student.go_to_output(name).evaluate(SEEN)


def saved_stills(path):
    """The pictures in a notebook's outputs, by cell."""
    notebook = json.loads(path.read_text())
    pictures = {}
    for cell in notebook["cells"]:
        for output in cell["outputs"]:
            if "image/png" in output.get("data", {}):
                png = base64.b64decode("".join(output["data"]["image/png"]))
                assert cell["id"] not in pictures
                pictures[cell["id"]] = np.array(Image.open(io.BytesIO(png)).convert("RGBA"))
    return pictures


def check_live(student):
    for name in SHOWN:
        if name in ("view", "webgl", "heat"):
            student.settle(student.go_to(name))
        found = seen(student, name)
        assert (found["outputs"], found["widgets"], found["stills"]) == (1, 1, []), name
        assert not any(word in found["text"] for word in ERRORS), name


def check_saved(student):
    """One still for each view, the question of the guess, and nothing else."""
    for name in SHOWN:
        found = seen(student, name)
        stills = int(name in STILLS)
        assert (found["outputs"], found["widgets"], len(found["stills"])) == (1, 0, stills), name
        assert found["room"] >= 0, name
        assert not any(word in found["text"] for word in ERRORS), name
    assert seen(student, "view")["stills"] == ["2 meshes side by side: one; two."]
    assert "iteration" in seen(student, "heat")["text"]
    assert "How many? (0 to 30)" in seen(student, "guess")["text"]


def test_a_saved_notebook_shows_the_last_stills(lab, page):
    student = Student(*page, "saved.ipynb")
    student.run_cells(*CELLS)
    check_live(student)
    student.picture("saved-live")
    # The camera is turned: the still in the notebook follows, once it has come to rest.
    first = student.page.evaluate(STILL_OF, "view")
    stage = student.go_to("view").locator(".stage").first
    student.redrawn(student.go_to("view"), lambda: stage.press("ArrowLeft"))
    student.wait_for(f"first => ({STILL_OF})('view') !== first", first)
    check_live(student)
    student.page.evaluate("window.jupyterapp.commands.execute('docmanager:save')")
    path = lab.notebooks / "saved.ipynb"
    pictures = saved_stills(path)
    assert sorted(pictures) == sorted(STILLS)
    before = np.array(Image.open(io.BytesIO(base64.b64decode(first))).convert("RGBA"))
    assert (pictures["view"] != before).any()
    for picture in pictures.values():
        assert 0.02 < (picture[:, :, 3] > 0).mean() < 0.9

    # Opened again, with a kernel that has nothing of all that.
    student = Student(*page, "saved.ipynb")
    student.wait_for("document.body.textContent.includes('model not found')")
    check_saved(student)
    for theme in ("Dark", "Light"):
        student.page.evaluate(THEME, f"JupyterLab {theme}")
        student.wait_for(DRESSED, str(theme == "Light").lower())
        student.go_to_output("view")
        student.picture(f"saved-again-{theme.lower()}")
    student.run_cells(*CELLS)
    check_live(student)

    # The kernel is restarted, and then run again.
    student.page.evaluate(
        "window.jupyterapp.shell.currentWidget.sessionContext.session.kernel.restart()"
    )
    check_live(student)
    student.run_cells(*CELLS)
    check_live(student)

    # Not trusted.
    text = path.read_text()
    (lab.notebooks / "foreign.ipynb").write_text(text.replace("60, 8", "50, 8"))
    student = Student(*page, "foreign.ipynb")
    assert "meshfair-live" not in student.page.locator(".jp-Notebook").inner_html()
    check_saved(student)
    student.go_to_output("view")
    student.picture("saved-untrusted")


# The picture that the open notebook would save for a cell.
STILL_OF = """name => window.jupyterapp.shell.currentWidget.content.widgets
    .find(cell => cell.model.id === name).model.sharedModel.outputs
    .map(output => output.data["image/png"]).find(png => png)"""
DRESSED = """light => document.body.dataset.jpThemeLight === light &&
    !document.querySelector("#jupyterlab-splash")"""
THEME = "theme => window.jupyterapp.commands.execute('apputils:change-theme', { theme })"
