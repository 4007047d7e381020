"""What a file holds beside its mesh, and where in it the mesh is."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from meshfair.checks import Floats, Integers
from meshfair.io.splicing import DOUBLE, Places


@dataclass(frozen=True, eq=False, repr=False)
class Attributes:
    """A file as it was read: give it to `write`, and what it held beside its mesh is kept.

    Attributes
    ----------
    name : str
        What messages call the file.
    format : str
        Its format, by the ending: ``".ply"``.
    data : bytes
        Its bytes, unpacked.
    V : ndarray of float64, shape (n, 3)
        The positions as `read` returned them; not to be written to.
    F : ndarray of int64, shape (m, 3)
        The triangles as `read` returned them; not to be written to.
    corner : ndarray of int64, shape (m, 3), or None
        For each corner of the triangles, which of all the corners of the file's faces it
        is; None where all of these are triangles.
    vertex : ndarray of int64, shape (k,), or None
        For each vertex of the file its row in ``V``; None where this is the same.
    """

    name: str
    format: str
    data: bytes
    V: Floats
    F: Integers
    corner: Integers | None = None
    vertex: Integers | None = None

    def __post_init__(self) -> None:
        self.V.flags.writeable = self.F.flags.writeable = False

    def of_corners(self, values: Integers) -> Integers:
        """A value of each corner of the file's faces, for the corners of the triangles.

        Parameters
        ----------
        values : ndarray, shape (c,)
            One for each corner in the file, c of them.

        Returns
        -------
        ndarray, shape (m, 3)
        """
        return values.reshape(-1, 3) if self.corner is None else values[self.corner]

    def fits(self, V: Floats, F: Integers) -> bool:
        """Whether a mesh has these faces and as many vertices.

        Parameters
        ----------
        V : ndarray of float64, shape (n, 3)
        F : ndarray of int64, shape (m, 3)

        Returns
        -------
        bool
        """
        return len(V) == len(self.V) and np.array_equal(F, self.F)

    def __repr__(self) -> str:
        return f"<attributes of {self.name}: {len(self.V)} vertices, {len(self.F)} faces>"


@dataclass(frozen=True)
class Layout:
    """Where in the bytes of a file its positions and normals are.

    Attributes
    ----------
    positions : list of Places
        The coordinates of the file's vertices; as many columns as one row of the file has.
    normals : list of Places
        Three columns, a normal in each row; or none.
    normal_of : ndarray of int64 or None
        For each corner of the file's faces the row of its normal, or -1; None
        where each vertex has one.
    by_face : bool
        Whether instead each face has one.
    types : list of Places
        Where the file announces the type of each column of positions, if it does.
    double : numpy.dtype
        Double precision in the file's byte order.
    """

    positions: Sequence[Places]
    normals: Sequence[Places] = ()
    normal_of: Integers | None = None
    by_face: bool = False
    types: Sequence[Places] = ()
    double: np.dtype[Any] = DOUBLE
