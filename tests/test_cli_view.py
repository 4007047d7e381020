"""meshfair view and compare: pages, pictures and reasons; pages in a real browser."""

import json
import re
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from meshes import grid
from meshfair import MeshError, cli, io, mesh, noise, shapes, viewer
from meshfair.cli import compare, pictures, view
from meshfair.viewer import distance, scripts, window


@pytest.fixture
def files(tmp_path):
    """A clean mesh, a noisy one, and a flat one."""
    V, F = shapes.knot()
    io.write(tmp_path / "clean.ply", V, F)
    io.write(tmp_path / "noisy.ply", noise.along_normals(V, F, 0.3, np.random.default_rng(3)), F)
    io.write(tmp_path / "flat.off", *grid(3))
    return tmp_path


@pytest.fixture
def run(capsys, monkeypatch, files):
    """Run ``meshfair`` in the folder of the files: its exit code, and what it printed."""
    monkeypatch.chdir(files)

    def run(*words):
        code = cli.main([str(word) for word in words])
        return code, *capsys.readouterr()

    return run


@pytest.fixture
def opened(monkeypatch):
    """What was to be opened in a browser, where there is a screen."""
    places = []
    monkeypatch.setattr(window, "has_screen", lambda: True)
    monkeypatch.setattr(view.webbrowser, "open", lambda place: places.append(place) or True)
    return places


# view


def test_view_opens_a_page_and_says_where_it_is(run, opened, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    code, text, err = run("view", "clean.ply", "noisy.ply")
    assert (code, err) == (0, "")
    (place,) = opened
    (page_,) = tmp_path.glob("meshfair-*/clean.ply.html")
    assert place == page_.as_uri()
    assert text.split() == ["page", str(page_)]


def test_view_keeps_the_page_and_draws_a_picture(run, opened, files):
    code, text, _ = run(
        "view", "clean.ply", "noisy.ply", "--out", "p.html", "--picture", "p.png", "--no-open"
    )
    assert code == 0
    assert text.split() == ["picture", "p.png", "page", "p.html"]
    assert not opened
    with Image.open("p.png") as picture:
        assert picture.size == (2 * pictures.SIZE[0] + pictures.BAR, pictures.SIZE[1])
    assert (files / "p.html").stat().st_size > 20_000
    code, text, _ = run("view", "clean.ply", "--out", "p.html", "--force", "--json")
    assert json.loads(text) == {"page": "p.html", "opened": True}
    assert len(opened) == 1


def test_view_without_a_screen_says_so(run, monkeypatch):
    monkeypatch.setattr(window, "has_screen", lambda: False)
    code, text, _ = run("view", "clean.ply", "--out", "p.html")
    assert code == 0
    assert "none could be opened here; open the page in one" in text


@pytest.mark.parametrize(("words", "message"), [
    (["clean.ply", "nothing.ply"], "nothing.ply"),
    (["clean.ply", "--no-open"], "--no-open leaves nothing to do"),
    (["clean.ply", "--out", "p.txt"], "p.txt: name the page .html or .htm"),
    (["clean.ply", "--out", "no/p.html"], "no/p.html: the folder no is not there"),
    (["clean.ply", "--out", "old.html"], "old.html is there already; replace it with --force"),
    (["clean.ply", "--picture", "p.gif"], "p.gif: name the picture .png, .jpg"),
    (["clean.ply", "--picture", "old.png"], "old.png is there already"),
])  # fmt: skip
def test_what_view_cannot_do_is_refused_before_the_work(run, opened, files, words, message):
    for name in ("old.html", "old.png"):
        (files / name).write_text("old")
    code, text, err = run("view", *words)
    assert (code, text) == (1, "")
    assert message in err
    assert err.count("\n") == 1
    assert not opened
    assert not (files / "p.html").exists()
    assert (files / "old.html").read_text() == (files / "old.png").read_text() == "old"


def test_a_page_needs_no_jupyter(run, opened, monkeypatch):
    for name in ("ipywidgets", "anywidget"):
        monkeypatch.setitem(__import__("sys").modules, name, None)
    assert run("view", "clean.ply", "--out", "p.html")[0] == 0


def test_titles_are_as_long_as_tells_files_apart(tmp_path):
    a, b, c = tmp_path / "x" / "m.ply", tmp_path / "y" / "m.ply", tmp_path / "n.ply"
    assert pictures.titles([a, c]) == ["m.ply", "n.ply"]
    assert pictures.titles([a, b]) == ["x/m.ply", "y/m.ply"]
    assert pictures.titles([a, a]) == ["m.ply", "m.ply"]


# Distances


def test_faces_are_divided_so_that_what_is_between_vertices_has_colours():
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    sides = np.array([
        [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5],
        [0, 5, 4], [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2],
    ])  # fmt: skip
    box = corners, np.concatenate([sides, [[1, 3, 7], [1, 7, 5]]])
    shown = viewer.by_distance([box, (corners, sides)], [(corners, sides), box], titles=["a", "b"])
    whole, without = shown.panels
    np.testing.assert_allclose(without.values, 0, atol=1e-12)
    on_lid = whole.V[:, 2] > 1 - 1e-9
    np.testing.assert_allclose(whole.values[~on_lid], 0, atol=1e-12)
    x, y = whole.V[on_lid, 0], whole.V[on_lid, 1]
    expected = np.min([x, 1 - x, y, 1 - y], axis=0)
    np.testing.assert_allclose(whole.values[on_lid], expected, atol=1e-12)
    assert 0.35 < shown.scale.high < 0.5
    # The same surface: area and volume are those of the box.
    assert mesh.area(whole.V, whole.F) == pytest.approx(6)
    assert mesh.volume(whole.V, whole.F) == pytest.approx(mesh.volume(*box))
    fine = shapes.icosphere(5)
    assert distance.divided(*fine)[1] is fine[1]


def test_a_mesh_without_a_reference_has_one_colour():
    V, F = shapes.icosphere(2)
    shown = viewer.by_distance([(V, F)], [None], titles=["a"])
    assert shown.scale is None
    assert shown.panels[0].values is None
    with pytest.raises(MeshError, match="vertex 3 has"):
        viewer.by_distance([(np.where(np.arange(len(V))[:, None] == 3, np.nan, V), F)], [None],
                           titles=["a"])  # fmt: skip


# compare


def test_compare_draws_both_meshes(run):
    code, text, _ = run("compare", "noisy.ply", "clean.ply", "--picture", "c.png")
    assert code == 0
    assert text.splitlines()[-1].split() == ["picture", "c.png"]
    with Image.open("c.png") as picture:
        pixels = np.asarray(picture)
    assert pixels.shape == (pictures.SIZE[1], 2 * pictures.SIZE[0] + pictures.BAR, 3)
    for half in (pixels[40:, : pictures.SIZE[0]], pixels[40:, pictures.SIZE[0] : -pictures.BAR]):
        assert 0.15 < (half.min(axis=2) < 240).mean() < 0.9
    code, _, err = run("compare", "noisy.ply", "clean.ply", "--picture", "c.png")
    assert code == 1
    assert "c.png is there already" in err
    code, text, _ = run(
        "compare", "noisy.ply", "clean.ply", "--picture", "c.png", "--force", "--json"
    )
    assert json.loads(text)["picture"] == "c.png"


@pytest.mark.parametrize("ending", pictures.FORMATS)
def test_pictures_of_each_ending_are_of_that_format(run, ending):
    assert run("view", "flat.off", "--picture", f"p{ending}", "--no-open")[0] == 0
    with Image.open(f"p{ending}") as picture:
        assert picture.format == pictures.FORMATS[ending]
        assert min(picture.getpixel((2, 2))) > 250  # white, not transparent


def test_compare_says_how_close_and_how_sure(run):
    _, text, _ = run("compare", "noisy.ply", "clean.ply")
    found = json.loads(run("compare", "noisy.ply", "clean.ply", "--json")[1])
    mean, widest = found["surface_distance"], found["hausdorff"]
    low, high = widest["value"], widest["value"] + widest["bound"]
    assert f"{mean['value']:.6g} ± {mean['bound']:.2g} mean edge lengths" in text
    assert (f"{low:.6g} to {high:.6g} mean" in text) == (widest["bound"] > 1e-9)
    assert {fact["unit"] for fact in found.values()} == set(compare.UNITS.values())


def test_compare_tells_equal_from_incomparable(run):
    _, text, _ = run("compare", "clean.ply", "clean.ply")
    rows = dict(re.split(r"  +", line, maxsplit=1) for line in text.splitlines())
    assert rows["snr"] == "infinite: the meshes are equal"
    assert rows["hausdorff"] == "0 mean edge lengths"
    equal = json.loads(run("compare", "clean.ply", "clean.ply", "--json")[1])["snr"]
    assert (equal["value"], equal["reason"]) == ("Infinity", None)
    _, text, _ = run("compare", "flat.off", "clean.ply")
    rows = dict(re.split(r"  +", line, maxsplit=1) for line in text.splitlines())
    for name in ("snr", "normal_angle"):
        assert rows[name].startswith("cannot be compared: the meshes have 16 and 1440 vertices")
    assert rows["volume_change"].startswith("cannot be compared: the mesh is open: 12 edges")
    other = json.loads(run("compare", "flat.off", "clean.ply", "--json")[1])
    assert other["snr"]["value"] is other["volume_change"]["value"] is None
    assert "is open" in other["volume_change"]["reason"]


def test_reasons_are_in_the_words_of_the_command(run, files):
    V, F = shapes.icosphere(1)
    io.write(files / "a.ply", V, F)
    F[4] = F[4, ::-1]
    io.write(files / "b.ply", V, F)
    _, text, _ = run("compare", "b.ply", "a.ply")
    assert "some faces are turned the other way round" in text
    assert text.count("meshfair repair --orient outward") == 2


# The page in a browser


# How many pixels each canvas shows, and how many of them in its outermost columns.
OPAQUE = """[...document.querySelectorAll(".stage canvas")].map(canvas => {
    const { clientWidth: width, clientHeight: height } = canvas;
    const copy = new OffscreenCanvas(width, height).getContext("2d");
    copy.drawImage(canvas, 0, 0, width, height);
    const count = (x, columns) => {
        const { data } = copy.getImageData(x, 0, columns, height);
        return data.filter((byte, k) => k % 4 === 3 && byte).length;
    };
    return { all: count(0, width), edges: count(0, 1) + count(width - 1, 1) };
})"""
CAMERA = "document.querySelector('.meshfair-player').player.view.camera.position"


def seen(tab):
    """What each panel shows, and how much of it is not white."""
    stages = [Image.open(BytesIO(stage.screenshot())) for stage in tab.query_selector_all(".stage")]
    return [np.asarray(image.convert("RGB")) for image in stages]


@pytest.mark.xdist_group("browser")
def test_the_page_shows_linked_meshes_from_a_file_without_a_network(browser, run, tmp_path):
    V, F = shapes.icosphere(2)
    far = np.array([448250.0, 5411940.0, 212.0])
    io.write(tmp_path / "<b>ball.obj", V + far, F)
    io.write(tmp_path / "larger.obj", 1.02 * V + far, F)
    assert run("view", "<b>ball.obj", "larger.obj", "--out", "page.html", "--no-open")[0] == 0

    context = browser.new_context(offline=True, viewport={"width": 900, "height": 420})
    tab, complaints, asked = context.new_page(), [], []
    tab.on("pageerror", lambda error: complaints.append(str(error)))
    tab.on("console", lambda m: m.type == "error" and complaints.append(m.text))
    tab.on("request", lambda request: asked.append(request.url.split(":")[0]))
    tab.goto((tmp_path / "page.html").as_uri())
    tab.wait_for_selector(".meshfair-player[data-ready=true]")
    tab.wait_for_timeout(500)
    assert tab.title() == "<b>ball.obj, larger.obj"
    captions = [caption.inner_text() for caption in tab.query_selector_all("figcaption")]
    assert captions == ["<b>ball.obj", "larger.obj"]
    assert "distance from <b>ball.obj, in its unit" in tab.inner_text(".foot")
    assert tab.inner_text(".bar .high") in ("0.02", "≥ 0.02")  # rounding decides
    plain, coloured = seen(tab)
    for pixels in (plain, coloured):
        rows, columns = np.nonzero(pixels.min(axis=2) < 250)
        size = np.array(pixels.shape[:2])
        extent = np.array([np.ptp(rows), np.ptp(columns)])
        assert (extent < size).all()  # all of it,
        assert (extent / size).max() > 0.8  # and not small
    assert (coloured.reshape(-1, 3).astype(int) @ [1, 1, -2]).max() > 150  # yellow
    assert (plain.reshape(-1, 3).astype(int) @ [1, 1, -2]).max() < 50  # blue

    first = tab.evaluate(CAMERA)
    box = tab.query_selector_all(".stage")[1].bounding_box()
    tab.mouse.move(box["x"] + 150, box["y"] + 150)
    tab.mouse.down()
    tab.mouse.move(box["x"] + 250, box["y"] + 180, steps=4)
    tab.mouse.up()
    tab.wait_for_timeout(300)
    assert np.abs(np.subtract(tab.evaluate(CAMERA), first)).max() > 0.1
    turned = seen(tab)
    assert (turned[0] != plain).any()  # turning one turns all
    assert (turned[1] != coloured).any()
    tab.keyboard.press("r")
    tab.wait_for_timeout(300)
    np.testing.assert_allclose(tab.evaluate(CAMERA), first, atol=1e-6)

    tab.set_viewport_size({"width": 400, "height": 900})  # narrow
    tab.wait_for_timeout(500)
    for opaque in tab.evaluate(OPAQUE):
        assert opaque["all"] > 100
        assert opaque["edges"] == 0  # nothing is cut
    assert complaints == []
    assert set(asked) <= {"file", "data"}
    context.close()


@pytest.mark.xdist_group("browser")
def test_the_live_views_script_reports_each_frame_as_shown_whatever_is_in_it(browser):
    script = scripts.text("stage.js", "kernel.js", "frames.js")
    tab = browser.new_page()
    tab.set_content("<body><div id=view style='width: 300px'></div></body>")
    tab.add_script_tag(
        type="module",
        content=script
        + """
window.sent = [];
const model = {
  get: () => 1, off: () => {},
  send: (message) => window.sent.push(message.kind),
  on: (name, receive) => (window.receive = receive),
};
render({ model, el: document.getElementById("view") });
""",
    )
    tab.wait_for_function("window.receive !== undefined")
    jpeg = BytesIO()
    Image.new("RGB", (30, 20), "red").save(jpeg, "JPEG")
    frame = {"kind": "frame", "number": 1, "panels": [0], "titles": ["a"], "draft": False}
    bar = {"label": "x", "low": 0, "high": 1, "stops": ["#000000", "#ffffff"]}
    broken = [
        frame | {"bar": bar | {"low": None, "high": None}},  # as JSON has NaN
        frame | {"bar": bar | {"stops": None}},
        frame | {"bar": None, "titles": None},
        frame | {"bar": None, "panels": [7]},
    ]
    give = "([message, data]) => window.receive(message, [new Uint8Array(data)])"
    for k, message in enumerate(broken):
        tab.evaluate(give, [message, list(jpeg.getvalue())])
        assert tab.evaluate("window.sent.filter(kind => kind === 'shown').length") == k + 1
        assert (tab.inner_text(".error") == "") == (k == 0)
    assert tab.inner_text(".error").startswith("TypeError")
    tab.evaluate(give, [frame | {"bar": bar}, list(jpeg.getvalue())])
    assert tab.inner_text(".error") == ""
    assert tab.inner_text(".bar .high") == "1"
    tab.close()


def test_a_page_of_many_meshes_and_a_title_that_is_none(tmp_path):
    V, F = shapes.icosphere(0)
    shown = viewer.SideBySide([V] * 17, F)  # browsers give no more than sixteen WebGL contexts
    shown.save(tmp_path / "p.html")
    with pytest.raises(ValueError, match="title is 3; give a text"):
        shown.save(tmp_path / "p.html", 3)


def test_a_page_loads_nothing_and_holds_no_end_of_its_own(tmp_path):
    V, F = shapes.icosphere(0)
    title = "</script><script>alert(1)</script>"
    viewer.SideBySide(V, F, titles=title).save(tmp_path / "p.html", title)
    text = (tmp_path / "p.html").read_text(encoding="utf-8")
    assert "alert(1)</script>" not in text
    assert not re.search(r"""(src|href)\s*=\s*["'](?!data:)""", text)
