"""The formats: which a file has, by its ending or by what one says."""

from os import PathLike
from pathlib import Path
from types import ModuleType
from typing import BinaryIO, NamedTuple, TypeAlias

from meshfair.io import obj, off, ply, stl
from meshfair.io.errors import file_error
from meshfair.io.grids import Grids
from meshfair.io.scenes import Scenes

SCENES = frozenset(["colours", "opacity", "normals", "texture coordinates"])
GRIDS = SCENES | {"polygons"}
FORMATS: dict[str, ModuleType | Scenes | Grids] = {
    ".obj": obj,
    ".off": off,
    ".ply": ply,
    ".stl": stl,
    ".glb": Scenes(".glb", SCENES),
    ".gltf": Scenes(".gltf", SCENES),
    ".3mf": Scenes(".3mf", frozenset()),
    ".dae": Scenes(".dae", frozenset(["normals", "texture coordinates"])),
    ".vtk": Grids(".vtk", GRIDS - {"texture coordinates"}),
    ".vtu": Grids(".vtu", GRIDS),
}
"""What reads and writes each format, by the ending of its files."""

File: TypeAlias = str | PathLike[str] | BinaryIO


class Format(NamedTuple):
    """What a file is: the ending of its format, and whether it is compressed."""

    ending: str
    packed: bool

    @property
    def module(self) -> ModuleType | Scenes | Grids:
        """What reads and writes it."""
        return FORMATS[self.ending]


def name_of(file: File) -> str:
    """What messages call a file."""
    if isinstance(file, (str, PathLike)):
        return str(Path(file))
    name = getattr(file, "name", None)
    return name if isinstance(name, str) else "the stream"


def format_of(file: File, format: str | None) -> Format:
    """The format that is given, or that a file's ending tells."""
    advice = "name it by what it is, or convert it"
    if format is not None:
        name, what, advice = f"file.{format.removeprefix('.')}", "format", "give one of them"
    elif isinstance(file, (str, PathLike)):
        name, what = Path(file).name, "ending"
    else:
        found = "a stream has no ending that tells its format"
        raise file_error("name", found, "the format has to be known", "give format='ply', say")
    name = name.lower()
    ending = Path(name.removesuffix(".gz")).suffix
    if ending not in FORMATS:
        known = f"{', '.join(FORMATS)}, or one of them and .gz, was expected"
        raise file_error("name", f"the {what} {ending!r}", known, advice)
    return Format(ending, name.endswith(".gz"))
