"""Many meshes through one task: it goes on where one fails, and says at the end what was done."""

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Protocol

from meshfair.cli import files, printing


class Task(Protocol):
    """What is done to each mesh."""

    def inputs(self, source: files.Place) -> list[files.Place]:
        """The files that are read."""

    def __call__(
        self, source: files.Place, out: files.Place, advance: Callable[[float], None]
    ) -> dict[str, Any]:
        """Do it, and return what there is to say of it, method and seconds among it."""

    def told(self, facts: dict[str, Any]) -> str:
        """What was done, in a few words for the table."""


def run(task: Task, places: Sequence[files.Place], options: argparse.Namespace) -> int:
    """Do the task with each mesh, into the folder of ``options``, and print a table.

    Parameters
    ----------
    task : Task
    places : sequence of Place
        What is read.
    options : argparse.Namespace

    Returns
    -------
    int
        0, or 1 where a mesh failed.

    Raises
    ------
    ValueError, OSError
        Two meshes that would have one name in the folder, or no folder: nothing is done then.
    KeyboardInterrupt
        After the table of what was done until then.
    """
    outs = _outputs(places, options)
    options.folder.mkdir(exist_ok=True)
    done: list[dict[str, Any]] = []
    try:
        for number, (source, out) in enumerate(outs.items(), 1):
            label = f"{number} of {len(outs)}, {source.name}: "
            with options.messages.warnings(about=str(source)), printing.progress(label) as advance:
                done.append(_facts(task, source, out, advance, options))
    except KeyboardInterrupt:
        _print(task, done, len(outs), options)
        raise KeyboardInterrupt(f"after {len(done)} of {len(outs)} meshes") from None
    _print(task, done, len(outs), options)
    return int(any("error" in facts for facts in done))


def _outputs(places: Sequence[files.Place], options: argparse.Namespace) -> dict[Path, Path]:
    """The output of each input; an error where two would be one."""
    taken: dict[Path, Path] = {}
    for source in places:
        if source == files.STANDARD:
            raise ValueError("- is standard input, which --out cannot name; give OUT instead")
        out = options.folder / source.name
        if out in taken:
            raise ValueError(
                f"{taken[out]} and {source} would both be written to {out}; denoise them one "
                "after the other, into different folders"
            )
        taken[out] = source
    if options.format:
        raise ValueError("--format is for standard input and output; files keep their formats")
    if options.folder.exists() and not options.folder.is_dir():
        raise FileExistsError(f"--out {options.folder} is a file; give a folder")
    if not options.folder.parent.is_dir():
        raise FileNotFoundError(
            f"--out {options.folder}: {options.folder.parent} is not there; create it"
        )
    return {source: out for out, source in taken.items()}


def _facts(
    task: Task,
    source: Path,
    out: Path,
    advance: Callable[[float], None],
    options: argparse.Namespace,
) -> dict[str, Any]:
    """What the task says, or why it failed."""
    try:
        if not source.is_file():
            raise FileNotFoundError(f"{source}: there is no such file; check its name")
        files.check_output(out, task.inputs(source), options.force)
        return {"in": source} | task(source, out, advance)
    except Exception as error:
        message, _ = options.messages.explained(error, about=str(source))
        return {"in": source, "error": message}


def _print(task: Task, done: list[dict[str, Any]], total: int, options: argparse.Namespace) -> None:
    """Print the table, or the same as JSON."""
    failed = [facts for facts in done if "error" in facts]
    if options.json:
        counts = {"done": len(done) - len(failed), "failed": len(failed)}
        printing.print_json({"files": done} | counts | {"interrupted": len(done) < total})
        return
    rows = [
        (facts["in"], facts["method"], task.told(facts), f"{facts['seconds']:.2f}")
        for facts in done
        if "error" not in facts
    ]
    if rows:
        printing.print_table([("file", "method", "done", "seconds"), *rows], clip_first=True)
    for facts in failed:
        reason = facts["error"].removeprefix(f"{facts['in']}: ")
        text = f"{facts['in']}: failed: {reason}"
        print(printing.wrapped(text, "    ") if sys.stdout.isatty() else text)
    told = f"{len(rows)} of {total} meshes written to {options.folder}"
    print(f"{told}; {len(failed)} failed" if failed else told)
