"""A PLY file of vertices and faces, with any columns."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from meshfair.checks import Integers
from meshfair.io.faces import spans
from meshfair.io.ply_header import TYPES
from meshfair.io.text import Ragged, encode_ragged, encode_rows

PATTERNS = {"double": "%r", "float": "%.9g", "uchar": "%d"}


class Columns(NamedTuple):
    """Numbers of each row: their type, and the name of each."""

    type: str
    names: Sequence[str]
    values: NDArray[Any]

    @property
    def header(self) -> str:
        """The lines that announce them."""
        return "".join(f"property {self.type} {name}\n" for name in self.names)

    @property
    def pattern(self) -> str:
        """A row of them as text."""
        return " ".join(len(self.names) * [PATTERNS[self.type]])

    @property
    def packed(self) -> NDArray[Any]:
        """The numbers in their type."""
        return np.ascontiguousarray(self.values, TYPES[self.type].newbyteorder("<"))


class Lists(NamedTuple):
    """A list of each row: its name, the values of all, and how many each has."""

    name: str
    values: NDArray[Any]
    lengths: Integers

    @property
    def header(self) -> str:
        """The line that announces them."""
        length = "uchar" if self.lengths.max() < 256 else "int"
        return f"property list {length} {'float' if self._floats else 'int'} {self.name}\n"

    @property
    def packed(self) -> tuple[NDArray[Any], NDArray[Any]]:
        """The lengths and the values in their types."""
        lengths = self.lengths.astype("u1" if self.lengths.max() < 256 else "<i4")
        return lengths, self.values.astype("<f4" if self._floats else "<i4")

    @property
    def _floats(self) -> bool:
        return self.values.dtype.kind == "f"


def encode_file(
    binary: bool, comment: str, vertices: Sequence[Columns], faces: Sequence[Columns | Lists]
) -> bytes:
    """The bytes of a file; binary ones are little endian.

    Parameters
    ----------
    binary : bool
    comment : str
        A line of the header, with its end; or nothing.
    vertices, faces : sequence of Columns or Lists
        What the rows hold, one after the other; the corners first.
    """
    corners = faces[0]
    assert isinstance(corners, Lists)
    header = [f"ply\nformat {'binary_little_endian' if binary else 'ascii'} 1.0\n{comment}"]
    header += [f"element vertex {len(vertices[0].values)}\n", *(part.header for part in vertices)]
    header += [f"element face {len(corners.lengths)}\n", *(part.header for part in faces)]
    rows = _binary(vertices, faces) if binary else _text(vertices, faces)
    return b"".join(["".join([*header, "end_header\n"]).encode(), *rows])


def _binary(vertices: Sequence[Columns], faces: Sequence[Columns | Lists]) -> list[NDArray[Any]]:
    parts: list[tuple[NDArray[Any], Integers | int]] = []  # numbers, and how many each row has
    for part in faces:
        if isinstance(part, Columns):
            parts.append((part.packed, len(part.names)))
        else:
            lengths, values = part.packed
            alike = part.lengths.min() == part.lengths.max()
            parts += [(lengths, 1), (values, int(part.lengths[0]) if alike else part.lengths)]
    if all(isinstance(width, int) for _, width in parts):
        rows = _side_by_side([values.reshape(-1, width) for values, width in parts])
    else:
        m = len(faces[0].lengths) if isinstance(faces[0], Lists) else len(faces[0].values)
        sizes = [np.broadcast_to(values.itemsize * np.asarray(w), m) for values, w in parts]
        rows = _interleaved([values for values, _ in parts], np.column_stack(sizes))
    return [_side_by_side([part.packed for part in vertices]), rows]


def _side_by_side(tables: Sequence[NDArray[Any]]) -> NDArray[Any]:
    if len(tables) == 1:
        return tables[0]
    rows = np.empty(len(tables[0]), [(str(k), t.dtype, t.shape[1:]) for k, t in enumerate(tables)])
    for k, table in enumerate(tables):
        rows[str(k)] = table
    return rows


def _interleaved(columns: Sequence[NDArray[Any]], sizes: Integers) -> NDArray[np.uint8]:
    """Rows that have from each column so many bytes, shape (rows, columns)."""
    begins = np.cumsum(sizes.ravel()).reshape(sizes.shape) - sizes
    rows = np.empty(sizes.sum(), np.uint8)
    for k, column in enumerate(columns):
        rows[spans(begins[:, k], sizes[:, k])] = column.ravel().view(np.uint8)
    return rows


def _text(vertices: Sequence[Columns], faces: Sequence[Columns | Lists]) -> list[bytes]:
    pattern = " ".join(part.pattern for part in vertices)
    data = encode_rows(f"{pattern}\n", np.column_stack([part.values for part in vertices]))
    (corners, *more) = faces
    if isinstance(corners, Lists) and not more and np.all(corners.lengths == 3):
        return [data, encode_rows("3 %d %d %d\n", corners.values.reshape(-1, 3))]
    columns: list[Ragged] = []
    for part in faces:
        if isinstance(part, Columns):
            rows, width = part.values.shape
            columns.append((part.values.ravel(), np.full(rows, width)))
        else:
            columns.append((part.lengths, np.ones(len(part.lengths), np.int64)))
            columns.append((part.values, part.lengths))
    return [data, encode_ragged(*columns)]
