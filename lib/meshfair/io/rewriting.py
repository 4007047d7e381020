"""A file once more with other positions: what else it holds stays byte for byte."""

from collections.abc import Sequence

import numpy as np

from meshfair.checks import Booleans, Floats
from meshfair.io.attributes import Attributes, Layout
from meshfair.io.faces import spans
from meshfair.io.normals import renewed
from meshfair.io.precision import check_single
from meshfair.io.splicing import Change, Places, put, rewritten_words, spliced, widened, word
from meshfair.io.text import parse_numbers
from meshfair.mesh import face_normals

# How numbers are written as text, so that they read back the same; a normal is a float32.
EXACT, WHOLE, NORMAL = "%r", "%d", "%.9g"


def rewritten(attributes: Attributes, layout: Layout, V: Floats) -> tuple[bytes, Floats]:
    """The bytes of a file with new positions, and with new normals where it has some.

    A number that has not changed keeps its bytes. Positions have the type they
    had, unless it is one of whole numbers or too small: then they become double.

    Parameters
    ----------
    attributes : Attributes
        The file.
    layout : Layout
        Where its numbers are.
    V : ndarray of float64, shape (n, 3)

    Returns
    -------
    data : bytes
    stored : ndarray of float64, shape (n, 3)
        The positions as they will be read again.
    """
    moved = V.view(np.int64) != attributes.V.view(np.int64)
    if not moved.any():
        return attributes.data, V
    rows = slice(None) if attributes.vertex is None else attributes.vertex
    positions = _changes(layout.positions, V[rows], moved[rows])
    normals = _normals(attributes, layout, V, moved) if layout.normals else []
    if all(change.fits() for change in positions):
        coarsest = min(layout.positions, key=lambda places: places.dtype.itemsize)
        stored = np.where(moved, coarsest.stored(V), V)
        return _written(attributes.data, positions + normals), stored
    if not layout.types:
        check_single(V)
    edits = [word(place, b"double") for place in layout.types]
    if layout.positions[0].size is None:  # all rows get longer
        data = _written(attributes.data, normals)
        everywhere = np.ones(len(V), bool)
        edits += [widened(c._replace(chosen=everywhere), layout.double) for c in positions]
    else:
        positions = [change._replace(pattern=EXACT) for change in positions]
        data = _written(attributes.data, positions + normals)
    return spliced(data, edits), V


def _changes(columns: Sequence[Places], values: Floats, chosen: Booleans) -> list[Change]:
    shape = -1, len(columns)
    parts = zip(columns, values.reshape(shape).T, chosen.reshape(shape).T, strict=True)
    return [Change(*part, EXACT if part[0].dtype.kind == "f" else WHOLE) for part in parts]


def _written(data: bytes, changes: list[Change]) -> bytes:
    if not changes:
        return data
    if changes[0].places.size is not None:
        return rewritten_words(data, changes)
    copy = bytearray(data)
    for change in changes:
        put(copy, change)
    return bytes(copy)


def _normals(attributes: Attributes, layout: Layout, V: Floats, moved: Booleans) -> list[Change]:
    F = attributes.F
    if layout.by_face:
        normals, changed = face_normals(V, F), np.any(moved[F], axis=(1, 2))
    else:
        old = np.column_stack([_numbers(attributes.data, places) for places in layout.normals])
        row = F if layout.normal_of is None else attributes.of_corners(layout.normal_of)
        normals, changed = renewed(attributes.V, V, F, row, old)
    changes = _changes(layout.normals, normals, np.column_stack(3 * [changed]))
    return [change._replace(pattern=NORMAL) for change in changes]


def _numbers(data: bytes, places: Places) -> Floats:
    """The numbers in a column of a file; NaN where words are none."""
    if places.size is None:
        where = places.at[:, None] + np.arange(places.dtype.itemsize)
        values: Floats = np.frombuffer(data, np.uint8)[where].view(places.dtype)[:, 0]
        return values.astype(np.float64)
    size = places.size + 1
    codes = np.frombuffer(data + b"\n", np.uint8)[spans(places.at, size)]
    codes[np.cumsum(size) - 1] = 32
    numbers = parse_numbers(codes.tobytes(), np.float64, len(size))
    return np.full(len(size), np.nan) if numbers is None else numbers
