"""Meshes and their colours as bytes for the page that draws them."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from meshfair.checks import Floats
from meshfair.viewer.camera import Camera
from meshfair.viewer.panel import SURFACE, Panel, Scale
from meshfair.viewer.placement import Placement

NO_VALUE = 255  # among the places on the scale, which are from 0 to 254
FINEST = 65535  # steps of a grid along the longest side of the first meshes
NEAREST = 5  # arrays, at most, of which a similar one is made up
ASPECTS = (0.5, 1.0, 1.5, 2.0, 3.0)  # of panels that have cameras of their own

Entries = NDArray[Any]


class Seen(Protocol):
    """What a page is told of a view."""

    panels: list[Panel]
    titles: list[str]
    label: str
    up: Floats

    @property
    def scale(self) -> Scale | None:
        """How the panels' values become colours."""

    def camera_for(self, aspect: float) -> Camera:
        """The camera for panels of this shape."""


def parts(panel: Panel, scale: Scale | None) -> NDArray[np.uint8] | None:
    """A panel's values as places on the scale, 0 to 254, `NO_VALUE` where it is no number."""
    if panel.values is None or scale is None:
        return None
    places = np.rint(254 * np.clip(scale.parts(panel.values), 0, 1)).astype(np.uint8)
    places[~np.isfinite(panel.values)] = NO_VALUE
    return places


def look(panel: Panel, scale: Scale | None) -> dict[str, Any]:
    """How a panel is drawn, apart from its mesh and its values."""
    coloured = panel.values is not None
    return {
        "smooth": panel.smooth,
        "edges": panel.edges,
        "color": list(panel.none if coloured else SURFACE),
        "stops": scale.stops() if coloured and scale is not None else None,
    }


def pose(camera: Camera) -> list[float]:
    """A camera as nine numbers, with six digits that count."""
    numbers = (*camera.position, *camera.target, *camera.up)
    return [float(f"{number:.6g}") for number in numbers]


class Grid:
    """Positions as whole numbers of 16 bits, around the centre of some first meshes.

    Parameters
    ----------
    panels : sequence of Panel
        A mesh of their size has a step of one in `FINEST` parts of it; one that is up to
        2 ** k times as large, a step 2 ** k times as long.
    """

    def __init__(self, panels: Sequence[Panel]) -> None:
        self.placement = Placement.of(panels)

    def steps(self, panel: Panel) -> tuple[NDArray[np.int16], int]:
        """A mesh's positions in steps, and the power of 2 of the step's length."""
        X = self.placement.panel(panel).V * FINEST
        reach = float(np.abs(X).max())
        power = max(0, int(np.ceil(np.log2(reach / 32767.5)))) if reach > 32767.5 else 0
        # Half a step beyond the last whole number is rounded to it.
        return np.clip(np.rint(X / 2**power), -32767, 32767).astype(np.int16), power

    def units(self, power: int) -> float:
        """What a step is in the units of the page, in which the first meshes have size 1."""
        return float(2**power / FINEST)

    def cameras(self, view: Seen) -> list[list[Any]]:
        """The view's cameras for panels of several shapes, in the units of the page."""
        placed = (self.placement.camera(view.camera_for(aspect)) for aspect in ASPECTS)
        return [[aspect, pose(camera)] for aspect, camera in zip(ASPECTS, placed, strict=True)]


class Arrays:
    """Arrays of whole numbers as one string of bytes, each of them once.

    What is stored is the difference to what is expected: the entry before, or the best sum of
    multiples of some similar arrays, rounded. Byte by byte, zlib then makes it small. player.js
    has the way back, and computes the same sums to the last bit.
    """

    def __init__(self) -> None:
        # Of each: kind of numbers, entries, stride, similar arrays, and their factors.
        self.facts: list[tuple[str, int, int, list[int], list[float]]] = []
        self.size = 0  # about how many bytes there are, compressed
        self._bytes: list[bytes] = []
        self._stored: list[Entries] = []
        self._known: dict[tuple[str, bytes], int] = {}

    def add(self, entries: Entries, stride: int, similar: Sequence[int] = ()) -> int:
        """Store an array; its number.

        Parameters
        ----------
        entries : ndarray of int16, uint16, uint32 or uint8
        stride : int
            After how many entries one of the same kind comes: 3 for coordinates.
        similar : sequence of int
            Numbers of arrays that it may differ little from.

        Returns
        -------
        int
        """
        flat = np.ascontiguousarray(entries).ravel()
        kind = f"{flat.dtype.kind}{flat.itemsize}"
        key = (kind, flat.tobytes())
        if key in self._known:
            return self._known[key]
        before = np.zeros_like(flat)
        before[stride:] = flat[:-stride]
        best: tuple[list[int], list[float]] = ([], [])
        planes = _planes(flat, before)
        size = len(zlib.compress(planes, 1))
        nearest = self._nearest(flat, similar)
        for count in range(1, len(nearest) + 1):
            bases = nearest[:count]
            others = [self._stored[number] for number in bases]
            factors = _factors(flat, others)
            found = _planes(flat, _sum(others, factors, flat.dtype))
            if (shorter := len(zlib.compress(found, 1))) < size:
                best, planes, size = (bases, factors), found, shorter
        self.size += size
        self._bytes.append(planes)
        self._stored.append(flat)
        self.facts.append((kind, len(flat), stride, *best))
        self._known[key] = len(self.facts) - 1
        return len(self.facts) - 1

    def _nearest(self, flat: Entries, similar: Sequence[int]) -> list[int]:
        """Of some arrays the few that differ least, the nearest first."""
        apart = {}
        for number in similar:
            other = self._stored[number]
            if other.dtype == flat.dtype and len(other) == len(flat):
                apart[number] = int(np.abs(np.subtract(flat, other, dtype=np.int64)).sum())
        return sorted(apart, key=apart.__getitem__)[:NEAREST]

    def faces(self, F: Entries) -> int:
        """Store faces."""
        small = F.size == 0 or F.max() < 2**16
        return self.add(F.astype(np.uint16 if small else np.uint32), 3)

    def joined(self) -> bytes:
        """All of them, one after the other."""
        return b"".join(self._bytes)


def _factors(flat: Entries, others: Sequence[Entries]) -> list[float]:
    """The multiples of some arrays whose sum comes closest to another."""
    if len(others) == 1:
        return [1.0]
    columns = np.stack(others, axis=1).astype(np.float64)
    found = np.linalg.lstsq(columns, flat.astype(np.float64), rcond=None)[0]
    return [round(float(x), 6) for x in found]


def _sum(others: Sequence[Entries], factors: Sequence[float], dtype: np.dtype[Any]) -> Entries:
    """A sum of multiples of arrays, rounded; one product after the other, as the page adds."""
    total = np.full(len(others[0]), 0.5)
    for other, factor in zip(others, factors, strict=True):
        total += factor * other
    return np.floor(total).astype(np.int64).astype(dtype)


def _planes(entries: Entries, expected: Entries) -> bytes:
    """The differences' lowest bytes, then the next higher ones, and so on.

    Small differences of either sign become small numbers: 0, -1, 1, -2 are 0, 1, 2, 3.
    """
    width = entries.dtype.itemsize
    apart = (entries - expected).view(f"i{width}")
    folded = (apart << 1) ^ (apart >> (8 * width - 1))
    little = folded.astype(folded.dtype.newbyteorder("<"))
    return little.view(np.uint8).reshape(-1, width).T.tobytes()
