"""Polygon File Format: a header in text that announces elements, then their rows.

An element has properties, and each row has for each of them a number, or a
list: its length and its numbers. Rows are text, or binary in either byte order.
"""

from collections.abc import Sequence
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from meshfair.checks import Floats, Integers
from meshfair.io.attributes import Layout
from meshfair.io.extras import Extras
from meshfair.io.opening import check_content
from meshfair.io.ply_extras import COLOR, NORMAL, TEXTURE, extras
from meshfair.io.ply_header import names_of_faces, read_header
from meshfair.io.ply_rows import polygons, read_tables, rows_of_text, words_of_vertices
from meshfair.io.ply_writing import Columns, Lists, encode_file
from meshfair.io.splicing import Places
from meshfair.io.text import Lines, normalised_text, words_of
from meshfair.mesh import vertex_normals

__all__ = ["HOLDS", "encode", "extras", "is_binary", "layout", "parse"]

HOLDS = frozenset(
    [
        "polygons",
        "colours",
        "colours of faces",
        "opacity",
        "normals",
        "texture coordinates",
        "the name of the texture's image",
    ]
)
CORNERS = "vertex_indices"


def parse(stream: BinaryIO) -> tuple[Floats, NDArray[Any], Integers]:
    """Read vertices and polygons from a stream of bytes; returns as `obj.parse`."""
    check_content(stream, "PLY")
    data = stream.read()
    order, elements, at = read_header(data)
    element, name = names_of_faces(elements)
    tables = read_tables(data, order, elements, at)
    V = np.column_stack([tables["vertex"][axis].values for axis in "xyz"])
    return V.astype(np.float64), *polygons(element, tables[element][name])


def is_binary(data: bytes) -> bool:
    """Whether the rows of a file are binary, not text."""
    return read_header(data)[0] is not None


def layout(data: bytes) -> Layout:
    """Where positions and normals are in a file that was read."""
    order, elements, at = read_header(data)
    properties = {p.name: p for e in elements if e.name == "vertex" for p in e.properties}
    if order:
        table = read_tables(data, order, elements, at)["vertex"]
    else:
        rows = rows_of_text(data, at)
        words, which = words_of(rows), words_of_vertices(Lines(rows), elements)

    def places(names: Sequence[str]) -> list[Places]:
        if order:
            return [Places(table[n].starts, dtype=table[n].table.dtype) for n in names]
        return [Places.of_words(words, which[n], properties[n].dtype) for n in names]

    found = [properties[name] for name in NORMAL if name in properties]
    has_normals = len(found) == 3 and all(p.dtype.kind == "f" and not p.length for p in found)
    normals = places(NORMAL) if has_normals else ()
    of_header = words_of(normalised_text(data[:at], comments=False))
    types = [Places.of_words(of_header, np.array([properties[axis].word])) for axis in "xyz"]
    double = np.dtype(np.float64).newbyteorder(order or "=")
    return Layout(places("xyz"), normals, types=types, double=double)


def encode(V: Floats, F: Integers, binary: bool, more: Extras | None) -> tuple[bytes, Floats]:
    """The bytes of a file, and the positions in it, which are float64."""
    vertices = [Columns("double", "xyz", V)]
    if more is None:
        triangles = Lists(CORNERS, F.ravel(), np.full(len(F), 3))
        return encode_file(binary, "", vertices, [triangles]), V
    if more.normals:
        vertices.append(Columns("float", NORMAL, vertex_normals(V, F)))
    if more.colors is not None:
        vertices.append(Columns("uchar", COLOR[: more.colors.shape[1]], more.colors))
    faces: list[Columns | Lists] = [Lists(CORNERS, more.corners, more.counts)]
    if more.texture is not None and more.texture_of is more.corners:
        vertices.append(Columns("float", TEXTURE[0], more.texture))
    elif more.texture is not None and more.texture_of is not None:
        at_corners = np.where(more.texture_of[:, None] >= 0, more.texture[more.texture_of], 0)
        faces.append(Lists("texcoord", at_corners.ravel(), 2 * more.counts))
    if more.face_colors is not None:
        faces.append(Columns("uchar", COLOR[: more.face_colors.shape[1]], more.face_colors))
    comment = f"comment TextureFile {more.image}\n" if more.image else ""
    return encode_file(binary, comment, vertices, faces), V
