"""Make what students get: their files alone, without solutions and hidden tests.

`meshfair handout a2 --out a2.zip` writes an archive with a folder `a2`; with an
--out that does not end in .zip, the folder itself. Several assignments, or
`all`, go into one.
"""

import argparse
import sys
import zipfile
from io import BytesIO
from pathlib import Path

# The same files give the same bytes, whenever they are packed.
EARLIEST = (1980, 1, 1, 0, 0, 0)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the subcommand's arguments."""
    parser.add_argument(
        "assignments", nargs="+", help="a1 ... a6, all, or paths of instructor's files"
    )
    parser.add_argument("--out", type=Path, required=True, help="a .zip file, or a folder")
    parser.add_argument(
        "--solutions",
        action="store_true",
        help="what the teacher gets instead: notebooks with the solutions, and the hidden tests",
    )
    parser.add_argument("--force", action="store_true", help="write over what is there")


def run(options: argparse.Namespace) -> int:
    """Write the files, and name them.

    Returns
    -------
    int
        0.

    Raises
    ------
    ValueError
        No such assignment.
    FileExistsError
        Something is there already.
    """
    from meshfair_grading.command import check_installed, instructors_file, known_assignments
    from meshfair_grading.source import Source

    check_installed()
    wanted = options.assignments
    if wanted == ["all"]:
        wanted = known_assignments()
    files = {
        f"{source.name}/{name}": text
        for source in (Source.read(instructors_file(one)) for one in dict.fromkeys(wanted))
        for name, text in (
            source.solution_files() if options.solutions else source.student_files()
        ).items()
    }
    if options.out.suffix == ".zip":
        _write({options.out: _zipped(files)}, force=options.force)
    else:
        texts = {options.out / name: text.encode() for name, text in files.items()}
        _write(texts, force=options.force)
    print(f"{options.out}: {', '.join(files)}", file=sys.stdout)
    return 0


def _zipped(files: dict[str, str]) -> bytes:
    """An archive that is the same whenever it is made."""
    archive = BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, text in files.items():
            entry = zipfile.ZipInfo(name, EARLIEST)
            entry.external_attr = 0o644 << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            packed.writestr(entry, text.encode())
    return archive.getvalue()


def _write(files: dict[Path, bytes], *, force: bool) -> None:
    there = [path for path in files if path.exists()]
    if there and not force:
        raise FileExistsError(f"{there[0]} exists; give --force to write over it")
    for path, content in files.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
