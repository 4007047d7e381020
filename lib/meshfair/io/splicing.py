"""New numbers in an old file: what is not one of the changed numbers stays byte for byte."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from meshfair.checks import Booleans, Floats, Integers

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
    pattern: str  # as which they are written in a text

    def fits(self) -> bool:
        """Whether the type can hold the values, rounded where it is one of fractions."""
        if self.places.dtype.kind == "f":
            return bool(np.abs(self.values).max() <= np.finfo(self.places.dtype).max)
        values = self.values[self.chosen]
        return bool(np.all(self.places.stored(values) == values))


class Edit(NamedTuple):
    """Pieces of a file that are replaced: where they begin, their length, and the new bytes."""

    at: Integers
    size: Integers
    new: list[bytes]


def widened(change: Change, double: np.dtype[Any]) -> Edit:
    """The replacement of binary numbers by ones of double precision."""
    data, size = change.values[change.chosen].astype(double).tobytes(), double.itemsize
    new = [data[k : k + size] for k in range(0, len(data), size)]
    at = change.places.at[change.chosen]
    return Edit(at, np.full(len(at), change.places.dtype.itemsize), new)


def word(place: Places, new: bytes) -> Edit:
    """The replacement of one word of a text."""
    assert place.size is not None
    return Edit(place.at, place.size, [new])


def spliced(data: bytes, edits: Sequence[Edit]) -> bytes:
    """The bytes with all pieces replaced; these stand in any order and do not overlap."""
    parts, end = [], 0
    for at, size, new in sorted(piece for edit in edits for piece in zip(*edit, strict=True)):
        parts += [data[end:at], new]
        end = at + size
    return b"".join([*parts, data[end:]])


def rewritten_words(data: bytes, changes: Sequence[Change]) -> bytes:
    """A text with other numbers, written as each change says."""
    words = [
        (places.at[chosen], places.size[chosen], values[chosen], np.full(chosen.sum(), kind))
        for kind, (places, values, chosen, _) in enumerate(changes)
        if places.size is not None
    ]
    at, size, values, kind = (np.concatenate(parts) for parts in zip(*words, strict=True))
    order = np.argsort(at, kind="stable")
    at, size, values, kind = at[order], size[order], values[order], kind[order]
    # The text becomes a pattern: one %r, say, for each number, and %% for each percent sign.
    codes = np.frombuffer(data, np.uint8)
    at += np.searchsorted(np.flatnonzero(codes == ord("%")), at)
    codes = np.frombuffer(data.replace(b"%", b"%%"), np.uint8)
    new_size = np.array([len(change.pattern) for change in changes])[kind]
    gaps = np.diff(at, prepend=0) - np.append(0, size[:-1])
    last = len(codes) - at[-1] - size[-1]
    is_kept, is_old = (
        np.repeat(
            np.append(np.tile([True, False], len(at)), True),
            np.append(np.column_stack([gaps, sizes]).ravel(), last),
        )
        for sizes in (size, new_size)
    )
    pattern = np.empty(len(is_old), np.uint8)
    pattern[is_old] = codes[is_kept]
    begin = np.cumsum(gaps + new_size) - new_size
    for number, change in enumerate(changes):
        for k, letter in enumerate(change.pattern.encode()):
            pattern[begin[kind == number] + k] = letter
    text = pattern.tobytes().decode("latin-1") % tuple(values.tolist())
    return text.encode("latin-1")


def put(data: bytearray, change: Change) -> None:
    """Write binary numbers in place."""
    places, values, chosen, _ = change
    stride = int(places.at[1] - places.at[0]) if len(places.at) > 1 else 0
    if np.all(places.at[1:] - places.at[:-1] == stride):
        column = np.ndarray(len(values), places.dtype, data, int(places.at[0]), (stride,))
        np.copyto(column, values, where=chosen, casting="unsafe")
    else:
        where = places.at[chosen, None] + np.arange(places.dtype.itemsize)
        bytes_of = values[chosen].astype(places.dtype).view(np.uint8)
        np.frombuffer(data, np.uint8)[where.ravel()] = bytes_of
