"""The submissions of a class, whatever their folders are called and whatever lies in them.

Nothing here ends the marking of the others: what is odd about one student's files
becomes that student's status.
"""

import contextlib
import os
import re
import stat
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from meshfair_grading.printable import printable

LARGEST_FILE = 1_000_000
LISTED = 5  # names of what lies there instead
DEEPEST = 2  # folders below the student's own in which the file may lie
# Made by systems and by archives, not by students.
NO_STUDENT = (".", "__")
OF_ASSIGNMENTS = re.compile(r"a\d+", re.I)


@dataclass(frozen=True)
class Submission:
    """What was found for one student."""

    student: str
    """Whose it is, fit to be printed."""
    path: Path | None
    remark: str = ""
    own: Path | None = None
    """The student's folder, which links must not leave."""
    status: str = "nothing handed in"
    """Where there is no path: why, in a few words."""


def find(folder: str | Path, assignment: str) -> list[Submission]:
    """Find the submissions in a folder.

    Each student has a folder named by their identity, with ``a2.py`` in it or
    in its subfolder ``a2`` (nbgrader's layout), or else a file of their own
    beside the others, ``IDENTITY.py``. The likeliest misplacements are taken with a remark.

    Parameters
    ----------
    folder : path
    assignment : str

    Returns
    -------
    list of Submission
        Sorted by student.

    Raises
    ------
    ValueError
        No submission there at all.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise ValueError(
            f"{printable(str(folder))} is no folder; give the one with the submissions"
        )
    found: dict[str, Submission] = {}
    for entry in sorted(folder.iterdir(), key=lambda entry: os.fsencode(entry.name)):
        if entry.name.startswith(NO_STUDENT):
            continue
        is_folder = False
        with contextlib.suppress(OSError):
            is_folder = entry.is_dir() or entry.is_symlink()
        if is_folder and entry.suffix != ".py":
            one = _in_folder(entry, assignment)
        elif entry.suffix == ".py" and entry.is_symlink():
            why = "a link to a file elsewhere"
            one = Submission(printable(entry.stem), None, f"The file is {why}.", status=why)
        elif entry.suffix == ".py":
            one = Submission(printable(entry.stem), entry, own=folder)
        else:
            continue
        if one.student in found:
            why = "a folder and a file, or two names that look alike"
            one = Submission(one.student, None, f"There is {why}: hand in one of them.", status=why)
        found[one.student] = one
    if not found:
        where = printable(str(folder))
        raise ValueError(f"{where} holds neither folders of students nor .py files")
    return sorted(found.values(), key=lambda one: one.student)


def _in_folder(folder: Path, assignment: str) -> Submission:
    student, name = printable(folder.name), f"{assignment}.py"
    if folder.is_symlink():
        why = "a link to another folder"
        return Submission(student, None, f"The folder is {why}: hand in files.", status=why)
    try:
        files = list(_files(folder))
    except OSError as error:
        why = f"cannot be read ({error.strerror})"
        return Submission(student, None, f"The folder {why}.", status=why)

    def taken(path: Path, remark: str = "") -> Submission:
        return Submission(student, path, remark, own=folder)

    for expected in (folder / name, folder / assignment / name):
        if expected in files:
            return taken(expected)
    called = [path for path in files if path.name == name]
    alike = [path for path in files if _is_like(path.name, assignment)]
    alone = [path for path in files if path.suffix == ".py" and path.parent == folder]
    alone = [path for path in alone if not OF_ASSIGNMENTS.match(path.name)]
    for candidates in (called, alike, alone):
        if len(candidates) == 1:
            there = printable(str(candidates[0].relative_to(folder)))
            return taken(
                candidates[0], f"The file is {there}; hand it in as {name}, without a folder."
            )
    names = sorted(printable(str(path.relative_to(folder))) for path in files)
    listed = ", ".join(names[:LISTED]) + (", ..." if len(names) > LISTED else "")
    remark = f"There is no {name}, but {listed}." if names else "The folder is empty."
    if any(path.suffix == ".ipynb" for path in files) and not alike:
        remark += f" A notebook holds none of your functions: hand in {name}."
    return Submission(student, None, remark)


def _files(folder: Path, depth: int = 0) -> Iterator[Path]:
    """The files of a student, in folders that are no links."""
    for entry in sorted(folder.iterdir(), key=lambda entry: os.fsencode(entry.name)):
        if entry.name.startswith(NO_STUDENT):
            continue
        if entry.is_dir() and not entry.is_symlink():
            if depth < DEEPEST:
                with contextlib.suppress(OSError):
                    yield from _files(entry, depth + 1)
        else:
            yield entry


def _is_like(name: str, assignment: str) -> bool:
    """Whether a name is that of the file with something added: ``A2.PY``, ``a2 (1).py``."""
    stem, ending = os.path.splitext(name.lower())
    return ending == ".py" and re.match(rf"{re.escape(assignment.lower())}(?!\d)", stem) is not None


def read(submission: Submission) -> bytes:
    """The file that was handed in.

    Parameters
    ----------
    submission : Submission

    Returns
    -------
    bytes

    Raises
    ------
    ValueError
        There is none, or none that can be read; the message is a status.
    """
    if submission.path is None:
        raise ValueError(submission.status)
    try:
        real = submission.path.resolve(strict=True)
        if submission.own and not real.is_relative_to(submission.own.resolve()):
            raise ValueError("a link to a file elsewhere")
        # What has become a link or a pipe in between is neither followed nor waited for.
        file = os.open(real, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or "a link to itself"
        raise ValueError(f"cannot be read ({reason})") from None
    with open(file, "rb") as opened:
        if not stat.S_ISREG(os.fstat(file).st_mode):
            raise ValueError("not a regular file")
        try:
            content = opened.read(LARGEST_FILE + 1)
        except OSError as error:
            raise ValueError(f"cannot be read ({error.strerror})") from None
    if len(content) > LARGEST_FILE:
        raise ValueError(f"a file of more than {LARGEST_FILE / 1e6:g} MB")
    return content


def handed_in(folder: str | Path, assignment: str) -> dict[str, bytes]:
    """The files that can be read, by student.

    Parameters
    ----------
    folder : path
    assignment : str

    Returns
    -------
    dict of str to bytes
    """
    found = {}
    for submission in find(folder, assignment):
        with contextlib.suppress(ValueError):
            found[submission.student] = read(submission)
    return found
