"""Make the students' files from the instructors': ``python -m meshfair_grading.generate``.

Reads ``notebooks/assignments/source/*.py`` and writes a folder for each into
``notebooks/assignments/student``. With ``--check`` it only compares, and with
``--nbgrader COURSE`` it writes source notebooks into an nbgrader course.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import meshfair
from meshfair_grading.source import Source

# Where an editable install finds the repository; a copied package has none.
ASSIGNMENTS = Path(meshfair.__file__).parents[2] / "notebooks" / "assignments"


def generate(source: Source, folder: str | Path) -> None:
    """Write what a student gets.

    Parameters
    ----------
    source : meshfair_grading.source.Source
    folder : path
        A folder with the assignment's name is made in it.
    """
    for name, text in source.student_files().items():
        _write(Path(folder) / source.name / name, text)


def drifted(source: Source, folder: str | Path) -> list[str]:
    """Which of a student's files are not what the instructor's file makes.

    Parameters
    ----------
    source : meshfair_grading.source.Source
    folder : path

    Returns
    -------
    list of str
        Names of files that differ or are missing.
    """
    made = Path(folder) / source.name
    return [
        f"{source.name}/{name}"
        for name, text in source.student_files().items()
        if not (made / name).exists() or (made / name).read_text(encoding="utf-8") != text
    ]


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8", newline="\n")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line.

    Returns
    -------
    int
        1 where ``--check`` finds a difference.
    """
    summary, _, rest = (__doc__ or "").partition("\n\n")
    parser = argparse.ArgumentParser(description=summary, epilog=rest)
    parser.add_argument("--assignments", type=Path, default=ASSIGNMENTS, metavar="FOLDER")
    parser.add_argument("--check", action="store_true", help="compare, write nothing")
    parser.add_argument("--nbgrader", type=Path, metavar="COURSE")
    options = parser.parse_args(arguments)
    sources = [Source.read(path) for path in sorted(options.assignments.glob("source/*.py"))]
    if not sources:
        parser.error(f"no instructor's files in {options.assignments / 'source'}")
    student = options.assignments / "student"
    if options.check:
        names = [name for source in sources for name in drifted(source, student)]
        for name in names:
            print(f"{name} is not what its source makes: run make assignments", file=sys.stderr)
        return int(bool(names))
    for source in sources:
        if options.nbgrader:
            path = options.nbgrader / "source" / source.name / f"{source.name}.ipynb"
            _write(path, source.nbgrader_notebook())
        else:
            generate(source, student)
    return 0


if __name__ == "__main__":
    sys.exit(main())
