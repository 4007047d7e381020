"""Balls, bars and arrows as parts of a mesh, so that they are drawn with it everywhere."""

from __future__ import annotations

import numpy as np

from meshfair.checks import Floats, Integers
from meshfair.shapes import icosphere

SIDES = 10  # of a bar


class Solids:
    """A mesh to which solids are added, each with one value and one vertex that it stands for.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    """

    def __init__(self, V: Floats, F: Integers) -> None:
        self._V, self._F = [V], [F]
        self._values: list[Floats] = [np.zeros(len(F))]
        self._owner: list[Integers] = [np.arange(len(V))]
        self._count = len(V)

    def _add(self, V: Floats, F: Integers, value: float, owner: int) -> None:
        self._V.append(V)
        self._F.append(F + self._count)
        self._values.append(np.full(len(F), value))
        self._owner.append(np.full(len(V), owner))
        self._count += len(V)

    def ball(self, centre: Floats, radius: float, value: float, owner: int) -> None:
        """Add a ball."""
        V, F = icosphere(2)
        self._add(centre + radius * V / np.linalg.norm(V, axis=1, keepdims=True), F, value, owner)

    def cone(
        self, a: Floats, b: Floats, radii: tuple[float, float], value: float, owner: int
    ) -> None:
        """Add a round bar from a to b with a radius at each; none where they coincide."""
        along = b - a
        length = np.linalg.norm(along)
        if length == 0:
            return
        along = along / length
        across = np.eye(3)[np.abs(along).argmin()]
        u = np.cross(along, across)
        u /= np.linalg.norm(u)
        angle = 2 * np.pi * np.arange(SIDES) / SIDES
        ring = np.outer(np.cos(angle), u) + np.outer(np.sin(angle), np.cross(along, u))
        V = np.concatenate([a + radii[0] * ring, b + radii[1] * ring, [a, b]])
        i = np.arange(SIDES)
        j = (i + 1) % SIDES
        below, above = np.full(SIDES, 2 * SIDES), np.full(SIDES, 2 * SIDES + 1)
        F = np.concatenate(
            [
                np.stack([i, j, j + SIDES], axis=1),
                np.stack([i, j + SIDES, i + SIDES], axis=1),
                np.stack([below, j, i], axis=1),
                np.stack([above, i + SIDES, j + SIDES], axis=1),
            ]
        )
        self._add(V, F, value, owner)

    def bar(self, a: Floats, b: Floats, radius: float, value: float, owner: int) -> None:
        """Add a round bar from a to b."""
        self.cone(a, b, (radius, radius), value, owner)

    def arrow(self, a: Floats, b: Floats, radius: float, value: float, owner: int) -> None:
        """Add an arrow from a to b; short ones are all head."""
        length = float(np.linalg.norm(b - a))
        if length == 0:
            return
        neck = b - (b - a) * min(1.0, 5 * radius / length)
        self.bar(a, neck, radius, value, owner)
        self.cone(neck, b, (2.2 * radius, 0.0), value, owner)

    def mesh(self) -> tuple[Floats, Integers, Floats, Integers]:
        """All of it.

        Returns
        -------
        V : ndarray of float64, shape (n', 3)
        F : ndarray of int64, shape (m', 3)
        values : ndarray of float64, shape (m',)
            Of the faces; 0 on the mesh itself.
        owner : ndarray of int64, shape (n',)
            Which vertex of the mesh each vertex stands for.
        """
        return (
            np.concatenate(self._V),
            np.concatenate(self._F),
            np.concatenate(self._values),
            np.concatenate(self._owner),
        )
