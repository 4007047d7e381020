"""The view without EGL: k3d draws the meshes in the page itself."""

from __future__ import annotations

import html
from collections.abc import Iterable
from typing import Any

import ipywidgets
import k3d
import numpy as np
from matplotlib.colors import to_hex

from meshfair.viewer.backend import Shown
from meshfair.viewer.camera import FIELD_OF_VIEW, Camera
from meshfair.viewer.panel import SURFACE, Panel, Scale

HEIGHT = 300  # CSS pixels, as in frames.css


class InPage:
    """A view's panels as k3d plots with linked cameras.

    Parameters
    ----------
    view : meshfair.viewer.View
    """

    def __init__(self, view: Shown) -> None:
        self._view = view
        self._titles = [ipywidgets.HTML() for _ in view.placed]
        self._plots = [plot() for _ in view.placed]
        self._meshes: list[Any] = [None] * len(view.placed)
        for other in self._plots[1:]:
            ipywidgets.jslink((self._plots[0], "camera"), (other, "camera"))
        panel = ipywidgets.Layout(flex="1 1 180px", min_width="180px")
        row = ipywidgets.HBox(
            [
                ipywidgets.VBox([title, plot], layout=panel)
                for title, plot in zip(self._titles, self._plots, strict=True)
            ],
            layout=ipywidgets.Layout(flex_flow="row wrap", width="100%"),
        )
        self._bar = ipywidgets.HTML()
        self.widget = ipywidgets.VBox([row, self._bar], layout={"width": "100%"})
        self.refresh(range(len(view.placed)))
        self.camera_moved()

    def refresh(self, panels: Iterable[int]) -> None:
        """Show some panels' meshes, values and titles of now."""
        scale = self._view.scale
        self._bar.value = "" if scale is None else bar(scale, self._view.label)
        for k in panels:
            panel = self._view.placed[k]
            self._titles[k].value = html.escape(self._view.titles[k])
            mesh = self._meshes[k]
            if mesh is not None and len(mesh.vertices) == len(panel.V):
                mesh.vertices = panel.V.astype(np.float32)
                if not np.array_equal(mesh.indices, panel.F):
                    mesh.indices = panel.F.astype(np.uint32)
                for name, value in _values(panel, scale).items():
                    setattr(mesh, name, value)
                continue
            if mesh is not None:
                self._plots[k] -= mesh
            self._meshes[k] = drawn(panel, scale)
            self._plots[k] += self._meshes[k]

    def camera_moved(self, panels: Iterable[int] = ()) -> None:
        """Point the plots' camera as the view's, and show some panels of now."""
        self.refresh(panels)
        place = pose(self._view.placed_camera)
        for plot in self._plots:
            plot.camera = place


def plot() -> Any:
    """An empty k3d plot."""
    return k3d.plot(
        height=HEIGHT,
        grid_visible=False,
        background_color=-1,  # the page's own, in both themes
        menu_visibility=False,
        camera_auto_fit=False,
        camera_fov=FIELD_OF_VIEW,
        axes_helper=0,
        colorbar_object_id=0,  # k3d's own bar would lie on the mesh
    )


def drawn(panel: Panel, scale: Scale | None) -> Any:
    """A panel, placed, as a k3d mesh."""
    return k3d.mesh(
        panel.V.astype(np.float32),
        panel.F.astype(np.uint32),
        flat_shading=not panel.smooth,
        side="double",
        **_values(panel, scale),
    )


def pose(camera: Camera) -> list[float]:
    """A camera, placed, as k3d has it."""
    return [*camera.position, *camera.target, *camera.up]


def _values(panel: Panel, scale: Scale | None) -> dict[str, Any]:
    """The traits of a k3d mesh that hold a panel's values: at vertices, or on triangles."""
    if panel.values is None or scale is None:
        color = SURFACE if panel.values is None else panel.none
        return {"attribute": [], "triangles_attribute": [], "color": int(to_hex(color)[1:], 16)}
    at = np.linspace(0, 1, 33)
    color_map = np.column_stack([at, scale.colormap(at)[:, :3]])
    values, low = scale.parts(panel.values), 0.0
    if not panel.complete:
        # Below its low end the scale gets a piece that is grey, for what has no value.
        low = -0.1
        values = np.where(panel.known, np.clip(values, 0, 1), low)
        color_map = np.concatenate([[(low, *panel.none), (-1e-3, *panel.none)], color_map])
        color_map[:, 0] = (color_map[:, 0] - low) / (1 - low)
    values = values.astype(np.float32)
    return {
        "attribute": values if panel.values_on == "vertices" else [],
        "triangles_attribute": values if panel.values_on == "faces" else [],
        "color_map": color_map.astype(np.float32).ravel(),
        "color_range": [low, 1.0],
    }


def bar(scale: Scale, label: str) -> str:
    """The colour bar as HTML."""
    look = f"linear-gradient(to right, {', '.join(scale.stops())}); width: 130px; height: 10px"
    colours = f'<i style="display: inline-block; background: {look}"></i>'
    low, high = map(html.escape, scale.ends())
    return f"{html.escape(label)} &ensp; {low} {colours} {high}"
