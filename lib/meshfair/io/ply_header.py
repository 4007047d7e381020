"""The header of a PLY file."""

import re
from collections import Counter
from itertools import product
from typing import Any

import numpy as np

from meshfair.io.errors import file_error, quoted
from meshfair.io.ply_rows import Element, Order, Property
from meshfair.io.text import Lines, normalised_text

ORDERS: dict[str, Order | None] = {
    "ascii": None,
    "binary_little_endian": "little",
    "binary_big_endian": "big",
}
OLD_NAMES = ["char", "uchar", "short", "ushort", "int", "uint", "float", "double"]
NAMES = ["int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"]
TYPES: dict[str, np.dtype[Any]] = {name: np.dtype(name) for name in (*NAMES, "int64", "uint64")}
TYPES |= {old: TYPES[name] for old, name in zip(OLD_NAMES, NAMES, strict=True)}


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


def read_header(data: bytes) -> tuple[Order | None, list[Element], int]:
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


def names_of_faces(elements: list[Element]) -> tuple[str, str]:
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
