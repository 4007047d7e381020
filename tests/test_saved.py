"""What notebooks keep of live widgets: outputs as published, and as nbconvert shows them."""

import base64
import functools
import io
import re
import threading
import time
import warnings
from html.parser import HTMLParser

import numpy as np
import pytest
from PIL import Image

explorers = pytest.importorskip("meshfair.explorers", reason="needs the notebooks extra")
from IPython.core.interactiveshell import InteractiveShell  # noqa: E402
from IPython.display import display  # noqa: E402
from IPython.utils.capture import capture_output  # noqa: E402

from meshfair import viewer  # noqa: E402
from meshfair.viewer import View, saved  # noqa: E402
from small_explorers import KINDS, F, V, small  # noqa: E402

WIDGET = "application/vnd.jupyter.widget-view+json"
SHOWN = {
    "view": lambda: View([V, V], F, titles=["a <b>", None], values=[V[:, 0], None], label="x"),
    "webgl": lambda: View(V, F, backend="webgl"),
    "edge": explorers.CotangentExplorer,
    **{name: functools.partial(small, name) for name in KINDS},
}


@pytest.fixture(autouse=True)
def notebook(monkeypatch):
    """As in a notebook, and where nothing asks for pages."""
    monkeypatch.delenv("MESHFAIR_PAGE", raising=False)
    shell = InteractiveShell.instance()
    yield shell
    InteractiveShell.clear_instance()


class Images(HTMLParser):
    """The images of a page, and its text outside of styles and scripts."""

    def __init__(self, page):
        super().__init__()
        self.images, self.text, self._silent = [], "", False
        self.feed(page)

    def handle_starttag(self, tag, attributes):
        self._silent = tag in ("style", "script")
        if tag == "img":
            self.images.append(dict(attributes))

    def handle_endtag(self, tag):
        self._silent = self._silent and tag not in ("style", "script")

    def handle_data(self, data):
        self.text += "" if self._silent else data


def pixels(png):
    return np.array(Image.open(io.BytesIO(base64.b64decode(png))).convert("RGBA"))


def changed(output, other):
    """The part of the pixels in which two outputs differ."""
    one, two = (pixels(o.data["image/png"]) for o in (output, other))
    return (one != two).any(axis=2).mean()


@pytest.mark.parametrize("name", SHOWN)
def test_a_notebook_gets_a_still_and_then_the_widget(name):
    shown = SHOWN[name]()
    with capture_output() as captured, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the explorers, about meshes this small
        display(shown)
    kept, live = (output.data for output in captured.outputs)
    # Once, and with nothing that a reader without the widget could show twice.
    assert live == {WIDGET: live[WIDGET], "text/plain": ""}
    page = Images(kept["text/html"])
    (image,) = page.images
    assert image["alt"] == kept["text/plain"] != ""
    assert image["src"] == f"data:image/png;base64,{kept['image/png']}"
    # Less wide than the page where that is narrow, and in proportion.
    assert "max-width: 100%" in image["style"]
    assert "height" not in image
    picture = pixels(kept["image/png"])
    assert picture.shape[1] == int(image["width"])
    assert picture[:, :, 3].min() == 0  # transparent: for light and dark pages
    assert 0.02 < (picture[:, :, 3] > 0).mean() < 0.95
    # The rules name the widget that comes with them.
    (number,) = set(re.findall(r"meshfair-live-(\w+)", kept["text/html"]))
    assert number == live[WIDGET]["model_id"]
    assert len(kept["text/html"]) < 100_000
    if hasattr(shown, "controls"):
        described = [control.description for control in shown.controls.values()]
        assert all(f"{text} " in page.text for text in described)


def test_a_question_keeps_what_was_guessed(monkeypatch):
    monkeypatch.setattr(saved, "REST", 0.0)
    guess = explorers.Prediction("How <many>?", (0, 30), unit="dB")
    with capture_output() as captured:
        display(guess)
        assert len(captured.outputs) == 2
        guess.guess = 4
        wait_for(lambda: len(captured.outputs) == 3)
    first, _, second = captured.outputs
    assert Images(first.data["text/html"]).text.strip() == "Your guess. How <many>? (0 to 30 dB)"
    assert "You guess 4 dB" in Images(second.data["text/html"]).text
    with capture_output() as captured:
        display(guess.reveal(2, "So it is."))
    (answer,) = captured.outputs
    assert WIDGET not in answer.data
    assert "The answer is" in answer.data["text/html"]


def wait_for(condition, seconds=20.0):
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def rest():
    """Wait until nothing waits for a rest any more."""
    wait_for(lambda: not any(t.name.startswith("still") for t in threading.enumerate()))


def test_the_still_follows_once_nothing_moves(monkeypatch):
    monkeypatch.setattr(saved, "REST", 0.1)
    view = View(V, F)
    view.update(V)
    rest()  # nothing is drawn before the view is shown
    with capture_output() as captured:
        display(view)
        first = captured.outputs[0]
        for _ in range(30):  # a drag
            view.camera = view.camera.orbit(0.02, 0.0, view.up)
            time.sleep(0.01)
        rest()
        view.camera = view.camera  # nothing else is to be seen
        view.fit(view.aspect)
        rest()
        (turned,) = captured.outputs[2:]
        view.reset()
        rest()
        *_, back = captured.outputs
        with view.together():
            view.update(1.5 * V)
            view.update(2 * V, title="larger")
        rest()
        *_, larger = captured.outputs
    for one in (turned, back, larger):
        assert one.update
        assert one.transient == first.transient
    # At a few edges a picture depends on what was drawn before it.
    assert changed(turned, first) > 0.05
    assert changed(back, first) < 0.001
    assert larger.data["text/plain"] == "A mesh: larger."


def test_an_explorer_s_still_follows_its_controls(monkeypatch):
    monkeypatch.setattr(saved, "REST", 0.1)
    explorer = explorers.AveragingExplorer(V, F, iterations=3)
    with capture_output() as captured:
        display(explorer)
        rest()
        before = len(captured.outputs)
        explorer.controls["iteration"].value = 3
        explorer.wait()
        rest()
    assert len(captured.outputs) == before + 1
    assert "iteration 3" in captured.outputs[-1].data["text/html"]
    assert explorer.view.titles[-1] in captured.outputs[-1].data["text/plain"]


def test_what_cannot_be_drawn_leaves_the_still_of_before(monkeypatch, capfd):
    monkeypatch.setattr(saved, "REST", 0.0)
    view = View(V, F)
    with capture_output() as captured:
        display(view)
        monkeypatch.setattr(viewer.View, "still", lambda self: 1 / 0)
        view.update(2 * V)
        rest()
        assert len(captured.outputs) == 2
    assert "Error" not in capfd.readouterr().err


def test_two_cells_with_one_view_have_one_still():
    view = View(V, F)
    with capture_output() as captured:
        display(view)
        display(view)
    one, _, other, _ = captured.outputs
    assert one.transient == other.transient  # an update reaches both
    assert one.data == other.data


@pytest.fixture(scope="module")
def executed():
    """A notebook that was run, as nbclient leaves it."""
    nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed")
    nbformat = pytest.importorskip("nbformat")
    sources = [
        "from meshfair import explorers, shapes, viewer\nV, F = shapes.knot(30, 5)",
        "viewer.View(V, F, titles='<knot>')",
        "explorers.HeatExplorer(V, F, iterations=3)",
        "explorers.CotangentExplorer()",
        "guess = explorers.Prediction('How many?', (0, 30))\nguess",
        "guess.reveal(2, 'So it is.')",
    ]
    cells = [nbformat.v4.new_code_cell(source) for source in sources]
    notebook = nbformat.v4.new_notebook(cells=cells)
    nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
    return notebook


@pytest.mark.slow
@pytest.mark.xdist_group("kernel")
@pytest.mark.parametrize("state", [True, False], ids=["with-state", "without"])
@pytest.mark.parametrize("template", ["lab", "classic"])
def test_nbconvert_shows_one_still_of_each(executed, state, template):
    nbconvert = pytest.importorskip("nbconvert")
    notebook = executed.copy()
    assert "widgets" in notebook.metadata
    if not state:
        notebook.metadata = {k: v for k, v in notebook.metadata.items() if k != "widgets"}
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # "is not able to be represented"
        text, _ = nbconvert.HTMLExporter(template_name=template).from_notebook_node(notebook)
    page = Images(text)
    alts = [image["alt"] for image in page.images]
    assert alts[0] == "A mesh: <knot>."
    assert alts[1].startswith("3 meshes side by side: ground truth; noisy")
    assert alts[2].startswith("Two triangles at an edge")
    assert len(alts) == 3
    for image in page.images:
        assert (pixels(image["src"].partition(",")[2])[:, :, 3] > 0).mean() > 0.02
    assert "How many? (0 to 30)" in page.text
    assert "The answer is 2" in page.text
    for word in ("Error", "not found", "Loading widget", "HeatExplorer object", "VBox("):
        assert word not in page.text


@pytest.mark.slow
@pytest.mark.xdist_group("kernel")
def test_a_notebook_in_latex_has_the_stills(executed):
    nbconvert = pytest.importorskip("nbconvert")
    source = nbconvert.LatexExporter().from_notebook_node(executed)[0]
    assert source.count(r"\adjustimage") == 3
    assert "meshfair-saved" not in source
