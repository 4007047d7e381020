"""Polygon File Format: a header in text that announces elements, then their rows.

An element has properties, and each row has for each of them a number, or a
list: its length and its numbers. Rows are text, or binary in either byte order.
"""

import re
from collections import Counter
from collections.abc import Sequence
from itertools import product
from typing import Any, BinaryIO, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from meshfair.checks import Booleans, Floats, Integers
from meshfair.io.attributes import Layout
from meshfair.io.errors import file_error, quoted
from meshfair.io.faces import spans
from meshfair.io.opening import check_content
from meshfair.io.splicing import Places
from meshfair.io.text import Lines, blanked, encode_rows, normalised_text, words_of

Order: TypeAlias = Literal["little", "big"]
ORDERS: dict[str, Order | None] = {
    "ascii": None,
    "binary_little_endian": "little",
    "binary_big_endian": "big",
}
OLD_NAMES = ["char", "uchar", "short", "ushort", "int", "uint", "float", "double"]
NAMES = ["int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"]
TYPES: dict[str, np.dtype[Any]] = {name: np.dtype(name) for name in (*NAMES, "int64", "uint64")}
NORMAL = ("nx", "ny", "nz")
TYPES |= {old: TYPES[name] for old, name in zip(OLD_NAMES, NAMES, strict=True)}

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

    values: NDArray[Any]
    lengths: Integers  # how many each row has
    at: Integers  # where those of each row begin: which word of the rows, or which byte


Table: TypeAlias = dict[str, Column]


def parse(stream: BinaryIO) -> tuple[Floats, NDArray[Any], Integers]:
    """Read vertices and polygons from a stream of bytes; returns as `obj.parse`."""
    check_content(stream, "PLY")
    data = stream.read()
    order, elements, at = _header(data)
    element, name = _names_of_faces(elements)
    tables = _tables(data, order, elements, at)
    V = np.column_stack([tables["vertex"][axis].values for axis in "xyz"])
    corners, counts, _ = tables[element][name]
    if element == "tristrips":
        corners, counts = _strips(corners.astype(np.float64), counts)
    return V.astype(np.float64), corners, counts


def layout(data: bytes) -> Layout:
    """Where positions and normals are in a file that was read."""
    order, elements, at = _header(data)
    table = _tables(data, order, elements, at)["vertex"]
    words = None if order else words_of(_rows_of_text(data, at))
    properties = {p.name: p for e in elements if e.name == "vertex" for p in e.properties}

    def places(names: Sequence[str]) -> list[Places]:
        if words:
            return [Places.of_words(words, table[n].at, properties[n].dtype) for n in names]
        return [Places(table[n].at, dtype=table[n].values.dtype) for n in names]

    has_normals = all(name in properties and not properties[name].length for name in NORMAL)
    of_header = words_of(normalised_text(data[:at], comments=False))
    types = [Places.of_words(of_header, np.array([properties[axis].word])) for axis in "xyz"]
    double = np.dtype(np.float64).newbyteorder(order or "=")
    normals = places(NORMAL) if has_normals else ()
    return Layout(places("xyz"), normals, types=types, double=double)


def _end_of_header(data: bytes) -> int:
    """Where the rows start: after a line end, of the first line's kind if there is one.

    Binary rows may start with a byte that looks like the rest of another kind.
    """
    first = re.match(rb"(?:\xef\xbb\xbf)?\s*ply[ \t]*(\r\n|\r|\n)", data)
    if not first:
        raise file_error("line 1", f"found {quoted(data)}", "a PLY file starts with the line ply")
    end = rb"[\r\n][ \t]*end_header[ \t]*(?:%b|\r\n|\r|\n|\Z)" % first[1]
    last = re.search(end, data)
    if not last:
        raise file_error("header", "it does not end", "the line end_header closes it")
    return last.end()


def _header(data: bytes) -> tuple[Order | None, list[Element], int]:
    """The byte order (None for text), the elements that are announced, and where rows begin."""
    end = _end_of_header(data)
    lines = Lines(normalised_text(data[:end], comments=False))
    orders: list[Order | None] = []
    elements: list[Element] = []
    starts = lines.starts()
    for i, line in enumerate(lines.split()):
        match [word.decode("latin-1") for word in line]:
            case ["ply"] | ["end_header"] | ["comment" | "obj_info", *_]:
                pass
            case ["format", order, "1.0"] if order in ORDERS and not orders:
                orders.append(ORDERS[order])
            case ["element", name, rows] if re.fullmatch("[0-9]{1,18}", rows):
                elements.append(Element(name, int(rows), []))
            case ["property", dtype, name] if elements and dtype in TYPES:
                elements[-1].properties.append(Property(name, TYPES[dtype], word=starts[i] + 1))
            case ["property", "list", length, dtype, name] if (
                elements and dtype in TYPES and length in TYPES and TYPES[length].kind != "f"
            ):
                elements[-1].properties.append(Property(name, TYPES[dtype], TYPES[length]))
            case _:
                raise file_error(
                    f"header, {lines.place(i)}",
                    f"found {quoted(b' '.join(line))}",
                    "one 'format ascii 1.0' or a binary one, 'element NAME COUNT', 'property TYPE "
                    "NAME' or 'property list INTEGER-TYPE TYPE NAME' was expected",
                )
    if not orders:
        raise file_error("header", "no line tells the format", "one like 'format ascii 1.0' has to")
    names = [[e.name for e in elements], *([p.name for p in e.properties] for e in elements)]
    for group in filter(None, names):
        ((name, times),) = Counter(group).most_common(1)
        if times > 1:
            raise file_error("header", f"{name!r} is announced {times} times", "once was expected")
    return orders[0], [element for element in elements if element.properties], end


def _names_of_faces(elements: list[Element]) -> tuple[str, str]:
    """The element of faces or strips and its list of corners, if there are vertices, too."""
    numbers = {(e.name, p.name) for e in elements for p in e.properties if p.length is None}
    lists = {(e.name, p.name) for e in elements for p in e.properties if p.length is not None}
    for names in product(["face", "tristrips"], ["vertex_indices", "vertex_index"]):
        if names in lists and numbers.issuperset(("vertex", axis) for axis in "xyz"):
            return names
    announced = [(e.name, *(p.name for p in e.properties)) for e in elements]
    raise file_error(
        "header",
        f"the elements and their properties are {announced}",
        "vertex with numbers x, y and z, and face with a list vertex_indices are needed",
        "export the file as a mesh of vertices and faces",
    )


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


def _tables(data: bytes, order: Order | None, elements: list[Element], at: int) -> dict[str, Table]:
    """The table of each element, from rows that start at byte ``at``."""
    if order:
        return _binary_tables(data, at, elements, order)
    return _text_tables(Lines(_rows_of_text(data, at)), elements)


def _rows_of_text(data: bytes, at: int) -> bytes:
    """The normalised text with blanks instead of all that is no row."""
    text = normalised_text(data, comments=False)
    rows = text[at + 1 :]
    if b"comment" in rows:
        rows = COMMENT.sub(lambda line: blanked(line[0]), rows)
    return blanked(text[: at + 1]) + rows


def _text_tables(lines: Lines, elements: list[Element]) -> dict[str, Table]:
    """The table of each element, from one line for each row."""
    lines = lines.as_rows(
        [(e.rows, [p.length is not None for p in e.properties]) for e in elements]
    )
    if sum(element.rows for element in elements) != len(lines):
        announced = " and ".join(
            f"{element.rows} rows of element {element.name!r}" for element in elements
        )
        raise file_error("header", f"{announced} announced", f"{len(lines)} lines follow")
    tables: dict[str, Table] = {}
    row, word = 0, 0
    for element in elements:
        rows = lines[row : row + element.rows]
        tables[element.name] = _text_table(rows, element, word)
        row += element.rows
        word += rows.words.sum()
    return tables


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
    starts = at + np.arange(len(rows)) * layout.itemsize
    offsets = {name: offset for name, (_, offset, *_) in (layout.fields or {}).items()}
    table = {
        name: Column(rows[name].ravel(), np.full(len(rows), n), starts + offsets[name])
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


def encode(V: Floats, F: Integers, binary: bool) -> bytes:
    """The bytes of a file, with coordinates as float64."""
    header = (
        f"ply\nformat {'binary_little_endian' if binary else 'ascii'} 1.0\n"
        f"element vertex {len(V)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(F)}\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode()
    if not binary:
        return header + encode_rows("%r %r %r\n", V) + encode_rows("3 %d %d %d\n", F)
    faces = np.empty(len(F), [("length", "u1"), ("corners", "<i4", 3)])
    faces["length"], faces["corners"] = 3, F
    return header + V.astype("<f8").tobytes() + faces.tobytes()
