"""Mark the submissions of an assignment: a CSV, and feedback for each student.

Each submission runs in processes of its own with limits; what this system
cannot hold back is said on standard error. A second run marks only what is
new or has changed.
"""

import argparse
import sys
from importlib.util import find_spec
from pathlib import Path

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
    parser.add_argument("--out", type=Path, required=True, help="the CSV to write")
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
    from meshfair.checks import NotInstalledError, install

    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:  # now, and not after the first student
        raise NotInstalledError(f"grading needs {', '.join(missing)}; run: {install('grading')}")

    from tqdm import tqdm

    from meshfair_grading.isolation import Isolation, Limits
    from meshfair_grading.marking import grade
    from meshfair_grading.source import Source

    source = Source.read(_instructors_file(options.assignment))
    isolation = Isolation.detect(
        Limits(
            call=options.seconds, total=6 * options.seconds, memory=round(options.memory * 1e9)
        )
    )  # fmt: skip
    for line in isolation.describe():
        print(line, file=sys.stderr)
    marks = grade(
        options.submissions,
        source,
        options.out,
        isolation,
        seed=options.seed,
        jobs=options.jobs,
        progress=lambda marks, total: tqdm(marks, total=total, unit="student"),
    )
    earned = [sum(outcome.earned for outcome in mark.outcomes) for mark in marks]
    graded = sum(mark.status == "graded" for mark in marks)
    print(
        f"{len(marks)} submissions, {graded} of them could be run, "
        f"mean {sum(earned) / len(earned):.1f} points: {options.out}"
    )
    return 0


def _instructors_file(assignment: str) -> Path:
    """The file of an assignment that is given by its path or, in a clone, by its name."""
    from meshfair.checks import did_you_mean
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
    known = sorted(file.stem for file in folder.glob("*.py"))
    raise ValueError(
        f"there is no assignment {assignment}; there are {', '.join(known)}"
        f"{did_you_mean(assignment, known)}"
    )
