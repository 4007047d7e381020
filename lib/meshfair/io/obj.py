"""Wavefront OBJ: lines of a keyword and its values; vertices are counted from 1."""

import re
from typing import BinaryIO

import numpy as np

from meshfair.checks import Booleans, Floats, Integers
from meshfair.io.attributes import Attributes, Layout
from meshfair.io.errors import file_error
from meshfair.io.extras import Colors, Extras, bytes_of_fractions
from meshfair.io.opening import check_content
from meshfair.io.splicing import Places
from meshfair.io.text import (
    Lines,
    encode_ragged,
    encode_rows,
    is_blank,
    normalised_text,
    parse_numbers,
    words_of,
)
from meshfair.mesh import vertex_normals

# The rest of the format is not part of a triangle mesh, and is skipped. Subdivision
# tools added t, and skinning tools vw.
SKIPPED = frozenset(
    b"bevel bmat bsp bzp c_interp call cdc cdp con cres csh cstype ctech curv curv2 d_interp deg "
    b"end g hole l lod maplib mg mtllib o p parm res s scrv shadow_obj sp stech step surf "
    b"t trace_obj trim usemap usemtl vn vp vt vw".split()
)
HOLDS = frozenset(["polygons", "colours", "normals", "texture coordinates"])
# What no other format knows, and the keywords that tell it.
OTHERS = {
    "materials": [b"usemtl", b"mtllib"],
    "groups": [b"g", b"o"],
    "smoothing groups": [b"s"],
    "lines and points": [b"l", b"p"],
}
LONGEST_KEYWORD = max(map(len, SKIPPED))
# x y z, and a fourth coordinate (1), a colour (3 or 4) or both, which are left out.
VALUES_OF_VERTEX = (3, 4, 6, 7, 8)
# What may follow the vertex in a corner v/vt/vn.
TEXTURE_AND_NORMAL = re.compile(rb"/(?<=\d/)(?:[-+]?\d+)?(?:/(?:[-+]?\d+)?)?(?=\s)")


def parse(stream: BinaryIO) -> tuple[Floats, Integers, Integers]:
    """Read vertices and polygons from a stream of bytes.

    Returns
    -------
    V : ndarray of float64, shape (n, 3)
    corners, counts
        The polygons, as in `meshfair.io.faces.check_corners`.
    """
    check_content(stream, "OBJ")
    text = normalised_text(stream.read(), comments=True)
    lines = Lines(_joined(text), original=text)
    is_vertex, is_face = _starting(lines, b"v"), _starting(lines, b"f")
    rest = lines[~(is_vertex | is_face)]
    keywords = rest.first_words(LONGEST_KEYWORD + 1)
    expected = "a line starts with v, f or another OBJ keyword"
    rest.require(np.isin(keywords, list(SKIPPED)), keywords, "as keyword", expected)
    V = _vertices(lines[is_vertex].without_letter())
    vertices_before = np.cumsum(is_vertex, dtype=np.int64)[is_face]
    return V, *_faces(lines[is_face].without_letter(), vertices_before, len(V))


def _joined(text: bytes) -> bytes:
    """The text with each line that ends with a backslash joined to the next."""
    return text.replace(b"\\\n", b"  ")


def _starting(lines: Lines, keyword: bytes) -> Booleans:
    """Which lines start with a keyword of one letter or two."""
    last = len(lines.codes) - 1
    fits = is_blank(lines.codes[np.minimum(lines.begin + len(keyword), last)])
    for k, letter in enumerate(keyword):
        fits &= lines.codes[np.minimum(lines.begin + k, last)] == letter
    return fits


def layout(data: bytes) -> Layout:
    """Where positions and normals are in a file that was read."""
    text = _joined(normalised_text(data, comments=True))
    lines, words = Lines(text), words_of(text)
    first = lines.starts()

    def values(which: Booleans) -> list[Places]:
        return [Places.of_words(words, first[which] + k) for k in (1, 2, 3)]

    positions, is_normal = values(_starting(lines, b"v")), _starting(lines, b"vn")
    if not np.any(is_normal) or np.any(lines.words[is_normal] != 4):
        return Layout(positions)
    normal_of = _named(lines, _starting(lines, b"f"), is_normal, 2)
    return Layout(positions, values(is_normal), normal_of)


def _named(lines: Lines, is_face: Booleans, is_named: Booleans, part: int) -> Integers:
    """The texture coordinate (part 1) or the normal (part 2) of each corner, from 0; or -1."""
    faces = lines[is_face].without_letter()
    # With zeros for what is left out, the parts of all words are one array of numbers.
    text = faces.codes.tobytes()
    if np.any((faces.codes[:-1] == ord("/")) & is_blank(faces.codes[1:])):
        text = re.sub(rb"/+(?=\s)", b"", text)
    text = text.replace(b"//", b"/0/")
    codes = np.frombuffer(b"\n" + text, np.uint8)
    begin = np.flatnonzero(is_blank(codes[:-1]) & ~is_blank(codes[1:]))
    slash = np.flatnonzero(codes == ord("/"))
    parts = 1 + np.bincount(np.searchsorted(begin, slash) - 1, minlength=len(begin))
    numbers = parse_numbers(text.replace(b"/", b" "), np.int64, parts.sum())
    assert numbers is not None  # the file has been read
    at = np.cumsum(parts) - parts + part
    named = np.where(parts > part, numbers[np.minimum(at, len(numbers) - 1)], 0)
    before = np.repeat(np.cumsum(is_named)[is_face], faces.words)
    named = np.where(named < 0, named + before, named - 1)
    return np.where((named >= 0) & (named < is_named.sum()), named, -1)


def _vertices(lines: Lines) -> Floats:
    fits = np.isin(lines.words, VALUES_OF_VERTEX)
    lines.require(fits, lines.words, "values of a vertex", "it has x, y and z")
    return lines.numbers()[lines.starts()[:, None] + np.arange(3)]


def _faces(lines: Lines, vertices_before: Integers, n: int) -> tuple[Integers, Integers]:
    counts = lines.words
    lines.require(counts >= 3, counts, "corners of a face", "it has three or more")
    indices = lines.without(TEXTURE_AND_NORMAL).numbers(np.int64)
    # Negative ones count back from the vertices read so far: -1 is the latest.
    before = np.repeat(vertices_before, counts)
    corners = np.where(indices < 0, indices + before, indices - 1)
    fits = (indices != 0) & (corners >= 0) & (corners < n)
    if not fits.all():
        corner = np.argmin(fits)
        line = int(np.searchsorted(np.cumsum(counts), corner, side="right"))
        known = f"the file has {n} vertices (1 to {n}), {before[corner]} of them before this line"
        raise file_error(lines.place(line), f"vertex index {indices[corner]}", known)
    return corners, counts


def is_binary(data: bytes) -> None:
    """No file is, so this is nothing to choose."""


def extras(like: Attributes) -> Extras:
    """What a file that was read holds beside positions and faces."""
    data = like.data
    text = _joined(normalised_text(data, comments=True))
    lines = Lines(text)
    is_face, is_texture = _starting(lines, b"f"), _starting(lines, b"vt")
    vertices = lines[_starting(lines, b"v")].without_letter()
    corners, counts = _faces(
        lines[is_face].without_letter(),
        np.cumsum(_starting(lines, b"v"), dtype=np.int64)[is_face],
        len(vertices),
    )
    normal_of = _named(lines, is_face, _starting(lines, b"vn"), 2)
    texture = texture_of = None
    words = b" ".join(b" ".join(line[1:3]) for line in lines[is_texture].split())
    values = parse_numbers(words, np.float64, 2 * int(np.sum(is_texture)))
    named = _named(lines, is_face, is_texture, 1)
    if values is not None and np.any(named >= 0):
        texture, texture_of = values.reshape(-1, 2), named
    others = [
        what
        for what, keywords in OTHERS.items()
        if any(np.any(_starting(lines, keyword)) for keyword in keywords)
    ]
    return Extras(
        corners,
        counts,
        _colors(vertices),
        normals=bool(np.any(normal_of >= 0)),
        texture=texture,
        texture_of=texture_of,
        others=tuple(others),
    )


def _colors(lines: Lines) -> Colors | None:
    """The colours of vertices, if all have one: the last three values, or four."""
    size = int(lines.words[0])
    if size < 6 or np.any(lines.words != size):
        return None
    return bytes_of_fractions(lines.numbers().reshape(-1, size)[:, 4 if size == 8 else 3 :])


def encode(V: Floats, F: Integers, binary: bool, more: Extras | None) -> tuple[bytes, Floats]:
    """The bytes of a file, and the positions in it; this format has no binary form."""
    if more is None:
        return encode_rows("v %r %r %r\n", V) + encode_rows("f %d %d %d\n", F + 1), V
    if more.colors is None:
        data = encode_rows("v %r %r %r\n", V)
    else:
        colored = np.column_stack([V, more.colors[:, :3] / 255])
        data = encode_rows("v %r %r %r %.6g %.6g %.6g\n", colored)
    texture_of = np.full(len(more.corners), -1)
    if more.texture is not None and more.texture_of is not None:
        data += encode_rows("vt %.9g %.9g\n", more.texture)
        texture_of = more.texture_of
    if more.normals:
        data += encode_rows("vn %.9g %.9g %.9g\n", vertex_normals(V, F))
    corners = zip((more.corners + 1).tolist(), (texture_of + 1).tolist(), strict=True)
    if more.normals:
        words = [b"%d/%b/%d" % (v, b"%d" % t if t else b"", v) for v, t in corners]
    else:
        words = [b"%d/%d" % (v, t) if t else b"%d" % v for v, t in corners]
    ones = np.ones(len(more.counts), np.int64)
    data += encode_ragged((np.full(len(ones), b"f"), ones), (np.array(words), more.counts))
    return data, V
