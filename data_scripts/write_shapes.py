"""Write the built-in shapes to mesh files, to look at or to use in other programs."""

import argparse
from pathlib import Path

from meshfair import io, shapes

SHAPES = {
    "knot": shapes.knot,
    "icosphere": shapes.icosphere,
    "torus": shapes.torus,
    "box": shapes.box,
    "jet": shapes.jet,
    "jet-without-missiles": lambda: shapes.jet(missiles=False),
}


def main() -> None:
    """Write each shape to FOLDER/NAME.ENDING; one line a file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?", default=Path("data"), help="default: data")
    parser.add_argument("--ending", default="ply", choices=["obj", "off", "ply", "stl"])
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    for name, build in SHAPES.items():
        V, F = build()
        path = options.folder / f"{name}.{options.ending}"
        io.write(path, V, F)
        print(f"{path}: {len(V)} vertices, {len(F)} faces")


if __name__ == "__main__":
    main()
