"""Meshes drawn by matplotlib, triangle by triangle: where there is no OpenGL."""

import numpy as np


def draw_mesh(V, F, camera, field_of_view, size, values=None, limits=None, colours="viridis"):
    """Draw a mesh with matplotlib alone: faces painted from far to near.

    The fallback of `meshfair.viewer.render` where there is no EGL; the same
    camera and the same pixels, without shadows or hidden-surface tests.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    camera : meshfair.viewer.Camera
    field_of_view : float
        Vertical, in degrees.
    size : (int, int)
        Width and height in pixels.
    values, limits, colours
        As in `meshfair.viewer.render`.

    Returns
    -------
    ndarray of uint8, shape (height, width, 4)
    """
    from matplotlib import colormaps
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import PolyCollection
    from matplotlib.figure import Figure

    back = np.subtract(camera.position, camera.target)
    back /= np.linalg.norm(back)
    up = np.asarray(camera.up)
    X = (V - camera.position) @ np.stack([np.cross(up, back), up, back]).T
    corners = X[F]
    far_first = np.argsort(corners[:, :, 2].mean(axis=1))
    projected = corners[:, :, :2] / -corners[:, :, 2:]

    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1)
    facing = np.abs(normal @ [0.3, 0.4, 0.87]) / np.where(length > 0, length, 1)
    shade = (0.35 + 0.65 * facing)[:, None]
    base = np.array([0.55, 0.68, 0.86])
    if values is not None:
        on_faces = values[F].mean(axis=1) if len(values) == len(V) else values
        low, high = limits
        base = colormaps[colours]((on_faces - low) / ((high - low) or 1))[:, :3]
    paint = np.clip(shade * base, 0, 1)[far_first]

    figure = Figure(figsize=(size[0] / 100, size[1] / 100), dpi=100)
    figure.patch.set_alpha(0)
    axes = figure.add_axes([0, 0, 1, 1])
    half = np.tan(np.radians(field_of_view) / 2)
    axes.set(xlim=(-half * size[0] / size[1], half * size[0] / size[1]), ylim=(-half, half))
    axes.axis("off")
    axes.add_collection(
        PolyCollection(projected[far_first], facecolors=paint, edgecolors=paint, linewidths=0.3)
    )
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.array(canvas.buffer_rgba())
