"""Meshes side by side as a web page on file, which needs neither a kernel nor a network.

k3d draws them: its program, packed, is part of the page, and so are the meshes. See page.js.
"""

from __future__ import annotations

import base64
import html
import json
import zlib
from importlib.resources import files
from os import PathLike
from pathlib import Path
from typing import Protocol

from meshfair.checks import needed_for
from meshfair.io.saving import replace_file
from meshfair.viewer.camera import Camera
from meshfair.viewer.panel import Panel, Scale

MOST = 12  # panels: browsers draw in sixteen places at a time, and the page may have neighbours

PAGE = """\
<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
{style}</style>
</head>
<body>
<main></main>
<footer></footer>
<script type="text/plain" id="licences">
{licences}</script>
<script type="text/plain" id="k3d">{library}</script>
<script type="application/json" id="meshes">{meshes}</script>
<script type="module">
{script}</script>
</body>
</html>
"""


class Shown(Protocol):
    """What a page shows."""

    placed: list[Panel]
    titles: list[str]
    label: str

    @property
    def scale(self) -> Scale | None:
        """How the panels' values become colours."""

    def placed_camera_for(self, aspect: float) -> Camera:
        """The camera that sees the placed panels, for panels of this shape."""


def write_page(shown: Shown, path: str | PathLike[str], title: str) -> None:
    """Write a page with some panels; see `meshfair.viewer.SideBySide.page`."""
    if len(shown.placed) > MOST:
        raise ValueError(
            f"a page of {len(shown.placed)} meshes is more than browsers draw; give up to {MOST}"
        )
    with needed_for("a page"):
        from meshfair.viewer.in_page import drawn, plot, pose

    snapshots, camera = [], pose(shown.placed_camera_for(1.0))
    for panel in shown.placed:
        picture = plot()
        picture += drawn(panel, shown.scale)
        picture.camera = camera
        snapshots.append(_packed(picture.get_binary_snapshot(compression_level=6)))
    meshes = {
        "titles": shown.titles,
        "snapshots": snapshots,
        "camera": camera,
        "bar": shown.scale and bar(shown.scale, shown.label),
    }
    ours, theirs = files("meshfair.viewer"), files("k3d").joinpath("static")
    library = theirs.joinpath("standalone.js").read_bytes()
    text = PAGE.format(
        title=html.escape(title),
        style=ours.joinpath("page.css").read_text(encoding="utf-8"),
        script=ours.joinpath("page.js").read_text(encoding="utf-8"),
        licences=_licences(),
        library=_packed(zlib.compress(library, 9)),
        meshes=json.dumps(meshes).replace("<", "\\u003c"),  # a title may hold anything
    )
    replace_file(Path(path), text.encode())


def bar(scale: Scale, label: str) -> dict[str, object]:
    """What the page needs to draw the colour bar."""
    low, high = scale.ends()
    return {"label": label, "low": low, "high": high, "stops": scale.stops()}


def _licences() -> str:
    """What k3d and the libraries in it ask to be passed on with them."""
    from importlib.metadata import files as installed

    theirs = [file for file in installed("k3d") or [] if "license" in file.name.lower()]
    wanted = [file for file in theirs if file.name.startswith(("LICENSE", "standalone"))]
    texts = "\n".join(file.read_text(encoding="utf-8") for file in wanted)
    return html.escape(f"k3d draws this page.\n{texts}", quote=False)


def _packed(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")
