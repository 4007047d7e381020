"""Pictures of meshes: on file, live in a notebook, and in a window.

* `render` draws one picture into an array, without a screen: the report's figures.
* `View` is a live view in a notebook: drag to turn, wheel to zoom.
* `SideBySide` is the same without a notebook: pictures, and pages for a browser.
* `OnPage` is what both, and every explorer, can do: `save` a page that needs no kernel.
* `page_files` are the scripts and styles of such pages, for a site.
* `show` opens polyscope's own window, where there is a screen.

Importing this package needs neither polyscope nor Jupyter; they are loaded
when something is drawn, and a library that is missing is named in one sentence.
"""

from meshfair.viewer.camera import Camera
from meshfair.viewer.distance import by_distance
from meshfair.viewer.egl import has_egl
from meshfair.viewer.offscreen import on_gl_thread, render
from meshfair.viewer.page import OnPage
from meshfair.viewer.panel import CMAPS
from meshfair.viewer.scripts import page_files
from meshfair.viewer.side_by_side import SideBySide
from meshfair.viewer.view import View
from meshfair.viewer.window import show

__all__ = [
    "CMAPS",
    "Camera",
    "OnPage",
    "SideBySide",
    "View",
    "by_distance",
    "has_egl",
    "on_gl_thread",
    "page_files",
    "render",
    "show",
]
