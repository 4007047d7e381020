"""Read and write triangle meshes: OBJ, OFF, PLY and STL, each also compressed with gzip.

The vertices of a file come back in its order, and its faces too; what is no
mesh is refused with one sentence. Everything else that a sound file holds is
left out: normals, colours, texture, weights, materials, lines and points.
"""

import gzip
import logging
import warnings
from os import PathLike
from pathlib import Path
from types import ModuleType

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import Floats, Integers, MeshWarning, check_mesh, check_vertices
from meshfair.io import obj, off, ply, stl
from meshfair.io.errors import MeshFileError, file_error
from meshfair.io.faces import check_corners, fan
from meshfair.io.opening import decompressed, open_regular
from meshfair.io.saving import replace_file

__all__ = ["MeshFileError", "read", "write"]

FORMATS = {".obj": obj, ".off": off, ".ply": ply, ".stl": stl}

log = logging.getLogger(__name__)


def read(path: str | PathLike[str], *, weld_stl: bool = False) -> tuple[Floats, Integers]:
    """Read a triangle mesh.

    Parameters
    ----------
    path : str or os.PathLike
        A regular file ending in .obj, .off, .ply or .stl, or in one of these
        and .gz; upper case is the same.
    weld_stl : bool
        Merge the vertices of an STL file that have equal coordinates. This
        format stores three vertices for each triangle and shares none, so
        without it no triangle has a neighbour, and a `MeshWarning` says so.

    Returns
    -------
    V : ndarray of float64, shape (n, 3)
        Vertex positions, in the file's units and order, used by a face or not.
    F : ndarray of int64, shape (m, 3)
        Vertex indices of the triangles, from 0, in the file's order. Faces of
        more corners become fans of triangles, and a `MeshWarning` says so.

    Raises
    ------
    MeshFileError, MeshError
        No mesh, or one that is cut or damaged: the message has the file, the
        place in it, what is there, what should be, and what to do.
    """
    path = Path(path)
    try:
        module, packed = _format(path)
        # A float32 that is NaN may warn when it is widened; it is refused below.
        with open_regular(path) as file, np.errstate(invalid="ignore"):
            V, corners, counts = module.parse(decompressed(file) if packed else file)
        V = check_vertices(V, str(path))
        check_corners(corners, counts, len(V))
    except MeshFileError as error:
        raise MeshFileError(f"{path}: {error}") from None
    except OSError as error:
        raise MeshFileError(f"{path}: reading failed ({error.strerror}); check the disk") from None
    F = fan(corners.astype(np.int64), counts)
    if len(F) > len(counts):
        warnings.warn(
            f"{path}: {np.sum(counts > 3)} of {len(counts)} faces have more than three corners "
            f"(up to {counts.max()}); they are cut into fans, which makes {len(F)} triangles",
            MeshWarning,
            stacklevel=2,
        )
    return _welded(path, V, F, weld_stl) if module is stl else (V, F)


def write(path: str | PathLike[str], V: ArrayLike, F: ArrayLike, *, binary: bool = True) -> None:
    """Write a triangle mesh; after any failure the old file or the new one is whole.

    Coordinates come back from `read` bit by bit, except that a binary STL holds
    them in float32.

    Parameters
    ----------
    path : str or os.PathLike
        The ending tells the format, as for `read`. A file of this name is
        replaced when the new one is complete.
    V : array_like, shape (n, 3)
        Vertex positions, in any unit of length.
    F : array_like of integers, shape (m, 3)
        Vertex indices of the triangles, from 0.
    binary : bool
        Write PLY (little endian, float64) and STL in binary, not as text.

    Raises
    ------
    MeshError
        Arrays that are no mesh; see `meshfair.checks.check_mesh`.
    MeshFileError
        An unknown ending, or a file that cannot be written.
    """
    path = Path(path)
    V, F = check_mesh(V, F)
    try:
        module, packed = _format(path)
        data = module.encode(V, F, binary)
        replace_file(path, gzip.compress(data, 6, mtime=0) if packed else data)
    except MeshFileError as error:
        raise MeshFileError(f"{path}: {error}") from None


def _format(path: Path) -> tuple[ModuleType, bool]:
    """The module for a file's ending, and whether it is compressed."""
    name = path.name.lower()
    ending = Path(name.removesuffix(".gz")).suffix
    if ending not in FORMATS:
        known = f"{', '.join(FORMATS)}, or one of them and .gz, was expected"
        raise file_error(
            "name", f"the ending {ending!r}", known, "name it by what it is, or convert it"
        )
    return FORMATS[ending], name.endswith(".gz")


def _welded(path: Path, V: Floats, F: Integers, weld: bool) -> tuple[Floats, Integers]:
    """The triangles of an STL with or without shared vertices; what was done is reported."""
    if not weld:
        warnings.warn(
            f"{path}: an STL file shares no vertices, so each of the {len(F)} triangles has three "
            f"of its own; read it with weld_stl=True to merge those with equal coordinates",
            MeshWarning,
            stacklevel=3,
        )
        return V, F
    label = np.zeros(len(V), np.int64)
    for coordinate in V.T:  # vertices keep one label as long as their coordinates are equal
        _, rank = np.unique(coordinate, return_inverse=True)
        _, first, label = np.unique(label * len(V) + rank, return_index=True, return_inverse=True)
    order = np.argsort(first)  # merged vertices stay in the file's order
    new = np.argsort(order)
    log.info("%s: merged %d vertices into %d", path, len(V), len(first))
    return V[first[order]], new[label][F]
