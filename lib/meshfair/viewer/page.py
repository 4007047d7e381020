"""Meshes and explorers as HTML, which needs neither a kernel nor a network."""

from __future__ import annotations

import base64
import html
import io
import os
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from meshfair.checks import check_text
from meshfair.io.saving import replace_file
from meshfair.viewer.panel import Scale
from meshfair.viewer.scripts import page_files

if TYPE_CHECKING:
    from PIL.Image import Image

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
<body class="meshfair-page">
<main>
{part}</main>
<script>
{script}</script>
</body>
</html>
"""

PART = """\
<div class="meshfair-player" role="group" aria-label="{label}">
<img class="still" src="data:image/webp;base64,{still}" width="{width}" height="{height}" \
alt="{label}">
<script type="application/octet-stream" class="packed">{packed}</script>
</div>
"""


def for_page() -> bool:
    """Whether notebooks show what moves without a kernel: ``MESHFAIR_PAGE`` is set and not 0."""
    return os.environ.get("MESHFAIR_PAGE", "0") not in ("", "0")


def part(packed: str, still: Image, label: str) -> str:
    """What a page shows of a view or an explorer: a still, and what makes it move.

    Parameters
    ----------
    packed : str
        From `meshfair.viewer.recording.Recording`.
    still : PIL.Image.Image
        What is seen without scripts, or without WebGL.
    label : str
        What is seen, in words.

    Returns
    -------
    str
        HTML without a blank line, so that it can stand in Markdown.
    """
    data = io.BytesIO()
    still.save(data, "WEBP", quality=85, method=4)
    return PART.format(
        label=html.escape(label),
        still=base64.b64encode(data.getvalue()).decode("ascii"),
        width=still.width,
        height=still.height,
        packed=packed,
    )


def write_page(given: str, path: str | PathLike[str], title: str) -> None:
    """Write a page with what `part` gives, and the scripts and styles for it."""
    shared = page_files()
    page = PAGE.format(
        title=html.escape(check_text(title, "title")),
        style=shared["meshfair.css"],
        part=given,
        script=shared["meshfair.js"],
    )
    replace_file(Path(path), page.encode())


class OnPage:
    """What can stand on a web page without a kernel: views, and every explorer."""

    def to_html(self) -> str:
        """Give it as a part of a web page, in which meshes turn and controls go on working.

        An explorer goes through its settings for that, and the page's controls go to the states
        that were stored; a view gives what it shows now.

        Returns
        -------
        str
            HTML for a page that has the files of `meshfair.viewer.page_files`; without them,
            or without WebGL, a still is seen.

        Raises
        ------
        ImportError
            matplotlib or Pillow is missing; the message says what to install.
        """
        return self._part()

    def _part(self) -> str:
        raise NotImplementedError

    def save(self, path: str | PathLike[str], title: str = "meshfair") -> None:
        """Write a web page with it.

        The page needs neither a kernel nor a network: what draws the meshes is in it.

        Parameters
        ----------
        path : path
            An HTML file; one that is there is replaced.
        title : str
            The page's.

        Raises
        ------
        ValueError
            A title that is no text.
        ImportError
            matplotlib or Pillow is missing; the message says what to install.
        """
        write_page(self.to_html(), path, title)


def described(titles: list[str], label: str) -> str:
    """What a picture of meshes shows, in words."""
    named = "; ".join(title for title in titles if title)
    count = len(titles)
    meshes = "A mesh" if count == 1 else f"{count} meshes side by side"
    said = f"{meshes}: {named}" if named else meshes
    return f"{said}. Colours: {label}." if label else f"{said}."


def bar(scale: Scale, label: str) -> dict[str, object]:
    """What the page needs to draw the colour bar."""
    low, high = scale.ends()
    return {"label": label, "low": low, "high": high, "stops": scale.stops()}
