"""Where meshes lie and how large they are: taken off before they are drawn.

What draws computes in single precision, in which a mesh of 1 m in a country's grid, 5,000 km from
its origin, has but a few places. Around their own centre and of size 1 meshes look the same
wherever they lie and in whatever unit: up to 1e8 times their own size away from the
origin (beyond that the double precision of their positions shows), and for sizes from 1e-100
to 1e75.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from meshfair.checks import Floats
from meshfair.viewer.camera import Camera
from meshfair.viewer.panel import Panel


@dataclass(frozen=True, eq=False)
class Placement:
    """A centre and a size, taken off meshes and cameras alike. Compared by identity."""

    centre: Floats
    size: float

    @classmethod
    def of(cls, panels: Sequence[Panel]) -> Placement:
        """The centre and the longest side of the box around some panels' meshes."""
        low = np.min([panel.box[0] for panel in panels], axis=0)
        high = np.max([panel.box[1] for panel in panels], axis=0)
        return cls((low + high) / 2, float((high - low).max()) or 1.0)

    def holds(self, panels: Sequence[Panel]) -> bool:
        """Whether it still does for these panels' meshes, so that none needs to be placed anew."""
        now = Placement.of(panels)
        near = np.abs(now.centre - self.centre).max() <= 4 * self.size
        return bool(near and self.size / 4 <= now.size <= 4 * self.size)

    def panel(self, panel: Panel) -> Panel:
        """A panel of which the mesh has been placed; what no face uses lies in the centre."""
        X = panel.V - self.centre
        X /= self.size
        if not panel.used.all():
            X[~panel.used] = 0
        return Panel(X, panel.F, panel.values, panel.smooth, panel.edges, panel.none)

    def camera(self, camera: Camera) -> Camera:
        """The camera that sees placed meshes as this one sees them where they are."""
        position, target = (
            tuple(((point - self.centre) / self.size).tolist())
            for point in (camera.position, camera.target)
        )
        return Camera(position, target, camera.up)
