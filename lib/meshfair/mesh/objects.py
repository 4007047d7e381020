"""Meshes of other libraries: taken in the place of V and F, and given back in their own kind.

They are known by their attributes, so that none of these libraries is imported: trimesh's Trimesh,
pyvista's PolyData, open3d's TriangleMesh (of both its interfaces), meshio's Mesh, and
whatever looks like one of them.
"""

from collections.abc import Callable, Iterator
from copy import deepcopy
from functools import wraps
from inspect import signature
from typing import Any, NamedTuple, ParamSpec, TypeVar

import numpy as np

from meshfair.checks import Floats, Integers, MeshError, check_mesh
from meshfair.mesh.geometry import vertex_normals

P = ParamSpec("P")
R = TypeVar("R")


class Kind(NamedTuple):
    """How a library keeps a mesh."""

    attributes: tuple[str, str]
    """By which such a mesh is known: what holds positions, and what holds faces."""
    positions: Callable[[Any], Any]
    faces: Callable[[Any], Any]
    move: Callable[[Any, Floats], Any]
    """Gives a mesh new positions."""


def _padded_triangles(mesh: Any) -> Any:
    """VTK's list of faces: the number of corners before each."""
    faces = np.asarray(mesh.faces)
    if faces.ndim == 1 and len(faces) % 4 == 0 and np.all(faces[::4] == 3):
        return faces.reshape(-1, 4)[:, 1:]
    raise MeshError("the mesh has faces that are no triangles; take mesh.triangulate()")


def _triangle_cells(mesh: Any) -> Any:
    """The cells of one type, by its name or by its number in VTK."""
    surface = {name: cells for name, cells in mesh.cells_dict.items() if name not in _NO_SURFACE}
    triangles = [cells for name, cells in surface.items() if name in ("triangle", 5)]
    if len(surface) != len(triangles):
        others = ", ".join(str(name) for name in surface if name not in ("triangle", 5))
        raise MeshError(f"the mesh has cells that are no triangles ({others}); triangulate it")
    return triangles[0] if triangles else []


_NO_SURFACE = ("vertex", "line", 1, 2, 3, 4)  # points and lines, which no filter moves


def _move_vertices(mesh: Any, V: Floats) -> None:
    mesh.vertices = V if isinstance(mesh.vertices, np.ndarray) else type(mesh.vertices)(V)
    for part in ("triangle", "vertex"):  # open3d keeps normals until it is told
        if getattr(mesh, f"has_{part}_normals", bool)():
            getattr(mesh, f"compute_{part}_normals")()


def _move_points(mesh: Any, V: Floats) -> None:
    mesh.points = V
    data = getattr(mesh, "point_data", {})
    for name in [name for name in data if name.lower() == "normals"]:
        data[name] = vertex_normals(*arrays(mesh)).astype(np.asarray(data[name]).dtype)


def _move_tensors(mesh: Any, V: Floats) -> None:
    old = mesh.vertex.positions
    mesh.vertex.positions = type(old)(V.astype(old.numpy().dtype))
    for part in ("triangle", "vertex"):
        if "normals" in getattr(mesh, part):
            getattr(mesh, f"compute_{part}_normals")()


KINDS = (
    Kind(("vertices", "faces"), lambda m: m.vertices, lambda m: m.faces, _move_vertices),
    Kind(("vertices", "triangles"), lambda m: m.vertices, lambda m: m.triangles, _move_vertices),
    Kind(
        ("vertex", "triangle"),
        lambda m: m.vertex.positions.numpy(),
        lambda m: m.triangle.indices.numpy(),
        _move_tensors,
    ),
    Kind(("points", "faces"), lambda m: m.points, _padded_triangles, _move_points),
    Kind(("points", "cells_dict"), lambda m: m.points, _triangle_cells, _move_points),
)


def _kind(mesh: Any) -> Kind | None:
    if isinstance(mesh, (np.ndarray, list, tuple)):
        return None
    return next((k for k in KINDS if all(hasattr(mesh, name) for name in k.attributes)), None)


def is_object(mesh: Any) -> bool:
    """Whether this is a mesh of another library, and no array.

    Parameters
    ----------
    mesh : object

    Returns
    -------
    bool
    """
    return _kind(mesh) is not None


def arrays(mesh: Any) -> tuple[Floats, Integers]:
    """The arrays V and F of another library's mesh.

    Parameters
    ----------
    mesh : object
        A mesh of trimesh, pyvista, open3d or meshio, or what has their attributes.

    Returns
    -------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)

    Raises
    ------
    MeshError
        No such object; faces that are no triangles; no mesh.
    """
    kind = _kind(mesh)
    if kind is None:
        known = " or ".join(
            f"{positions} and {faces}"
            for positions, faces in dict.fromkeys(k.attributes for k in KINDS)
        )
        raise MeshError(f"{type(mesh).__name__} is no mesh that is known; it needs {known}")
    return check_mesh(np.asarray(kind.positions(mesh)), np.asarray(kind.faces(mesh)))


def moved(mesh: Any, V: Floats) -> Any:
    """A copy of another library's mesh with new positions, and its normals computed anew.

    Parameters
    ----------
    mesh : object
        As in `arrays`; it stays as it is.
    V : ndarray of float64, shape (n, 3)

    Returns
    -------
    object
        Of the same kind, with all else that the mesh holds.

    Raises
    ------
    MeshError
        No such object, or positions of another number of vertices.
    """
    kind = _kind(mesh)
    if kind is None or len(V) != len(arrays(mesh)[0]):
        raise MeshError(f"{type(mesh).__name__} is no mesh of {len(V)} vertices")
    copy = next((getattr(mesh, name) for name in ("copy", "clone") if hasattr(mesh, name)), None)
    other = copy() if copy else deepcopy(mesh)
    kind.move(other, V)
    return other


def takes_meshes(function: Callable[P, R]) -> Callable[P, R]:
    """Decorate a function of V and F, which then also takes a mesh object in their place.

    Parameters
    ----------
    function : function
        Its arguments V, V_true, ... may be such objects; where an argument F, F_true, ...
        comes right after one, the object stands for both.

    Returns
    -------
    function
    """
    names = list(signature(function).parameters)

    @wraps(function)
    def unpacked(*args: P.args, **kwargs: P.kwargs) -> R:
        if any(_kind(value) for value in args):
            args = tuple(_unpacked(args, names))  # type: ignore[assignment]
        return function(*args, **kwargs)

    return unpacked


def _unpacked(args: tuple[Any, ...], names: list[str]) -> Iterator[Any]:
    """The arguments with the arrays of each mesh in its place."""
    position = 0
    for value in args:
        if _kind(value) is None:
            yield value
            position += 1
            continue
        V, F = arrays(value)
        yield V
        position += 1
        if position < len(names) and names[position].startswith("F"):
            yield F
            position += 1
