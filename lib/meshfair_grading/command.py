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
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from meshfair_grading.isolation import Isolation
    from meshfair_grading.source import Source

# Beside what marks submissions: to read an instructor's file, to write feedback, to show progress.
NEEDED = ("jupytext", "nbformat", "jinja2", "packaging", "psutil", "tqdm")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the subcommand's arguments."""
    parser.add_argument(
        "submissions", type=Path, help="folder with a folder, or a .py file, for each student"
    )
    parser.add_argument(
        "--assignment", required=True, help="a1 ... a6, or the path of an instructor's file"
    )
    parser.add_argument("--out", type=Path, help="the CSV to write")
    parser.add_argument(
        "--explain",
        metavar="STUDENT",
        help="print what was run and what came back for one student, and write nothing",
    )
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
    check_installed()
    if options.out is None and options.explain is None:
        raise ValueError("give --out the CSV to write, or --explain a student")

    from tqdm import tqdm

    from meshfair_grading.gradebook import teachers_folder
    from meshfair_grading.isolation import Isolation, Limits
    from meshfair_grading.marking import grade
    from meshfair_grading.overview import write_overview
    from meshfair_grading.source import Source
    from meshfair_grading.submissions import handed_in

    source = Source.read(instructors_file(options.assignment))
    limits = Limits(
        call=options.seconds, total=6 * options.seconds, memory=round(options.memory * 1e9)
    )
    with ExitStack() as stack:
        elsewhere = None
        if options.scheduler is None or options.explain is not None:
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
        if options.seed is None:
            print(
                f"seed: that of {source.path.name}, which students know; give --seed a number "
                "that only you know, and note it for appeals",
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
            force=options.force,
            progress=lambda marks, total: tqdm(marks, total=total, unit="student"),
            elsewhere=elsewhere,
        )
    assignment = source.load()
    teacher = teachers_folder(options.out)
    files = handed_in(options.submissions, source.name)
    write_overview(teacher, assignment, marks, files, source.stub())
    earned = [sum(outcome.earned for outcome in mark.outcomes) for mark in marks]
    graded = sum(mark.status == "graded" for mark in marks)
    print(
        f"{len(marks)} submissions, {graded} of them could be run, "
        f"mean {sum(earned) / len(earned):.1f} points: {options.out}, {teacher / 'overview.html'}"
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
    from meshfair_grading.submissions import find, handed_in

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
    known = known_assignments()
    raise ValueError(
        f"there is no assignment {assignment}; there are {', '.join(known)}"
        f"{did_you_mean(assignment, known)}"
    )
