"""What a notebook needs: pictures of the student's own result, patience, and checks.

``%load_ext meshfair_grading.notebook`` makes a cell that meets a function which
is not done yet end with one line instead of a traceback, and figures that can be read on light
and on dark pages. `practise` lends the checks of an assignment to a notebook of the course.
"""

import io
import runpy
import sys
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from meshfair.plotting import for_both_themes
from meshfair.viewer import Camera, render
from meshfair_grading.assignment import Assignment
from meshfair_grading.generate import ASSIGNMENTS

SIZE = (480, 400)  # pixels of each picture


@dataclass(frozen=True)
class Picture:
    """A picture that a notebook shows where it is the last value of a cell."""

    png: bytes = field(repr=False)

    def _repr_png_(self) -> bytes:
        return self.png


def show(
    meshes: Mapping[str, ArrayLike],
    F: ArrayLike,
    *,
    direction: Sequence[float] = (1, -1.6, 0.7),
    values: Mapping[str, ArrayLike] | None = None,
    label: str = "",
    limits: tuple[float, float] | None = None,
    edges: bool = False,
) -> Picture:
    """Draw meshes with the same faces side by side, from one camera.

    Parameters
    ----------
    meshes : dict of str to array_like, shape (n, 3)
        Vertices by title; the first decides where the camera stands.
    F : array_like of integers, shape (m, 3)
    direction : three floats
        From the mesh towards the camera.
    values : dict of str to array_like, shape (n,) or (m,), optional
        Numbers to show as colours, by title, on one common scale.
    label : str
        What the numbers are, at the colour bar.
    limits : (float, float), optional
        Ends of the scale; the smallest and the largest value by default.
    edges : bool
        Draw the edges.

    Returns
    -------
    Picture
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    values = values or {}
    if values and limits is None:
        everything = np.concatenate([np.ravel(v) for v in values.values()])
        limits = float(everything.min()), float(everything.max())
    camera = Camera.around(next(iter(meshes.values())), direction, aspect=SIZE[0] / SIZE[1])
    figure = Figure(figsize=(4.2 * len(meshes), 3.9), layout="constrained")
    for position, (title, V) in enumerate(meshes.items(), 1):
        axes = figure.add_subplot(1, len(meshes), position, title=title)
        axes.axis("off")
        axes.imshow(
            render(
                V, F, camera, size=SIZE, values=values.get(title), limits=limits, edges=edges
            )
        )  # fmt: skip
    if values and limits:
        scale = ScalarMappable(Normalize(*limits), "viridis")
        figure.colorbar(scale, ax=figure.axes, label=label, shrink=0.8)
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=110)
    return Picture(file.getvalue())


def practise(assignment: str) -> Assignment:
    """The checks of an assignment, for functions that are written in the notebook itself.

    Parameters
    ----------
    assignment : str
        Its name, such as ``"a2"``.

    Returns
    -------
    Assignment
        ``check = practise("a2")``, and then ``check("distance_weights")``.

    Raises
    ------
    FileNotFoundError
        This installation came without the assignments.
    """
    path = ASSIGNMENTS / "student" / assignment / f"{assignment}_checks.py"
    if not path.is_file():
        raise FileNotFoundError(
            f"the checks of {assignment} are in notebooks/assignments of the repository, and this "
            "installation came without; open the notebook in a clone"
        )
    check: Assignment = runpy.run_path(str(path))["check"]
    check.module = "__main__"
    return check


def load_ipython_extension(shell: Any) -> None:
    """Called by IPython's ``%load_ext``."""
    shell.set_custom_exc((NotImplementedError,), _say_what_is_not_done)
    for_both_themes()


def _say_what_is_not_done(
    shell: Any,
    kind: type[BaseException],
    error: BaseException,
    trace: TracebackType,
    tb_offset: int | None = None,
) -> None:
    pyplot = sys.modules.get("matplotlib.pyplot")
    if pyplot is not None:
        pyplot.close("all")  # else the cell would show the empty axes that it has begun with
    stub = traceback.extract_tb(trace)[-1]
    print(f"`{stub.name}` is not done yet ({Path(stub.filename).name}, line {stub.lineno})")
