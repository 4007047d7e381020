"""The controls that explorers share: sliders and menus with names, units and tooltips."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import ipywidgets as widgets

from meshfair.viewer import coloring
from meshfair.weights import BY_NAME

PLAIN = "none"  # the colouring without values
NAMED = {"description_width": "7.6em"}
WIDE = {"width": "calc(100% - 8px)", "max_width": "34em"}

LARGEST_SIZE = 1.2  # of noise, in mean edge lengths

# How menus write the noise models' names.
NOISES = {
    "normals": "along the normals",
    "gaussian": "Gaussian",
    "uniform": "uniform",
    "correlated": "correlated (as scanners leave it)",
    "impulsive": "impulsive (one in ten)",
}


def slider(
    kind: Any,
    description: str,
    tooltip: str,
    *,
    value: float,
    ends: tuple[float, float],
    step: float,
    **options: Any,
) -> Any:
    """A slider that shows its value while it moves.

    Parameters
    ----------
    kind : type
        ``ipywidgets.FloatSlider`` or ``IntSlider``.
    description, tooltip : str
        A name with its unit, and a sentence.
    value, step : number
        What it shows first, and the least that it moves.
    ends : (number, number)
        The least and the largest value.
    **options
        Others of ``kind``, such as ``readout_format``.

    Returns
    -------
    ipywidgets.Widget
    """
    return kind(
        value=value,
        min=ends[0],
        max=ends[1],
        step=step,
        description=description,
        tooltip=tooltip,
        continuous_update=True,
        style=dict(NAMED),
        layout=dict(WIDE),
        **options,
    )


def choice(
    description: str,
    options: Iterable[str],
    value: str,
    tooltip: str,
    labels: Mapping[str, str] | None = None,
) -> Any:
    """A menu with a name.

    Parameters
    ----------
    description, tooltip : str
        A name, and a sentence.
    options : iterable of str
        What can be chosen.
    value : str
        The first choice.
    labels : dict of str to str, optional
        What the page shows for some of the options.

    Returns
    -------
    ipywidgets.Dropdown
    """
    return widgets.Dropdown(
        options=[((labels or {}).get(name, name), name) for name in options],
        value=value,
        description=description,
        tooltip=tooltip,
        style=dict(NAMED),
        layout=dict(WIDE),
    )


def color_choice(value: str = "displacement") -> Any:
    """The menu of what the meshes are coloured by."""
    return choice(
        "colour by",
        [*coloring.COLORINGS, PLAIN],
        value,
        "What the colours of the noisy meshes show",
    )


def noise_choice(models: Iterable[str], value: str, tooltip: str) -> Any:
    """The menu of noise models."""
    return choice("noise", models, value, tooltip, NOISES)


def size_slider(size: float, *, any_model: bool = False) -> Any:
    """The slider of the noise's size, along the normals or of a model that can be chosen."""
    name, meaning = "noise (edges)", "Standard deviation of the noise along the normals"
    if any_model:
        name, meaning = "size (edges)", "Standard deviation, or for uniform noise its range"
    return slider(
        widgets.FloatSlider,
        name,
        f"{meaning}, in mean edge lengths",
        value=size,
        ends=(0.0, LARGEST_SIZE),
        step=0.01,
    )


def tau_slider(tau: float, ends: tuple[float, float]) -> Any:
    """The slider of the time step."""
    return slider(
        widgets.FloatSlider,
        "time step τ",
        "Each iteration moves a vertex this part of the way to its neighbours' weighted mean",
        value=tau,
        ends=ends,
        step=0.05,
    )


def weights_choice(value: str = "combinatorial") -> Any:
    """The menu of weights."""
    return choice("weights", BY_NAME, value, "How much each neighbour counts")


def two_digits(number: float) -> str:
    """A number with two digits behind the point, or the sign for infinity: 27.31."""
    return f"{number:.2f}".replace("inf", "∞")


def said(control: Any, value: Any = None) -> str:
    """What a control shows of a value, in words.

    Parameters
    ----------
    control : ipywidgets.Widget
        A slider, a menu or a box.
    value : optional
        One that it could have; its own by default.

    Returns
    -------
    str
    """
    value = control.value if value is None else value
    if hasattr(control, "options"):
        return next(label for label, option in control.options if option == value)
    if isinstance(value, bool):
        return "yes" if value else "no"
    return format(value, control.readout_format)
