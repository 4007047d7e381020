"""Which back end draws a view in the page."""

from __future__ import annotations

from meshfair.checks import check_choice, needed_for
from meshfair.viewer.backend import Backend, Shown
from meshfair.viewer.egl import has_egl


def made(name: str | None, view: Shown) -> Backend:
    """What draws a view in the page, by name; its libraries are loaded here."""
    if name is None:
        name = "polyscope" if has_egl() else "webgl"
    name = check_choice(name, "backend", ("polyscope", "webgl"))
    with needed_for("a live view"):
        if name == "polyscope":
            from meshfair.viewer.frames import Frames

            return Frames(view)
        from meshfair.viewer.in_page import InPage

        return InPage(view)
