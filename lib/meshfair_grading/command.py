"""Mark the submissions of an assignment: a CSV, and feedback for each student.

Each submission runs in processes of its own with limits; what this system
cannot hold back is said on standard error. A second run marks only what is
new or has changed.
"""

import argparse
import sys
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial
from importlib.util import find_spec
from math import isfinite
from pathlib import Path

# Beside what marks submissions: to read an instructor's file, to write feedback, to show progress.
NEEDED = ("jupytext", "nbformat", "jinja2", "packaging", "psutil", "tqdm")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the subcommand's arguments."""
    parser.add_argument(
        "submissions", type=Path, help="folder with a folder, or a .py file, for each student"
    )
    parser.add_argument(
        "--assignment", required=True, help="a1 ... a5, or the path of an instructor's file"
    )
    parser.add_argument("--out", type=Path, required=True, help="the CSV to write")
    parser.add_argument(
        "--force", action="store_true", help="write over files that this command did not make"
    )
    parser.add_argument("--seed", type=_whole(0), help="of the unseen meshes (new each year)")
    parser.add_argument(
        "--jobs", type=_whole(1), default=2, help="submissions at a time (default 2)"
    )
    parser.add_argument(
        "--seconds",
        type=_above_zero,
        default=10.0,
        help="limit for each call of a function (default 10)",
    )
    parser.add_argument(
        "--memory", type=_above_zero, default=2.0, help="limit in gigabytes (default 2)"
    )
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="mark on the dask cluster of this scheduler, as many at a time as it has workers",
    )
    parser.add_argument(
        "--without-walls",
        action="store_true",
        help="mark where bubblewrap does not work, too: for a machine that you can throw away",
    )


def _whole(least: int) -> Callable[[str], int]:
    """The type of an option that is a whole number."""

    def number(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = least - 1
        if value < least:
            raise argparse.ArgumentTypeError(f"{text!r}; give a whole number of at least {least}")
        return value

    return number


def _above_zero(text: str) -> float:
    """The type of an option that is a finite number above zero."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not (value > 0 and isfinite(value)):
        raise argparse.ArgumentTypeError(f"{text!r}; give a number above 0")
    return value


def run(options: argparse.Namespace) -> int:
    """Mark, write, and say what happened.

    Returns
    -------
    int
        0, whatever marks the submissions got; 1 where a cluster went away.

    Raises
    ------
    ValueError, OSError
        No such assignment, no submissions, or no walls; results that would be written over
        somebody's files.
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
    limits = Limits(
        call=options.seconds, total=6 * options.seconds, memory=round(options.memory * 1e9)
    )
    with ExitStack() as stack:
        elsewhere = None
        if options.scheduler is None:
            isolation = Isolation.detect(limits, without_walls=options.without_walls)
            lines = isolation.describe()
        else:
            from meshfair.experiments.cluster import connect
            from meshfair_grading.cluster import PACKAGES, check_walls, marks_on

            cluster = stack.enter_context(connect(options.scheduler, packages=PACKAGES))
            isolation = Isolation(limits)
            lines = check_walls(cluster, without_walls=options.without_walls)
            elsewhere = partial(
                marks_on,
                cluster,
                source=source,
                limits=limits,
                without_walls=options.without_walls,
            )
        for line in lines:
            print(line, file=sys.stderr)
        marks = grade(
            options.submissions,
            source,
            options.out,
            isolation,
            seed=options.seed,
            jobs=options.jobs,
            force=options.force,
            progress=lambda marks, total: tqdm(marks, total=total, unit="student"),
            elsewhere=elsewhere,
        )
    earned = [sum(outcome.earned for outcome in mark.outcomes) for mark in marks]
    graded = sum(mark.status == "graded" for mark in marks)
    print(
        f"{len(marks)} submissions, {graded} of them could be run, "
        f"mean {sum(earned) / len(earned):.1f} points: {options.out}"
    )
    return 0


def walls_of_this_system() -> tuple[str, str, str]:
    """What `meshfair doctor` says of the walls around submissions.

    Returns
    -------
    state, found, advice : str
    """
    from meshfair_grading.walls import trouble

    found = trouble()
    if not found:
        return "ok", "bubblewrap keeps submissions in", ""
    return "note", found, "without it meshfair grade marks with --without-walls only"


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
