"""A file once more with other positions: what else it holds stays byte for byte."""

from collections.abc import Sequence

import numpy as np

from meshfair.checks import Booleans, Floats
from meshfair.io.attributes import Attributes, Layout
from meshfair.io.faces import spans
from meshfair.io.normals import renewed
from meshfair.io.precision import check_single
from meshfair.io.splicing import Change, Edit, Places, edit, put, spliced, word
from meshfair.io.text import parse_numbers
from meshfair.mesh import face_normals

DIGITS = 9  # of normals in text: a float32 has no more


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
        return _written(attributes.data, positions + normals, []), stored
    if not layout.types:
        check_single(V)
    if layout.positions[0].size is None:  # all rows get longer
        positions = [change._replace(chosen=np.ones_like(change.chosen)) for change in positions]
    widened = [edit(change, layout.double) for change in positions]
    widened += [word(place, b"double") for place in layout.types]
    return _written(attributes.data, normals, widened), V


def _changes(columns: Sequence[Places], values: Floats, chosen: Booleans) -> list[Change]:
    shape = -1, len(columns)
    parts = zip(columns, values.reshape(shape).T, chosen.reshape(shape).T, strict=True)
    return [Change(*part) for part in parts]


def _written(data: bytes, changes: list[Change], edits: list[Edit]) -> bytes:
    in_place = [change for change in changes if change.places.size is None]
    edits = edits + [edit(change) for change in changes if change.places.size is not None]
    copy = bytearray(data)
    for change in in_place:
        put(copy, change)
    return spliced(copy, edits) if edits else bytes(copy)


def _normals(attributes: Attributes, layout: Layout, V: Floats, moved: Booleans) -> list[Change]:
    F = attributes.F
    if layout.by_face:
        normals, changed = face_normals(V, F), np.any(moved[F], axis=(1, 2))
    else:
        old = np.column_stack([_numbers(attributes.data, places) for places in layout.normals])
        row = F if layout.normal_of is None else attributes.of_corners(layout.normal_of)
        normals, changed = renewed(attributes.V, V, F, row, old)
    if layout.normals[0].size is not None:
        normals = np.round(normals, DIGITS)
    return _changes(layout.normals, normals, np.column_stack(3 * [changed]))


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
