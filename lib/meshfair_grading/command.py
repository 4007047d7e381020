"""Mark the submissions of an assignment: a CSV, and feedback for each student.

Each submission runs in processes of its own with limits; what this system
cannot hold back is said on standard error. A second run marks only what is
new or has changed.
"""

import argparse
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from meshfair_grading.isolation import Isolation
    from meshfair_grading.source import Source

# Beside what marks submissions: to read an instructor's file, to write feedback, to show progress.
NEEDED = ("jupytext", "nbformat", "jinja2", "tqdm")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the subcommand's arguments."""
    parser.add_argument(
        "submissions", type=Path, help="folder with a folder, or a .py file, for each student"
    )
    parser.add_argument(
        "--assignment", required=True, help="a1 ... a5, or the path of an instructor's file"
    )
    parser.add_argument("--out", type=Path, help="the CSV to write")
    parser.add_argument(
        "--explain",
        metavar="STUDENT",
        help="print what was run and what came back for one student, and write nothing",
    )
    parser.add_argument("--seed", type=int, help="of the unseen meshes (new each year)")
    parser.add_argument("--jobs", type=int, default=2, help="submissions at a time (default 2)")
    parser.add_argument(
        "--seconds", type=float, default=10.0, help="limit for each call of a function (default 10)"
    )
    parser.add_argument(
        "--memory", type=float, default=2.0, help="limit in gigabytes (default 2)"
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Mark, write, and say what happened.

    Returns
    -------
    int
        0, whatever marks the submissions got.

    Raises
    ------
    ValueError
        No such assignment, or no submissions.
    NotInstalledError
        A library is missing.
    """
    check_installed()
    if options.out is None and options.explain is None:
        raise ValueError("give --out the CSV to write, or --explain a student")

    from tqdm import tqdm

    from meshfair_grading.isolation import Isolation, Limits
    from meshfair_grading.marking import grade, handed_in
    from meshfair_grading.overview import write_overview
    from meshfair_grading.source import Source

    source = Source.read(instructors_file(options.assignment))
    isolation = Isolation.detect(
        Limits(
            call=options.seconds, total=6 * options.seconds, memory=round(options.memory * 1e9)
        )
    )  # fmt: skip
    for line in isolation.describe():
        print(line, file=sys.stderr)
    if options.seed is None:
        print(
            f"seed: that of {source.path.name}, which students know; give --seed a number that "
            "only you know, and note it for appeals",
            file=sys.stderr,
        )
    if options.explain is not None:
        print(_explained(options.explain, options.submissions, source, isolation, options.seed))
        return 0
    marks = grade(
        options.submissions,
        source,
        options.out,
        isolation,
        seed=options.seed,
        jobs=options.jobs,
        progress=lambda marks, total: tqdm(marks, total=total, unit="student"),
    )
    assignment = source.load()
    teacher = options.out.with_name(f"{options.out.stem}_teacher")
    files = handed_in(options.submissions, source.name)
    write_overview(teacher, assignment, marks, files, source.stub())
    earned = [sum(outcome.earned for outcome in mark.outcomes) for mark in marks]
    graded = sum(mark.status == "graded" for mark in marks)
    print(
        f"{len(marks)} submissions, {graded} of them could be run, "
        f"mean {sum(earned) / len(earned):.1f} points: {options.out}, {teacher / 'overview.html'}"
    )
    return 0


def check_installed() -> None:
    """Raise `NotInstalledError` where a library is missing: now, not after the first student."""
    from meshfair.checks import NotInstalledError, install

    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        raise NotInstalledError(f"grading needs {', '.join(missing)}; run: {install('grading')}")


def _explained(
    student: str, folder: Path, source: "Source", isolation: "Isolation", seed: int | None
) -> str:
    """How the mark of one student came about."""
    from meshfair_grading.explain import explain
    from meshfair_grading.marking import find, handed_in

    found = {one.student: one for one in find(folder, source.name)}
    if student not in found:
        raise ValueError(f"{folder} has no submission of {student}; there are {', '.join(found)}")
    content = handed_in(folder, source.name).get(student, b"")
    assignment = source.load()
    seed = assignment.seed if seed is None else seed
    return explain(found[student], content, assignment, isolation, seed)


def known_assignments() -> list[str]:
    """The names of the assignments that came with this installation."""
    from meshfair_grading.generate import ASSIGNMENTS

    return sorted(file.stem for file in (ASSIGNMENTS / "source").glob("*.py"))


def instructors_file(assignment: str) -> Path:
    """The file of an assignment that is given by its path or, in a clone, by its name."""
    from meshfair_grading.generate import ASSIGNMENTS

    folder, path = ASSIGNMENTS / "source", Path(assignment)
    if path.suffix != ".py":
        path = folder / f"{assignment}.py"
    if path.is_file():
        return path
    if path.parent != folder:
        raise ValueError(f"there is no file {path}")
    if not folder.is_dir():
        raise ValueError(
            "this installation came without the assignments; give --assignment the path of an "
            f"instructor's file, such as notebooks/assignments/source/{path.name} of the repository"
        )
    known = ", ".join(known_assignments())
    raise ValueError(f"there is no assignment {assignment}; there are {known}")
