"""What goes along with a mesh from one format to another."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from meshfair.checks import Floats, Integers
from meshfair.io.welding import same_rows

Colors = NDArray[np.uint8]


@dataclass(frozen=True)
class Extras:
    """What more a file holds that other formats know too.

    Attributes
    ----------
    corners, counts
        The polygons, as in `meshfair.io.faces.check_corners`.
    colors : ndarray of uint8, shape (n, 3) or (n, 4), or None
        Red, green and blue of each vertex, and its opacity.
    face_colors : ndarray of uint8, shape (m, 3) or (m, 4), or None
        The same of each face.
    normals : bool
        Whether vertices have normals.
    texture : ndarray of float64, shape (t, 2), or None
        Texture coordinates.
    texture_of : ndarray of int64, or None
        Which of these each corner has, or -1; ``corners`` where each vertex has one.
    image : str or None
        The name of the texture's file.
    others : tuple of str
        What else there is, which goes nowhere.
    """

    corners: Integers
    counts: Integers
    colors: Colors | None = None
    face_colors: Colors | None = None
    normals: bool = False
    texture: Floats | None = None
    texture_of: Integers | None = None
    image: str | None = None
    others: tuple[str, ...] = field(default=())

    def kinds(self) -> list[str]:
        """What there is, in the words of messages."""
        colors = [array for array in (self.colors, self.face_colors) if array is not None]
        there = {
            "polygons": bool(np.any(self.counts > 3)),
            "colours": self.colors is not None,
            "colours of faces": self.face_colors is not None,
            "opacity": any(array.shape[1] == 4 and array[:, 3].min() < 255 for array in colors),
            "normals": self.normals,
            "texture coordinates": self.texture is not None,
            "the name of the texture's image": self.image is not None,
        }
        return [kind for kind, is_there in there.items() if is_there] + list(self.others)

    def without_faces(self, F: Integers) -> Extras:
        """What is left for other faces: all that belongs to the vertices."""
        by_vertex = self.texture_of is self.corners
        return Extras(
            F.ravel(),
            np.full(len(F), 3),
            self.colors,
            normals=self.normals,
            texture=self.texture if by_vertex else None,
            texture_of=F.ravel() if by_vertex else None,
            image=self.image if by_vertex else None,
        )


def split_at_seams(n: int, extras: Extras) -> tuple[Integers, Extras]:
    """The same mesh with one texture coordinate for each vertex.

    Vertices with several become as many; the first of them keeps its place, and the
    others come behind all vertices.

    Parameters
    ----------
    n : int
        Number of vertices.
    extras : Extras

    Returns
    -------
    rows : ndarray of int64
        Which of the old vertices each of the new ones is.
    extras : Extras
    """
    if extras.texture is None or extras.texture_of is None or extras.texture_of is extras.corners:
        return np.arange(n), extras
    pairs = np.column_stack([extras.corners, extras.texture_of]).astype(np.float64)
    first, pair = same_rows(pairs)
    vertex, coordinate = extras.corners[first], extras.texture_of[first]
    _, is_first = np.unique(vertex, return_index=True)
    number = np.full(len(first), -1)
    number[is_first] = vertex[is_first]
    more = np.flatnonzero(number < 0)
    number[more] = n + np.arange(len(more))
    rows = np.concatenate([np.arange(n), vertex[more]])
    texture = np.zeros((len(rows), 2))
    known = coordinate >= 0
    texture[number[known]] = extras.texture[coordinate[known]]
    corners = number[pair]
    colors = None if extras.colors is None else extras.colors[rows]
    return rows, replace(
        extras, corners=corners, colors=colors, texture=texture, texture_of=corners
    )


def bytes_of_fractions(values: Floats) -> Colors:
    """Colours as bytes, from fractions of 1, or from 0 to 255 where any is larger than 1."""
    values = np.nan_to_num(values, nan=0.0)
    scale = 255 if values.size == 0 or values.max() <= 1 else 1
    return np.clip(np.rint(values * scale), 0, 255).astype(np.uint8)
