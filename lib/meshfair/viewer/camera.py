"""Where a picture is taken from."""

from dataclasses import dataclass

import numpy as np

from meshfair.checks import check_vertices

FIELD_OF_VIEW = 25.0  # degrees, vertical: long enough a lens to keep proportions
POLE = np.radians(3)  # how close an orbit comes to looking straight down, where up has no meaning


def _unit(x):
    return np.asarray(x, float) / np.linalg.norm(x)


@dataclass(frozen=True)
class Camera:
    """Where a picture is taken from, in the units of the mesh."""

    position: tuple
    target: tuple
    up: tuple

    @classmethod
    def around(cls, V, direction, up=(0, 0, 1), *, aspect=4 / 3, margin=0.03):
        """The nearest camera that sees all of a mesh from a direction.

        Parameters
        ----------
        V : array_like, shape (n, 3)
        direction : three floats
            From the mesh towards the camera.
        up : three floats
            What is up in the picture, not parallel to ``direction``.
        aspect : float
            Width over height of the picture.
        margin : float
            Free border on each side, as a share of the picture's half width.

        Returns
        -------
        Camera
        """
        V = check_vertices(V)
        back = _unit(direction)
        right = _unit(np.cross(up, back))
        frame = np.stack([right, np.cross(back, right), back])
        X = V @ frame.T
        tan = np.tan(np.radians(FIELD_OF_VIEW) / 2) * (1 - margin) * np.array([aspect, 1.0])
        # A vertex is in the picture while |x - target| <= (distance - depth) tan, on
        # both sides of each axis; the tightest pair of sides sets target and distance.
        high = (X[:, :2] + tan * X[:, 2:]).max(axis=0)
        low = (X[:, :2] - tan * X[:, 2:]).min(axis=0)
        distance = ((high - low) / (2 * tan)).max()
        x, y = (high + low) / 2
        depth = (X[:, 2].max() + X[:, 2].min()) / 2
        position, target = np.array([[x, y, distance], [x, y, depth]]) @ frame
        return cls(tuple(position), tuple(target), tuple(frame[1]))

    def orbit(self, yaw, pitch, axis):
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
        """
        axis = _unit(axis)
        offset = np.subtract(self.position, self.target)
        distance = np.linalg.norm(offset)
        back = offset / distance
        polar = np.clip(np.arccos(back @ axis) - pitch, POLE, np.pi - POLE)
        right = _unit(np.cross(axis, back))
        front = np.cross(right, axis)
        front = np.cos(yaw) * front + np.sin(yaw) * right
        back = np.cos(polar) * axis + np.sin(polar) * front
        up = _unit(axis - (axis @ back) * back)
        return Camera(tuple(self.target + distance * back), self.target, tuple(up))

    def pan(self, x, y):
        """Slide sideways and upwards, by shares of the picture's height.

        Returns
        -------
        Camera
        """
        offset = np.subtract(self.position, self.target)
        height = 2 * np.linalg.norm(offset) * np.tan(np.radians(FIELD_OF_VIEW) / 2)
        step = height * (x * _unit(np.cross(self.up, offset)) + y * np.asarray(self.up))
        return Camera(tuple(self.position + step), tuple(self.target + step), self.up)

    def zoom(self, factor):
        """Move to ``factor`` times the distance from the target.

        Returns
        -------
        Camera
        """
        offset = np.subtract(self.position, self.target)
        return Camera(tuple(self.target + factor * offset), self.target, self.up)
