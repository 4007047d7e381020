"""Writing of a file in any format, anew or like another."""

import gzip
import warnings
from os import PathLike
from pathlib import Path
from types import ModuleType

from numpy.typing import ArrayLike

from meshfair.checks import Floats, Integers, MeshWarning, check_mesh, warn
from meshfair.io.attributes import Attributes
from meshfair.io.carrying import carried
from meshfair.io.companions import left_behind
from meshfair.io.errors import MeshFileError
from meshfair.io.formats import FORMATS, File, format_of, name_of
from meshfair.io.precision import loss
from meshfair.io.reading import read
from meshfair.io.rewriting import rewritten
from meshfair.io.saving import replace_file
from meshfair.mesh.objects import takes_meshes


@takes_meshes
def write(
    path: File,
    V: ArrayLike,
    F: ArrayLike,
    *,
    binary: bool | None = None,
    like: Attributes | str | PathLike[str] | None = None,
    format: str | None = None,
) -> None:
    """Write a triangle mesh; after any failure the old file or the new one is whole.

    Coordinates come back from `read` bit by bit, except where a file holds them in
    float32: a binary STL, glTF and Collada do, and others may that are written like
    a file that does. Where this harms the mesh, a `MeshWarning` says so.

    Parameters
    ----------
    path : str, os.PathLike or binary stream
        The ending tells the format, as for `read`. A file of this name is
        replaced when the new one is complete. An open file needs `format`.
    V : array_like, shape (n, 3)
        Vertex positions, in any unit of length.
    F : array_like of integers, shape (m, 3)
        Vertex indices of the triangles, from 0. A mesh object of another library may
        stand for V and F, see `meshfair.mesh.arrays`; these alone are written of it.
    binary : bool, optional
        Write PLY (little endian, float64) and STL in binary, not as text; by
        default as the file that it is written like, else in binary.
    like : Attributes, str or os.PathLike, optional
        The file that the mesh was read from, or what `read` returned for it with
        ``attributes=True``. In OBJ, OFF, PLY, STL and VTK everything but the
        positions stays as it is there, byte for byte, and normals are computed
        anew; in the other formats it is written anew. In another format than the
        file's, or for other faces, what can be is kept, and a `MeshWarning` says
        what is not; another one names files that a file refers to (an OBJ's
        materials, a PLY's picture) and that are not in the folder it is written to.
    format : str, optional
        The format, such as ``"ply"`` or ``"obj.gz"``, whatever the ending is.

    Raises
    ------
    MeshError
        Arrays that are no mesh; see `meshfair.checks.check_mesh`.
    MeshFileError
        An unknown ending, or a file that cannot be written.
    NotInstalledError
        A format whose library is missing; the message says what to install.
    """
    name = name_of(path)
    V, F = check_mesh(V, F)
    if like is not None and not isinstance(like, Attributes):
        like = _attributes(like, len(V))
    try:
        wanted = format_of(path, format)
        data, told = _encoded(V, F, wanted.ending, binary, like)
        if like and isinstance(path, (str, PathLike)):
            told += _sentences(left_behind(data, like, Path(path)))
        if wanted.packed:
            data = gzip.compress(data, 6, mtime=0)
        if isinstance(path, (str, PathLike)):
            replace_file(Path(path), data)
        else:
            path.write(data)
    except MeshFileError as error:
        raise MeshFileError(f"{name}: {error}") from None
    for message in told:
        warn(f"{name}: {message}")


def _encoded(
    V: Floats, F: Integers, ending: str, binary: bool | None, like: Attributes | None
) -> tuple[bytes, list[str]]:
    """The bytes of a file, and what is to be told about them."""
    module, more, told = FORMATS[ending], None, []
    if like and like.format == ending:
        was_binary = module.is_binary(like.data)
        if like.fits(V, F) and (binary is None or was_binary in (None, binary)):
            if isinstance(module, ModuleType):
                data, stored = rewritten(like, module.layout(like.data), V)
            else:
                data, stored = module.rewritten(like, V)
            return data, _sentences(loss(V, F, stored))
        binary = was_binary if binary is None else binary
    if like:
        more, message = carried(like, V, F, ending)
        told += _sentences(message)
    data, stored = module.encode(V, F, binary is not False, more)
    return data, told + _sentences(loss(V, F, stored))


def _sentences(message: str) -> list[str]:
    return [message] if message else []


def _attributes(path: str | PathLike[str], n: int) -> Attributes:
    """Those of a file whose mesh has n vertices, in an STL welded or not."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        attributes = read(path, attributes=True)[2]
        if attributes.vertex is not None and len(attributes.V) != n:
            return read(path, attributes=True, weld=False)[2]
    return attributes
