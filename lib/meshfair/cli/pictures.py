"""The pictures and pages that subcommands write: what they share."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from meshfair.cli import files

if TYPE_CHECKING:
    from meshfair.viewer import SideBySide

# What Pillow calls the formats.
FORMATS = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG", ".webp": "WEBP"}
SIZE = (480, 400)  # pixels of each mesh in a picture
BAR = 110  # and of the colour bar


def add_picture(parser: argparse.ArgumentParser) -> None:
    """Declare a picture that is written; see `check_picture`."""
    parser.add_argument(
        "--picture",
        metavar="FILE",
        type=files.file,
        help=f"draw the meshes into a picture ({', '.join(FORMATS)})",
    )


def check_picture(path: Path | None, inputs: Sequence[Path], force: bool) -> None:
    """Refuse a picture that cannot be written, before the work; see `files.check_free`."""
    if path is None:
        return
    if path.suffix.lower() not in FORMATS:
        raise ValueError(f"{path}: name the picture {', '.join(FORMATS)}")
    files.check_free(path, inputs, force)


def write_picture(path: Path, shown: "SideBySide", inputs: Sequence[Path], force: bool) -> None:
    """Write meshes side by side as a picture, all of it or nothing."""
    from io import BytesIO

    from meshfair.io.saving import replace_file

    width, height = SIZE
    size = (len(shown.panels) * width + (BAR if shown.scale else 0), height)
    data = BytesIO()
    shown.still(size, background="white").save(data, FORMATS[path.suffix.lower()])
    check_picture(path, inputs, force)
    replace_file(path, data.getvalue())


def titles(paths: Sequence[Path]) -> list[str]:
    """What stands above meshes: the files' names, with as many folders as tell them apart."""
    parts = [path.absolute().parts for path in paths]
    for depth in range(1, max(map(len, parts)) + 1):
        names = ["/".join(part[-depth:]) for part in parts]
        if len(set(names)) == len(set(parts)):
            break
    return names
