"""Old VTK files as bytes: surfaces, which meshio reads only as grids, and where numbers are."""

import re
from typing import Any

import numpy as np

from meshfair.io.attributes import Layout
from meshfair.io.errors import file_error
from meshfair.io.splicing import Places
from meshfair.io.text import normalised_text, words_of

HEAD = re.compile(rb"\A[^\n]*\n[^\n]*\n\s*(?P<kind>ASCII|BINARY)\s+DATASET\s+(?P<set>\w+)")
POLYGONS = re.compile(rb"\nPOLYGONS\s+(?P<rows>\d{1,12})\s+(?P<size>\d{1,12})\s*?\n")
ARRAY = re.compile(rb"\s*(?:OFFSETS|CONNECTIVITY)\s+\w*?(?P<bits>32|64)[ \t]*\r?\n", re.IGNORECASE)
OTHERS = re.compile(rb"\n(?:VERTICES|LINES|TRIANGLE_STRIPS)\s+\d+\s+\d+[ \t]*\r?\n")
NEXT = re.compile(rb"(?=\s(?:POINT_DATA|CELL_DATA|METADATA)\s)|\s*\Z")
POINTS = re.compile(rb"\nPOINTS\s+(?P<rows>\d{1,12})\s+(?P<type>float|double)[ \t]*\r?\n")
# The normals' own section, or the other forms in which programs write them.
NORMALS = re.compile(
    rb"\n(?:NORMALS\s+\S+|VECTORS\s+Normals|Normals\s+3\s+\d+)\s+(?P<type>float|double)[ \t]*\r?\n"
)
# What meshio does not know, and the same in words that it knows.
UNKNOWN = {
    rb"\nNORMALS\s+(\S+\s+(?:float|double)[ \t]*\r?\n)": rb"\nVECTORS \1",
    rb"\nTEXTURE_COORDINATES\s+(\S+)\s+(\d)\s+(float|double)[ \t]*\r?\n": (
        rb"\nSCALARS \1 \3 \2\nLOOKUP_TABLE default\n"
    ),
}
TYPES: dict[bytes, np.dtype[Any]] = {b"float": np.dtype(">f4"), b"double": np.dtype(">f8")}
POLYGON = 7  # VTK's number for this kind of cell


def as_grid(data: bytes) -> bytes:
    """The same file as an unstructured grid, where it is a surface of polygons.

    Both store the cells alike; a grid names the kind of each cell, too.
    """
    for pattern, known in UNKNOWN.items():
        data = re.sub(pattern, known, data)
    head, polygons = HEAD.match(data), POLYGONS.search(data)
    if not head or head["set"] != b"POLYDATA":
        return data
    if not polygons or OTHERS.search(data):
        found = "a surface without polygons, or with points, lines or strips beside them"
        raise file_error("content", found, "polygons alone are read", "triangulate it first")
    rows, sizes, end = int(polygons["rows"]), [int(polygons["size"])], polygons.end()
    is_new = ARRAY.match(data, end) is not None  # since version 5.1, with offsets
    cells = rows - is_new
    if head["kind"] == b"ASCII":
        end = NEXT.search(data, end).end()  # type: ignore[union-attr]
        kinds = b"\n".join([b"%d" % POLYGON] * cells)
    else:
        if is_new:
            sizes.insert(0, rows)
        for size in sizes:
            array = ARRAY.match(data, end)
            end = array.end() + size * int(array["bits"]) // 8 if array else end + 4 * size
        kinds = np.full(cells, POLYGON, ">i4").tobytes()
    return b"".join(
        [
            data[: head.start("set")] + b"UNSTRUCTURED_GRID" + data[head.end() : polygons.start()],
            b"\nCELLS %d %d\n" % (rows, sizes[-1]) + data[polygons.end() : end],
            b"\nCELL_TYPES %d\n" % cells + kinds + b"\n" + data[end:].lstrip(),
        ]
    )


def layout(data: bytes) -> Layout | None:
    """Where positions and normals are; None if it is not clear."""
    head, points, normals = HEAD.match(data), POINTS.search(data), NORMALS.search(data)
    if not head or not points:
        return None
    rows = int(points["rows"])

    def columns(found: re.Match[bytes]) -> list[Places]:
        if head["kind"] == b"BINARY":
            dtype = TYPES[found["type"]]
            first = found.end() + 3 * dtype.itemsize * np.arange(rows)
            return [Places(first + k * dtype.itemsize, dtype=dtype) for k in range(3)]
        first = np.searchsorted(words[0], found.end()) + 3 * np.arange(rows)
        return [Places.of_words(words, first + k) for k in range(3)]

    if head["kind"] == b"ASCII":
        words = words_of(normalised_text(data, comments=False))
    return Layout(columns(points), columns(normals) if normals else ())
