"""What a PLY file holds beside positions and faces, by the names that programs give it."""

import re
from collections.abc import Sequence

import numpy as np

from meshfair.checks import Floats, Integers
from meshfair.io.attributes import Attributes
from meshfair.io.extras import Colors, Extras, bytes_of_fractions
from meshfair.io.ply_header import names_of_faces, read_header
from meshfair.io.ply_rows import Property, Table, polygons, read_tables

NORMAL = ("nx", "ny", "nz")
TEXTURE = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))
COLOR = ("red", "green", "blue", "alpha")
COLORS = (
    COLOR,
    COLOR[:3],
    tuple(f"diffuse_{name}" for name in COLOR[:3]),
)


def extras(like: Attributes) -> Extras:
    """What a file that was read holds beside positions and faces."""
    data = like.data
    order, elements, at = read_header(data)
    tables = read_tables(data, order, elements, at)
    element, name = names_of_faces(elements)
    corners, counts = polygons(element, tables[element][name])
    corners = corners.astype(np.int64)
    properties = {e.name: e.properties for e in elements}
    vertices = _Known("vertex", properties["vertex"], tables["vertex"])
    vertices.numbers("xyz")
    faces = _Known("face", properties[element], tables[element])
    faces.lists(name, tables[element][name].lengths)
    colors, texture, texture_of = vertices.colors(), vertices.first(TEXTURE), corners
    face_colors = faces.colors() if element == "face" else None
    if texture is None and element == "face":
        at_corners = faces.lists("texcoord", 2 * counts)
        if at_corners is not None:
            texture, texture_of = at_corners.reshape(-1, 2), np.arange(len(corners))
    has_normals = vertices.numbers(NORMAL) is not None
    image = re.search(rb"[\r\n]comment\s+TextureFile\s+([^\r\n]+)", data[:at])
    others = [f"element {e.name}" for e in elements if e.name not in ("vertex", element) and e.rows]
    return Extras(
        corners,
        counts,
        colors,
        face_colors,
        has_normals,
        texture,
        None if texture is None else texture_of,
        image[1].decode("latin-1").strip() if image else None,
        (*vertices.rest(), *faces.rest(), *others),
    )


class _Known:
    """The properties of one element, and which of them are known by now."""

    def __init__(self, name: str, properties: Sequence[Property], table: Table) -> None:
        self._name, self._table = name, table
        self._properties = {p.name: p for p in properties}
        self._known: set[str] = set()

    def numbers(self, names: Sequence[str]) -> Floats | None:
        """The columns of these names, if all are there and none is of lists."""
        found = [self._properties[name] for name in names if name in self._properties]
        if len(found) < len(names) or any(p.length is not None for p in found):
            return None
        self._known.update(names)
        return np.column_stack([self._table[name].values for name in names]).astype(np.float64)

    def first(self, choices: Sequence[Sequence[str]]) -> Floats | None:
        """The first of several groups of columns that is there."""
        groups = (self.numbers(names) for names in choices)
        return next((columns for columns in groups if columns is not None), None)

    def lists(self, name: str, lengths: Integers) -> Floats | None:
        """The column of this name, if it is one of lists of these lengths."""
        column = self._table.get(name)
        if column is None or not np.array_equal(column.lengths, lengths):
            return None
        self._known.add(name)
        return column.values.astype(np.float64)

    def colors(self) -> Colors | None:
        """The colours, as bytes."""
        before = set(self._known)
        values = self.first(COLORS)
        if values is None:
            return None
        dtype = self._properties[(self._known - before).pop()].dtype
        if dtype.kind == "f":
            return bytes_of_fractions(values)
        return np.clip(values * (255 / np.iinfo(dtype).max), 0, 255).astype(np.uint8)

    def rest(self) -> list[str]:
        """All others, in words."""
        left = [name for name in self._properties if name not in self._known]
        return [f"property {name} of {self._name}" for name in left]
