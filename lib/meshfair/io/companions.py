"""Files that a mesh file names beside itself: an OBJ its materials, a PLY its picture."""

import os
import re
from collections.abc import Iterator
from pathlib import Path

from meshfair.io.attributes import Attributes

# Lines that are kept byte for byte, whatever folder a file is written to.
NAMING = {
    ".obj": re.compile(rb"mtllib[ \t]+([^\r\n]+)"),
    ".ply": re.compile(rb"comment TextureFile[ \t]+([^\r\n]+)"),
}


def left_behind(data: bytes, like: Attributes, path: Path) -> str:
    """A sentence on files that a written file names and that are only beside its origin.

    Parameters
    ----------
    data : bytes
        What is written, unpacked.
    like : Attributes
        The file that it is written like.
    path : pathlib.Path
        Where it is written to.

    Returns
    -------
    str
        Empty where nothing is left behind.
    """
    if like.format not in NAMING or not os.path.isfile(like.name):
        return ""
    folder = Path(like.name).parent
    names = dict.fromkeys(_named(data, like.format, folder))
    left = [str(folder / name) for name in names if not (path.parent / name).exists()]
    if not left:
        return ""
    return f"names {', '.join(left)}: copy that beside it, with what it names in turn"


def _named(data: bytes, ending: str, folder: Path) -> Iterator[str]:
    """The files of a folder that the lines name: what follows the keyword, or words of it."""
    end = data.find(b"end_header") if ending == ".ply" else len(data)
    for line in NAMING[ending].finditer(data, 0, end):
        if data[data.rfind(b"\n", 0, line.start()) + 1 : line.start()].strip():
            continue  # within a line, such as a comment's
        rest = os.fsdecode(line[1].strip())
        for names in ([rest], rest.split()):
            # os.path also says no to a name that no file can have.
            if there := [name for name in names if os.path.isfile(folder / name)]:
                yield from there
                break
