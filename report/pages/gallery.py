"""Every filter on the same meshes: a notebook each, whose pictures make the gallery."""

import base64
import inspect
import io
import re

import nbformat
from nbformat import NotebookNode
from PIL import Image

from meshfair import denoising, filters

MESHES = {"box": "a box", "torus": "a torus", "jet": "a jet"}
THUMBNAIL = 320  # pixels of width

SETUP = """\
import json

from PIL import Image

from meshfair import denoise, metrics, viewer
from meshfair.experiments import noisy_pair


def shown(V, F, V_true, camera):
    angles = metrics.normal_angles(V, V_true, F)
    return Image.fromarray(
        viewer.render(V, F, camera, size=(640, 480), values=angles, limits=(0, 40), cmap="magma")
    )
"""

MESH = """\
V_noisy, V_true, F = noisy_pair("{mesh}", 0.2, 1)
result = denoise(V_noisy, F, "{method}", parameters="auto")
before, after = (metrics.normal_angles(V, V_true, F) for V in (V_noisy, result.V))
print(f"{{result.parameters}}\\n{{before.mean():.1f}} -> {{after.mean():.1f}} degrees")
viewer.View(
    [V_noisy, result.V, V_true],
    F,
    titles=["noisy", "{method}", "true"],
    values=[before, after, None],
    limits=(0, 40),
    cmap="magma",
    label="angle to the true normal, in degrees",
)
"""

PICTURE = """\
camera = viewer.Camera.around(V_true, (1, -1, 0.6), aspect=4 / 3)
shown(result.V, F, V_true, camera)
"""


def methods() -> list[str]:
    """The names of the filters."""
    return denoising.methods()


def summary(method: str) -> str:
    """A filter's first line."""
    function = getattr(filters, method.replace("-", "_"))
    first = (inspect.getdoc(function) or "").partition("\n\n")[0].replace("\n", " ")
    return re.sub(r"\s*\[\w+\]_", "", first)


def notebook(method: str) -> str:
    """The notebook of one filter."""
    cell, code = nbformat.v4.new_markdown_cell, nbformat.v4.new_code_cell
    function = method.replace("-", "_")
    cells = [
        cell(
            f"# {method}\n\n{summary(method)} [Reference](../reference/filters.md) · "
            "[which filter for which mesh](../which-filter.md)\n\nNoise of 0.2 mean edge lengths "
            "along the normals, parameters chosen from the noisy mesh alone."
        ),
        code(SETUP, metadata={"tags": ["hide-input"]}),
    ]
    for mesh in MESHES:
        cells.append(cell(f"## {mesh}"))
        cells.append(code(MESH.format(mesh=mesh, method=method)))
        cells.append(code(PICTURE, metadata={"tags": ["picture"], "mesh": mesh}))
    for position, each in enumerate(cells):
        each["id"] = f"{function.replace('_', '-')}-{position}"
        each["source"] = each["source"].rstrip()
    kernel = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    return nbformat.writes(nbformat.v4.new_notebook(cells=cells, metadata=kernel))


def thumbnails(method: str, executed: NotebookNode) -> dict[str, bytes]:
    """The pictures that the notebook of a filter has made, small, by file name."""
    found = {}
    for cell in executed.cells:
        if "picture" not in cell.metadata.get("tags", ()):
            continue
        for output in cell.outputs:
            if png := output.get("data", {}).get("image/png"):
                picture = Image.open(io.BytesIO(base64.b64decode(png)))
                picture.thumbnail((THUMBNAIL, THUMBNAIL))
                written = io.BytesIO()
                picture.save(written, "webp", quality=80)
                found[f"{method}-{cell.metadata['mesh']}.webp"] = written.getvalue()
    return found
