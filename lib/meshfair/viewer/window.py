"""Polyscope's own window, in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import check_mesh, check_text, check_values, needed_for
from meshfair.mesh import takes_meshes
from meshfair.viewer.panel import Panel, Scale, colors
from meshfair.viewer.placement import Placement

NO_SCREEN = (
    "there is no screen here to open a window on; in a notebook use meshfair.viewer.View, "
    "for a picture on file meshfair.viewer.render"
)


@takes_meshes
def show(
    V: ArrayLike, F: ArrayLike, *, values: ArrayLike | None = None, title: str = "meshfair"
) -> subprocess.Popen[bytes]:
    """Open polyscope's desktop window on a mesh, and go on without waiting for it.

    It shows the mesh around its own centre and of size 1, wherever it lies.
    The window belongs to a process of its own: a notebook's polyscope draws
    without a screen, and one process cannot do both.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    values : array_like, shape (n,) or (m,), optional
        A number for each vertex or each face, shown as a colour; grey where it
        is NaN or infinite.
    title : str
        The window's title.

    Returns
    -------
    subprocess.Popen
        ``.wait()`` waits until the window is closed, ``.terminate()`` closes it.

    Raises
    ------
    MeshError
        No mesh, or values that do not fit it.
    RuntimeError
        There is no screen.
    ImportError
        polyscope is missing; the message says what to install.
    """
    V, F = check_mesh(V, F)
    numbers = None if values is None else check_values(values, len(V), len(F), finite=False)
    title = check_text(title, "title")
    if not has_screen():
        raise RuntimeError(NO_SCREEN)
    with needed_for("a window"):
        import polyscope  # noqa: F401 (the window's process has no notebook to say it in)
    panel = Panel(V, F, numbers)
    shown = np.empty(0) if numbers is None else numbers
    if numbers is not None and not panel.complete:  # for which polyscope has no colour
        shown = colors(panel, Scale.of([panel]))
    placed = Placement.of([panel]).panel(panel)
    with tempfile.NamedTemporaryFile(suffix=".npz", delete=False) as file:
        np.savez(file, V=placed.V, F=F, values=shown, title=title)
    return subprocess.Popen([sys.executable, "-m", __name__, file.name])


def has_screen() -> bool:
    """Whether a window can be opened: always assumed on macOS and Windows."""
    named = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    return bool(named) or sys.platform in ("darwin", "win32")


def _main(path: str) -> None:
    """The window's process: show the mesh that `show` wrote, until it is closed."""
    import polyscope as ps

    with np.load(path) as saved:
        V, F, values, title = (saved[name] for name in ("V", "F", "values", "title"))
    Path(path).unlink()
    ps.set_use_prefs_file(False)
    ps.set_program_name(str(title))
    ps.init()
    ps.set_ground_plane_mode("none")
    mesh = ps.register_surface_mesh("mesh", V, F)
    if values.size:
        on = "vertices" if len(values) == len(V) else "faces"
        add = mesh.add_color_quantity if values.ndim == 2 else mesh.add_scalar_quantity
        add("values", values, defined_on=on, enabled=True)
    ps.show()


if __name__ == "__main__":
    _main(sys.argv[1])
