"""Meshes that outgrow the picture, or become too thin to be seen: drawn so that they are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from meshfair.checks import Floats, Integers
from meshfair.mesh import area, vertex_normals
from meshfair.viewer import Camera, View
from meshfair.viewer.camera import FIELD_OF_VIEW

THIN = 0.05  # part of the ground truth's area below which nothing may be seen of a mesh
HAIR = 0.006  # what is added to it on each side, as a part of the ground truth's size: a pixel


class Frame:
    """What a view shows when nobody has turned it: some meshes, and others no larger.

    A flow past its stable step grows without bound. If the camera went after it, the
    meshes beside it would be dots; if not, it would stand within the mesh. And a flow that
    goes on for long makes a tube so thin that no pixel shows it.

    Parameters
    ----------
    view : View
    meshes : sequence of ndarray, shape (n, 3)
        What fills the picture; the first is the ground truth.
    F : ndarray of int64, shape (m, 3)
        The faces of all of them.
    """

    def __init__(self, view: View, meshes: Sequence[Floats], F: Integers) -> None:
        self._view, self._used = view, np.unique(F)
        self.V = np.concatenate([V[self._used] for V in meshes])
        self._F, self._area = F, area(meshes[0], F)
        self._home: tuple[float, Camera] | None = None  # for a shape of the picture
        self._hair = HAIR * np.ptp(meshes[0], axis=0).max() * vertex_normals(meshes[0], F)

    def drawn(self, V: Floats) -> tuple[Floats, str]:
        """A mesh as it is to be drawn, and what the title says of that.

        Parameters
        ----------
        V : ndarray of float64, shape (n, 3)

        Returns
        -------
        V : ndarray of float64, shape (n, 3)
            As it is where it fits into the picture and can be seen there; else reduced to
            fit just into it, or with a hair's thickness.
        remark : str
            Such as ", drawn 1 : 12"; empty where the mesh is as it is.
        """
        if area(V, self._F) < THIN * self._area:
            return V + self._hair, ", drawn thicker"
        if self._home is None or self._home[0] != self._view.aspect:
            self._home = self._view.aspect, self._camera(self.V)
        home = self._home[1]
        if _sees(home, V[self._used], self._view.aspect):
            return V, ""
        needed = self._camera(V[self._used])
        size = _distance(needed) / _distance(home)
        # Seen from the same point a mesh looks the same in every size.
        near = home.position + (V - needed.position) / max(size, 1.0)
        return near, f", drawn 1 : {_three_digits(size)}" if size > 1.005 else ", drawn moved"

    def _camera(self, V: Floats) -> Camera:
        view = self._view
        return Camera.around(V, view.direction, view.up, aspect=view.aspect)


def _sees(camera: Camera, V: Floats, aspect: float) -> bool:
    """Whether all of a mesh is in a picture of this shape, width over height."""
    across, up, towards = ((V - camera.position) @ camera.axes.T).T
    half = np.tan(np.radians(FIELD_OF_VIEW) / 2) * -towards
    return bool((np.abs(across) <= aspect * half).all() and (np.abs(up) <= half).all())


def _distance(camera: Camera) -> float:
    return float(np.linalg.norm(np.subtract(camera.position, camera.target)))


def _three_digits(size: float) -> str:
    return f"{float(f'{size:.3g}'):,.12g}" if size < 1e6 else f"{size:.1e}"
