"""What an explorer shows at many positions of its controls, for a page without a kernel.

Pages cannot compute: an explorer goes through a part of its settings, and what it shows with
each is stored. The main control gets many positions; each of the others some, and with each
of them the main control a few.
"""

from __future__ import annotations

import html
import itertools
import time
import warnings
from collections.abc import Iterator, Sequence
from typing import Any, Protocol

import numpy as np

from meshfair.checks import MeshWarning
from meshfair.explorers.controls import said
from meshfair.explorers.curves import CurvePlot
from meshfair.viewer import View
from meshfair.viewer.recording import Recording

LARGEST = 1_000_000  # bytes of a page that an explorer may take
LONGEST = 25.0  # seconds that going through the settings may take
SHARE = 0.6  # of both, at most, for the main control alone
MANY, SOME, FEW = 41, 9, 6  # positions: of the main control, of others, of the main with those
LIVE = "Stored states: a notebook with Python behind it computes any setting."

Settings = dict[str, Any]


class Played(Protocol):
    """What is asked of an explorer."""

    controls: dict[str, Any]
    view: View
    plots: list[CurvePlot]
    main: str
    error: Exception | None

    def settings(self) -> Settings:
        """The controls' values by name."""

    def wait(self, timeout: float = 60) -> None:
        """Wait until what the settings ask for is shown."""

    def seen(self) -> tuple[str, str]:
        """The line below the controls, and what stands at the end, as HTML."""


def recorded(explorer: Played) -> Recording:
    """Go through an explorer's settings, and come back to those of before.

    Parameters
    ----------
    explorer : Explorer
        At rest.

    Returns
    -------
    Recording
        Its first state is the one that the explorer is in.
    """
    recording = Recording(explorer.view, live=LIVE)
    before, found = explorer.settings(), []

    def take() -> None:
        now = explorer.settings()
        if explorer.error is not None or now in found:
            return
        note, below = explorer.seen()
        plots = [recording.curves(_traits(plot)) for plot in explorer.plots]
        recording.add(explorer.view, plots=plots, note=html.unescape(note), below=below)
        found.append(now)

    take()
    began = time.monotonic()

    def spent() -> float:
        return max(recording.size / LARGEST, (time.monotonic() - began) / LONGEST)

    main = explorer.main
    for position in _spread(_positions(explorer.controls[main], before[main], MANY)):
        if spent() > SHARE:
            break
        _go(explorer, {main: position})
        take()
    for change in _changes(explorer.controls, before, main):
        if spent() > 1:
            break
        # What changes goes last: it may move another control to where it is at its best.
        _go(explorer, {k: v for k, v in before.items() if k not in change} | change)
        take()
    _go(explorer, before)
    recording.facts["controls"] = [
        _control(name, control, _ordered(control, [settings[name] for settings in found]), main)
        for name, control in explorer.controls.items()
    ]
    for number, settings in enumerate(found):
        at = [
            _ordered(control, [other[name] for other in found]).index(settings[name])
            for name, control in explorer.controls.items()
        ]
        recording.place(number, at)
    return recording


def _go(explorer: Played, settings: Settings) -> None:
    """Move the controls one after the other, and wait."""
    with warnings.catch_warnings():
        # A few waves of a mesh, or many steps, leave next to nothing of it: that is to be seen.
        warnings.simplefilter("ignore", MeshWarning)
        for name, value in settings.items():
            if explorer.controls[name].value != value:
                explorer.controls[name].value = value
        explorer.wait(600)


def _changes(controls: dict[str, Any], before: Settings, main: str) -> Iterator[Settings]:
    """Other settings than those of before, one control after the other, in turns."""
    rows = [
        [{name: at} for at in _spread(_positions(control, now, SOME)) if at != now]
        for (name, control), now in zip(controls.items(), before.values(), strict=True)
        if name != main
    ]
    turns = [change for turn in itertools.zip_longest(*rows) for change in turn if change]
    # Each control alone comes first: all of them shall move, and the main one with them later.
    yield from turns
    few = _positions(controls[main], before[main], FEW)
    yield from (change | {main: at} for change in turns for at in few)


def _positions(control: Any, now: Any, most: int) -> list[Any]:
    """Some values of a control in their order, that of now among them; all of a menu."""
    if hasattr(control, "options"):
        return [value for _, value in control.options]
    if isinstance(now, bool):
        return [False, True]
    count = round((control.max - control.min) / control.step) + 1
    steps = np.unique(np.linspace(0, count - 1, min(most, count)).round())
    kind = type(now)
    found = [kind(round(control.min + step * control.step, 10)) for step in steps]
    return sorted({*found, now})


def _spread(values: Sequence[Any]) -> list[Any]:
    """The same values, so that those at the beginning lie far apart: both ends, the middle, ..."""
    if len(values) < 3:
        return list(values)
    order, gaps = [0, len(values) - 1], [(0, len(values) - 1)]
    while gaps:
        low, high = gaps.pop(0)
        if high - low < 2:
            continue
        middle = (low + high) // 2
        order.append(middle)
        gaps += [(low, middle), (middle, high)]
    return [values[k] for k in order]


def _ordered(control: Any, values: Sequence[Any]) -> list[Any]:
    """Values of a control, each once, in the control's order."""
    if isinstance(values[0], bool):
        return [False, True] if len(set(values)) == 2 else [values[0]]
    if hasattr(control, "options"):
        return [value for _, value in control.options if value in values]
    return sorted(set(values))


def _control(name: str, control: Any, values: Sequence[Any], main: str) -> dict[str, Any]:
    """What a page needs to know of a control."""
    kind = "menu" if hasattr(control, "options") else "range"
    if isinstance(values[0], bool):
        kind = "box"
    return {
        "label": control.description,
        "tooltip": control.tooltip or "",
        "kind": kind,
        "texts": [said(control, value) for value in values],
        "main": name == main,
        "checked": [bool(value) for value in values] if kind == "box" else None,
    }


def _traits(plot: CurvePlot) -> dict[str, Any]:
    """What is to be seen of a plot."""
    names = ("title", "x_label", "y_label", "series", "x_range", "y_range", "threshold", "marker")
    return {name: getattr(plot, name) for name in names}
