"""Read and write triangle meshes: OBJ, OFF, PLY and STL, each also compressed with gzip.

With the extra ``formats`` also glTF (.glb, .gltf), 3MF, Collada (.dae), and VTK (.vtk, .vtu).

The vertices of a file come back in its order, and its faces too; what is no
mesh is refused with one sentence. Everything else that a sound file holds, such as
colours, texture coordinates and materials, is returned on request as one object
(`Attributes`) and kept by `write` with it.
"""

from meshfair.io.attributes import Attributes
from meshfair.io.errors import MeshFileError
from meshfair.io.formats import FORMATS
from meshfair.io.reading import read
from meshfair.io.writing import write

__all__ = ["FORMATS", "Attributes", "MeshFileError", "read", "write"]
