"""Where a picture is taken from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import (
    Floats,
    check_direction,
    check_number,
    check_point,
    check_vertices,
)

FIELD_OF_VIEW = 25.0  # degrees, vertical: long enough a lens to keep proportions
AXES = np.array([[0.0, 0, 1], [0, 1, 0], [1, 0, 0]])  # what is up, where nothing else says
POLE = np.radians(3)  # how close an orbit comes to looking straight down, where up has no meaning

Point = tuple[float, float, float]


def _unit(x: ArrayLike) -> Floats:
    x = np.asarray(x, dtype=np.float64)
    return x / np.linalg.norm(x)


def _parallel(a: Floats, b: Floats) -> bool:
    """Whether two unit vectors have no direction across both, but for rounding."""
    return bool(np.linalg.norm(np.cross(a, b)) < 1e-9)


def _point(x: Floats) -> Point:
    a, b, c = x.tolist()
    return a, b, c


@dataclass(frozen=True)
class Camera:
    """Where a picture is taken from, in the units of the mesh.

    Parameters
    ----------
    position, target : three floats
        Where it stands, and what it looks at.
    up : three floats
        What is up in the picture.

    Raises
    ------
    ValueError
        No such points, one place for both, or an ``up`` along which the camera looks.
    """

    position: Point
    target: Point
    up: Point

    def __post_init__(self) -> None:
        for name in ("position", "target", "up"):
            object.__setattr__(self, name, check_point(getattr(self, name), name))
        back = check_direction(np.subtract(self.position, self.target), "position - target")
        if _parallel(check_direction(self.up, "up"), back):
            raise ValueError(f"up is {self.up}, along which the camera looks; turn it")

    @classmethod
    def around(
        cls,
        V: ArrayLike,
        direction: ArrayLike,
        up: ArrayLike = (0, 0, 1),
        *,
        aspect: float = 4 / 3,
        margin: float = 0.03,
    ) -> Camera:
        """The nearest camera that sees all of a mesh from a direction.

        Parameters
        ----------
        V : array_like, shape (n, 3)
        direction : three floats
            From the mesh towards the camera.
        up : three floats
            What is up in the picture. Where it is parallel to ``direction``, which has no
            meaning, that one of the axes z, y and x stands up that is most across.
        aspect : float
            Width over height of the picture.
        margin : float
            Free border on each side, as a share of the picture's half width, 0 to 0.9.

        Returns
        -------
        Camera

        Raises
        ------
        MeshError, ValueError
            No vertices; directions that are none; ``aspect`` or ``margin`` out of
            their bounds.
        """
        V = check_vertices(V)
        back, upright = check_direction(direction, "direction"), check_direction(up, "up")
        if _parallel(upright, back):
            upright = min(AXES, key=lambda axis: round(abs(float(back @ axis)), 6))
        right = np.cross(upright, back)
        aspect = check_number(aspect, "aspect", 0, open_low=True)
        margin = check_number(margin, "margin", 0, 0.9)
        right = _unit(right)
        axes = np.stack([right, np.cross(back, right), back])
        # Around their middle, lest far from the origin their digits be lost.
        middle = V.min(axis=0) / 2 + V.max(axis=0) / 2
        X = (V - middle) @ axes.T
        tan = np.tan(np.radians(FIELD_OF_VIEW) / 2) * (1 - margin) * np.array([aspect, 1.0])
        # A vertex is in the picture while |x - target| <= (distance - depth) tan, on
        # both sides of each axis; the tightest pair of sides sets target and distance.
        high = (X[:, :2] + tan * X[:, 2:]).max(axis=0)
        low = (X[:, :2] - tan * X[:, 2:]).min(axis=0)
        distance = ((high - low) / (2 * tan)).max()
        x, y = (high + low) / 2
        depth = (X[:, 2].max() + X[:, 2].min()) / 2
        if distance <= depth:  # one point, seen from nearby for want of a size
            distance = depth + max(1.0, 1e-6 * float(np.abs(V).max()))
        position, target = middle + np.array([[x, y, distance], [x, y, depth]]) @ axes
        return cls(_point(position), _point(target), _point(axes[1]))

    @property
    def axes(self) -> Floats:
        """To the right, upwards and backwards, as unit vectors; shape (3, 3)."""
        back = _unit(np.subtract(self.position, self.target))
        right = _unit(np.cross(self.up, back))
        return np.stack([right, np.cross(back, right), back])

    def orbit(self, yaw: float, pitch: float, axis: ArrayLike) -> Camera:
        """Walk around the target, as on a turntable.

        Parameters
        ----------
        yaw : float
            Angle around ``axis``, in radians; positive moves the camera to its right.
        pitch : float
            Angle upwards, in radians; ends just before the axis itself.
        axis : three floats
            What stays upright.

        Returns
        -------
        Camera

        Raises
        ------
        ValueError
            Angles that are no finite numbers, or no axis.
        """
        yaw = check_number(yaw, "yaw", -np.inf)
        pitch = check_number(pitch, "pitch", -np.inf)
        axis = check_direction(axis, "axis")
        offset = np.subtract(self.position, self.target)
        distance = np.linalg.norm(offset)
        back = offset / distance
        polar = np.clip(np.arccos(np.clip(back @ axis, -1, 1)) - pitch, POLE, np.pi - POLE)
        # Straight above or below, the picture's own right is as good as any.
        right = self.axes[0] if _parallel(axis, back) else _unit(np.cross(axis, back))
        front = _unit(np.cross(right, axis))
        front = np.cos(yaw) * front + np.sin(yaw) * right
        back = np.cos(polar) * axis + np.sin(polar) * front
        up = _unit(axis - (axis @ back) * back)
        return Camera(_point(self.target + distance * back), self.target, _point(up))

    def pan(self, x: float, y: float) -> Camera:
        """Slide sideways and upwards, by shares of the picture's height.

        Parameters
        ----------
        x, y : float
            To the right and upwards.

        Returns
        -------
        Camera

        Raises
        ------
        ValueError
            Shares that are no finite numbers.
        """
        x, y = check_number(x, "x", -np.inf), check_number(y, "y", -np.inf)
        right, up, _ = self.axes
        distance = np.linalg.norm(np.subtract(self.position, self.target))
        height = 2 * distance * np.tan(np.radians(FIELD_OF_VIEW) / 2)
        step = height * (x * right + y * up)
        return Camera(_point(self.position + step), _point(self.target + step), self.up)

    def zoom(self, factor: float) -> Camera:
        """Move to ``factor`` times the distance from the target.

        Parameters
        ----------
        factor : float
            Above 0; below 1 moves closer.

        Returns
        -------
        Camera

        Raises
        ------
        ValueError
            A factor that is no finite number above 0.
        """
        factor = check_number(factor, "factor", 0, open_low=True)
        offset = np.subtract(self.position, self.target)
        return Camera(_point(self.target + factor * offset), self.target, self.up)

    def follow(self, before: Camera, after: Camera) -> Camera:
        """See as much of what another camera sees now as this one saw of what it saw before.

        Parameters
        ----------
        before, after : Camera
            The other camera: where this one stands to it, and at what scale, stays.

        Returns
        -------
        Camera
        """
        size = np.linalg.norm(np.subtract(after.position, after.target)) / np.linalg.norm(
            np.subtract(before.position, before.target)
        )
        position, target = (
            after.target + size * np.subtract(point, before.target)
            for point in (self.position, self.target)
        )
        return Camera(_point(position), _point(target), self.up)


def check_camera(camera: Any) -> Camera:
    """What is given, where it is a camera.

    Raises
    ------
    ValueError
        It is none.
    """
    if not isinstance(camera, Camera):
        raise ValueError(f"camera is {camera!r}; give a meshfair.viewer.Camera")
    return camera
