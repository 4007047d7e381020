"""VTK and VTU: grids of cells, read and written by meshio."""

from __future__ import annotations

import io
import tempfile
from contextlib import redirect_stderr
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from meshfair.checks import Floats, Integers, needed_for
from meshfair.io import legacy_vtk
from meshfair.io.attributes import Attributes
from meshfair.io.errors import file_error, one_line
from meshfair.io.extras import Extras, bytes_of_fractions, split_at_seams
from meshfair.io.normals import renewed
from meshfair.io.rewriting import rewritten
from meshfair.mesh import vertex_normals

if TYPE_CHECKING:
    from meshio import Mesh

CORNERS = {3: "triangle", 4: "quad"}
SURFACES = {*CORNERS.values(), "polygon"}
COLORS, NORMALS, TEXTURE = ("RGB", "RGBA", "Colors", "rgb"), "Normals", "TCoords"


@dataclass(frozen=True)
class Grids:
    """One of the formats; the functions are those of the module `meshfair.io.obj`."""

    ending: str
    HOLDS: frozenset[str]

    def parse(self, stream: BinaryIO) -> tuple[Floats, Integers, Integers, str]:
        """Read those cells of a grid that are polygons; and what is to be told."""
        grid = self._grid(stream.read())
        corners, counts = _polygons(grid)
        if not len(counts):
            kinds = sorted({block.type for block in grid.cells})
            found = f"the cells are of the kinds {kinds}"
            raise file_error("faces", found, "polygons were expected", "extract the surface first")
        others = ", ".join(sorted({block.type for block in grid.cells} - SURFACES))
        told = f"of its cells, those of the kinds {others} are no faces" if others else ""
        return np.array(grid.points, np.float64), corners, counts, told

    def is_binary(self, data: bytes) -> None:
        """New files are, so this is nothing to choose."""

    def extras(self, like: Attributes) -> Extras:
        """What a file that was read holds beside positions and faces."""
        grid = self._grid(like.data)
        corners, counts = _polygons(grid)
        arrays = {name: np.asarray(values) for name, values in grid.point_data.items()}
        n = len(grid.points)
        name = next((k for k in COLORS if k in arrays and arrays[k].shape in ((n, 3), (n, 4))), "")
        colors = arrays.pop(name, None)
        if colors is not None and colors.dtype != np.uint8:
            colors = bytes_of_fractions(colors.astype(np.float64))
        texture = arrays.pop(TEXTURE, np.zeros(0)).astype(np.float64)
        has_texture = texture.shape == (n, 2)
        has_normals = arrays.pop(NORMALS, None) is not None
        cells = [f"array {name} of cells" for name in grid.cell_data]
        return Extras(
            corners,
            counts,
            colors,
            normals=has_normals,
            texture=texture if has_texture else None,
            texture_of=corners if has_texture else None,
            others=(*(f"array {name} of points" for name in arrays), *cells),
        )

    def encode(
        self, V: Floats, F: Integers, binary: bool, more: Extras | None
    ) -> tuple[bytes, Floats]:
        """The bytes of a file, and the positions in it."""
        rows = np.arange(len(V))
        arrays: dict[str, NDArray[Any]] = {}
        if more is None:
            blocks = [("triangle", F)]
        else:
            normals = vertex_normals(V, F) if more.normals else None
            rows, more = split_at_seams(len(V), more)
            if normals is not None:
                arrays[NORMALS] = normals[rows]
            if more.colors is not None:
                arrays[COLORS[more.colors.shape[1] == 4]] = more.colors
            if more.texture is not None:
                arrays[TEXTURE] = more.texture
            blocks = _blocks(more.corners, more.counts)
        with needed_for(f"a {self.ending} file"):
            from meshio import Mesh
        return self._written(Mesh(V[rows], blocks, point_data=arrays)), V

    def rewritten(self, like: Attributes, V: Floats) -> tuple[bytes, Floats]:
        """A grid once more with other positions: its arrays are kept."""
        layout = legacy_vtk.layout(like.data) if self.ending == ".vtk" else None
        if layout and len(layout.positions[0].at) == len(V):
            return rewritten(like, layout, V)
        if np.array_equal(V, like.V):
            return like.data, V
        grid = self._grid(like.data)
        if NORMALS in grid.point_data:
            old = np.asarray(grid.point_data[NORMALS])
            normals, changed = renewed(like.V, V, like.F, like.F, old.astype(np.float64))
            grid.point_data[NORMALS] = np.where(changed[:, None], normals, old).astype(old.dtype)
        grid.points = V.astype(grid.points.dtype.newbyteorder("="))
        return self._written(grid), grid.points.astype(np.float64)

    def _grid(self, data: bytes) -> Mesh:
        with needed_for(f"a {self.ending} file"):
            import meshio
        read = {".vtk": meshio.vtk.read, ".vtu": meshio.vtu.read}[self.ending]
        with tempfile.TemporaryDirectory() as folder, redirect_stderr(io.StringIO()):
            path = Path(folder, "grid")
            path.write_bytes(legacy_vtk.as_grid(data) if self.ending == ".vtk" else data)
            try:
                return read(path)
            except (MemoryError, KeyboardInterrupt):
                raise
            except BaseException as error:  # of a damaged file, even SystemExit
                found = f"{type(error).__name__} ({one_line(error)})"
                raise file_error("content", found, f"a whole {self.ending} was expected") from None

    def _written(self, grid: Mesh) -> bytes:
        import meshio

        write = {".vtk": meshio.vtk.write, ".vtu": meshio.vtu.write}[self.ending]
        with tempfile.TemporaryDirectory() as folder, redirect_stderr(io.StringIO()):
            path = Path(folder, "grid")
            write(path, grid)
            return path.read_bytes()


def _polygons(grid: Mesh) -> tuple[Integers, Integers]:
    """Corners and counts of the cells that are polygons; see `faces.check_corners`."""
    cells = [np.asarray(block.data) for block in grid.cells if block.type in SURFACES]
    corners = [cell.ravel() for cell in cells]
    counts = [np.full(len(cell), cell.shape[1]) for cell in cells]
    none = [np.empty(0, np.int64)]
    return np.concatenate(none + corners), np.concatenate(none + counts)


def _blocks(corners: Integers, counts: Integers) -> list[tuple[str, Any]]:
    """The polygons in runs of as many corners."""
    changes = np.flatnonzero(np.diff(counts)) + 1
    parts = np.split(corners, np.cumsum(counts)[changes - 1])
    sizes = counts[np.append(0, changes)]
    return [
        (CORNERS.get(int(size), "polygon"), part.reshape(-1, size))
        for part, size in zip(parts, sizes, strict=True)
    ]
