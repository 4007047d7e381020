"""How meshes and figures look: scales, clicks, themes."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshfair import plotting, shapes, viewer
from meshfair.viewer import Camera, View, coloring, offscreen, scripts
from meshfair.viewer.panel import Panel, Scale
from meshfair.viewer.picking import pick

needs_egl = pytest.mark.skipif(not viewer.has_egl(), reason="polyscope cannot draw here: no EGL")
V, F = shapes.torus(sections=24, sides=12)
ROOT = Path(__file__).resolve().parent.parent
FIGURE_CODE = {".py", ".js", ".ipynb", ".typ"}
# The first of matplotlib's default colours, which are nearly those of the weights.
MATPLOTLIBS_OWN = {"#1f77b4", "#ff7f0e", "#2ca02c", "#d62728"}

# Scales


def scale_of(values, limits=None):
    values = np.resize(np.asarray(values, dtype=float), len(V))
    return Scale.of([Panel(V, F, values)], limits)


@pytest.mark.parametrize(
    ("values", "ends"),
    [
        ([0.02, 0.5, 1.2], (0, 1.2)),  # near 0 for its length: from 0
        ([-1.2, -0.5, -0.02], (-1.2, 0)),
        ([20, 21], (20, 21)),
        ([-0.3, 2], (-0.3, 2)),
        ([0, 0], (0, 1)),  # and not 0 to 1e-9
        ([3, 3], (0, 3)),
        ([-3, -3], (-3, 0)),
    ],
)
def test_a_scale_begins_at_zero_where_the_quantity_does(values, ends):
    scale = scale_of(values)
    assert (scale.low, scale.high) == ends
    assert not scale.below
    assert not scale.above


def test_a_scale_says_where_values_lie_beyond_it():
    assert scale_of([0, 0.5, 2], limits=(0, 1)).ends() == ("0", "≥ 1")
    assert scale_of([-1, 0.5], limits=(0, 1)).ends() == ("≤ 0", "1")
    assert scale_of([0, 1], limits=(0, 1)).ends() == ("0", "1")
    assert scale_of([0, 123456], limits=(0, 123456)).ends() == ("0", "1.2e+05")
    assert scale_of([0, 0.9473], limits=(0, 0.9473)).ends() == ("0", "0.947")


@given(st.floats(1e-6, 1e12))
def test_bars_end_at_the_next_round_number(number):
    end = coloring.round_up(number)
    assert number * (1 - 1e-9) <= end <= 1.34 * number  # from 3 to 4 is the longest way
    assert float(f"{end:.1e}") == pytest.approx(end, rel=1e-12)  # two digits


@pytest.mark.parametrize("name", coloring.COLORINGS)
def test_limits_hold_all_but_two_in_a_hundred(name, rng):
    look = coloring.COLORINGS[name]
    values = rng.normal(size=1000) * 3
    low, high = look.limits(values)
    assert np.mean(np.abs(values) > high) <= 0.02
    assert low == (-high if look.signed else 0)
    assert look.limits(np.zeros(5))[1] == coloring.round_up(look.least)


def test_signed_displacement_of_a_sphere_that_has_grown_or_shrunk():
    X, G = shapes.icosphere(2)
    of = coloring.signed_displacement(X, G)
    for factor in (0.9, 1.2):
        distance = coloring.displacement(X, G)(factor * X)
        np.testing.assert_allclose(of(factor * X), np.sign(factor - 1) * distance, rtol=1e-3)


# Clicks


def project(points, camera, aspect):
    """Where points are in a picture, from -1 to 1."""
    across, up, towards = ((points - camera.position) @ camera.axes.T).T
    half = np.tan(np.radians(viewer.camera.FIELD_OF_VIEW) / 2) * -towards
    return np.column_stack([across / half / aspect, up / half])


@pytest.mark.parametrize("aspect", [0.5, 1.6])
def test_a_click_finds_the_vertex_on_the_near_side(aspect):
    X, G = shapes.icosphere(2)
    camera = Camera.around(X, (1, -0.4, 0.3), aspect=aspect)
    towards = np.array(camera.position)
    places = project(X, camera, aspect)
    # A vertex of the unit sphere can be seen where the camera is above its tangent plane.
    heights = X @ towards
    for vertex in np.flatnonzero(heights > 1.3):
        assert pick(X, G, camera, tuple(0.999 * places[vertex]), aspect) == vertex
    for vertex in np.flatnonzero(heights < -0.2 * np.linalg.norm(towards)):
        found = pick(X, G, camera, tuple(places[vertex]), aspect)
        assert found is None or heights[found] > heights[vertex]
    assert pick(X, G, camera, (0.99, 0.99), aspect) is None


def test_nothing_behind_the_camera_is_clicked():
    X, G = shapes.icosphere(1)
    camera = Camera((3, 0, 0), (6, 0, 0), (0, 0, 1))
    assert pick(X, G, camera, (0.0, 0.0), 1.0) is None


def test_a_view_tells_what_was_clicked():
    view = View([V, V], F, backend="webgl")
    view.click(1, 0.0, 0.3)  # which nobody wants to know
    clicked = []
    view.on_pick(lambda panel, vertex: clicked.append((panel, vertex)))
    at = project(V, view.camera, view.aspect)
    nearest = np.linalg.norm(V - view.camera.position, axis=1).argmin()
    view.click(1, *at[nearest])
    view.click(0, 1.0, 1.0)
    assert clicked == [(1, nearest)]


def test_a_page_that_asks_is_answered():
    class Silent:
        sent: list = []  # noqa: RUF012 (one view, one test)

        def send(self, message, buffers=None):
            self.sent.append(message)

    view = View(V, F, backend="polyscope")
    view.widget.send = Silent().send
    clicked = []
    view.on_pick(lambda *which: clicked.append(which))
    view._backend._receive(None, {"kind": "ping"}, None)
    assert Silent.sent == [{"kind": "pong"}]
    nearest = np.linalg.norm(V - view.camera.position, axis=1).argmin()
    x, y = project(V, view.camera, view.aspect)[nearest]
    message = {"kind": "click", "panel": 0, "x": float(x), "y": float(y)}
    view._backend._receive(None, message, None)
    assert clicked == [(0, nearest)]


# Cameras


def test_refit_shows_what_has_grown_and_keeps_the_readers_turn():
    view = View(V, F, backend="webgl")
    view.refit(3 * V)
    np.testing.assert_allclose(
        view.camera.position,
        Camera.around(3 * V, (1, -1, 0.6), aspect=view.aspect).position,
    )
    turned = view.camera.orbit(0.7, 0.1, view.up).zoom(0.5)
    view.camera = turned
    view.refit(6 * V)
    np.testing.assert_allclose(view.camera.axes, turned.axes, atol=1e-12)
    np.testing.assert_allclose(view.camera.position, 2 * np.array(turned.position), atol=1e-9)


# Themes


@needs_egl
def test_a_still_is_transparent_after_a_dark_page(rng):
    dark = (0.07, 0.07, 0.07)
    camera = Camera.around(V, (1, -1, 0.6))
    viewer.on_gl_thread(
        lambda: offscreen.scene().draw(Panel(V, F), camera, (40, 30), background=dark)
    )
    view = View([V, V], F, titles=["a", "b"], values=[None, V[:, 2]])
    picture = np.array(view.still((600, 300)))
    assert picture.shape[2] == 4
    assert np.all(picture[:, :2, 3] == 0)
    white = np.array(view.still((600, 300), background="white"))
    assert white.shape[2] == 3
    assert np.all(white[:, :2] == 255)
    with pytest.raises(ValueError, match="background is 'blurple'; give a colour such as 'white'"):
        view.still((600, 300), background="blurple")


@needs_egl
def test_edges_of_an_older_mesh_do_not_stay(rng):
    camera = Camera.around(V, (1, -1, 0.6))

    def drawn(edges, faces):
        panel = Panel(V, faces, edges=edges)
        return viewer.on_gl_thread(
            lambda: offscreen.scene().draw(panel, camera, (120, 90), slot=7).astype(float)
        )

    plain = drawn(False, F.copy())
    assert np.abs(drawn(True, F.copy()) - plain).mean() > 1
    np.testing.assert_array_equal(drawn(False, F.copy()), plain)


@needs_egl
def test_what_has_no_value_has_the_colour_that_is_asked_for():
    view = View(V, F, values=np.full(len(F), np.nan))
    view.none = (0.0, 0.8, 0.0)
    view.update(values=np.full(len(F), np.nan))
    picture = np.array(view.still((200, 200)))
    red, green, blue = picture[picture[:, :, 3] == 255][:, :3].mean(axis=0)
    assert green > 2 * max(red, blue)


def luminance(color):
    """Relative luminance, by WCAG 2.1."""
    c = np.asarray(color[:3])
    linear = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    return linear @ [0.2126, 0.7152, 0.0722]


def test_figures_can_be_read_on_light_and_on_dark_pages(tmp_path):
    mpl = pytest.importorskip("matplotlib")
    from matplotlib.colors import to_rgb
    from matplotlib.figure import Figure

    with mpl.rc_context():
        plotting.for_both_themes()
        figure = Figure(figsize=(3, 2))
        axes = figure.subplots()
        axes.plot([0, 1], [0, 1], label="a")
        axes.set(xlabel="x", title="t")
        axes.legend()
        figure.savefig(tmp_path / "figure.png")
        written = [axes.title, axes.xaxis.label, *axes.get_xticklabels()]
        inks = {to_rgb(text.get_color()) for text in written}
    inline = pytest.importorskip("matplotlib_inline.backend_inline")
    assert inline._fetch_figure_metadata(figure) is None  # else the page puts a colour behind it
    pixels = mpl.image.imread(tmp_path / "figure.png")
    assert pixels[0, 0, 3] == 0
    assert pixels[pixels.shape[0] // 2, pixels.shape[1] // 2 + 30, 3] < 0.1  # within the axes
    for ink in inks:
        for page in ((1, 1, 1), (0.067, 0.067, 0.067)):  # JupyterLab's two
            low, high = sorted([luminance(ink), luminance(page)])
            assert (high + 0.05) / (low + 0.05) > 3  # WCAG's least for large letters and graphs


# Colours and legends of curves


def typed_colours(text):
    """Colours written in code: by their hexadecimal numbers, or as matplotlib's tab:blue."""
    from matplotlib.colors import to_hex

    names = re.findall(r"#[0-9A-Fa-f]{6}\b|\btab:[a-z]+", text)
    return {to_hex(name) for name in names}


def test_no_figure_gives_a_colour_of_the_weights_to_anything_else():
    from matplotlib.colors import to_hex

    of_weights = {to_hex(colour) for colour in plotting.WEIGHT_COLORS.values()}
    assert of_weights.isdisjoint(to_hex(colour) for colour in plotting.OTHER_COLORS)
    folders = [ROOT / "report", ROOT / "notebooks", ROOT / "lib" / "meshfair"]
    files = [p for folder in folders for p in folder.rglob("*") if p.suffix in FIGURE_CODE]
    made = {"build", "site", "site-build"}
    files = [p for p in files if made.isdisjoint(p.parts) and p.name != "plotting.py"]
    typed = {p.name: typed_colours(p.read_text(encoding="utf-8")) for p in files}
    assert {name for name, colours in typed.items() if colours & of_weights} == set()
    assert not [name for name, colours in typed.items() if colours & MATPLOTLIBS_OWN]


def test_curves_without_a_colour_take_none_of_the_weights():
    import matplotlib as mpl

    for style in (plotting.STYLE, plotting.BOTH_THEMES):
        with mpl.rc_context(style):
            cycle = [given["color"] for given in mpl.rcParams["axes.prop_cycle"]]
        assert cycle == list(plotting.OTHER_COLORS)


def test_explorers_have_the_colours_of_figures():
    script = scripts.text("curves.js")
    given = re.search(r"const COLORS = (\[.*?\]);", script).group(1)
    assert tuple(json.loads(given)) == plotting.OTHER_COLORS[: len(json.loads(given))]


def test_a_legend_says_what_the_marks_mean():
    import pandas as pd
    from matplotlib.figure import Figure

    table = pd.DataFrame({"weights": ["distance"] * 3, "time": [0, 1, 2], "snr": [1.0, 3.0, 2.0]})
    axes = Figure().subplots()
    plotting.draw_curves(axes, table, "snr", best="max")
    curve, mark = axes.lines
    assert mark.get_xydata().tolist() == [[1, 3]]
    plotting.legend(axes, "best time")
    shown = axes.get_legend()
    assert [text.get_text() for text in shown.get_texts()] == ["distance", "best time"]
    (drawn,) = [h for h in shown.legend_handles if h.get_marker() != "None"]
    assert drawn.get_marker() == mark.get_marker()
    assert drawn.get_color() == mark.get_color() == curve.get_color()
    plotting.legend(axes)
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["distance"]
