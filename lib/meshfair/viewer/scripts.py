"""The scripts and styles that run in pages: for widgets, for pages on file, and for sites."""

from __future__ import annotations

import re
from importlib.resources import files

EXPORT = "export default { render };\n"

# What draws meshes, in the order in which one needs the other.
DRAWING = ("stage.js", "camera.js", "painter.js", "picture.js", "meshes.js")

# What a widget runs that draws meshes by itself.
LIVE = (*DRAWING, "kernel.js", "in_page.js")

# The plots of a page on file; each is shut off from the others.
PLOTS = {"renderCurves": "curves.js", "renderCotangents": "cotangents.js"}
STYLES = ("frames.css", "curves.css", "cotangents.css", "player.css")


def text(*names: str) -> str:
    """Files of the folder ``web``, one after the other.

    Parameters
    ----------
    *names : str
        Such as ``"stage.js"``; what names another's functions comes after it.

    Returns
    -------
    str
    """
    folder = files("meshfair.viewer").joinpath("web")
    return "\n".join(folder.joinpath(name).read_text(encoding="utf-8") for name in names)


def page_files() -> dict[str, str]:
    """The script and the styles that pages with meshes and explorers need, for a site.

    A page that has the script and the styles shows what `View.to_html` and the explorers'
    ``to_html`` give, and what notebooks hold that were executed with ``MESHFAIR_PAGE=1``
    in their environment.

    Returns
    -------
    dict of str to str
        Names of files, and what is in them: ``meshfair.js``, a classic script that needs no
        other file, and ``meshfair.css``.
    """
    plots = []
    for name, file in PLOTS.items():
        body, count = re.subn(re.escape(EXPORT), "return render;\n", text(file))
        assert count == 1, file
        plots.append(f"const {name} = (() => {{\n{body}}})();\n")
    script = "\n".join([text(*DRAWING), *plots, text("player.js")])
    return {"meshfair.js": f"(() => {{\n{script}}})();\n", "meshfair.css": text(*STYLES)}
