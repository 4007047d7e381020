"""States of a view, with what stands around it, as a page without a kernel shows them."""

from __future__ import annotations

import base64
import json
import struct
import zlib
from collections.abc import Sequence
from typing import Any

from meshfair.viewer.packing import Arrays, Grid, Seen, look, parts
from meshfair.viewer.page import bar

DIGITS = 5  # that count, of the numbers of curves


class Recording:
    """One state of a view, or several that the controls of a page go to.

    What two states have in common is stored once: meshes, values, curves, texts.

    Parameters
    ----------
    view : SideBySide
        Its first state gives the grid of all positions.
    **facts
        What the page needs besides, such as the controls; see player.js.
    """

    def __init__(self, view: Seen, **facts: Any) -> None:
        self.facts = facts
        self.grid = Grid(view.panels)
        self.states: list[dict[str, Any]] = []
        self._up = [float(x) for x in view.up]
        self._arrays = Arrays()
        self._things: dict[str, int] = {}
        self._shown: dict[str, list[int]] = {}  # by kind

    @property
    def size(self) -> int:
        """About how many bytes the page needs for what there is so far."""
        texts = sum(map(len, self._things)) // 4 + 40 * len(self.states)
        return (self._arrays.size + texts) * 4 // 3

    def add(self, view: Seen, **around: Any) -> None:
        """Take down the state that a view is in.

        Parameters
        ----------
        view : SideBySide
        **around
            What else is to be seen in this state, as JSON has it.
        """
        scale = view.scale
        panels = []
        for panel, title in zip(view.panels, view.titles, strict=True):
            steps, power = self.grid.steps(panel)
            V = self._store(f"V{power}", steps, 3)
            F = self._arrays.faces(panel.F)
            places = parts(panel, scale)
            values = -1 if places is None else self._store("values", places, 1)
            drawn = look(panel, scale) | {"units": self.grid.units(power)}
            panels.append([V, F, values, self._thing(drawn), self._thing(title)])
        self.states.append(
            {
                "panels": panels,
                "bar": self._thing(scale and bar(scale, view.label)),
                "cameras": self._thing(self.grid.cameras(view)),
                **{name: self._thing(fact) for name, fact in around.items()},
            }
        )

    def place(self, number: int, at: Sequence[int]) -> None:
        """Say at which positions of the controls a state is.

        Parameters
        ----------
        number : int
            Of the state, in the order in which they were added.
        at : sequence of int
            For each control, which of its texts.
        """
        self.states[number]["at"] = self._thing(list(at))

    def curves(self, traits: dict[str, Any]) -> dict[str, Any]:
        """The traits of a plot, of which the numbers are stored once for all states."""
        series = [
            {k: self._numbers(v) if k in ("x", "y") else v for k, v in curve.items()}
            for curve in traits["series"]
        ]
        return {**traits, "series": series}

    def packed(self) -> str:
        """All of it, as text for a page."""
        header = {
            **self.facts,
            "up": self._up,
            "arrays": self._arrays.facts,
            "things": [json.loads(text) for text in self._things],
            "states": self.states,
        }
        return pack(header, self._arrays.joined())

    def _store(self, kind: str, entries: Any, stride: int) -> int:
        shown = self._shown.setdefault(kind, [])
        number = self._arrays.add(entries, stride, shown)
        if number not in shown:
            shown.append(number)
        return number

    def _thing(self, thing: Any) -> int:
        """The number of something that may be there already."""
        text = json.dumps(thing, separators=(",", ":"), allow_nan=False)
        return self._things.setdefault(text, len(self._things))

    def _numbers(self, numbers: Sequence[float]) -> int:
        return self._thing([float(f"{x:.{DIGITS}g}") for x in numbers])


def pack(header: dict[str, Any], arrays: bytes = b"") -> str:
    """What player.js unpacks, as text for a page."""
    text = json.dumps(header, separators=(",", ":"), allow_nan=False).encode()
    whole = struct.pack("<I", len(text)) + text + arrays
    return base64.b64encode(zlib.compress(whole, 9)).decode("ascii")
