"""Texts that a student has a say in, made fit for where they are shown."""

import hashlib
import re
from collections.abc import Iterable

LONGEST = 100  # characters of a file's name
PLAIN = re.compile(r"[\w][\w .@+-]*", re.ASCII)
# Names that are devices on Windows, and those of the grader's own files.
TAKEN = re.compile(
    r"(con|prn|aux|nul|com\d|lpt\d|leaderboard|records|summary|similar)(\..*)?", re.I
)
# A table's program takes a text with these first as a formula.
FORMULA = ("=", "+", "-", "@", "\t", "\r")


def printable(text: str) -> str:
    """A text without characters that change how the rest is shown, each written out instead.

    Control characters, marks that turn the direction of writing, and bytes that are no UTF-8.

    Parameters
    ----------
    text : str

    Returns
    -------
    str
    """
    return "".join(c if c.isprintable() else _written_out(c) for c in text)


def _written_out(character: str) -> str:
    code = ord(character)
    if 0xDC80 <= code <= 0xDCFF:  # a byte of a name that is no UTF-8
        return f"\\x{code - 0xDC00:02x}"
    return character.encode("unicode_escape").decode("ascii")


def cell(text: str) -> str:
    """A cell of a CSV that no program of tables takes for a formula.

    Parameters
    ----------
    text : str

    Returns
    -------
    str
    """
    return f"'{text}" if text.startswith(FORMULA) else text


def file_names(students: Iterable[str]) -> dict[str, str]:
    """A name for each student's files: their own where it can be one, and each only once.

    Parameters
    ----------
    students : iterable of str

    Returns
    -------
    dict of str to str
        By student.
    """
    students = list(students)
    lowered = [student.lower() for student in students]
    names = {}
    for student, lower in zip(students, lowered, strict=True):
        plain = PLAIN.fullmatch(student) and not student.endswith((" ", "."))
        alone = lowered.count(lower) == 1 and not TAKEN.fullmatch(student)
        if plain and alone and len(student) <= LONGEST:
            names[student] = student
        else:
            digest = hashlib.sha256(student.encode("utf-8", "backslashreplace")).hexdigest()[:10]
            kept = re.sub(r"[^\w@+-]+", "-", student, flags=re.ASCII).strip("-")[:40]
            names[student] = f"{kept or 'student'}-{digest}"
    return names
