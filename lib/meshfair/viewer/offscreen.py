"""Polyscope without a screen: one GL thread, one scene, pixels out."""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from meshfair.checks import check_choice, check_flag, check_mesh, check_size, check_values
from meshfair.mesh import takes_meshes
from meshfair.viewer.camera import FIELD_OF_VIEW, Camera, check_camera
from meshfair.viewer.egl import MISSING_EGL, MISSING_POLYSCOPE, has_egl, has_polyscope
from meshfair.viewer.painter import paint
from meshfair.viewer.panel import LINES, NONE, SURFACE, Panel, Scale, colors
from meshfair.viewer.placement import Placement

LARGEST = 8192  # pixels of a picture's side, as far as OpenGL's buffers go when it is supersampled

Pixels = NDArray[np.uint8]
Result = TypeVar("Result")


@functools.cache
def gl_thread() -> ThreadPoolExecutor:
    """The executor with the one thread that may speak to polyscope.

    The GL context belongs to the thread that made it, and a notebook's
    callbacks come on any thread, so one thread does it all.
    """
    return ThreadPoolExecutor(1, thread_name_prefix="polyscope")


def on_gl_thread(function: Callable[[], Result]) -> Result:
    """Call a function on the GL thread, and wait for what it returns.

    Parameters
    ----------
    function : callable
        Without arguments.

    Returns
    -------
    object
        What the function returns; what it raises is raised here.
    """
    return gl_thread().submit(function).result()


@takes_meshes
def render(
    V: ArrayLike,
    F: ArrayLike,
    camera: Camera,
    *,
    size: tuple[int, int] = (800, 600),
    values: ArrayLike | None = None,
    limits: tuple[float, float] | None = None,
    cmap: str = "viridis",
    smooth: bool = False,
    edges: bool = False,
    quality: int = 2,
    none: tuple[float, float, float] = NONE,
) -> Pixels:
    """Draw a mesh, from a camera, into an array of pixels.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    camera : Camera
    size : (int, int)
        Width and height in pixels, up to 8192.
    values : array_like, shape (n,) or (m,), optional
        A number for each vertex or each face, shown as a colour.
    limits : (float, float), optional
        The values at both ends of the colour scale; by default the range of
        those that are finite.
    cmap : str
        A colour map, one of `meshfair.viewer.CMAPS`: those that polyscope and
        matplotlib both have.
    smooth : bool
        Shade smoothly across the faces.
    edges : bool
        Draw the edges as thin lines.
    quality : int
        Supersampling in each direction, 1 (a draft) to 4.
    none : three floats
        The colour where a value is NaN or infinite, each from 0 to 1; grey by default.

    Returns
    -------
    ndarray of uint8, shape (height, width, 4)
        Red, green, blue and opacity; transparent where no mesh is.

    Raises
    ------
    MeshError, ValueError
        No mesh, values that do not fit it, or an option that is none.
    ImportError
        Neither polyscope nor matplotlib is installed.

    Warns
    -----
    UserWarning
        Once, where polyscope or EGL is missing and matplotlib draws instead.
    """
    V, F = check_mesh(V, F)
    size = check_size(size, "size", 1, LARGEST)
    quality = check_choice(quality, "quality", (1, 2, 3, 4))
    check_camera(camera)
    numbers = None if values is None else check_values(values, len(V), len(F), finite=False)
    # A copy: the scene knows its arrays by identity, and the caller may write to its own.
    smooth, edges = check_flag(smooth, "smooth"), check_flag(edges, "edges")
    panel = Panel(V, F.copy(), numbers, smooth, edges, none)
    scale = Scale.of([panel], limits, cmap)
    placement = Placement.of([panel])
    panel, camera = placement.panel(panel), placement.camera(camera)
    if not has_egl():
        _warn_of_matplotlib()
        return paint(panel, camera, size, scale)
    return on_gl_thread(lambda: scene().draw(panel, camera, size, scale=scale, quality=quality))


@functools.cache
def _warn_of_matplotlib() -> None:
    reason = MISSING_EGL if has_polyscope() else MISSING_POLYSCOPE
    warnings.warn(reason, UserWarning, stacklevel=3)


class Scene:
    """Polyscope, started without a screen. Made and used on the GL thread only."""

    def __init__(self) -> None:
        import polyscope as ps

        ps.set_allow_headless_backends(True)
        ps.set_use_prefs_file(False)  # it would leave files in the working directory
        ps.set_verbosity(0)
        ps.set_warn_for_invalid_values(False)
        ps.init("openGL3_egl")
        ps.set_ground_plane_mode("none")
        ps.set_view_projection_mode("perspective")
        self._ps = ps
        self._quality = 1
        self._panels: dict[int, Panel] = {}  # slot -> the panel that polyscope holds there

    def draw(
        self,
        panel: Panel,
        camera: Camera,
        size: tuple[int, int],
        *,
        slot: int = 0,
        scale: Scale | None = None,
        quality: int = 1,
        background: Sequence[float] | None = None,
    ) -> Pixels:
        """Draw one panel.

        Parameters
        ----------
        panel : Panel
            Placed, as ``camera`` is: see `meshfair.viewer.placement`.
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
        if background is None:
            ps.set_background_color((1.0, 1.0, 1.0, 0.0))  # not that of the last picture
        else:
            # Polyscope takes light and shows colour: 1.1 times as bright, gamma 2.2 (measured).
            ps.set_background_color(tuple(np.power(background, 2.2) / 1.1))
        return np.array(ps.screenshot_to_buffer(transparent_bg=background is None))

    def _set_size(self, size: tuple[int, int], quality: int) -> None:
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

    def _show_only(self, slot: int | None) -> None:
        for other in self._panels:
            self._ps.get_surface_mesh(f"panel {other}").set_enabled(other == slot)

    def _register(self, slot: int, panel: Panel, scale: Scale | None) -> None:
        """Bring a slot up to date, by the shortest way."""
        old = self._panels.get(slot)
        style = (panel.smooth, panel.edges, panel.values is None)
        if (
            old is not None
            and old.F is panel.F
            and len(old.V) == len(panel.V)
            and style == (old.smooth, old.edges, old.values is None)
        ):
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
            # Polyscope remembers a name's edges: those of an older mesh would stay.
            mesh.set_edge_width(0.6 if panel.edges else 0.0)
            mesh.set_edge_color(LINES)
        self._panels[slot] = panel
        if panel.values is None:
            return
        if scale is not None and panel.complete:
            mesh.add_scalar_quantity(
                "values",
                scale.parts(panel.values),
                defined_on=panel.values_on,
                enabled=True,
                vminmax=(0.0, 1.0),
                cmap=scale.cmap,
            )
        else:  # which polyscope's colour maps have no colour for
            mesh.add_color_quantity(
                "values", colors(panel, scale), defined_on=panel.values_on, enabled=True
            )


@functools.cache
def scene() -> Scene:
    """The one scene that there is; use it on the GL thread only."""
    return Scene()
