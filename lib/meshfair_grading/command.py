"""Mark the submissions of an assignment: a CSV, and feedback for each student.

Each submission runs in processes of its own with limits; what this system
cannot hold back is said on standard error. A second run marks only what is
new or has changed.
"""

import argparse
from pathlib import Path


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
    """
    import sys

    from tqdm import tqdm

    from meshfair_grading.generate import ASSIGNMENTS
    from meshfair_grading.isolation import Isolation, Limits
    from meshfair_grading.marking import grade
    from meshfair_grading.source import Source

    path = Path(options.assignment)
    if path.suffix != ".py":
        path = ASSIGNMENTS / "source" / f"{options.assignment}.py"
    if not path.exists():
        raise ValueError(
            f"there is no {path}; outside of a clone of the repository give --assignment the path "
            "of an instructor's file, from its folder notebooks/assignments/source"
        )
    source = Source.read(path)
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
