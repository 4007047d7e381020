"""The viewer: cameras, pictures, the frames' protocol, both backends, the window."""

import base64
import io
import subprocess
import sys
import threading
import types

import numpy as np
import pytest
from PIL import Image

from meshfair import MeshError, checks, shapes, viewer
from meshfair.viewer import Camera, View, coloring, egl, frames, in_page, offscreen, window
from meshfair.viewer.packing import NO_VALUE
from meshfair.viewer.painter import paint
from meshfair.viewer.panel import NONE, Panel, Scale, colors
from meshfair.viewer.placement import Placement

needs_egl = pytest.mark.skipif(not viewer.has_egl(), reason="polyscope cannot draw here: no EGL")
UP = (0.0, 0.0, 1.0)


@pytest.fixture
def torus():
    return shapes.torus(sections=24, sides=12)


@pytest.fixture
def camera(torus):
    return Camera.around(torus[0], (1, -1, 0.6))


# Cameras


@pytest.mark.parametrize("aspect", [0.5, 4 / 3, 3])
def test_around_sees_every_vertex_and_wastes_no_room(torus, aspect):
    camera = Camera.around(torus[0], (1, -1, 0.6), aspect=aspect, margin=0)
    back = np.subtract(camera.position, camera.target)
    back /= np.linalg.norm(back)
    right = np.cross(camera.up, back)
    X = torus[0] - camera.position
    half = np.tan(np.radians(viewer.camera.FIELD_OF_VIEW) / 2)
    across = np.abs(X @ right / (X @ back)).max() / (half * aspect)
    along = np.abs(X @ camera.up / (X @ back)).max() / half
    assert max(across, along) == pytest.approx(1)


def test_orbit_goes_around_the_target_and_comes_back(camera):
    turned = camera
    for _ in range(8):
        turned = turned.orbit(np.pi / 4, 0, UP)
    np.testing.assert_allclose(turned.position, camera.position)
    np.testing.assert_allclose(turned.up, camera.up)
    turned = camera.orbit(0.7, 0.3, UP)
    assert turned.target == camera.target
    distances = [np.linalg.norm(np.subtract(c.position, c.target)) for c in (camera, turned)]
    assert distances[0] == pytest.approx(distances[1])
    assert np.dot(turned.up, np.subtract(turned.position, turned.target)) == pytest.approx(0)


def test_orbit_moves_the_camera_to_its_right_and_up(camera):
    right = np.cross(camera.up, np.subtract(camera.position, camera.target))
    assert np.dot(np.subtract(camera.orbit(0.1, 0, UP).position, camera.position), right) > 0
    assert camera.orbit(0, 0.1, UP).position[2] > camera.position[2]


def test_orbit_stops_before_the_pole(camera):
    top = camera.orbit(0, 10, UP)
    back = np.subtract(top.position, top.target)
    assert 0.99 < back[2] / np.linalg.norm(back) < 1
    np.testing.assert_allclose(top.orbit(0, 10, UP).position, top.position)


def test_pan_and_zoom(camera):
    moved = camera.pan(0.25, -0.5)
    shift = np.subtract(moved.position, camera.position)
    np.testing.assert_allclose(shift, np.subtract(moved.target, camera.target))
    assert np.dot(shift, camera.up) < 0
    np.testing.assert_allclose(camera.zoom(0.5).zoom(2).position, camera.position)
    assert camera.zoom(0.5).target == camera.target


# Pictures


@needs_egl
def test_render_is_transparent_around_the_mesh(torus, camera):
    pixels = viewer.render(*torus, camera, size=(120, 90))
    assert pixels.shape == (90, 120, 4)
    assert pixels.dtype == np.uint8
    assert pixels[0, 0, 3] == 0
    assert 0.2 < (pixels[:, :, 3] == 255).mean() < 0.8


@needs_egl
def test_quality_and_size_hold_for_the_very_picture_that_asks_for_them(torus, camera):
    for quality, size in [(1, (120, 90)), (4, (120, 90)), (2, (64, 48)), (1, (64, 48))]:
        pixels = viewer.render(*torus, camera, size=size, quality=quality)
        assert pixels.shape[1::-1] == size
        softened = np.any((pixels[:, :, 3] > 0) & (pixels[:, :, 3] < 255))
        assert softened == (quality > 1)


@needs_egl
def test_render_sees_arrays_that_were_written_to(torus, camera):
    V, F = torus
    before = viewer.render(V, F, camera, size=(60, 45))
    V *= 0.5
    assert np.any(viewer.render(V, F, camera, size=(60, 45)) != before)


@needs_egl
@pytest.mark.parametrize("background", [(1, 1, 1), (0.07, 0.07, 0.07), (0.2, 0.4, 0.6), (0, 0, 0)])
def test_background_is_the_pages_colour(torus, camera, background):
    panel = Panel(*torus)
    pixels = viewer.on_gl_thread(
        lambda: offscreen.scene().draw(panel, camera, (40, 30), background=background)
    )
    np.testing.assert_allclose(pixels[0, 0, :3] / 255, background, atol=0.02)
    # And is no other picture's: stills of a page in the dark are transparent, too.
    assert viewer.render(*torus, camera, size=(40, 30))[0, 0, 3] == 0


@needs_egl
def test_values_colour_vertices_or_faces(torus, camera):
    V, F = torus
    plain = viewer.render(V, F, camera, size=(60, 45))
    for values in (V[:, 0], np.arange(len(F))):
        assert np.any(viewer.render(V, F, camera, size=(60, 45), values=values) != plain)
    constant = viewer.render(V, F, camera, size=(60, 45), values=np.ones(len(V)))
    assert np.any(constant[:, :, 3] == 255)


def test_without_egl_matplotlib_draws_and_says_so_once(torus, camera, monkeypatch):
    monkeypatch.setattr(offscreen, "has_egl", lambda: False)
    offscreen._warn_of_matplotlib.cache_clear()
    with pytest.warns(UserWarning, match="apt.txt: libx11-6"):
        pixels = viewer.render(*torus, camera, size=(60, 45), values=torus[0][:, 0])
    assert pixels.shape == (45, 60, 4)
    assert np.any(pixels[:, :, 3] == 255)
    viewer.render(*torus, camera, size=(60, 45))  # a second warning would be an error


@needs_egl
@pytest.mark.parametrize("cmap", viewer.CMAPS)
def test_a_cmap_has_the_same_colours_in_polyscope_and_at_the_colour_bar(cmap):
    V, F = np.eye(3), np.array([[0, 1, 2]])
    camera = Camera.around(V, (1, 1, 1))
    stops = Scale(0, 1, cmap).stops()
    for k in (0, 8, 16):
        options = {"values": np.full(3, k / 16), "limits": (0, 1), "cmap": cmap}
        drawn = viewer.render(V, F, camera, size=(9, 9), **options)[4, 4, :3].astype(int)
        named = np.array([int(stops[k][i : i + 2], 16) for i in (1, 3, 5)])
        # The light makes colours paler, but keeps which channel is the stronger.
        differ = np.abs(named - named[:, None]) > 20
        assert np.all(
            np.sign(drawn - drawn[:, None])[differ] == np.sign(named - named[:, None])[differ]
        )


def test_matplotlib_paints_values_and_edges_from_far_to_near():
    near, far = np.eye(3), np.eye(3) - 1
    V, F = np.concatenate([near, far]), np.array([[0, 1, 2], [3, 4, 5]])
    camera = Camera.around(V, (1, 1, 1))
    for faces in (F, F[::-1]):
        values = np.where(faces[:, 0] == 0, 1.0, 0.0)
        pixels = paint(Panel(V, faces, values), camera, (41, 41), Scale(0, 1, "coolwarm"))
        red, _, blue, opacity = pixels[20, 20].astype(int)
        assert red > blue  # the near face's, whichever comes first
        assert opacity == 255
    plain, lined = (paint(Panel(V, F, edges=edges), camera, (41, 41)) for edges in (False, True))
    assert (
        lined[:, :, :3][lined[:, :, 3] == 255].min() < plain[:, :, :3][plain[:, :, 3] == 255].min()
    )


def valued(*values):
    return Panel(np.eye(3), np.array([[0, 1, 2]]), np.array(values))


def test_scale():
    V, F = np.eye(3), np.array([[0, 1, 2]])
    a, b = valued(0.0, 2, 1), valued(-1.0, 1, 0)
    assert Scale.of([Panel(V, F), Panel(V, F)]) is None
    assert Scale.of([a, Panel(V, F), b]) == Scale(-1, 2)
    assert Scale.of([a], limits=(0, 5), cmap="magma").high == 5
    for constant in (0.0, 1.0, -1e9, 1e-12, 1e75):
        scale = Scale.of([valued(*[constant] * 3)])
        assert scale.low < scale.high
    np.testing.assert_allclose(Scale(-1, 3).parts(np.array([-1, 0, 3.0])), [0, 0.25, 1])
    np.testing.assert_allclose(Scale(-1.5e308, 1.5e308).parts(np.array([0.0])), 0.5)


@pytest.mark.parametrize("none", [np.nan, np.inf, -np.inf])
def test_the_scale_is_that_of_finite_values_and_none_is_grey(none):
    panel = valued(1.0, none, 3.0)
    scale = Scale.of([panel])
    assert (scale.low, scale.high) == (1, 3)
    low, grey, high = colors(panel, scale)
    np.testing.assert_array_equal(grey, NONE)
    np.testing.assert_array_equal([low, high], scale.colormap([0.0, 1.0])[:, :3])
    empty = valued(none, none, none)
    assert Scale.of([empty]) is None
    np.testing.assert_array_equal(colors(empty, None), [NONE] * 3)
    # What no face uses is not drawn: it has no part in the scale, and needs no colour.
    stray = Panel(np.eye(4)[:, :3], panel.F, np.array([1.0, 2, 3, none]))
    assert stray.complete
    assert Scale.of([Panel(stray.V, panel.F, np.array([1.0, 2, 3, 1e9]))]).high == 3


# Anywhere, in any unit

GRID = (448250.0, 5411940.0, 212.0)  # metres in a country's coordinates
PLACES = [(1.0, GRID), (1e6, (0, 0, 0)), (1e-9, (0, 0, 0)), (1.0, (2e8,) * 3)]
EXTREMES = [(1e-100, (0, 0, 0)), (1e74, (0, 0, 0))]


def differing(first, second):
    """The share of pixels that differ by more than the last rounding of a colour."""
    return (np.abs(first.astype(int) - second).max(axis=2) > 2).mean()


@needs_egl
@pytest.mark.parametrize(("unit", "place"), PLACES + EXTREMES)
def test_the_picture_does_not_depend_on_place_or_unit(unit, place, monkeypatch):
    V, F = shapes.icosphere(3)
    # Far away double precision rounds positions: the same rounding for the ball at the origin.
    there = (V + place) * unit
    here = there / unit - place
    for with_egl in (True, False):
        if not with_egl:
            monkeypatch.setattr(offscreen, "has_egl", lambda: False)
            monkeypatch.setattr(offscreen, "_warn_of_matplotlib", lambda: None)
        pictures = [
            viewer.render(X, F, Camera.around(X, (1, -1, 0.6)), size=(160, 160), values=V[:, 2])
            for X in (here, there)
        ]
        # An edge that falls on a pixel's border to the last digit may go to either side.
        assert differing(*pictures) < 1e-3


@pytest.mark.parametrize(("unit", "place"), PLACES + EXTREMES)
def test_a_page_gets_positions_that_single_precision_holds(unit, place):
    V, F = shapes.icosphere(3)
    there = (V + place) * unit
    one = Drawing(View(there, F, backend="webgl"))
    reference = Drawing(View(there / unit - place, F, backend="webgl"))
    assert len(np.unique(one.positions(0), axis=0)) == len(V)
    np.testing.assert_allclose(one.positions(0), reference.positions(0), atol=1e-6)
    np.testing.assert_allclose(one.camera, reference.camera, atol=1e-6)


def test_values_that_single_precision_cannot_tell_apart_have_their_colours():
    V, F = shapes.icosphere(2)
    page = Drawing(View(V, F, values=5411940.0 + 1e-3 * V[:, 2], backend="webgl"))
    parts = (V[:, 2] - V[:, 2].min()) / np.ptp(V[:, 2])
    np.testing.assert_allclose(page.parts(0) / 254, parts, atol=0.5 / 254 + 1e-5)


def test_meshes_that_move_or_grow_are_placed_anew_and_small_changes_are_not(torus):
    V, F = torus
    view = View([V, V], F, backend="webgl")
    page = Drawing(view)
    placement = view._placement
    view.update(1.5 * V, panel=1)
    assert view._placement is placement
    far = V + [0, 0, 1e7]
    with view.together():
        view.update(far, panel=0)
        view.update(far, panel=1)
    view.look_at(far)
    for k in (0, 1):
        assert np.ptp(page.positions(k), axis=0).max() == pytest.approx(1)
        assert np.abs(page.positions(k)).max() < 1
    position = np.array(page.camera[:3])
    distance = np.linalg.norm(np.subtract(view.camera.position, far.mean(axis=0)))
    assert np.linalg.norm(position) == pytest.approx(distance / view._placement.size, rel=1e-6)


def test_what_no_face_uses_moves_neither_camera_nor_mesh(torus):
    V, F = torus
    stray = np.concatenate([V, [[1e6, 0, 0]]])
    view, reference = (View(X, F, backend="webgl") for X in (stray, V))
    assert view.camera == reference.camera
    np.testing.assert_array_equal(view.placed[0].V[:-1], reference.placed[0].V)
    np.testing.assert_array_equal(view.placed[0].V[-1], 0)


# Straight along up


@pytest.mark.parametrize("direction", [(0, 0, 1), (0, 0, -3), (0, 1e-12, 1)])
@pytest.mark.parametrize("up", [(0, 0, 1), (0, 0, -2)])
def test_looking_straight_along_up_takes_another_up(torus, direction, up):
    camera = Camera.around(torus[0], direction, up)
    np.testing.assert_allclose(camera.up, (0, 1, 0), atol=1e-9)  # as on a map
    np.testing.assert_allclose(np.abs(camera.axes[2]), [0, 0, 1], atol=1e-9)
    view = View(*torus, direction=direction, up=up, backend="webgl")
    turned = view.camera.orbit(0.3, 0.2, view.up)
    assert np.isfinite([*turned.position, *turned.up]).all()
    assert np.dot(turned.axes[1], view.up) > 0  # and now its own up is up


@pytest.mark.parametrize(("along", "other"), [((1, 0, 0), (0, 0, 1)), ((0, 2, 0), (0, 0, 1))])
def test_along_the_other_axes_z_is_up(torus, along, other):
    np.testing.assert_allclose(Camera.around(torus[0], along, along).up, other, atol=1e-12)


def test_a_single_point_is_seen_from_nearby():
    camera = Camera.around([[5e6, 1.0, 2.0]], (1, -1, 0.6))
    np.testing.assert_allclose(camera.target, [5e6, 1, 2])
    assert np.linalg.norm(np.subtract(camera.position, camera.target)) > 0.5


# Arguments


def mesh_of(view):
    return view.panels[0].V, view.panels[0].F


def test_arrays_stand_for_numbers_and_lists(torus):
    V, F = torus
    view = View(
        np.stack([V, 2 * V]),
        np.stack([F, F]),
        titles=np.array(["a", "b"]),
        values=np.stack([V[:, 0], V[:, 1]]),
        limits=np.array([0, 42.0]),
        direction=np.array([1, -1, 1]),
        up=np.array([0, 0, 1.0]),
        smooth=np.True_,
        backend="webgl",
    )
    assert view.titles == ["a", "b"]
    assert (view.scale.low, view.scale.high) == (0, 42)
    view.color_by("other", limits=np.array([1, 2]))
    assert view.scale.high == 2
    assert View([V, V], F, values=[None, None], backend="webgl").scale is None


def test_meshes_of_another_library_stand_for_both_arrays(torus):
    other = types.SimpleNamespace(vertices=torus[0], faces=torus[1])
    for view in (View(other, backend="webgl"), View([other, other], titles="x", backend="webgl")):
        np.testing.assert_array_equal(view.panels[-1].V, torus[0])
        np.testing.assert_array_equal(view.panels[-1].F, torus[1])
    with pytest.raises(MeshError, match="F is missing; give the faces"):
        View(torus[0], backend="webgl")


@pytest.mark.parametrize(("options", "message"), [
    ({"limits": (1, 0)}, r"limits is \(1, 0\); give two numbers, the smaller one first"),
    ({"limits": np.array([[0, 1]])}, "limits is array"),
    ({"limits": "12"}, "limits is '12'"),
    ({"limits": (0, np.nan)}, "limits is"),
    ({"cmap": "Viridis"}, r"did you mean 'viridis'\?"),
    ({"cmap": np.array(["viridis", "magma"])}, "cmap is array"),
    ({"cmap": ["viridis"]}, r"cmap is \['viridis'\]"),
    ({"titles": 3}, "titles is 3; give a text, or a list"),
    ({"titles": [3]}, "a title is 3; give a text"),
    ({"label": None}, "label is None; give a text"),
    ({"smooth": "yes"}, "smooth is 'yes'; give True or False"),
    ({"edges": 1}, "edges is 1; give True or False"),
    ({"direction": (0, 0, 0)}, "direction is"),
    ({"direction": ("1", "0", "0")}, "direction is"),
    ({"up": (0, 1)}, "up is"),
    ({"up": [[1], [1, 2]]}, "up is"),
    ({"backend": np.array(["webgl"] * 2)}, "backend is array"),
    ({"values": "height"}, "values holds values of type"),
    ({"values": [[1.0], [2.0, 3.0]]}, "2 entries; give one for each of 1 panels"),
])  # fmt: skip
def test_what_is_no_argument_is_refused_in_one_sentence(torus, options, message):
    with pytest.raises(ValueError, match=message) as caught:
        View(*torus, **{"backend": "webgl"} | options)
    assert "\n" not in str(caught.value).replace("\n", "", str(options).count("\n"))


@pytest.mark.parametrize(("use", "message"), [
    (lambda view: view.still((0, 100)), r"size is \(0, 100\); give width and height"),
    (lambda view: view.still((300.5, 100)), "two whole numbers of pixels from 64 to 8192"),
    (lambda view: view.still(300), "size is 300"),
    (lambda view: view.still((300, 200, 100)), "size is"),
    (lambda view: view.still((10**6, 100)), "from 64 to 8192"),
    (lambda view: view.update(panel=1), "panel is 1; give one of 0"),
    (lambda view: view.update(panel="first"), "panel is 'first'"),
    (lambda view: view.update(title=7), "title is 7; give a text"),
    (lambda view: view.color_by(None), "label is None"),
    (lambda view: view.color_by("height", cmap=""), "cmap is ''"),
    (lambda view: view.look_at(view.panels[0].V, direction="up"), "direction is 'up'"),
    (lambda view: view.fit(0), "aspect is 0"),
    (lambda view: view.camera.zoom(0), "factor is 0; give a number above 0"),
    (lambda view: view.camera.orbit(np.nan, 0, UP), "yaw is nan; give a finite number"),
    (lambda view: view.camera.orbit(0, 0, (0, 0, 0)), "axis is"),
    (lambda view: view.camera.pan("left", 0), "x is 'left'"),
    (lambda view: Camera((0, 0, 0), (0, 0, 0), UP), "position - target"),
    (lambda view: Camera((0, 0, np.inf), (0, 0, 0), UP), "position is"),
    (lambda view: Camera((0, 0, 3), (0, 0, 1), UP), "up is .* along which the camera looks"),
    (lambda view: viewer.render(*mesh_of(view), None), "camera is None; give a"),
    (lambda view: setattr(view, "camera", "top"), "camera is 'top'; give a"),
    (lambda view: viewer.render(*mesh_of(view), view.camera, size=(0, 1)), "from 1 to 8192"),
    (lambda view: viewer.render(*mesh_of(view), view.camera, quality=9), "quality is 9"),
    (lambda view: viewer.render(*mesh_of(view), view.camera, edges=None), "edges is None"),
])  # fmt: skip
def test_nor_are_those_of_methods(torus, use, message):
    view = View(*torus, backend="webgl")
    before = view.panels[0], view.titles[0], view.label, view.limits
    with pytest.raises(ValueError, match=message):
        use(view)
    assert (view.panels[0], view.titles[0], view.label, view.limits) == before


# Stills of any shape


def drawn(picture):
    """The box around what is not white: left, top, right, bottom, as parts of the picture."""
    rows, columns = np.nonzero(np.any(np.asarray(picture) < 250, axis=2))
    size = np.array(picture.size * 2)
    return np.array([columns.min(), rows.min(), columns.max() + 1, rows.max() + 1]) / size


@pytest.mark.parametrize("size", [(400, 400), (1000, 120), (120, 600), (100, 100)])
@pytest.mark.parametrize("direction", [(1, -1, 0.6), (0, 0, 1)])
def test_a_still_of_any_shape_shows_all_of_a_long_bar(size, direction):
    view = View(*shapes.box((10, 1, 1)), direction=direction, backend="webgl")
    left, top, right, bottom = drawn(view.still(size, background="white"))
    assert min(left, top) > 0
    assert max(right, bottom) < 1
    assert max(right - left, bottom - top) > 0.85  # and fills it


def test_a_still_from_a_camera_that_was_moved_shows_what_the_view_does():
    view = View(*shapes.box((10, 1, 1)), backend="webgl")
    view.camera = view.camera.orbit(0.4, 0, UP)
    left, _, right, _ = drawn(view.still((200, 400), background="white"))
    assert 0 < left < right < 1


def test_a_still_with_bar_and_titles_is_refused_where_nothing_is_left(torus):
    view = View([torus[0]] * 6, torus[1], titles="x", backend="webgl")
    with pytest.raises(ValueError, match="leaves 16 x 72 pixels for each of 6 panels"):
        view.still((100, 100))


def test_long_titles_are_cut_and_not_laid_over_each_other(torus):
    view = View([torus[0]] * 2, torus[1], titles="m" * 300, backend="webgl")
    picture = np.asarray(view.still((300, 200), background="white"))
    middle = picture[: viewer.stills.TITLE, 147:153]
    assert np.all(middle > 250)


# Values that are none


@needs_egl
@pytest.mark.parametrize("on", ["vertices", "faces"])
def test_a_value_that_is_none_takes_no_other_colours(on):
    V, F = shapes.icosphere(3)
    camera = Camera.around(V, (0, 0, 1))
    values = V[:, 0].copy() if on == "vertices" else V[F].mean(axis=1)[:, 0]
    plain = viewer.render(V, F, camera, size=(90, 90), values=values)
    values[np.argmin(V[:, 2]) if on == "vertices" else np.argmin(V[F].mean(axis=1)[:, 2])] = np.nan
    # At the back: nothing changes. (Colours are mixed in the picture's own way.)
    assert differing(plain, viewer.render(V, F, camera, size=(90, 90), values=values)) < 0.35
    values[:] = np.nan
    grey = viewer.render(V, F, camera, size=(90, 90), values=values)[45, 45, :3]
    assert np.ptp(grey.astype(int)) < 12
    assert np.ptp(plain[45, 45, :3].astype(int)) > 40


def test_a_page_knows_what_has_no_value(torus):
    V, F = torus
    values = V[:, 0].copy()
    values[5] = np.inf
    page = Drawing(View(V, F, values=values, backend="webgl"))
    assert page.parts(0)[5] == NO_VALUE
    assert (np.delete(page.parts(0), 5) <= 254).all()
    assert page.meshes[0]["look"]["color"] == list(NONE)


@needs_egl
def test_the_page_gets_a_bar_of_numbers_whatever_the_values_are(torus):
    values = torus[0][:, 2].copy()
    values[7] = np.nan
    page = Page(View(*torus, values=values))
    message, _ = page.wait_for(lambda m: m.get("number") == 1)
    assert float(message["bar"]["low"]) == pytest.approx(np.nanmin(values))
    assert float(message["bar"]["high"]) == pytest.approx(np.nanmax(values))


# A driver that hangs


def test_a_driver_that_hangs_is_waited_for_once_and_told_once(torus, monkeypatch):
    tried = []

    class Hanging:
        def __init__(self, command, **streams):
            tried.append(command)

        def wait(self, timeout):
            raise subprocess.TimeoutExpired("python", timeout)

        def kill(self):
            tried.append("killed")

    for cached in (egl._trial, egl._warn_of_hanging):
        cached.cache_clear()
        monkeypatch.setattr(egl, cached.__name__, cached)
    monkeypatch.setattr(egl.subprocess, "Popen", Hanging)
    try:
        with pytest.warns(UserWarning, match="the graphics driver did not answer within 60 s"):
            view = View(*torus)
        assert type(view._backend).__name__ == "InPage"
        View(*torus)  # a second warning would be an error
        assert not viewer.has_egl()
        assert [type(what) for what in tried] == [list, str]
    finally:
        for cached in (egl._trial, egl._warn_of_hanging):
            cached.cache_clear()


def test_without_a_process_of_its_own_there_is_no_egl(monkeypatch):
    def refuse(*arguments, **streams):
        raise OSError("no more processes")

    monkeypatch.setattr(egl.subprocess, "Popen", refuse)
    assert egl._trial.__wrapped__() is False


# Colourings


def test_colourings_of_a_sphere_that_has_grown():
    V, F = shapes.icosphere(3)
    grown = 1.1 * V
    edge = np.linalg.norm(V[F[:, 0]] - V[F[:, 1]], axis=1).mean()
    values = {name: c.of(V, F)(grown) for name, c in coloring.COLORINGS.items()}
    np.testing.assert_allclose(values["displacement"], 0.1 / edge, rtol=0.05)
    np.testing.assert_allclose(values["normal angle"], 0, atol=1e-6)
    assert np.median(values["curvature"]) == pytest.approx(edge / 1.1, rel=0.02)
    low, high = coloring.limits(values["curvature"])
    assert low == 0 < high


def test_normal_angle_has_a_value_for_faces_without_area():
    V = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]])
    F = np.array([[0, 1, 2], [0, 1, 3]])
    turned = V[:, [0, 2, 1]]
    np.testing.assert_allclose(coloring.normal_angle(V, F)(turned), [90, 0])


# Views


def test_a_view_takes_one_mesh_or_several(torus):
    V, F = torus
    assert View(V, F, backend="webgl").titles == [""]
    view = View([V, 2 * V], F, titles=["a", "b"], values=[None, V[:, 0]], backend="webgl")
    assert len(view.panels) == 2
    assert view.scale.low == V[:, 0].min()
    other = shapes.icosphere(1)
    view = View([V, other[0]], [F, other[1]], titles="same", backend="webgl")
    assert view.titles == ["same", "same"]
    assert len(view.panels[1].F) == len(other[1])


def test_a_view_refuses_what_does_not_fit(torus):
    V, F = torus
    with pytest.raises(ValueError, match="titles has 1 entries; give one for each of 2 panels"):
        View([V, V], F, titles=["a"], backend="webgl")
    with pytest.raises(MeshError, match="number for each of the 288 vertices or of the 576 faces"):
        View(V, F, values=[1.0, 2.0], backend="webgl")
    with pytest.raises(ValueError, match="give one of polyscope, webgl"):
        View(V, F, backend="vtk")
    with pytest.raises(ValueError, match="cmap is 'Reds'; give one of viridis"):
        View(V, F, cmap="Reds", backend="webgl")
    view = View(V, F, backend="webgl")
    with pytest.raises(ValueError, match="panel is -1; give one of 0"):
        view.update(V, panel=-1)
    with pytest.raises(ValueError, match="limits is"):
        view.color_by("height", limits=(1, 0))
    assert view.label == ""


@needs_egl
def test_still_and_display_data(torus):
    view = View([torus[0]] * 2, torus[1], titles=["a", "b"], values=[None, torus[0][:, 0]])
    assert view.still((600, 200)).size == (600, 200)
    data, _ = view._repr_mimebundle_()
    assert "application/vnd.jupyter.widget-view+json" in data
    assert Image.open(io.BytesIO(base64.b64decode(data["image/png"]))).size == viewer.stills.STILL


def test_look_at_moves_the_reset_view(torus):
    view = View(*torus, backend="webgl")
    first = view.camera
    view.look_at(torus[0][:12], direction=(1, 0, 0.1))
    closer = view.camera
    assert closer != first
    view.camera = closer.zoom(3)
    view.reset()
    assert view.camera == closer


def test_the_first_camera_stays_the_reset_view_when_meshes_change(torus):
    view = View(*torus, backend="webgl")
    first = view.camera
    view.update(2 * torus[0])
    view.reset()
    assert view.camera == first
    view.fit(0.5)  # nobody has turned it: it follows the page's shape
    refitted = Camera.around(torus[0], (1, -1, 0.6), aspect=0.5)
    np.testing.assert_allclose(view.camera.position, refitted.position)


class Page:
    """The page's end of the protocol of frames.js, in Python."""

    def __init__(self, view, width=120, height=90, answer=True):
        self.frames, self.errors = [], []
        self._page, self._answer = view._backend, answer
        self._came = threading.Condition()
        view.widget.send = self._receive
        self.send(kind="layout", width=width, height=height, ratio=2, background=[1, 1, 1])

    def send(self, **message):
        self._page._receive(None, message, None)

    def _receive(self, message, buffers=None):
        with self._came:
            (self.frames if message["kind"] == "frame" else self.errors).append((message, buffers))
            self._came.notify_all()
        if self._answer:
            self.send(kind="shown")

    def wait_for(self, condition):
        """Wait for a frame or an error of which something holds; return it."""

        def found():
            return next((f for f in (*self.frames, *self.errors) if condition(f[0])), None)

        with self._came:
            assert self._came.wait_for(found, timeout=30), "no such frame came"
            return found()


@needs_egl
def test_a_page_gets_all_panels_as_drafts_and_good_ones_at_rest(torus):
    page = Page(View([torus[0]] * 2, torus[1], titles=["a", "b"]))
    message, pictures = page.wait_for(lambda m: m.get("panels") == [0, 1])
    assert message["draft"]
    assert message["titles"] == ["a", "b"]
    assert Image.open(io.BytesIO(pictures[0])).size == (120, 90)
    page.send(kind="rest")
    for k in (0, 1):
        message, pictures = page.wait_for(lambda m, k=k: m.get("panels") == [k])
        assert not message["draft"]
        assert Image.open(io.BytesIO(pictures[0])).size == (240, 180)


@needs_egl
def test_one_frame_is_on_its_way_and_the_newest_comes_next(torus):
    V, F = torus
    view = View(V, F)
    page = Page(view, answer=False)
    page.wait_for(lambda m: m.get("number") == 1)
    for k in range(20):
        view.update(V * (1 + k / 20), title=f"move {k}")
    viewer.on_gl_thread(lambda: None)  # whatever was asked of the thread is done
    assert len(page.frames) == 1
    page.send(kind="shown")
    message, _ = page.wait_for(lambda m: m.get("number") == 2)
    assert message["titles"] == ["move 19"]
    viewer.on_gl_thread(lambda: None)
    assert len(page.frames) == 2


@needs_egl
def test_only_what_changed_is_sent(torus):
    V, F = torus
    view = View([V, V, V], F)
    page = Page(view)
    page.wait_for(lambda m: m.get("panels") == [0, 1, 2])
    with view.together():
        view.update(2 * V, panel=2, title="new")
        view.update(2 * V, panel=1)
    page.wait_for(lambda m: m.get("panels") == [1, 2] and m["titles"][1] == "new")


@needs_egl
def test_a_page_that_has_gone_does_not_stop_the_next_one(torus, monkeypatch):
    view = View(*torus)
    page = Page(view, answer=False)
    page.wait_for(lambda m: m.get("number") == 1)
    monkeypatch.setattr(frames, "LOST", 0.0)
    view.update(2 * torus[0])
    page.wait_for(lambda m: m.get("number") == 2)


@needs_egl
def test_pointer_moves_turn_the_camera_and_reset_brings_it_back(torus):
    view = View(*torus)
    page = Page(view)
    page.wait_for(lambda m: m.get("number") == 1)
    home = view.camera
    page.send(kind="move", yaw=0.5, pitch=0.2, pan=[0.1, 0], zoom=0.8)
    assert view.camera != home
    page.wait_for(lambda m: m.get("number") == 2)
    page.send(kind="reset")
    assert view.camera == home


@needs_egl
def test_the_camera_follows_the_pages_shape_until_it_is_moved(torus):
    view = View(*torus)
    page = Page(view, width=400, height=100)
    wide = view.camera
    page.send(kind="layout", width=100, height=100, ratio=1, background=[1, 1, 1])
    assert view.camera != wide
    view.camera = moved = view.camera.zoom(0.5)
    page.send(kind="layout", width=400, height=100, ratio=1, background=[1, 1, 1])
    assert view.camera == moved


@needs_egl
def test_the_page_is_told_what_failed(torus, monkeypatch):
    def broken(*arguments, **named):
        raise RuntimeError("the GL is gone")

    monkeypatch.setattr(offscreen.Scene, "draw", broken)
    page = Page(View(*torus))
    message, _ = page.wait_for(lambda m: m["kind"] == "error")
    assert message["text"] == "RuntimeError: the GL is gone"


@needs_egl
def test_a_frame_has_the_colour_bar_of_its_values(torus):
    V, F = torus
    view = View(V, F, values=V[:, 2], label="height (units)")
    page = Page(view)
    message, _ = page.wait_for(lambda m: m.get("number") == 1)
    assert message["bar"]["label"] == "height (units)"
    assert float(message["bar"]["high"]) == pytest.approx(V[:, 2].max())
    assert len(message["bar"]["stops"]) == 17
    view.color_by("other", limits=(0, 1))
    page.wait_for(lambda m: m["bar"]["label"] == "other" and m["bar"]["low"] == "≤ 0")
    view.update()
    page.wait_for(lambda m: m["bar"] is None)


class Drawing:
    """The page's end of the protocol of in_page.js, in Python."""

    def __init__(self, view, width=120, height=90, answer=True):
        self._page, self._answer = view._backend, answer
        self.meshes, self.messages = {}, []
        view.widget.send = self._receive
        self.send(kind="layout", width=width, height=height, fresh=True)

    def send(self, **message):
        self._page._receive(None, message, None)

    def _receive(self, message, buffers=None):
        self.messages.append(message)
        self.camera = message.get("camera", getattr(self, "camera", None))
        if message["kind"] != "show":
            return
        self.bar = message["bar"]
        for panel in message["panels"]:
            mesh = self.meshes.setdefault(panel["panel"], {})
            mesh |= {"title": panel["title"], "look": panel["look"]}
            mesh |= {name: k if k is None else buffers[k] for name, k in panel["arrays"].items()}
        if self._answer:
            self.send(kind="shown")

    def positions(self, k):
        return np.frombuffer(self.meshes[k]["V"], "<f4").reshape(-1, 3)

    def faces(self, k):
        return np.frombuffer(self.meshes[k]["F"], "<u4").reshape(-1, 3)

    def parts(self, k):
        return np.frombuffer(self.meshes[k]["parts"], np.uint8)


def test_the_page_draws_the_same_meshes_where_there_is_no_egl(torus, monkeypatch):
    V, F = torus
    monkeypatch.setattr(viewer.live, "has_egl", lambda: False)
    view = View([V, V], F, titles=["<a>", "b"], values=[None, V[:, 0]])
    page = Drawing(view)
    centre, size = view._placement.centre, view._placement.size
    np.testing.assert_allclose(page.positions(0) * size + centre, V, atol=1e-6)
    np.testing.assert_array_equal(page.faces(1), F)
    assert page.meshes[0]["parts"] is None
    assert len(page.parts(1)) == len(V)
    assert page.meshes[0]["title"] == "<a>"
    assert len(page.bar["stops"]) == 17
    view.update(2 * V, values=np.arange(len(F)), title="c")
    np.testing.assert_allclose(page.positions(0) * size + centre, 2 * V, atol=1e-6)
    assert len(page.parts(0)) == len(F)
    sphere = shapes.icosphere(1)
    view.update(sphere[0], F=sphere[1])
    np.testing.assert_array_equal(page.faces(0), sphere[1])
    view.look_at(V[:12])
    seen = np.array(page.camera[:3]) * view._placement.size
    np.testing.assert_allclose(seen + view._placement.centre, view.camera.position)
    view.color_by("other", limits=(0, 1))
    assert page.bar["label"] == "other"


def test_only_what_changed_is_sent_to_a_page_that_draws(torus):
    V, F = torus
    view = View([V, V, V], F, values=[V[:, 2]] * 3, backend="webgl")
    view.update(1.1 * V, panel=1)  # nobody is there
    page = Drawing(view)
    (first,) = page.messages
    assert first["whole"]
    assert [set(panel["arrays"]) for panel in first["panels"]] == [{"V", "F", "parts"}] * 3
    with view.together():
        view.update(1.2 * V, panel=2, values=V[:, 2], title="new")
        view.update(panel=1, values=V[:, 2])
    _, second = page.messages
    assert [panel["panel"] for panel in second["panels"]] == [1, 2]
    assert [set(panel["arrays"]) for panel in second["panels"]] == [{"parts"}, {"V"}]
    assert "camera" not in second
    view.reset()
    assert page.messages[-1]["panels"] == []
    # Another page, or the same one loaded anew, gets everything.
    page.send(kind="layout", width=120, height=90, fresh=True)
    assert [set(p["arrays"]) for p in page.messages[-1]["panels"]] == [{"V", "F", "parts"}] * 3


def test_a_camera_that_is_set_is_the_pages_at_once(torus):
    view = View(*torus, backend="webgl")
    page, told = Drawing(view), []
    view.follow(lambda: told.append(view.camera))
    view.camera = nearer = view.camera.zoom(0.5)
    placed = view.placed_camera
    assert page.camera == [*placed.position, *placed.target, *placed.up]
    assert (told, page.messages[-1]["panels"]) == ([nearer], [])
    with view.together():
        view.camera = nearer.zoom(0.5)
        view.update(2 * torus[0])
        assert len(page.messages) == 2
    assert len(page.messages) == 3


@needs_egl
def test_a_camera_that_is_set_is_drawn_at_once(torus):
    view = View(*torus)
    page = Page(view)
    _, (near,) = page.wait_for(lambda m: m.get("number") == 1)
    view.camera = view.camera.zoom(2)
    _, (far,) = page.wait_for(lambda m: m.get("number") == 2)
    near, far = (np.asarray(Image.open(io.BytesIO(p)).convert("L")) for p in (near, far))
    assert (far < 250).sum() < (near < 250).sum() / 3  # twice as far away: a quarter of it


def test_a_page_is_told_nothing_until_all_that_changes_together_has_changed(torus):
    V, F = torus
    view = View(V, F, backend="webgl")
    page = Drawing(view)
    layout = {"kind": "layout", "width": 120, "height": 90, "fresh": True}
    other = threading.Thread(target=page.send, kwargs=layout)
    with view.together():
        view.refit(9 * V)
        other.start()
        other.join(0.2)  # time enough to be told of a mesh without its camera
        assert len(page.messages) == 1
        view.update(9 * V)
    other.join()
    assert len(page.messages) > 1
    for message in page.messages:  # placed meshes have one size, so one camera sees them all
        np.testing.assert_allclose(message["camera"], page.messages[0]["camera"], atol=1e-9)


def test_a_page_that_changes_its_shape_meanwhile_does_not_move_the_camera(torus, monkeypatch):
    view = View(*torus, backend="webgl")
    other = threading.Thread(target=view.fit, args=(0.5,))
    home = view._camera_home

    def slow_home(*aspect):
        found = home(*aspect)
        if threading.current_thread() is not other and not other.ident:
            other.start()
            other.join(0.2)
        return found

    monkeypatch.setattr(view, "_camera_home", slow_home)
    view.refit(3 * torus[0])
    other.join()
    assert view.camera == Camera.around(3 * torus[0], (1, -1, 0.6), aspect=0.5)


def test_one_message_is_on_its_way_and_the_newest_comes_next(torus, monkeypatch):
    V, F = torus
    view = View(V, F, backend="webgl")
    page = Drawing(view, answer=False)
    for k in range(20):
        view.update(V * (1 + k / 20), title=f"move {k}")
    assert len(page.messages) == 1
    page.send(kind="shown")
    assert len(page.messages) == 2
    assert page.meshes[0]["title"] == "move 19"
    monkeypatch.setattr(in_page, "LOST", 0.0)  # a page that has gone does not stop the next
    view.update(V)
    assert len(page.messages) == 3


def test_python_knows_how_a_page_that_draws_has_turned(torus):
    view = View(*torus, backend="webgl")
    page = Drawing(view, width=400, height=100)
    home = view.camera
    wide = Camera.around(torus[0], (1, -1, 0.6), aspect=4.0)
    np.testing.assert_allclose(home.position, wide.position)
    page.send(kind="move", by=7, yaw=0.5, pitch=0.2, pan=[0.1, 0], zoom=0.8)
    turned = home.orbit(0.5, 0.2, view.up).pan(0.1, 0).zoom(0.8)
    assert view.camera == turned
    assert page.messages[-1]["by"] == 7
    placed = view.placed_camera
    assert page.camera == [*placed.position, *placed.target, *placed.up]
    page.send(kind="layout", width=100, height=100, fresh=False)
    assert view.camera == turned
    assert page.messages[-1]["panels"] == []
    page.send(kind="reset")
    assert view.camera == Camera.around(torus[0], (1, -1, 0.6), aspect=1.0)
    clicked = []
    view.on_pick(lambda *which: clicked.append(which))
    page.send(kind="click", panel=0, x=2.0, y=2.0)
    assert clicked == []
    page.send(kind="ping")
    assert page.messages[-1] == {"kind": "pong"}


# What is missing

OPTIONAL = ["anywidget", "ipywidgets", "matplotlib", "PIL", "polyscope", "traitlets"]


def python(code, *blocked):
    """Run some code in a Python of its own in which some libraries are not installed."""
    block = f"import sys; sys.modules.update(dict.fromkeys({blocked}))\n"
    done = subprocess.run(
        [sys.executable, "-c", block + code], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_viewer_loads_no_library_before_it_draws():
    code = "import meshfair.viewer; print(*(name for name, m in sys.modules.items() if m))"
    loaded = {name.split(".")[0] for name in python(code).split()}
    assert "meshfair" in loaded
    assert loaded.isdisjoint([*OPTIONAL, "igl"])


def test_without_any_optional_library_each_use_says_what_to_install():
    said = python(
        """
import warnings
from meshfair import shapes, viewer

warnings.simplefilter("ignore")  # matplotlib would draw in place of polyscope, were it there
V, F = shapes.icosphere(1)
camera = viewer.Camera.around(V, (1, 1, 1))
viewer.window.has_screen = lambda: True
assert not viewer.has_egl()


def explorer():
    import meshfair.explorers


for use in (
    lambda: viewer.render(V, F, camera),
    lambda: viewer.show(V, F),
    lambda: viewer.View(V, F),
    lambda: viewer.View(V, F, backend="polyscope"),
    explorer,
):
    try:
        use()
    except ImportError as error:
        print(error)
    else:
        print("nothing missing")
""",
        *OPTIONAL,
    ).splitlines()
    assert [line.split(" (")[0] for line in said] == [
        "a picture of a mesh needs matplotlib",
        "a window needs polyscope",
        "a live view needs anywidget",
        "a live view needs anywidget",
        "an explorer needs anywidget",
    ]
    ends = [line.split("; run: ")[1] for line in said]
    assert ends == [checks.install(extra) for extra in ["viewer"] * 2 + ["notebooks"] * 3]


def test_without_polyscope_matplotlib_draws_and_says_why():
    said = python(
        """
import warnings
from meshfair import shapes, viewer

V, F = shapes.icosphere(1)
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    pixels = viewer.render(V, F, viewer.Camera.around(V, (1, 1, 1)), size=(40, 30))
print(pixels.shape, pixels[15, 20, 3], *(warning.message for warning in caught))
""",
        "polyscope",
    )
    assert said.startswith("(30, 40, 4) 255 polyscope is not installed, so meshes are drawn with")
    assert said.rstrip().endswith(checks.install("viewer"))


def test_an_error_of_ours_is_not_called_a_missing_library():
    with (
        pytest.raises(ImportError, match="cannot import name") as caught,
        checks.needed_for("x"),
    ):
        from meshfair.viewer import nothing  # noqa: F401
    assert "install" not in str(caught.value)


# The window


def test_show_says_that_there_is_no_screen(torus, monkeypatch):
    monkeypatch.setattr(window, "has_screen", lambda: False)
    with pytest.raises(RuntimeError, match=r"no screen.*meshfair\.viewer\.View"):
        viewer.show(*torus)


@pytest.mark.parametrize(("platform", "display", "there"), [
    ("linux", "", False), ("linux", ":0", True), ("darwin", "", True), ("win32", "", True),
])  # fmt: skip
def test_has_screen(monkeypatch, platform, display, there):
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setenv("DISPLAY", display)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert window.has_screen() == there


def test_the_window_gets_the_mesh_and_its_values(torus, monkeypatch, tmp_path):
    calls = []

    class Recorder(types.ModuleType):
        def __getattr__(self, name):
            def call(*arguments, **named):
                calls.append((name, arguments))
                return self

            return call

    started = []
    monkeypatch.setattr(window, "has_screen", lambda: True)
    monkeypatch.setattr(window.tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(window.subprocess, "Popen", started.append)
    viewer.show(*torus, values=torus[0][:, 0], title="torus")
    (command,) = started
    assert command[1:3] == ["-m", "meshfair.viewer.window"]

    monkeypatch.setitem(sys.modules, "polyscope", Recorder("polyscope"))
    window._main(command[3])
    named = dict(calls)
    placement = Placement.of([Panel(*torus)])
    placed = named["register_surface_mesh"][1] * placement.size + placement.centre
    np.testing.assert_allclose(placed, torus[0], atol=1e-12)
    np.testing.assert_array_equal(named["add_scalar_quantity"][1], torus[0][:, 0])
    assert calls[-1] == ("show", ())
    assert list(tmp_path.iterdir()) == []

    values = torus[0][:, 0].copy()
    values[3] = np.nan
    viewer.show(*torus, values=values)
    window._main(started[1][3])
    np.testing.assert_array_equal(dict(calls)["add_color_quantity"][1][3], NONE)
