"""Object File Format: a header, one line for each vertex, one line for each face."""

import re
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from meshfair.checks import Floats, Integers
from meshfair.io.attributes import Attributes, Layout
from meshfair.io.errors import file_error, quoted
from meshfair.io.extras import Extras, bytes_of_fractions, split_at_seams
from meshfair.io.faces import spans
from meshfair.io.opening import check_content
from meshfair.io.splicing import Places
from meshfair.io.text import (
    Lines,
    Ragged,
    blanked,
    encode_ragged,
    encode_rows,
    normalised_text,
    words_of,
)
from meshfair.mesh import vertex_normals

HOLDS = frozenset(
    ["polygons", "colours", "colours of faces", "opacity", "normals", "texture coordinates"]
)
# The letters of the keyword tell what more each vertex has, in whatever order
# programs write them. The keyword may be left out, or the blank behind it.
HEADER = re.compile(
    rb"\s*+(?:(?P<more>(?:ST|C|N|4)*)OFF|off)?"
    rb"\s*(?P<n>\d{1,18})\s+(?P<m>\d{1,18})\s+\d{1,18}(?=\s)"
)


def parse(stream: BinaryIO) -> tuple[Floats, NDArray[Any], Integers]:
    """Read vertices and polygons from a stream of bytes; returns as `obj.parse`."""
    check_content(stream, "OFF")
    text = normalised_text(stream.read(), comments=True)
    header = HEADER.match(text)
    if not header:
        wanted = "OFF and the numbers of vertices, faces and edges were expected, and text"
        raise file_error("header", f"found {quoted(text.strip())}", wanted)
    lines, n, more, columns = _rows(text, header)
    return _vertices(lines[:n], columns, more), *_faces(lines[n:])


def _rows(text: bytes, header: re.Match[bytes]) -> tuple[Lines, int, bytes, int]:
    """One line a row; how many are vertices; what more these have, and how many numbers each."""
    more, n, m = header["more"] or b"", int(header["n"]), int(header["m"])
    columns = 3 + (b"4" in more) + 3 * (b"N" in more) + 2 * (b"ST" in more)
    lines = Lines(_without(header, text)).as_rows([(n, columns * [False]), (m, [True])])
    if len(lines) != n + m:
        raise file_error(
            "header", f"{n} vertices and {m} faces announced", f"{len(lines)} lines follow"
        )
    return lines, n, more, columns


def _without(header: re.Match[bytes], text: bytes) -> bytes:
    """The text with blanks instead of its header."""
    return blanked(header[0]) + text[header.end() :]


def layout(data: bytes) -> Layout:
    """Where positions and normals are in a file that was read."""
    text = normalised_text(data, comments=True)
    header = HEADER.match(text)
    assert header  # the file has been read
    lines, n, more, _ = _rows(text, header)
    words = words_of(_without(header, text))
    first = lines.starts()[:n]
    columns = [Places.of_words(words, first + k) for k in range(3)]
    if b"N" not in more:
        return Layout(columns)
    behind = 3 + (b"4" in more)
    return Layout(columns, [Places.of_words(words, first + behind + k) for k in range(3)])


def _vertices(lines: Lines, columns: int, more: bytes) -> Floats:
    # A colour of 3 or 4 values is found in files that announce none, too.
    allowed = (columns + 3, columns + 4) if b"C" in more else (columns, columns + 3, columns + 4)
    expected = f"it has {columns}, and a colour of 3 or 4"
    lines.require(np.isin(lines.words, allowed), lines.words, "values of a vertex", expected)
    numbers, starts = lines.numbers(), lines.starts()
    if b"4" in more:
        w = numbers[starts + 3]
        lines.require(w == 1, w, "as fourth coordinate", "only 1 is read", "divide x, y, z by it")
    return numbers[starts[:, None] + np.arange(3)]


def _faces(lines: Lines) -> tuple[NDArray[Any], Integers]:
    # Colours may be fractions; all other numbers are integers, which are read faster.
    has_fractions = np.isin(lines.codes, list(b".eE")).any()
    numbers = lines.numbers(np.float64 if has_fractions else np.int64)
    starts, values = lines.starts(), lines.words - 1
    counts = numbers[starts]
    fits = (counts >= 0) & np.isin(
        values - counts, (0, 1, 3, 4)
    )  # no colour, an index of one, RGB, RGBA
    lines.require(fits, values, "values after the count of a face", "the count is another")
    counts = counts.astype(np.int64)
    return numbers[spans(starts + 1, counts)], counts


def is_binary(data: bytes) -> None:
    """No file is, so this is nothing to choose."""


def extras(like: Attributes) -> Extras:
    """What a file that was read holds beside positions and faces."""
    data = like.data
    text = normalised_text(data, comments=True)
    header = HEADER.match(text)
    assert header  # the file has been read
    lines, n, more, columns = _rows(text, header)
    vertices, faces = lines[:n], lines[n:]
    corners, counts = _faces(faces)
    corners = corners.astype(np.int64)
    numbers, starts = vertices.numbers(), vertices.starts()
    has_normals, has_texture = b"N" in more, 2 * (b"ST" in more)
    texture = numbers[(starts + vertices.words)[:, None] - [2, 1]] if has_texture else None
    colors = None
    if np.all(vertices.words == vertices.words[0]) and vertices.words[0] > columns:
        color = np.arange(columns - has_texture, vertices.words[0] - has_texture)
        colors = bytes_of_fractions(numbers[starts[:, None] + color])
    size = faces.words - 1 - counts
    face_colors = None
    if size[0] >= 3 and np.all(size == size[0]):
        behind = (faces.starts() + faces.words - size)[:, None] + np.arange(size[0])
        face_colors = bytes_of_fractions(faces.numbers()[behind])
    return Extras(
        corners,
        counts,
        colors,
        face_colors,
        has_normals,
        texture,
        None if texture is None else corners,
        others=("colours by number",) if np.any(size == 1) else (),
    )


def encode(V: Floats, F: Integers, binary: bool, more: Extras | None) -> tuple[bytes, Floats]:
    """The bytes of a file, and the positions in it; its binary form is hardly known."""
    header = b"OFF\n%d %d 0\n"
    if more is None:
        table = encode_rows("%r %r %r\n", V) + encode_rows("3 %d %d %d\n", F)
        return header % (len(V), len(F)) + table, V
    normals = vertex_normals(V, F) if more.normals else None
    rows, more = split_at_seams(len(V), more)
    keyword, pattern = b"", "%r %r %r"
    columns: list[NDArray[Any]] = [V[rows]]
    if normals is not None:
        keyword, pattern = b"N", pattern + 3 * " %.9g"
        columns.append(normals[rows])
    if more.colors is not None:
        keyword, pattern = b"C" + keyword, pattern + more.colors.shape[1] * " %d"
        columns.append(more.colors)
    if more.texture is not None:
        keyword, pattern = b"ST" + keyword, pattern + 2 * " %.9g"
        columns.append(more.texture)
    ones = np.ones(len(more.counts), np.int64)
    faces: list[Ragged] = [(more.counts, ones), (more.corners, more.counts)]
    if more.face_colors is not None:
        faces.append((more.face_colors.ravel(), more.face_colors.shape[1] * ones))
    vertices = encode_rows(pattern + "\n", np.column_stack(columns))
    return keyword + header % (len(rows), len(ones)) + vertices + encode_ragged(*faces), V
