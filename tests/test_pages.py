"""Meshes and explorers in pages without a kernel: what is stored, and what a browser shows."""

import base64
import io
import json
import re
import struct
import warnings
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from meshfair import explorers, shapes, viewer
from meshfair.explorers import states
from meshfair.viewer import SideBySide, View, scripts
from meshfair.viewer.packing import NO_VALUE, Arrays
from meshfair.viewer.recording import Recording
from small_explorers import KINDS, MADE, small


@pytest.fixture
def knot():
    return shapes.knot(30, 6)


@pytest.fixture(scope="module")
def heat():
    """An explorer, and the page that it wrote of itself."""
    explorer = explorers.HeatExplorer(*shapes.knot(30, 6), iterations=6)
    explorer.wait()
    return explorer


def unpacked(part):
    """Header and arrays of what `to_html` gives: written from the format, not from its writer."""
    (text,) = re.findall(r'class="packed">([^<]*)</script>', part)
    whole = zlib.decompress(base64.b64decode(text))
    (length,) = struct.unpack("<I", whole[:4])
    header = json.loads(whole[4 : 4 + length])
    return header, decoded(header.get("arrays", []), whole[4 + length :])


def decoded(facts, rest):
    """The arrays, from what is stored of them."""
    arrays = []
    for kind, count, stride, bases, factors in facts:
        width = np.dtype(kind).itemsize
        planes = np.frombuffer(rest[: width * count], np.uint8).reshape(width, count)
        rest = rest[width * count :]
        folded = sum(plane.astype(np.int64) << 8 * k for k, plane in enumerate(planes))
        found = np.where(folded % 2, -(folded + 1) // 2, folded // 2)
        if bases:
            pairs = zip(factors, bases, strict=True)
            expected = sum((factor * arrays[base] for factor, base in pairs), 0.5)
            found = found + np.floor(expected).astype(np.int64)
        else:
            for k in range(stride):
                found[k::stride] = np.cumsum(found[k::stride])
        arrays.append(found.astype(kind))  # what is too large begins again from below
    assert not rest
    return arrays


def positions(header, arrays, state, panel):
    """A mesh's positions in units of the longest side of the first meshes' box."""
    V, _, _, look, _ = header["states"][state]["panels"][panel]
    return arrays[V].reshape(-1, 3) * header["things"][look]["units"]


@given(
    st.floats(-12, 12),
    st.floats(-4, 4),
    st.integers(0, 2**32 - 1),
    st.floats(1, 40),
)
def test_positions_are_stored_within_half_a_step(power, away, seed, growth):
    rng = np.random.default_rng(seed)
    V, F = shapes.icosphere(1)
    V = 10**power * (V + 0.1 * rng.standard_normal(V.shape) + away)
    view = SideBySide(V, F)
    recording = Recording(view)
    recording.add(view)
    # A mesh that has outgrown the grid: its steps are longer, by a power of 2.
    grown = SideBySide(growth * (V - V.mean(axis=0)) + V.mean(axis=0), F)
    recording.add(grown)
    header, arrays = unpacked(f'class="packed">{recording.packed()}</script>')
    low, high = V.min(axis=0), V.max(axis=0)
    side = (high - low).max()
    for state, shown in enumerate((view, grown)):
        wanted = (shown.panels[0].V - (low + high) / 2) / side
        extent = max(1.0, 2 * np.abs(wanted).max())
        # Half a step of 2^16 in the box, or of up to twice as long a one; and its last digits.
        bound = (0.5 if extent == 1 else 1.0) * extent / 65535 * (1 + 1e-3)
        assert np.abs(positions(header, arrays, state, 0) - wanted).max() <= bound


def test_values_and_faces_come_back(knot):
    V, F = knot
    values = V[:, 0].copy()
    values[3] = np.nan
    header, arrays = unpacked(SideBySide([V, V], F, values=[values, None]).to_html())
    (_, faces, places, look, _), (_, _, none, _, _) = header["states"][0]["panels"]
    np.testing.assert_array_equal(arrays[faces].reshape(-1, 3), F)
    known = np.isfinite(values)
    part = (values - values[known].min()) / np.ptp(values[known])
    assert arrays[places][3] == NO_VALUE
    assert np.abs(arrays[places][known] / 254 - part[known]).max() <= 0.5 / 254 + 1e-12
    assert none == -1
    assert len(header["things"][look]["stops"]) == 17


@pytest.mark.parametrize("kind", [np.int16, np.uint8, np.uint16, np.uint32])
@pytest.mark.parametrize("smooth", [True, False])
def test_whole_numbers_of_any_size_come_back(kind, smooth, rng):
    low, high = np.iinfo(kind).min, np.iinfo(kind).max
    ends = rng.integers(low, high, (2, 300), endpoint=True)
    weights = rng.uniform(0, 1, 12) if smooth else rng.integers(0, 2, 12)
    rows = [np.rint(w * ends[0] + (1 - w) * ends[1]).astype(kind) for w in weights]
    rows += [np.array([low, high] * 150, kind), np.array([high, low] * 150, kind)]
    arrays = Arrays()
    numbers = [arrays.add(row, 3, range(len(arrays.facts))) for row in rows]
    found = decoded(arrays.facts, arrays.joined())
    for number, row in zip(numbers, rows, strict=True):
        np.testing.assert_array_equal(found[number], row)
    if smooth and kind != np.uint8:
        # Two of them tell the others, but for rounding.
        assert len(zlib.compress(arrays.joined())) < 6 * rows[0].nbytes


def test_what_states_have_in_common_is_stored_once(knot):
    V, F = knot
    view = SideBySide([V, V], F)
    recording = Recording(view)
    for _ in range(100):
        recording.add(view)
    header, arrays = unpacked(f'class="packed">{recording.packed()}</script>')
    assert len(header["states"]) == 100
    assert len(arrays) == 2  # positions and faces
    # Raw, a hundred states of two panels are 12 bytes a face and 6 a vertex each.
    assert len(recording.packed()) < (6 * len(V) + 12 * len(F))


def test_an_explorer_goes_through_its_settings_and_comes_back(heat):
    before, best = heat.settings(), heat.view.titles[2]
    header, arrays = unpacked(heat.to_html())
    assert heat.settings() == before
    assert heat.view.titles[2] == best
    controls, things = header["controls"], header["things"]
    assert [control["label"] for control in controls] == [
        "weights", "noise (edges)", "time step τ", "colour by", "iteration"
    ]  # fmt: skip
    assert [control["main"] for control in controls] == [False] * 4 + [True]
    assert controls[0]["texts"] == ["combinatorial", "distance", "cotangent"]
    assert controls[4]["texts"] == [str(k) for k in range(7)]
    at = [things[state["at"]] for state in header["states"]]
    assert len(set(map(tuple, at))) == len(at)
    # The first is what was shown; each shows what Python computes with these settings.
    again = explorers.HeatExplorer(*shapes.knot(30, 6), iterations=6)
    V = np.concatenate([panel.V for panel in heat.view.panels])
    centre, side = (V.min(axis=0) + V.max(axis=0)) / 2, np.ptp(V, axis=0).max()
    for state in (0, 3, len(at) - 1):
        for k, control in enumerate(again.controls.values()):
            text = controls[k]["texts"][at[state][k]]
            options = dict(getattr(control, "options", ()))
            control.value = options[text] if options else type(control.value)(text)
        again.wait()
        shown = header["states"][state]
        assert things[shown["panels"][2][4]] == again.view.titles[2]
        stored = centre + side * positions(header, arrays, state, 2)
        np.testing.assert_allclose(stored, again.view.panels[2].V, atol=side / 65535)
        (plot,) = things[shown["plots"]]
        assert plot["marker"] == again.plots[0].marker


def test_an_explorer_takes_no_more_of_a_page_than_it_may(monkeypatch):
    explorer = explorers.HeatExplorer(*shapes.knot(60, 8), iterations=10)
    explorer.wait()
    whole = len(unpacked(explorer.to_html())[0]["states"])
    monkeypatch.setattr(states, "LARGEST", 60_000)
    packed = states.recorded(explorer).packed()
    # One state more may be stored than there is room for.
    assert len(packed) < 1.2 * 60_000
    assert 2 < len(unpacked(f'class="packed">{packed}</script>')[0]["states"]) < whole


def test_no_explorer_is_left_out():
    public = {getattr(explorers, name) for name in explorers.__all__}
    assert set(MADE) == {
        kind
        for kind in public
        if issubclass(kind, explorers.Explorer) and kind is not explorers.Explorer
    }


@pytest.mark.parametrize("name", KINDS)
def test_every_explorer_has_a_form_without_a_kernel(name, monkeypatch):
    monkeypatch.setattr(states, "LONGEST", 0.5)
    explorer = small(name)
    explorer.wait()
    before = explorer.settings()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        monkeypatch.setenv("MESHFAIR_PAGE", "1")
        data, _ = explorer._repr_mimebundle_()
    assert list(data) == ["text/html"]
    header, _ = unpacked(data["text/html"])
    assert len(header["states"]) > 1
    assert sum(control["main"] for control in header["controls"]) == 1
    assert explorer.settings() == before
    for state in header["states"]:
        for place, control in zip(header["things"][state["at"]], header["controls"], strict=True):
            assert 0 <= place < len(control["texts"])


def test_a_page_is_asked_for_by_the_environment(knot, monkeypatch):
    view, edge = View(*knot, titles="a <knot>", backend="webgl"), explorers.CotangentExplorer()
    guess = explorers.Prediction("How <many>?", (0, 30), unit="dB")
    shown = [view, edge, guess, guess.reveal(2, "So it is.")]
    for value in ("", "0"):
        monkeypatch.setenv("MESHFAIR_PAGE", value)
        for one in shown[:3]:
            assert "application/vnd.jupyter.widget-view+json" in str(one._repr_mimebundle_())
    monkeypatch.setenv("MESHFAIR_PAGE", "1")
    shown[3], texts = guess.reveal(2, "So it is."), []  # nobody is told that no guess was made
    for one in shown:
        data, _ = one._repr_mimebundle_()
        assert list(data) == ["text/html"]
        assert "\n\n" not in data["text/html"]  # Markdown would end the HTML there
        texts.append(data["text/html"])
    assert 'aria-label="A mesh: a &lt;knot&gt;."' in texts[0]
    assert "How &lt;many&gt;? (0 to 30 dB)" in texts[2]
    assert "The answer is <b>2 dB</b>. So it is." in texts[3]


def test_the_files_of_pages_are_plain_scripts_and_styles():
    found = viewer.page_files()
    assert sorted(found) == ["meshfair.css", "meshfair.js"]
    assert not re.search(r"^\s*(import|export)\b", found["meshfair.js"], re.MULTILINE)
    assert "</script" not in found["meshfair.js"]
    assert "</style" not in found["meshfair.css"]
    assert len("".join(found.values()).encode()) < 100_000


# In a browser


def opened(browser, path, complaints, **options):
    tab = browser.new_context(offline=True, **options).new_page()
    tab.on("pageerror", lambda error: complaints.append(str(error)))
    tab.on("console", lambda m: m.type == "error" and complaints.append(m.text))
    tab.goto(path.as_uri())
    return tab


def rest(tab):
    """Wait until what was planned has been drawn, and drawn well."""
    tab.evaluate("() => new Promise(go => requestAnimationFrame(() => requestAnimationFrame(go)))")
    stages = "[...document.querySelectorAll('.stage')]"
    tab.wait_for_function(f"{stages}.every(stage => stage.dataset.draft !== 'true')")


def marker(tab):
    return float(tab.get_attribute(".meshfair-curves svg line.marker", "x1"))


@pytest.mark.xdist_group("browser")
@pytest.mark.parametrize(("width", "scheme"), [(1440, "light"), (390, "dark")])
def test_an_explorer_moves_in_a_page_on_file(browser, heat, tmp_path, width, scheme):
    heat.save(tmp_path / "heat.html", "heat flow")
    complaints = []
    tab = opened(
        browser, tmp_path / "heat.html", complaints,
        viewport={"width": width, "height": 900}, color_scheme=scheme,
    )  # fmt: skip
    tab.wait_for_selector(".meshfair-player[data-ready=true] line.marker", state="attached")
    rest(tab)
    stored = tab.evaluate(
        "document.querySelector('.meshfair-player').player.arrays.map(a => [...a])"
    )
    assert stored == [array.tolist() for array in unpacked(heat.to_html())[1]]
    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    paper = np.asarray(Image.open(io.BytesIO(tab.screenshot())))[0, 0, :3]
    assert (paper.mean() < 60) == (scheme == "dark")
    stage = tab.locator(".stage").nth(2)
    first, label = stage.screenshot(), tab.inner_text("figcaption >> nth=2")
    assert label == heat.view.titles[2]
    assert stage.get_attribute("aria-label") == f"Mesh: {label}"

    box = stage.bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    tab.mouse.move(*middle)
    tab.mouse.down()
    tab.mouse.move(middle[0] + 60, middle[1] + 20, steps=3)
    tab.mouse.up()
    rest(tab)
    turned = stage.screenshot()
    assert turned != first
    tab.keyboard.press("ArrowLeft")
    tab.keyboard.press("+")
    rest(tab)
    assert stage.screenshot() != turned
    tab.keyboard.press("r")
    rest(tab)
    frame, before = int(stage.get_attribute("data-frame")), marker(tab)

    slider = tab.locator(".along input[type=range]")
    slider.focus()
    slider.press("End")
    rest(tab)
    assert int(stage.get_attribute("data-frame")) > frame
    assert marker(tab) > before
    assert "t = 1.20" in tab.inner_text("figcaption >> nth=2")
    assert slider.get_attribute("aria-valuetext") == "6"
    tab.select_option(".controls select >> nth=0", label="cotangent")
    rest(tab)
    assert "cotangent" in tab.inner_text("figcaption >> nth=2")
    tab.click("button.back")
    rest(tab)
    assert tab.inner_text("figcaption >> nth=2") == label
    assert marker(tab) == before
    # On a slow machine a frame may come when all that was asked for has been drawn.
    tab.evaluate("""() => {
        const { view } = document.querySelector(".meshfair-player").player;
        for (const { picture } of view.panels) picture.cost = 1000;
        view.draw();
    }""")
    rest(tab)
    assert complaints == []
    tab.context.close()


@pytest.mark.xdist_group("browser")
def test_the_cotangent_explorer_computes_in_the_page(browser, tmp_path):
    explorer, complaints = explorers.CotangentExplorer(), []
    explorer.save(tmp_path / "edge.html")
    tab = opened(browser, tmp_path / "edge.html", complaints)
    tab.wait_for_selector(".meshfair-player[data-ready=true] .said")
    assert f"= {explorer.weight:.2f}" in tab.inner_text(".said .weight")
    handle = tab.locator(".handle.h2")
    handle.focus()
    for _ in range(13):
        handle.press("ArrowRight")
    explorer.move("a", (-0.3, 1.2))
    assert explorer.weight < 0
    assert f"= \u2212{-explorer.weight:.2f}" in tab.inner_text(".said .weight")
    assert complaints == []
    tab.context.close()


@pytest.mark.xdist_group("browser")
def test_without_scripts_or_webgl_the_still_stays(browser, knot, tmp_path):
    SideBySide(*knot, titles="the knot").save(tmp_path / "knot.html")
    tab = opened(browser, tmp_path / "knot.html", [], java_script_enabled=False)
    assert tab.locator("img.still").bounding_box()["height"] > 100
    assert tab.get_attribute("img.still", "alt") == "A mesh: the knot."
    tab.context.close()

    tab = browser.new_context().new_page()
    tab.add_init_script("OffscreenCanvas.prototype.getContext = () => null")
    tab.goto((tmp_path / "knot.html").as_uri())
    tab.wait_for_selector(".meshfair-player[data-failed=true] .error")
    assert "no WebGL 2" in tab.inner_text(".error")
    assert tab.locator("img.still").bounding_box()["height"] > 100
    tab.context.close()


class Live:
    """A view that draws in the page, in a browser: what both say to each other is carried over."""

    HOST = """
window.sent = [];
const model = {
  get: () => COUNT, off: () => {}, send: (message) => window.sent.push(message),
  on: (name, receive) => (window.receive = receive),
};
const el = document.getElementById("view");
window.release = render({ model, el });
window.carry = (message, buffers) => window.receive(message, buffers.map((text) => {
  // As the notebook gives them: parts of a larger piece of memory, on any border.
  const letters = "?" + atob(text);
  const bytes = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
  return new DataView(bytes.buffer, 1);
}));
"""

    def __init__(self, tab, view, width=500):
        self.tab, self.view, self._posted = tab, view, []
        view.widget.send = lambda message, buffers=(): self._posted.append((message, buffers))
        style = "<style>" + scripts.text("frames.css") + "</style>"
        tab.set_content(f"{style}<body><div id=view style='width: {width}px'></div></body>")
        host = self.HOST.replace("COUNT", str(len(view.panels)))
        tab.add_script_tag(type="module", content=scripts.text(*scripts.LIVE) + host)
        tab.wait_for_function("window.sent !== undefined")

    def settle(self):
        """Carry messages until there are none any more, and the pictures are fine ones."""
        for _ in range(50):
            rest(self.tab)
            for message in self.tab.evaluate("window.sent.splice(0)"):
                self.view._backend._receive(None, message, None)
            posted, self._posted = self._posted, []
            for message, buffers in posted:
                texts = [base64.b64encode(data).decode() for data in buffers]
                self.tab.evaluate("([m, b]) => window.carry(m, b)", [message, texts])
            drafts = self.tab.locator(".stage:not([data-draft=false])").count()
            if not posted and not drafts:
                return
        raise AssertionError("no rest")

    def pictures(self):
        self.tab.evaluate("document.activeElement.blur()")  # without the line around it
        return [stage.screenshot() for stage in self.tab.locator(".stage").all()]


@pytest.mark.xdist_group("browser")
def test_a_view_without_egl_is_drawn_by_the_page_and_turned_by_both(browser, knot):
    V, F = knot
    view = View([V, V], F, titles=["a", "b"], values=[None, V[:, 2]], label="z", backend="webgl")
    complaints = []
    tab = browser.new_page()
    tab.on("pageerror", lambda error: complaints.append(str(error)))
    tab.on("console", lambda m: m.type == "error" and complaints.append(m.text))
    live = Live(tab, view)
    assert tab.locator("canvas").count() == 0  # a saved notebook's still goes where there is one
    live.settle()
    assert tab.locator("figcaption").all_inner_texts() == ["a", "b"]
    assert tab.inner_text(".bar .label") == "z"
    first = live.pictures()
    home = view.camera

    # The page turns, and Python knows.
    box = tab.locator(".stage").nth(1).bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    tab.mouse.move(x, y)
    tab.mouse.down()
    tab.mouse.move(x + box["height"] / 4, y, steps=3)
    tab.mouse.up()
    live.settle()
    turned = live.pictures()
    assert turned[0] != first[0]
    assert turned[1] != first[1]
    # A quarter of the panel's height, without its border, is an eighth of a whole turn.
    height = box["height"] - 2
    angle = -np.pi * (box["height"] / 4) / height
    expected = home.orbit(angle, 0, view.up)
    np.testing.assert_allclose(view.camera.position, expected.position, atol=1e-6)
    # Python turns, and the page follows.
    view.reset()
    live.settle()
    assert live.pictures() == first
    tab.locator(".stage").nth(1).press("ArrowLeft")
    live.settle()
    assert view.camera == home.orbit(np.pi / 24, 0, view.up)
    tab.click("text=Reset view")
    live.settle()
    assert view.camera == home
    assert live.pictures() == first

    # Another mesh in one panel leaves the other as it is.
    view.update(0.8 * V, panel=1, values=np.arange(len(F)), title="c")
    live.settle()
    changed = live.pictures()
    assert changed[0] == first[0]
    assert changed[1] != first[1]
    assert tab.locator(".stage").nth(1).get_attribute("aria-label") == "Mesh: c"

    clicked = []
    view.on_pick(lambda *which: clicked.append(which))
    nearest = np.linalg.norm(V - view.camera.position, axis=1).argmin()
    across, up, back = view.camera.axes @ (V[nearest] - view.camera.position)
    middle = tab.locator(".stage").nth(0).bounding_box()
    scale = middle["height"] / 2 / (np.tan(np.radians(12.5)) * -back)
    tab.mouse.click(
        middle["x"] + middle["width"] / 2 + scale * across,
        middle["y"] + middle["height"] / 2 - scale * up,
    )
    live.settle()
    assert clicked == [(0, nearest)]
    assert complaints == []
    tab.close()


@pytest.mark.xdist_group("browser")
def test_a_view_without_webgl_says_so(browser, knot):
    tab = browser.new_context().new_page()
    tab.add_init_script("OffscreenCanvas.prototype.getContext = () => null")
    tab.goto("about:blank")
    Live(tab, View(*knot, backend="webgl"))
    assert "no WebGL 2" in tab.inner_text("#view .error")
    tab.context.close()


def test_the_scripts_of_widgets_are_modules_of_their_own():
    for names in (
        scripts.LIVE,
        ("stage.js", "kernel.js", "frames.js"),
        ("curves.js",),
        ("cotangents.js",),
    ):
        assert scripts.text(*names).count(scripts.EXPORT) == 1
