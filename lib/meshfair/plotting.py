"""Curves with matplotlib: their style in the report, and in notebooks of both themes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal

from meshfair.checks import needed_for

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

# One colour for each weights, told apart by colour-blind readers too (Okabe, Ito).
WEIGHT_COLORS = {"combinatorial": "#0072B2", "distance": "#D55E00", "cotangent": "#009E73"}
WEIGHT_MARKS = {"combinatorial": "o", "distance": "s", "cotangent": "^"}
# All that is no weights, such as filters: none of the colours above, and read on any paper.
OTHER_COLORS = ("#AF58BA", "#A68A00", "#808080", "#8C6D5A", "#D4668F")
CYCLE = f"cycler('color', {list(OTHER_COLORS)})"

STYLE: dict[Any, Any] = {  # any of matplotlib's names, which differ between its versions
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": 10,
    "axes.labelsize": 9.5,
    "figure.constrained_layout.use": True,
    "axes.prop_cycle": CYCLE,
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


# Read on white and on nearly black paper alike; what is behind them is the page.
BOTH_THEMES: dict[Any, Any] = {
    **dict.fromkeys(("text.color", "axes.labelcolor", "axes.titlecolor", "xtick.color"), "#808080"),
    # Where all ticks are lighter than half, or all darker, IPython has the page put black or
    # white behind the figure. With one of each, by a hair, it leaves it alone.
    "ytick.color": "#7f7f7f",
    "axes.edgecolor": "#808080",
    "axes.prop_cycle": CYCLE,
    "axes.facecolor": "none",
    "figure.facecolor": "none",
    "grid.color": "#808080",
    "legend.framealpha": 0.0,
    "patch.edgecolor": "#808080",
    "savefig.facecolor": "auto",
}


def for_both_themes() -> None:
    """Draw all figures from now on so that they can be read on light and on dark pages.

    They are transparent, with what is written in grey, because a figure is drawn once and the
    page's theme may change.

    Raises
    ------
    ImportError
        matplotlib is missing; the message says what to install.
    """
    with needed_for("a figure"):
        import matplotlib as mpl

    mpl.rcParams.update(BOTH_THEMES)


@contextmanager
def figure(
    path: str | PathLike[str],
    size: tuple[float, float] = (6.3, 2.6),
    columns: int = 1,
    **subplots: Any,
) -> Iterator[Any]:
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
    with needed_for("a figure"):
        import matplotlib as mpl
        from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=size)
        yield drawn.subplots(1, columns, **subplots)
        drawn.savefig(path, metadata={"Date": None})


def shades(count: int) -> list[str]:
    """Greys for what has an order, such as sizes of noise: the more, the darker.

    Parameters
    ----------
    count : int
        At least 1.

    Returns
    -------
    list of str
        As matplotlib writes greys, the lightest first, black last.
    """
    return [f"{0.7 * k / max(count - 1, 1):.2f}" for k in reversed(range(count))]


def draw_curves(
    axes: Axes,
    table: pd.DataFrame,
    y: str,
    *,
    x: str = "time",
    best: Literal["max", "min"] | None = None,
) -> None:
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
        colour = WEIGHT_COLORS[name]
        axes.plot(rows[x], rows[y], color=colour, label=name)
        if best:
            top = rows.loc[rows[y].idxmax() if best == "max" else rows[y].idxmin()]
            axes.plot(top[x], top[y], WEIGHT_MARKS[name], color=colour, markersize=5)


def legend(axes: Axes, best: str | None = None, **options: Any) -> None:
    """A legend of what is drawn and of the marks at the best points.

    Parameters
    ----------
    axes : matplotlib Axes
        With the curves of `draw_curves`.
    best : str, optional
        What the marks stand for, such as "best time"; without it they have no entry.
    **options
        Passed to ``Axes.legend``.
    """
    from matplotlib.legend_handler import HandlerTuple
    from matplotlib.lines import Line2D

    curves, labels = axes.get_legend_handles_labels()
    handles: list[Any] = list(curves)
    if best:
        marks = (
            Line2D([], [], ls="", marker=mark, color=WEIGHT_COLORS[name], markersize=4.5)
            for name, mark in WEIGHT_MARKS.items()
            if name in labels
        )
        handles.append(tuple(marks))
        labels.append(best)
    handlers = {tuple: HandlerTuple(ndivide=None, pad=0.3)}
    axes.legend(handles, labels, handler_map=handlers, **options)
