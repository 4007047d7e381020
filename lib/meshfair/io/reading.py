"""Reading of a file in any format."""

import io
import logging
from os import PathLike
from pathlib import Path
from typing import BinaryIO, Literal, overload

import numpy as np

from meshfair.checks import Floats, Integers, check_vertices, warn
from meshfair.io import stl
from meshfair.io.attributes import Attributes
from meshfair.io.errors import MeshFileError, file_error
from meshfair.io.faces import check_corners
from meshfair.io.formats import File, format_of, name_of
from meshfair.io.opening import decompressed, open_regular
from meshfair.io.polygons import cut
from meshfair.io.welding import same_rows

log = logging.getLogger("meshfair.io")


@overload
def read(
    path: File, *, weld: bool = ..., attributes: Literal[False] = ..., format: str | None = ...
) -> tuple[Floats, Integers]: ...


@overload
def read(
    path: File, *, weld: bool = ..., attributes: Literal[True], format: str | None = ...
) -> tuple[Floats, Integers, Attributes]: ...


def read(
    path: File, *, weld: bool = True, attributes: bool = False, format: str | None = None
) -> tuple[Floats, Integers] | tuple[Floats, Integers, Attributes]:
    """Read a triangle mesh.

    Parameters
    ----------
    path : str, os.PathLike or binary stream
        A regular file ending in .obj, .off, .ply or .stl; with the extra
        ``formats`` also in .glb, .gltf, .3mf, .dae, .vtk or .vtu; or in one of
        these and .gz. Upper case is the same. Or an open file, such as
        ``sys.stdin.buffer``; this needs `format`.
    weld : bool
        Merge the vertices of an STL file that have equal coordinates. This
        format stores three vertices for each triangle and shares none, so
        without it no triangle has a neighbour.
    attributes : bool
        Return also what else the file holds, for `write`.
    format : str, optional
        The format, such as ``"ply"`` or ``"obj.gz"``, whatever the ending is.

    Returns
    -------
    V : ndarray of float64, shape (n, 3)
        Vertex positions, in the file's units and order, used by a face or not.
    F : ndarray of int64, shape (m, 3)
        Vertex indices of the triangles, from 0, in the file's order. Faces of
        more corners are cut into triangles of their area, and a `MeshWarning`
        says so, as it does where several meshes of a scene are read as one.
    attributes : Attributes
        Only where asked for.

    Raises
    ------
    MeshFileError, MeshError
        No mesh, or one that is cut or damaged: the message has the file, the
        place in it, what is there, what should be, and what to do.
    NotInstalledError
        A format whose library is missing; the message says what to install.
    """
    name = name_of(path)
    try:
        found = format_of(path, format)
        # A float32 that is NaN may warn when it is widened; it is refused below.
        with _opened(path) as file, np.errstate(invalid="ignore"):
            stream = decompressed(file) if found.packed else file
            if attributes:
                stream = _Bytes(stream.read())
                stream.name, data = name, stream.getvalue()
            V, corners, counts, *notes = found.module.parse(stream)
        V = check_vertices(V, name)
        check_corners(corners, counts, len(V))
    except MeshFileError as error:
        raise MeshFileError(f"{name}: {error}") from None
    except OSError as error:
        raise MeshFileError(f"{name}: reading failed ({error.strerror}); check the disk") from None
    corners = corners.astype(np.int64)
    triangles, told = cut(V, corners, counts)
    for note in filter(None, [*notes, told]):
        warn(f"{name}: {note}")
    F = corners.reshape(-1, 3) if triangles is None else corners[triangles]
    vertex = None
    if found.module is stl and weld:
        first, vertex = same_rows(V)
        log.info("%s: merged %d vertices into %d", name, len(V), len(first))
        V, F = V[first], vertex[F]
    if not attributes:
        return V, F
    return V, F, Attributes(name, found.ending, data, V.copy(), F.copy(), triangles, vertex)


class _Bytes(io.BytesIO):
    """The bytes of a file that may name others beside it."""

    name = ""


def _opened(file: File) -> BinaryIO:
    """A stream of bytes that can be read more than once."""
    if isinstance(file, (str, PathLike)):
        return open_regular(Path(file))
    data = file.read()
    if not isinstance(data, bytes):
        found = "the stream gives text"
        raise file_error("opening", found, "bytes were expected", "open it in binary mode, 'rb'")
    return io.BytesIO(data)
