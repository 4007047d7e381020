"""New numbers in an old file: what is not one of the changed numbers stays byte for byte."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from meshfair.checks import Booleans, Floats, Integers
from meshfair.io.faces import spans

DOUBLE: np.dtype[Any] = np.dtype(np.float64)


@dataclass(frozen=True)
class Places:
    """Where a column of numbers is in the bytes of a file.

    Attributes
    ----------
    at : ndarray of int64, shape (rows,)
        The first byte of each number.
    size : ndarray of int64, shape (rows,), or None
        The length of each word of a text; None for binary numbers.
    dtype : numpy.dtype
        The announced type of the numbers, with its byte order.
    """

    at: Integers
    size: Integers | None = None
    dtype: np.dtype[Any] = DOUBLE

    @classmethod
    def of_words(
        cls, words: tuple[Integers, Integers], which: Integers, dtype: Any = np.float64
    ) -> "Places":
        """The places of some words of a text, given as what `text.words_of` returns."""
        return cls(words[0][which], words[1][which], np.dtype(dtype))

    def stored(self, values: Floats) -> Floats:
        """The values as they are read again when they are written here: text is exact."""
        if self.size is not None and self.dtype.kind == "f":
            return values
        with np.errstate(over="ignore", invalid="ignore"):
            return values.astype(self.dtype).astype(np.float64)


class Change(NamedTuple):
    """A column of numbers, what they are to be, and which of them are to be written."""

    places: Places
    values: Floats
    chosen: Booleans

    def fits(self) -> bool:
        """Whether the type can hold the values, rounded where it is one of fractions."""
        values = self.values[self.chosen]
        stored = self.places.stored(values)
        is_float = self.places.dtype.kind == "f"
        return bool(np.all(np.isfinite(stored) if is_float else stored == values))


class Edit(NamedTuple):
    """Pieces of a file that are replaced: where they begin, their length, and the new bytes."""

    at: Integers
    size: Integers
    codes: NDArray[np.uint8]
    new_size: Integers


def edit(change: Change, double: np.dtype[Any] = DOUBLE) -> Edit:
    """The replacement of numbers by ones of any length: text, or this double precision."""
    places = change.places
    at, values = places.at[change.chosen], change.values[change.chosen]
    if places.size is not None:
        codes = np.frombuffer(("%r " * len(values) % tuple(values.tolist())).encode(), np.uint8)
        blank = codes == 32
        new_size = np.diff(np.flatnonzero(blank), prepend=-1) - 1
        return Edit(at, places.size[change.chosen], codes[~blank], new_size)
    old_size, new_size = (np.full(len(at), dtype.itemsize) for dtype in (places.dtype, double))
    return Edit(at, old_size, values.astype(double).view(np.uint8), new_size)


def word(place: Places, new: bytes) -> Edit:
    """The replacement of one word of a text."""
    assert place.size is not None
    return Edit(place.at, place.size, np.frombuffer(new, np.uint8), np.array([len(new)]))


def put(data: bytearray, change: Change) -> None:
    """Write binary numbers in place."""
    places, values, chosen = change
    stride = int(places.at[1] - places.at[0]) if len(places.at) > 1 else 0
    if np.all(places.at[1:] - places.at[:-1] == stride):
        column = np.ndarray(len(values), places.dtype, data, int(places.at[0]), (stride,))
        np.copyto(column, values, where=chosen, casting="unsafe")
    else:
        where = places.at[chosen, None] + np.arange(places.dtype.itemsize)
        bytes_of = values[chosen].astype(places.dtype).view(np.uint8)
        np.frombuffer(data, np.uint8)[where.ravel()] = bytes_of


def spliced(data: bytes | bytearray, edits: Sequence[Edit]) -> bytes:
    """The bytes with all pieces replaced; these stand in any order and do not overlap."""
    at, size, new_size = (np.concatenate([edit[k] for edit in edits]) for k in (0, 1, 3))
    codes = np.concatenate([edit.codes for edit in edits])
    order = np.argsort(at, kind="stable")
    codes = codes[spans((np.cumsum(new_size) - new_size)[order], new_size[order])]
    at, size, new_size = at[order], size[order], new_size[order]
    old = np.frombuffer(data, np.uint8)
    kept = np.ones(len(old), bool)
    kept[spans(at, size)] = False
    grown = np.cumsum(new_size - size)
    is_new = np.zeros(len(old) + (grown[-1] if len(grown) else 0), bool)
    is_new[spans(at + grown - (new_size - size), new_size)] = True
    result = np.empty(len(is_new), np.uint8)
    result[is_new] = codes
    result[~is_new] = old[kept]
    return result.tobytes()
