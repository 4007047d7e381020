"""Polyscope without a screen: one GL thread, one scene, pixels out."""

import contextlib
import functools
import subprocess
import sys
import warnings
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from meshfair.checks import check_mesh
from meshfair.viewer.camera import FIELD_OF_VIEW
from meshfair.viewer.painter import draw_mesh

SURFACE = (0.55, 0.68, 0.86)  # the colour of a mesh without values
MISSING_EGL = (
    "polyscope cannot draw here (no EGL), so meshes are drawn with matplotlib; on Debian or "
    "Ubuntu install the packages of apt.txt: libx11-6 libegl1 libgl1 libgl1-mesa-dri"
)


@dataclass(frozen=True, eq=False)
class Panel:
    """A mesh as it is drawn. Compared by identity: a changed mesh is a new panel."""

    V: np.ndarray
    F: np.ndarray
    values: np.ndarray | None = None
    smooth: bool = False
    edges: bool = False


@dataclass(frozen=True)
class Scale:
    """How values become colours: the two ends of the scale, and the colour map."""

    low: float
    high: float
    colours: str = "viridis"

    @classmethod
    def of(cls, values, limits=None, colours="viridis"):
        """The scale for some arrays of values, or None where none of them is given."""
        given = [x for x in values if x is not None]
        if not given:
            return None
        low, high = limits or (min(x.min() for x in given), max(x.max() for x in given))
        # A scale of no length divides by zero in every renderer.
        return cls(float(low), float(high) if high > low else float(low) + 1e-9, colours)

    def stops(self):
        """Seventeen colours, as CSS has them, from the low end to the high one."""
        from matplotlib import colormaps
        from matplotlib.colors import to_hex

        return [to_hex(colormaps[self.colours](k / 16)) for k in range(17)]


@functools.cache
def has_egl():
    """Whether polyscope can draw without a screen on this machine.

    Tried in a process of its own, since a GL library that fails can take the
    process with it. The answer is kept: about a second, once.

    Returns
    -------
    bool
    """
    trial = f"from {__name__} import Scene; Scene()"
    finished = subprocess.run([sys.executable, "-c", trial], capture_output=True, timeout=60)
    return finished.returncode == 0


@functools.cache
def gl_thread():
    """The executor with the one thread that may speak to polyscope.

    The GL context belongs to the thread that made it, and a notebook's
    callbacks come on any thread, so one thread does it all.
    """
    return ThreadPoolExecutor(1, thread_name_prefix="polyscope")


def on_gl_thread(function, *arguments, **named):
    """Call a function on the GL thread, and wait for what it returns."""
    return gl_thread().submit(function, *arguments, **named).result()


def render(
    V,
    F,
    camera,
    *,
    size=(800, 600),
    values=None,
    limits=None,
    colours="viridis",
    smooth=False,
    edges=False,
    quality=2,
):
    """Draw a mesh, from a camera, into an array of pixels.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    camera : Camera
    size : (int, int)
        Width and height in pixels.
    values : array_like, shape (n,) or (m,), optional
        A number for each vertex or each face, shown as a colour.
    limits : (float, float), optional
        The values at both ends of the colour scale; their range by default.
    colours : str
        A colour map that polyscope and matplotlib both have: viridis, magma,
        coolwarm, ...
    smooth : bool
        Shade smoothly across the faces.
    edges : bool
        Draw the edges as thin lines.
    quality : int
        Supersampling in each direction, 1 (a draft) to 4.

    Returns
    -------
    ndarray of uint8, shape (height, width, 4)
        Red, green, blue and opacity; transparent where no mesh is.

    Raises
    ------
    MeshError
        No mesh.

    Warns
    -----
    UserWarning
        Once, where EGL is missing and matplotlib draws instead.
    """
    V, F = check_mesh(V, F)
    values = None if values is None else np.asarray(values, dtype=float)
    scale = Scale.of([values], limits, colours)
    if not has_egl():
        _warn_missing_egl()
        limits = scale and (scale.low, scale.high)
        return draw_mesh(V, F, camera, FIELD_OF_VIEW, size, values, limits, colours)
    # Copies: the scene knows its arrays by identity, and the caller may write to its own.
    panel = Panel(V.copy(), F.copy(), values, smooth, edges)
    return on_gl_thread(draw, panel, camera, size, scale=scale, quality=quality)


@functools.cache
def _warn_missing_egl():
    warnings.warn(MISSING_EGL, UserWarning, stacklevel=3)


class Scene:
    """Polyscope, started without a screen. Made and used on the GL thread only."""

    def __init__(self):
        import polyscope as ps

        ps.set_allow_headless_backends(True)
        ps.set_use_prefs_file(False)  # it would leave files in the working directory
        ps.set_verbosity(0)
        ps.set_warn_for_invalid_values(False)
        ps.init("openGL3_egl")
        with contextlib.suppress(AttributeError):
            ps.set_imgui_ini_file(None)
        ps.set_ground_plane_mode("none")
        ps.set_view_projection_mode("perspective")
        self._ps = ps
        self._quality = 1
        self._panels = {}  # slot -> the panel that polyscope holds there

    def draw(self, panel, camera, size, *, slot=0, scale=None, quality=1, background=None):
        """Draw one panel.

        Parameters
        ----------
        panel : Panel
        camera : meshfair.viewer.Camera
        size : (int, int)
            Width and height in pixels.
        slot : int
            Where polyscope keeps the mesh. A panel that differs from the
            slot's last one in its positions alone is not built anew.
        scale : Scale, optional
            Colours for the panel's values.
        quality : int
            Supersampling in each direction.
        background : three floats, optional
            Colour behind the mesh, 0 to 1; transparent without.

        Returns
        -------
        ndarray of uint8, shape (height, width, 4)
        """
        ps = self._ps
        self._set_size(size, quality)
        self._register(slot, panel, scale)
        self._show_only(slot)
        lens = ps.CameraIntrinsics(fov_vertical_deg=FIELD_OF_VIEW, aspect=size[0] / size[1])
        look = np.subtract(camera.target, camera.position)
        place = ps.CameraExtrinsics(root=camera.position, look_dir=look, up_dir=camera.up)
        ps.set_view_camera_parameters(ps.CameraParameters(lens, place))
        if background is not None:
            # Polyscope takes light and shows colour: 1.1 times as bright, gamma 2.2 (measured).
            ps.set_background_color(tuple(np.power(background, 2.2) / 1.1))
        return np.array(ps.screenshot_to_buffer(transparent_bg=background is None))

    def _set_size(self, size, quality):
        """Size the buffers for a picture with some supersampling.

        Without a window, polyscope 2.6 sizes its buffers when the window's
        size is set, and by the factor that the last frame was drawn with. So
        a new factor is first taken over by a frame of nothing.
        """
        if quality != self._quality:
            self._ps.set_SSAA_factor(quality)
            self._show_only(None)
            self._ps.set_window_size(1, 1)
            self._ps.screenshot_to_buffer()
            self._quality = quality
        self._ps.set_window_size(*size)

    def _show_only(self, slot):
        for other in self._panels:
            self._ps.get_surface_mesh(f"panel {other}").set_enabled(other == slot)

    def _register(self, slot, panel, scale):
        """Bring a slot up to date, by the shortest way."""
        old = self._panels.get(slot)
        style = (panel.smooth, panel.edges, panel.values is None)
        same_mesh = old is not None and old.F is panel.F and len(old.V) == len(panel.V)
        if same_mesh and style == (old.smooth, old.edges, old.values is None):
            mesh = self._ps.get_surface_mesh(f"panel {slot}")
            if old.V is not panel.V:
                mesh.update_vertex_positions(panel.V)
        else:
            mesh = self._ps.register_surface_mesh(
                f"panel {slot}",
                panel.V,
                panel.F,
                color=SURFACE,
                smooth_shade=panel.smooth,
                material="wax" if panel.values is None else "clay",
            )
            if panel.edges:
                mesh.set_edge_width(0.6)
                mesh.set_edge_color((0.1, 0.15, 0.25))
        self._panels[slot] = panel
        if panel.values is not None:
            on = "vertices" if len(panel.values) == len(panel.V) else "faces"
            mesh.add_scalar_quantity(
                "values",
                panel.values,
                defined_on=on,
                enabled=True,
                vminmax=(scale.low, scale.high),
                cmap=scale.colours,
            )


@functools.cache
def _scene():
    return Scene()


def draw(*arguments, **named):
    """`Scene.draw` of the one scene that there is; call it on the GL thread only."""
    return _scene().draw(*arguments, **named)
