"""Pictures of meshes: polyscope without a screen, through EGL."""

import contextlib
import functools
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from meshfair import plotting
from meshfair.checks import check_mesh, check_vertices

FIELD_OF_VIEW = 25.0  # degrees, vertical: long enough a lens to keep proportions
SURFACE = (0.55, 0.68, 0.86)  # the colour of a mesh without values
MISSING_EGL = (
    "polyscope cannot draw here (no EGL), so meshes are drawn with matplotlib; on Debian or "
    "Ubuntu install the packages of apt.txt: libx11-6 libegl1 libgl1 libgl1-mesa-dri"
)


@dataclass(frozen=True)
class Camera:
    """Where a picture is taken from, in the units of the mesh."""

    position: tuple
    target: tuple
    up: tuple

    @classmethod
    def around(cls, V, direction, up=(0, 0, 1), *, aspect=4 / 3, margin=0.03):
        """The nearest camera that sees all of a mesh from a direction.

        Parameters
        ----------
        V : array_like, shape (n, 3)
        direction : three floats
            From the mesh towards the camera.
        up : three floats
            What is up in the picture, not parallel to ``direction``.
        aspect : float
            Width over height of the picture.
        margin : float
            Free border on each side, as a share of the picture's half width.

        Returns
        -------
        Camera
        """
        V = check_vertices(V)
        back = np.asarray(direction, float) / np.linalg.norm(direction)
        right = np.cross(up, back)
        right /= np.linalg.norm(right)
        frame = np.stack([right, np.cross(back, right), back])
        X = V @ frame.T
        tan = np.tan(np.radians(FIELD_OF_VIEW) / 2) * (1 - margin) * np.array([aspect, 1.0])
        # A vertex is in the picture while |x - target| <= (distance - depth) tan, on
        # both sides of each axis; the tightest pair of sides sets target and distance.
        high = (X[:, :2] + tan * X[:, 2:]).max(axis=0)
        low = (X[:, :2] - tan * X[:, 2:]).min(axis=0)
        distance = ((high - low) / (2 * tan)).max()
        x, y = (high + low) / 2
        depth = (X[:, 2].max() + X[:, 2].min()) / 2
        position, target = np.array([[x, y, distance], [x, y, depth]]) @ frame
        return cls(tuple(position), tuple(target), tuple(frame[1]))


@functools.cache
def has_egl():
    """Whether polyscope can draw without a screen on this machine.

    Tried in a process of its own, since a GL library that fails can take the
    process with it. The answer is kept: about a second, once.

    Returns
    -------
    bool
    """
    trial = "from meshfair.viewer import _polyscope; _polyscope()"
    finished = subprocess.run([sys.executable, "-c", trial], capture_output=True, timeout=60)
    return finished.returncode == 0


@functools.cache
def _gl_thread():
    # The GL context belongs to the thread that made it, so one thread does it all.
    return ThreadPoolExecutor(1, thread_name_prefix="polyscope")


def on_gl_thread(function, *arguments, **named):
    """Call a function on the one thread that may speak to polyscope, and wait for it."""
    return _gl_thread().submit(function, *arguments, **named).result()


@functools.cache
def _polyscope():
    """Polyscope, started without a screen; call it on the GL thread only."""
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
    return ps


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
    if values is not None and limits is None:
        limits = (float(values.min()), float(values.max()))
    if not has_egl():
        _warn_missing_egl()
        return plotting.draw_mesh(V, F, camera, FIELD_OF_VIEW, size, values, limits, colours)
    return on_gl_thread(
        _render, V, F, camera, size, values, limits, colours, smooth, edges, quality
    )


@functools.cache
def _warn_missing_egl():
    import warnings

    warnings.warn(MISSING_EGL, UserWarning, stacklevel=3)


def _render(V, F, camera, size, values, limits, colours, smooth, edges, quality):
    ps = _polyscope()
    ps.set_window_size(*size)
    ps.set_SSAA_factor(quality)
    ps.remove_all_structures()
    mesh = ps.register_surface_mesh(
        "mesh",
        V,
        F,
        color=SURFACE,
        smooth_shade=smooth,
        material="wax" if values is None else "clay",
    )
    if edges:
        mesh.set_edge_width(0.6)
        mesh.set_edge_color((0.1, 0.15, 0.25))
    if values is not None:
        on = "vertices" if len(values) == len(V) else "faces"
        mesh.add_scalar_quantity(
            "values", values, defined_on=on, enabled=True, vminmax=limits, cmap=colours
        )
    lens = ps.CameraIntrinsics(fov_vertical_deg=FIELD_OF_VIEW, aspect=size[0] / size[1])
    look = np.subtract(camera.target, camera.position)
    place = ps.CameraExtrinsics(root=camera.position, look_dir=look, up_dir=camera.up)
    ps.set_view_camera_parameters(ps.CameraParameters(lens, place))
    return np.array(ps.screenshot_to_buffer(transparent_bg=True))
