"""The files that subcommands read and write: what they share."""

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

from meshfair.checks import Floats, Integers


def add_input(
    parser: argparse.ArgumentParser, name: str = "file", purpose: str = "the mesh to read"
) -> None:
    """Declare a mesh file that is read; see `read`."""
    parser.add_argument(name, metavar=name.upper(), type=Path, help=purpose)


def add_reading(parser: argparse.ArgumentParser) -> None:
    """Declare how meshes are read."""
    parser.add_argument(
        "--weld-stl",
        action="store_true",
        help="merge the corners of an STL file that are in the same place",
    )


def add_output(parser: argparse.ArgumentParser) -> None:
    """Declare the mesh file that is written; see `check_output`."""
    parser.add_argument(
        "out", metavar="OUT", type=Path, help="the mesh to write; its ending tells the format"
    )
    parser.add_argument("--force", action="store_true", help="replace OUT if it is there")


def add_json(parser: argparse.ArgumentParser) -> None:
    """Declare machine-readable output; see `meshfair.cli.printing`."""
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")


def read(path: Path, options: argparse.Namespace) -> tuple[Floats, Integers]:
    """Read a mesh as the options of `add_reading` say.

    Returns
    -------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    """
    from meshfair import io

    return io.read(path, weld_stl=options.weld_stl)


def check_output(out: Path, inputs: Sequence[Path], force: bool) -> None:
    """Refuse an output that would destroy something, or that cannot be written.

    Called before the work, so that nothing is computed in vain.

    Parameters
    ----------
    out : pathlib.Path
    inputs : sequence of pathlib.Path
        Never written over, not even with ``force``.
    force : bool
        Whether another file of this name may be replaced.

    Raises
    ------
    OSError, MeshError
        One sentence: what is in the way, and what to do.
    """
    from meshfair import io

    if Path(out.name.lower().removesuffix(".gz")).suffix not in io.FORMATS:
        raise ValueError(f"{out}: name it {', '.join(io.FORMATS)}, or one of them and .gz")
    for path in inputs:
        if out.exists() and path.exists() and os.path.samefile(out, path):
            raise FileExistsError(f"{out} is an input too; give the output another name")
    if out.is_dir():
        raise IsADirectoryError(f"{out} is a folder; give the name of a file in it")
    if out.exists() and not force:
        raise FileExistsError(f"{out} is there already; replace it with --force, or choose a name")
    check_folder(out)


def check_folder(out: Path) -> None:
    """Refuse an output in a folder that is not there or cannot be written to.

    Parameters
    ----------
    out : pathlib.Path

    Raises
    ------
    PermissionError
    """
    if not os.access(out.parent, os.W_OK):
        reason = "cannot be written to" if out.parent.is_dir() else "is not there"
        raise PermissionError(f"{out}: the folder {out.parent} {reason}; choose another")


def write(out: Path, V: Floats, F: Integers, inputs: Sequence[Path], force: bool) -> None:
    """Write the mesh, after the checks of `check_output` once more: work takes time."""
    from meshfair import io

    check_output(out, inputs, force)
    io.write(out, V, F)
