"""Stereolithography: triangles of three positions, in text or binary; no vertex is shared."""

import re
from collections.abc import Iterator
from typing import BinaryIO

import numpy as np

from meshfair.checks import Floats, Integers
from meshfair.io import text
from meshfair.io.attributes import Attributes, Layout
from meshfair.io.errors import file_error, quoted
from meshfair.io.extras import Extras
from meshfair.io.opening import check_content
from meshfair.io.precision import check_single
from meshfair.io.splicing import Places
from meshfair.mesh import face_normals

HOLDS: frozenset[str] = frozenset()
HEADER = 84  # bytes: 80 of anything, then the number of triangles
RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])

SOLID = re.compile(rb"\s*solid\b[^\n]*")
FACET = re.compile(
    # The normal follows from the corners, and is often NaN where there is no area.
    rb"\s*facet\s+normal\s+\S+\s+\S+\s+\S+\s+outer\s+loop"
    + 3 * rb"\s+vertex\s+(\S+\s+\S+\s+\S+)"
    + rb"\s+endloop\s+endfacet\b"
)
# The words of a facet, and which of them are its normal and its corners.
WORDS, NUMBERS = 21, (2, 3, 4, 8, 9, 10, 12, 13, 14, 16, 17, 18)
END = re.compile(rb"\s*end ?solid\b[^\n]*")
NOTHING = re.compile(rb"\s*\Z")


def parse(stream: BinaryIO) -> tuple[Floats, Integers, Integers]:
    """Read triangles from a stream of bytes; returns as `obj.parse`, three vertices for each."""
    size = stream.seek(0, 2)
    stream.seek(0)
    head = stream.read(HEADER)
    announced = int.from_bytes(head[80:], "little")
    whole = HEADER + announced * RECORD.itemsize
    stream.seek(0)
    # Many a binary file starts with solid too, or with anything, so its size decides.
    if size == whole:
        V = np.frombuffer(stream.read(), RECORD, offset=HEADER)["corners"]
        V = V.astype(np.float64).reshape(-1, 3)
    else:
        kind = check_content(stream, "STL", "binary data")
        if kind == "binary data" or not (kind or head.isascii()):
            found = f"{announced} triangles announced, which makes {whole} bytes"
            raise file_error("header, byte 80", found, f"the file has {size}")
        V = _corners(_normalised(stream.read()))
    return V, np.arange(len(V)), np.full(len(V) // 3, 3)


def is_binary(data: bytes) -> bool:
    """Whether a file is binary, not text: its size decides."""
    announced = int.from_bytes(data[80:HEADER], "little")
    return len(data) == HEADER + announced * RECORD.itemsize


def layout(data: bytes) -> Layout:
    """Where positions and normals are in a file that was read."""
    if is_binary(data):
        at = np.arange(HEADER, len(data), RECORD.itemsize)
        columns = [Places(at + 4 * k, dtype=np.dtype("<f4")) for k in range(12)]
    else:
        lower = _normalised(data)
        words = text.words_of(lower)
        first = _first_words(lower, words[0])
        columns = [Places.of_words(words, first + k) for k in NUMBERS]
    return Layout(columns[3:], columns[:3], by_face=True)


def extras(like: Attributes) -> Extras:
    """What a file that was read holds beside positions: the colours of its triangles."""
    data = like.data
    others: tuple[str, ...] = ()
    colors = None
    if is_binary(data):
        words = np.frombuffer(data, RECORD, offset=HEADER)["attribute"]
        # Magics sets bit 15 where a facet has the colour of all, VisCAM where it has its own.
        is_magics = b"COLOR=" in data[:80]
        if np.any(words) and np.all((words >> 15 == 0) if is_magics else (words >> 15 == 1)):
            parts = np.column_stack([words >> shift & 31 for shift in (0, 5, 10)])
            colors = (parts if is_magics else parts[:, ::-1]) * 255 // 31
            colors = colors.astype(np.uint8)
        elif np.any(words):
            others = ("attribute words",)
        m = len(words)
    else:
        lower = _normalised(data)
        m = sum(1 for _ in _facets(lower))
        others = ("solids",) if lower.count(b"endsolid") > 1 else ()
    return Extras(np.arange(3 * m), np.full(m, 3), face_colors=colors, others=others)


def _first_words(data: bytes, begin: Integers) -> Integers:
    """Which words of a text that was read the facets of all solids begin with."""
    codes, facets, at = np.frombuffer(data, np.uint8)[1:], [], 0
    while at < len(begin):
        at = int(np.searchsorted(begin, data.find(b"\n", begin[at] + 1)))  # behind solid NAME
        number = int(np.argmin(np.append(codes[begin[at::WORDS]] == ord("f"), False)))
        facets.append(at + WORDS * np.arange(number))
        at += WORDS * number
        at = int(np.searchsorted(begin, data.find(b"\n", begin[at] + 1)))
    return np.concatenate(facets)


def _normalised(data: bytes) -> bytes:
    return text.normalised_text(data, comments=False).lower()


def _facets(data: bytes) -> Iterator[re.Match[bytes]]:
    """The facets of all solids in a text of lower case: a normal and three positions each."""
    at = 0
    while not NOTHING.match(data, at):
        at = _match(SOLID, data, at, "the line solid NAME")
        while facet := FACET.match(data, at):
            yield facet
            at = facet.end()
        at = _match(END, data, at, "a facet (normal, outer loop, three vertices) or endsolid")


def _corners(data: bytes) -> Floats:
    """The positions in a text of lower case."""
    corners: list[bytes] = []
    for facet in _facets(data):
        corners += facet.groups()
    V = text.parse_numbers(b" ".join(corners), np.float64, 3 * len(corners))
    if V is None:
        k = next(k for k, c in enumerate(corners) if text.parse_numbers(c, np.float64, 3) is None)
        raise file_error(
            f"face {k // 3}", f"vertex {quoted(corners[k])}", "three numbers were expected"
        )
    return V.reshape(-1, 3)


def _match(pattern: re.Pattern[bytes], data: bytes, at: int, expected: str) -> int:
    """Where the pattern ends that has to come next."""
    found = pattern.match(data, at)
    if not found:
        rest = data[at : at + 200].strip()
        place = text.line_at(data, data.find(rest, at))
        raise file_error(
            place, f"found {quoted(rest) if rest else 'the end'}", f"{expected} has to follow"
        )
    return found.end()


def encode(V: Floats, F: Integers, binary: bool, more: Extras | None) -> tuple[bytes, Floats]:
    """The bytes of a file, and the positions in it; a triangle without area has normal zero."""
    check_single(V)
    corners, normals = V[F], face_normals(V, F)
    if binary:
        records = np.zeros(len(F), RECORD)
        records["normal"], records["corners"] = normals, corners
        data = b"meshfair".ljust(80) + len(F).to_bytes(4, "little") + records.tobytes()
        return data, V.astype(np.float32).astype(np.float64)
    facet = (
        "facet normal %.6g %.6g %.6g\nouter loop\n"
        + 3 * "vertex %r %r %r\n"
        + "endloop\nendfacet\n"
    )
    rows = np.column_stack([normals, corners.reshape(-1, 9)])
    return b"solid meshfair\n" + text.encode_rows(facet, rows) + b"endsolid meshfair\n", V
