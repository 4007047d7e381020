"""The meshes that subcommands read and write: what they share."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from meshfair.checks import LARGEST_COORDINATE, Floats, Integers

if TYPE_CHECKING:
    from meshfair.io import Attributes

STANDARD: Literal["-"] = "-"
"""Standard input or output, in place of a file."""
# The endings of `meshfair.io.FORMATS`, which is not loaded for --help.
FORMATS = ("obj", "off", "ply", "stl", "glb", "gltf", "3mf", "dae", "vtk", "vtu")
READABLE = ("obj", "off")  # on a terminal

Place = Path | Literal["-"]


class _Stream(BytesIO):
    """A mesh in memory, whole or not there at all; messages call it by its name."""

    def __init__(self, name: str, data: bytes = b"") -> None:
        super().__init__(data)
        self.name = name


def place(text: str) -> Place:
    """A file by its name, or standard input or output."""
    return STANDARD if text == STANDARD else file(text)


def file(text: str) -> Path:
    """A file by its name."""
    if text == STANDARD:
        raise argparse.ArgumentTypeError("- is standard input, which this cannot be; give a file")
    if not text:
        raise argparse.ArgumentTypeError("the name of the file is empty; give one")
    return Path(text)


def add_input(
    parser: argparse.ArgumentParser,
    name: str = "file",
    purpose: str = "the mesh to read",
    *,
    standard: bool = False,
) -> None:
    """Declare a mesh file that is read, which may be standard input; see `read`."""
    kind = place if standard else file
    parser.add_argument(name, metavar=name.upper(), type=kind, help=purpose)


def add_reading(parser: argparse.ArgumentParser) -> None:
    """Declare how meshes are read."""
    parser.add_argument(
        "--no-weld",
        action="store_true",
        help="keep the corners of an STL file's triangles apart that are in the same place",
    )


def add_format(parser: argparse.ArgumentParser) -> None:
    """Declare the format of standard input and output."""
    parser.add_argument(
        "--format",
        choices=FORMATS,
        metavar="FORMAT",
        help="of standard input and output, which - stands for: " + ", ".join(FORMATS),
    )


def add_output(parser: argparse.ArgumentParser) -> None:
    """Declare the mesh file that is written; see `check_output`."""
    parser.add_argument(
        "out", metavar="OUT", type=place, help="the mesh to write; its ending tells the format"
    )
    add_force(parser)


def add_force(parser: argparse.ArgumentParser) -> None:
    """Declare that files may be replaced."""
    parser.add_argument("--force", action="store_true", help="replace OUT if it is there")


def add_json(parser: argparse.ArgumentParser) -> None:
    """Declare machine-readable output; see `meshfair.cli.printing`."""
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")


def check_standard(options: argparse.Namespace, source: Place, out: Place | None = None) -> None:
    """Settle the format of standard input and output, as ``options.format``.

    Parameters
    ----------
    options : argparse.Namespace
        With the argument of `add_format`.
    source, out : Place
        What is read, and what is written.

    Raises
    ------
    ValueError
        A format that is missing, or that nothing needs.
    """
    places = [source] if out is None else [source, out]
    if STANDARD not in places:
        if options.format:
            raise ValueError(
                "--format is for standard input and output, which - stands for; the ending of a "
                "file's name tells its format"
            )
        return
    if options.format is None and source != STANDARD and ending(source)[1:] in FORMATS:
        options.format = ending(source)[1:]  # what comes out is what went in
    if options.format is None:
        raise ValueError(f"- has no ending; give its --format, one of {', '.join(FORMATS)}")
    if source == STANDARD and sys.stdin.isatty():
        raise ValueError("standard input is the terminal; send a mesh into it, by < or a pipe")
    if out == STANDARD and options.format not in READABLE and sys.stdout.isatty():
        raise ValueError("standard output is the terminal; send the mesh on, by > or a pipe")


def read(path: Place, options: argparse.Namespace) -> tuple[Floats, Integers]:
    """Read a mesh as the options of `add_reading` say.

    Returns
    -------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    """
    V, F, _ = read_whole(path, options)
    return V, F


def read_whole(path: Place, options: argparse.Namespace) -> tuple[Floats, Integers, Attributes]:
    """Read a mesh, and all else that its file holds.

    Returns
    -------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    attributes : meshfair.io.Attributes
        For `write`.
    """
    from meshfair import io

    weld = not options.no_weld
    if path == STANDARD:
        stream = _Stream("standard input", sys.stdin.buffer.read())
        try:
            return io.read(stream, format=options.format, weld=weld, attributes=True)
        except io.MeshFileError as error:
            advice = str(error).replace("name it by what it is", "give its --format")
            raise io.MeshFileError(advice) from None
    return io.read(path, weld=weld, attributes=True)


# What denoise and noise say themselves, where they meet it.
TOLD_ANYWAY = ("duplicate_vertices", "inconsistent_edges")


def warn_of_problems(path: Place, V: Floats, F: Integers) -> None:
    """Say in one line which problems of a mesh may spoil what is done to it.

    Parameters
    ----------
    path : Place
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)

    Warns
    -----
    MeshWarning
    """
    from meshfair.checks import warn
    from meshfair.mesh import inspect
    from meshfair.mesh.findings import KINDS

    problems = [
        f"{len(found.where):,} {KINDS[found.kind].title}"
        for found in inspect(V, F).findings
        if found.problem and found.kind not in TOLD_ANYWAY
    ]
    if problems:
        told = "; ".join(problems)
        warn(f"{path}: {told} (meshfair info says what that affects, and what helps)")


def ending(path: Path) -> str:
    """The ending of a file's name that tells its format, in lower case, with its dot."""
    return Path(path.name.lower().removesuffix(".gz")).suffix


def check_output(out: Place, inputs: Sequence[Place], force: bool) -> None:
    """Refuse an output that would destroy something, or that cannot be written.

    Called before the work, so that nothing is computed in vain.

    Parameters
    ----------
    out : Place
    inputs : sequence of Place
        Never written over, not even with ``force``.
    force : bool
        Whether another file of this name may be replaced.

    Raises
    ------
    OSError, MeshError
        One sentence: what is in the way, and what to do.
    """
    from meshfair import io

    if out == STANDARD:
        return
    if ending(out) not in io.FORMATS:
        raise ValueError(f"{out}: name it {', '.join(io.FORMATS)}, or one of them and .gz")
    check_free(out, inputs, force)


def check_free(out: Path, inputs: Sequence[Place], force: bool) -> None:
    """Refuse any file, not a mesh alone, that would destroy something or cannot be written.

    Parameters and errors are those of `check_output`.
    """
    for path in inputs:
        if path != STANDARD and out.exists() and path.exists() and os.path.samefile(out, path):
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


def write(
    out: Place,
    V: Floats,
    F: Integers,
    like: Attributes,
    inputs: Sequence[Place],
    options: argparse.Namespace,
) -> None:
    """Write the mesh, after the checks of `check_output` once more: work takes time.

    Parameters
    ----------
    out : Place
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    like : meshfair.io.Attributes
        What `read_whole` found.
    inputs : sequence of Place
        See `check_output`.
    options : argparse.Namespace

    Raises
    ------
    OSError, MeshError, FloatingPointError
        What is in the way; positions that have outgrown all numbers.
    """
    import numpy as np

    from meshfair import io

    if not np.all(np.abs(V) <= LARGEST_COORDINATE):
        raise FloatingPointError(
            f"the result has coordinates beyond {LARGEST_COORDINATE:g}, so nothing is written; "
            "take smaller values"
        )
    if out == STANDARD:
        whole = _Stream("standard output")
        io.write(whole, V, F, like=like, format=options.format)
        sys.stdout.buffer.write(whole.getvalue())
        sys.stdout.buffer.flush()
        return
    check_output(out, inputs, options.force)
    io.write(out, V, F, like=like)
