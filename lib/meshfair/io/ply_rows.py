"""The rows of a PLY file, text or binary, as tables."""

import re
from collections.abc import Iterator
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from meshfair.checks import Booleans, Floats, Integers
from meshfair.io.errors import file_error
from meshfair.io.faces import spans
from meshfair.io.text import Lines, blanked, normalised_text

Order: TypeAlias = Literal["little", "big"]
COMMENT = re.compile(rb"^[^\S\n]*comment\s[^\n]*", re.MULTILINE)


class Property(NamedTuple):
    """One column of an element; ``length`` is the type of a list's length, else None."""

    name: str
    dtype: np.dtype[Any]
    length: np.dtype[Any] | None = None
    word: int = 0  # which one of the header its type is


class Element(NamedTuple):
    """One table of the file, as the header announces it."""

    name: str
    rows: int
    properties: list[Property]


class Column(NamedTuple):
    """The values of a property in all rows, one after another."""

    table: NDArray[Any]  # of any shape: what nobody asks for is not copied
    lengths: Integers  # how many each row has
    at: Integers | range  # where those of each row begin: which word of the rows, or which byte

    @property
    def values(self) -> NDArray[Any]:
        """The values in one dimension."""
        return self.table.ravel()

    @property
    def starts(self) -> Integers:
        """What ``at`` says, as an array."""
        at = self.at
        return np.arange(at.start, at.stop, at.step) if isinstance(at, range) else at


Table: TypeAlias = dict[str, Column]


def read_tables(
    data: bytes, order: Order | None, elements: list[Element], at: int
) -> dict[str, Table]:
    """The table of each element, from rows that start at byte ``at``."""
    if order:
        return _binary_tables(data, at, elements, order)
    return _text_tables(Lines(rows_of_text(data, at)), elements)


def rows_of_text(data: bytes, at: int) -> bytes:
    """The normalised text with blanks instead of all that is no row."""
    text = normalised_text(data, comments=False)
    rows = text[at + 1 :]
    if b"comment" in rows:
        rows = COMMENT.sub(lambda line: blanked(line[0]), rows)
    return blanked(text[: at + 1]) + rows


def polygons(element: str, column: Column) -> tuple[NDArray[Any], Integers]:
    """Corners and counts from the element of faces or strips; see `faces.check_corners`."""
    if element == "tristrips":
        return _strips(column.values.astype(np.float64), column.lengths)
    return column.values, column.lengths


def _strips(corners: Floats, counts: Integers) -> tuple[Floats, Integers]:
    """Triangles of strips, which end at -1 and at the end of a row.

    Each corner after the first two of a strip makes a triangle with the two
    before it, and every second one of these is the other way round.
    """
    corners = np.insert(corners, np.cumsum(counts), -1)
    at = np.arange(len(corners))
    start = np.maximum.accumulate(np.where(corners == -1, at + 1, 0))
    triangles = np.column_stack([corners[:-2], corners[1:-1], corners[2:]])
    is_odd = (at - start)[:-2] % 2 == 1
    triangles[is_odd] = triangles[is_odd][:, [0, 2, 1]]
    triangles = triangles[~np.any(triangles == -1, axis=1)]
    return triangles.ravel(), np.full(len(triangles), 3)


def words_of_vertices(lines: Lines, elements: list[Element]) -> dict[str, Integers]:
    """Which word of the rows each number of the vertices is, by property."""
    element, rows, word = next(p for p in _text_parts(lines, elements) if p[0].name == "vertex")
    if any(p.length is not None for p in element.properties):
        return {name: column.starts for name, column in _text_table(rows, element, word).items()}
    first = rows.starts() + word
    return {p.name: first + k for k, p in enumerate(element.properties)}


def _text_tables(lines: Lines, elements: list[Element]) -> dict[str, Table]:
    """The table of each element, from one line for each row."""
    parts = _text_parts(lines, elements)
    return {element.name: _text_table(rows, element, word) for element, rows, word in parts}


def _text_parts(lines: Lines, elements: list[Element]) -> Iterator[tuple[Element, Lines, int]]:
    """Each element, one line for each of its rows, and which word is the first of these."""
    lines = lines.as_rows(
        [(e.rows, [p.length is not None for p in e.properties]) for e in elements]
    )
    if sum(element.rows for element in elements) != len(lines):
        announced = " and ".join(
            f"{element.rows} rows of element {element.name!r}" for element in elements
        )
        raise file_error("header", f"{announced} announced", f"{len(lines)} lines follow")
    row, word = 0, 0
    for element in elements:
        rows = lines[row : row + element.rows]
        yield element, rows, word
        row += element.rows
        word += int(rows.words.sum())


def _text_table(lines: Lines, element: Element, word: int) -> Table:
    def check(fits: Booleans) -> None:
        found = f"values in a row of element {element.name!r}"
        lines.require(fits, lines.words, found, "its properties take another number of them")

    fractions = any(p.dtype.kind == "f" for p in element.properties)
    numbers = lines.numbers(np.float64 if fractions else np.int64)
    at, end = lines.starts(), lines.starts() + lines.words
    table = {}
    for p in element.properties:
        lengths = np.ones(len(lines), np.int64)
        if p.length is not None:
            check(at < end)
            lengths, at = numbers[at], at + 1
        check((lengths >= 0) & (lengths <= end - at) & (lengths == np.floor(lengths)))
        lengths = lengths.astype(np.int64)
        table[p.name] = Column(numbers[spans(at, lengths)], lengths, at + word)
        at = at + lengths
    check(at == end)
    return table


def _binary_tables(data: bytes, at: int, elements: list[Element], order: Order) -> dict[str, Table]:
    tables = {}
    for element in elements:
        least = sum((p.length or p.dtype).itemsize for p in element.properties)
        if element.rows * least > len(data) - at:
            found = (
                f"{element.rows} rows of element {element.name!r}, of {least} bytes or more each"
            )
            raise file_error(f"byte {at}", found, f"{len(data) - at} bytes are left")
        tables[element.name], at = _binary_table(data, at, element, order)
    if data[at:].strip():
        raise file_error(
            f"byte {at}", f"{len(data) - at} bytes more", "the announced rows end here"
        )
    return tables


def _binary_table(data: bytes, at: int, element: Element, order: Order) -> tuple[Table, int]:
    """One table, and the byte where it ends."""
    first, end = _rows_one_by_one(data, at, element, order, min(element.rows, 1))
    if element.rows < 2:
        return first, end
    alike = _rows_alike(data, at, element, order, first)
    return alike or _rows_one_by_one(data, at, element, order, element.rows)


def _rows_alike(
    data: bytes, at: int, element: Element, order: Order, first: Table
) -> tuple[Table, int] | None:
    """All rows at once if their lists are as long as those of the first row, else None."""
    length_of = {name: len(column.values) for name, column in first.items()}
    fields: list[Any] = []
    for p in element.properties:
        if p.length is not None:
            fields.append((f"length of {p.name}", p.length))
        fields.append((p.name, p.dtype, (length_of[p.name],)))
    layout = np.dtype(fields).newbyteorder(order)
    end = at + element.rows * layout.itemsize
    if end > len(data):
        return None
    rows = np.frombuffer(data, layout, element.rows, at)
    # A list of another length cannot hide: up to it all rows are where they should be.
    lists = [p.name for p in element.properties if p.length is not None]
    if any(np.any(rows[f"length of {name}"] != length_of[name]) for name in lists):
        return None
    offsets = {name: offset for name, (_, offset, *_) in (layout.fields or {}).items()}
    table = {
        name: Column(
            rows[name],
            np.full(len(rows), n),
            range(at + offsets[name], end + offsets[name], layout.itemsize),
        )
        for name, n in length_of.items()
    }
    return table, end


def _rows_one_by_one(
    data: bytes, at: int, element: Element, order: Order, number: int
) -> tuple[Table, int]:
    """The table of this many rows, whatever the lengths of their lists, and where they end."""
    pieces: dict[str, list[bytes]] = {p.name: [] for p in element.properties}
    starts: dict[str, list[int]] = {p.name: [] for p in element.properties}
    for row in range(number):
        for p in element.properties:
            length = 1
            if p.length is not None:
                start, at = at, at + p.length.itemsize
                length = int.from_bytes(data[start:at], order, signed=p.length.kind == "i")
            start, at = at, at + length * p.dtype.itemsize
            if not start <= at <= len(data):
                found = f"row {row} of element {element.name!r} has a list of {length}"
                raise file_error(f"byte {start}", found, f"{len(data) - start} bytes are left")
            pieces[p.name].append(data[start:at])
            starts[p.name].append(start)
    table = {}
    for p in element.properties:
        values = np.frombuffer(b"".join(pieces[p.name]), p.dtype.newbyteorder(order))
        lengths = np.array([len(piece) for piece in pieces[p.name]], np.int64) // p.dtype.itemsize
        table[p.name] = Column(values, lengths, np.array(starts[p.name], np.int64))
    return table, at
