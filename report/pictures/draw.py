"""Draw README's pictures: `make pictures`.

Few colours and no more pixels than a page shows, so that all of them stay under 300 kB.
"""

import io
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

from meshfair import denoise, metrics, viewer
from meshfair.experiments import noisy_pair

HERE = Path(__file__).resolve().parent
METHODS = ("heat", "bilateral-normal", "learned")
COLOURS = 96


def save(figure: plt.Figure, name: str) -> None:
    """Write a figure as a PNG with a palette."""
    written = io.BytesIO()
    figure.savefig(written, dpi=110, facecolor="white")
    plt.close(figure)
    picture = Image.open(written).convert("RGB").quantize(COLOURS)
    picture.save(HERE / name, optimize=True)


def row(name: str, mesh: str, coloured: bool, **camera: object) -> None:
    """A noisy mesh and what some filters make of it, in a row."""
    noisy, V, F = noisy_pair(mesh, 0.2, 1)
    shown = {"noisy": noisy} | {
        method: denoise(noisy, F, method, parameters="auto").V for method in METHODS
    }
    eye = viewer.Camera.around(np.concatenate([V, noisy]), aspect=1.3, **camera)
    figure, panels = plt.subplots(1, len(shown), figsize=(10, 2.2), layout="constrained")
    for panel, (title, X) in zip(panels, shown.items(), strict=True):
        angles = metrics.normal_angles(X, V, F)
        options = {"values": angles, "limits": (0, 40), "cmap": "magma"} if coloured else {}
        panel.imshow(viewer.render(X, F, eye, size=(520, 400), **options))
        panel.set_axis_off()
        panel.set_title(f"{title}, {angles.mean():.0f}°", fontsize=9)
    save(figure, name)


if __name__ == "__main__":
    row("jet.png", "jet", coloured=False, direction=(0.8, -1, 0.7))
    row("box.png", "box", coloured=True, direction=(1, -1, 0.6))
    sizes = {path.name: path.stat().st_size for path in HERE.glob("*.png")}
    print(", ".join(f"{name} {size / 1e3:.0f} kB" for name, size in sizes.items()))
