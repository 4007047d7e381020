"""GLB and glTF, 3MF and Collada: scenes of meshes, read and written by trimesh."""

import io
import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np

from meshfair.checks import Floats, Integers, needed_for
from meshfair.io.attributes import Attributes
from meshfair.io.errors import file_error, one_line
from meshfair.io.extras import Colors, Extras, split_at_seams
from meshfair.io.normals import renewed
from meshfair.mesh import vertex_normals


class Part(NamedTuple):
    """A mesh of a scene: its node there, the mesh, and the matrix that puts it in its place."""

    node: str
    mesh: Any
    matrix: Floats

    @property
    def V(self) -> Floats:
        """The positions in the scene."""
        V = np.asarray(self.mesh.vertices, np.float64)
        if np.array_equal(self.matrix, np.eye(4)):
            return V
        return V @ self.matrix[:3, :3].T + self.matrix[:3, 3]

    @property
    def F(self) -> Integers:
        """The triangles, which a mirroring turns round as it does the surface."""
        F = np.asarray(self.mesh.faces, np.int64)
        return F[:, ::-1] if np.linalg.det(self.matrix[:3, :3]) < 0 else F

    @property
    def normals(self) -> Floats | None:
        """The normals of its vertices that the file holds, in the mesh's own coordinates."""
        return self.mesh.vertex_normals if "vertex_normals" in self.mesh._cache else None


@dataclass(frozen=True)
class Scenes:
    """One of the formats; the functions are those of the module `meshfair.io.obj`."""

    ending: str
    HOLDS: frozenset[str]

    def parse(self, stream: BinaryIO) -> tuple[Floats, Integers, Integers, str]:
        """Read the meshes of a scene as one, each where the scene puts it; and what to tell."""
        scene = self._scene(stream.read(), getattr(stream, "name", ""))
        parts = self._parts(scene)
        F = _faces(parts)
        kinds = {type(thing).__name__ for thing in scene.geometry.values()} - {"Trimesh"}
        told = [f"its {len(parts)} meshes are read as one"] if len(parts) > 1 else []
        told += [f"it also shows what is no mesh: {', '.join(sorted(kinds))}"] if kinds else []
        V = np.concatenate([part.V for part in parts])
        return V, F.ravel(), np.full(len(F), 3), "; ".join(told)

    def is_binary(self, data: bytes) -> None:
        """The format decides, so this is nothing to choose."""

    def extras(self, like: Attributes) -> Extras:
        """What a file that was read holds beside positions and faces."""
        parts = self._parts(self._scene(like.data, like.name))
        visuals = [part.mesh.visual for part in parts]
        corners = _faces(parts).ravel()
        textures: list[Any] = [getattr(visual, "uv", None) for visual in visuals]
        has_texture = all(uv is not None and len(uv) for uv in textures)
        has_materials = any(getattr(visual, "material", None) is not None for visual in visuals)
        return Extras(
            corners,
            np.full(len(corners) // 3, 3),
            _all([_vertex_colors(visual) for visual in visuals]),
            _all([v.face_colors if v.kind == "face" else None for v in visuals]),
            all(part.normals is not None for part in parts),
            np.concatenate(textures) if has_texture else None,
            corners if has_texture else None,
            others=("materials",) if has_materials else (),
        )

    def encode(
        self, V: Floats, F: Integers, binary: bool, more: Extras | None
    ) -> tuple[bytes, Floats]:
        """The bytes of a file, and the positions in it."""
        with needed_for(f"a {self.ending} file"):
            from trimesh import Scene, Trimesh
            from trimesh.visual import TextureVisuals
        normals, rows = None, np.arange(len(V))
        if more is not None:
            normals = vertex_normals(V, F) if more.normals else None
            rows, more = split_at_seams(len(V), more)
            F = more.corners.reshape(-1, 3) if len(rows) > len(V) else F
        mesh: Any = Trimesh(V[rows], F, process=False, validate=False)
        if normals is not None:
            mesh.vertex_normals = normals[rows]
        if more is not None and more.texture is not None:
            mesh.visual = TextureVisuals(uv=more.texture)
            if more.colors is not None:
                opaque = np.full((len(rows), 1), 255, np.uint8)
                mesh.visual.vertex_attributes["color"] = np.hstack([more.colors, opaque])[:, :4]
        elif more is not None and more.colors is not None:
            mesh.visual.vertex_colors = more.colors
        return self._exported(Scene([mesh])), self._stored(V)

    def rewritten(self, like: Attributes, V: Floats) -> tuple[bytes, Floats]:
        """A scene once more with other positions of its meshes."""
        if np.array_equal(V, like.V):
            return like.data, V
        scene = self._scene(like.data, like.name)
        at, seen, stored = 0, set[int](), []
        for part in self._parts(scene):
            mesh, matrix, F = part.mesh, part.matrix, np.asarray(part.mesh.faces, np.int64)
            V_old, at = np.array(mesh.vertices), at + len(mesh.vertices)
            V_new = (V[at - len(V_old) : at] - matrix[:3, 3]) @ np.linalg.inv(matrix[:3, :3]).T
            normals = part.normals
            if id(mesh) in seen:  # shown more than once, and now not everywhere the same
                mesh = mesh.copy()
                name = scene.add_geometry(mesh, node_name=f"{part.node} of its own")
                scene.graph.update(part.node, geometry=scene.graph[name][1])
                scene.graph.transforms.remove_node(name)
            seen.add(id(mesh))
            mesh.vertices = V_new
            stored.append(self._stored(V_new) @ matrix[:3, :3].T + matrix[:3, 3])
            if normals is not None:
                mesh.vertex_normals = renewed(V_old, V_new, F, F, np.array(normals))[0]
        return self._exported(scene), np.concatenate(stored)

    def _scene(self, data: bytes, name: str) -> Any:
        with needed_for(f"a {self.ending} file"), _quiet():
            from trimesh import load_scene
            from trimesh.resolvers import FilePathResolver

            resolver = FilePathResolver(name) if Path(name).is_file() else None
            try:
                return load_scene(
                    io.BytesIO(data), file_type=self.ending[1:], resolver=resolver, process=False
                )
            except (ImportError, MemoryError):
                raise
            except Exception as error:  # a damaged file, wherever the library met it
                found = f"trimesh ended with {type(error).__name__} ({one_line(error)})"
                raise file_error("content", found, f"a whole {self.ending} was expected") from None

    def _parts(self, scene: Any) -> list[Part]:
        """The meshes of a scene, in an order that is the same when it is read again."""
        nodes = scene.graph.nodes_geometry
        if self.ending != ".dae":  # where names are made up, and the order is kept
            nodes = sorted(nodes)
        parts = []
        for node in nodes:
            matrix, name = scene.graph[node]
            thing = scene.geometry[name]
            if type(thing).__name__ == "Trimesh" and len(thing.faces):
                parts.append(Part(node, thing, np.asarray(matrix, np.float64)))
        if not parts:
            raise file_error("faces", "there are none", "a mesh was expected", "export a mesh")
        return parts

    def _exported(self, scene: Any) -> bytes:
        with needed_for(f"a {self.ending} file"), _quiet():
            from trimesh.exchange.dae import export_collada
            from trimesh.exchange.gltf import export_glb, export_gltf
            from trimesh.exchange.threemf import export_3MF

            has_normals = all(part.normals is not None for part in self._parts(scene))
            if self.ending == ".dae":
                data = export_collada(scene.dump())
            elif self.ending == ".3mf":
                data = export_3MF(scene)
            elif self.ending == ".glb":
                data = export_glb(scene, include_normals=has_normals)
            else:
                files = export_gltf(scene, include_normals=has_normals, embed_buffers=True)
                data = files["model.gltf"]
        return bytes(data)

    def _stored(self, V: Floats) -> Floats:
        return V if self.ending == ".3mf" else V.astype(np.float32).astype(np.float64)


@contextmanager
def _quiet() -> Iterator[None]:
    """What the library logs and warns of while it guesses is not for the user."""
    logger = logging.getLogger("trimesh")
    disabled, logger.disabled = logger.disabled, True
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            yield
    finally:
        logger.disabled = disabled


def _faces(parts: list[Part]) -> Integers:
    """The triangles of all meshes, numbered as the vertices of all."""
    sizes = [len(part.mesh.vertices) for part in parts]
    before = np.cumsum(sizes) - sizes
    return np.concatenate([part.F + k for part, k in zip(parts, before, strict=True)])


def _vertex_colors(visual: Any) -> Colors | None:
    colors = visual.vertex_colors if visual.kind == "vertex" else None
    return getattr(visual, "vertex_attributes", {}).get("color", colors)


def _all(arrays: list[Colors | None]) -> Colors | None:
    """The arrays as one, if all are there."""
    there = [np.asarray(array, np.uint8) for array in arrays if array is not None]
    return np.concatenate(there) if len(there) == len(arrays) else None
