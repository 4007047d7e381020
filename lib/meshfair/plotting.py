"""Curves and plain pictures with matplotlib."""

from contextlib import contextmanager

import numpy as np

# One colour for each weights, told apart by colour-blind readers too (Okabe, Ito).
WEIGHT_COLOURS = {"combinatorial": "#0072B2", "distance": "#D55E00", "cotangent": "#009E73"}
WEIGHT_MARKS = {"combinatorial": "o", "distance": "s", "cotangent": "^"}

STYLE = {
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": 10,
    "axes.labelsize": 9.5,
    "figure.constrained_layout.use": True,
    "axes.formatter.use_mathtext": True,  # cmr10 has no minus sign of its own
    "font.family": "serif",
    "font.serif": ["cmr10"],
    "font.size": 9.5,
    "grid.alpha": 0.25,
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "lines.linewidth": 1.5,
    "mathtext.fontset": "cm",
    "svg.fonttype": "path",
    "svg.hashsalt": "meshfair",  # the same figure is the same file
}


@contextmanager
def figure(path, size=(6.3, 2.6), columns=1, **subplots):
    """A figure in the report's style, saved when the block ends.

    Parameters
    ----------
    path : path
        Where to save it; SVG and PDF are vector graphics.
    size : (float, float)
        Width and height in inches.
    columns : int
        Number of panels side by side.
    **subplots
        Passed to ``matplotlib.figure.Figure.subplots``.

    Yields
    ------
    matplotlib Axes, or an array of them
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=size)
        yield drawn.subplots(1, columns, **subplots)
        drawn.savefig(path, metadata={"Date": None})


def draw_curves(axes, table, y, *, x="time", best=None):
    """Draw one curve for each weights.

    Parameters
    ----------
    axes : matplotlib Axes
    table : pandas.DataFrame
        With columns weights, ``x`` and ``y``.
    y, x : str
        Columns to draw.
    best : "max" or "min", optional
        Mark the best point of each curve.
    """
    for name, rows in table.groupby("weights", sort=False):
        colour = WEIGHT_COLOURS[name]
        axes.plot(rows[x], rows[y], color=colour, label=name)
        if best:
            top = rows.loc[rows[y].idxmax() if best == "max" else rows[y].idxmin()]
            axes.plot(top[x], top[y], WEIGHT_MARKS[name], color=colour, markersize=5)


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
