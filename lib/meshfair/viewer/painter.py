"""Meshes drawn by matplotlib, triangle by triangle: where there is no OpenGL."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from meshfair.checks import needed_for
from meshfair.mesh import face_normals
from meshfair.viewer.camera import FIELD_OF_VIEW, Camera
from meshfair.viewer.panel import LINES, SURFACE, Panel, Scale, colors

LIGHT = (0.3, 0.4, 0.87)  # towards the light, in the camera's axes


def paint(
    panel: Panel, camera: Camera, size: tuple[int, int], scale: Scale | None = None
) -> NDArray[np.uint8]:
    """Draw a panel with matplotlib alone: faces painted from far to near.

    The fallback of `meshfair.viewer.render` where polyscope cannot draw; the same
    camera and the same pixels, without shadows or hidden-surface tests.

    Parameters
    ----------
    panel : Panel
    camera : meshfair.viewer.Camera
    size : (int, int)
        Width and height in pixels.
    scale : Scale, optional
        Colours for the panel's values.

    Returns
    -------
    ndarray of uint8, shape (height, width, 4)

    Raises
    ------
    ImportError
        matplotlib is missing; the message says what to install.
    """
    with needed_for("a picture of a mesh"):
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.collections import PolyCollection
        from matplotlib.figure import Figure

    X = (panel.V - camera.position) @ camera.axes.T
    corners = X[panel.F]
    far_first = np.argsort(corners[:, :, 2].mean(axis=1))
    projected = (corners[:, :, :2] / -corners[:, :, 2:])[far_first]

    shade = 0.35 + 0.65 * np.abs(face_normals(X, panel.F) @ LIGHT)
    base = np.array(SURFACE)
    if panel.values is not None:
        base = colors(panel, scale)
        if panel.values_on == "vertices":
            base = base[panel.F].mean(axis=1)
    faces = np.clip(shade[:, None] * base, 0, 1)[far_first]

    width, height = size
    figure = Figure(figsize=(width / 100, height / 100), dpi=100)
    figure.patch.set_alpha(0)
    axes = figure.add_axes((0, 0, 1, 1))
    half = np.tan(np.radians(FIELD_OF_VIEW) / 2)
    axes.set(xlim=(-half * width / height, half * width / height), ylim=(-half, half))
    axes.axis("off")
    edges = np.array([LINES]) if panel.edges else faces
    axes.add_collection(
        PolyCollection(list(projected), facecolors=faces, edgecolors=edges, linewidths=0.3)
    )
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.array(canvas.buffer_rgba())
