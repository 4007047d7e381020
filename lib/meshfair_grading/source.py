"""An instructor's file, and the files for students that are made from it.

The file is Python in jupytext's percent format: cells that begin with a
line ``# %%``. A word after it says where the cell goes:

================  ===========================================================
``[markdown]``    text of the notebook
(nothing)         code of the notebook
``result``        code of the notebook that calls the student's functions
``module``        the student's file, ``a2.py``
``checks``        ``a2_checks.py``
================  ===========================================================

What stands between ``### BEGIN SOLUTION`` and ``### END SOLUTION`` becomes
``raise NotImplementedError``; what stands between ``### BEGIN HIDDEN TESTS``
and ``### END HIDDEN TESTS`` is left out. ``module`` and ``checks`` cells run
when the file is loaded for grading, the others only in the notebook.
"""

from __future__ import annotations

import hashlib
import re
import types
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from nbformat import NotebookNode

    from meshfair_grading.assignment import Assignment

KINDS = ("[markdown]", "", "result", "module", "checks")
HEAD = re.compile(r"^# %%", re.M)
SOLUTION = re.compile(r"^([ ]*)### BEGIN SOLUTION\n.*?^[ ]*### END SOLUTION\n", re.M | re.S)
HIDDEN = re.compile(
    r"^\n?[ ]*### BEGIN HIDDEN TESTS\n.*?^[ ]*### END HIDDEN TESTS\n", re.M | re.S
)  # with the blank line before it, where there is one
MARKER = re.compile(r"### (BEGIN|END) (SOLUTION|HIDDEN TESTS)")
CHECKED_TASK = re.compile(r'^@check\.part\(\s*"(\w+)"', re.M)

METADATA = {
    "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
    "language_info": {"name": "python"},
}


@dataclass(frozen=True)
class Cell:
    """One cell of an instructor's file."""

    kind: str
    text: str
    line: int
    """Line of the file at which ``text`` starts, from 1."""


@dataclass(frozen=True)
class Source:
    """An instructor's file, cut into cells."""

    name: str
    """Such as ``a2``."""
    path: Path
    cells: tuple[Cell, ...]
    digest: str
    """Fingerprint of the file's bytes."""

    @classmethod
    def read(cls, path: str | PathLike[str]) -> Source:
        """Read an instructor's file.

        Parameters
        ----------
        path : path

        Returns
        -------
        Source

        Raises
        ------
        ValueError
            A cell of an unknown kind, or a marker without its partner.
        """
        path = Path(path)
        data = path.read_bytes()
        cells = tuple(_cells(data.decode(), path))
        for cell in cells:
            if MARKER.search(_released(cell.text)):
                raise ValueError(
                    f"{path}, cell at line {cell.line}: a ### BEGIN or ### END without its partner"
                )
        return cls(path.stem, path, cells, hashlib.sha256(data).hexdigest())

    def load(self) -> Assignment:
        """Run the checks, hidden ones included.

        Returns
        -------
        meshfair_grading.assignment.Assignment
            The object that the checks call ``check``.

        Raises
        ------
        ValueError
            They make none.
        """
        module = types.ModuleType(f"{self.name}_checks")
        module.__file__ = str(self.path)
        for cell in self.cells:
            if cell.kind == "checks":  # with the file's own line numbers
                code = "\n" * (cell.line - 1) + cell.text
                exec(compile(code, str(self.path), "exec"), module.__dict__)
        check: Assignment | None = getattr(module, "check", None)
        if check is None:
            raise ValueError(
                f"{self.path} is no instructor's file: no cell '# %% checks' makes a `check`"
            )
        check.solution = self.solution()
        return check

    def solution(self) -> str:
        """The student's file as the instructor would hand it in.

        Returns
        -------
        str
        """
        return self._text("module", _without_markers)

    def stub(self) -> str:
        """The student's file as it is handed out.

        Returns
        -------
        str
        """
        return self._text("module", _released)

    def student_files(self) -> dict[str, str]:
        """All that a student gets.

        Returns
        -------
        dict of str to str
            Contents by file name: notebook, stub, checks.
        """
        cells = [c for c in self.cells if c.kind in ("[markdown]", "", "result")]
        return {
            f"{self.name}.ipynb": _notebook(
                [self._student_cell(i, c) for i, c in enumerate(cells)]
            ),
            f"{self.name}.py": self.stub(),
            f"{self.name}_checks.py": self._text("checks", _released),
        }

    def solution_files(self) -> dict[str, str]:
        """What the teacher gets: a notebook in which the solution stands after each task's text.

        Returns
        -------
        dict of str to str
            Contents by file name: the notebook, which runs from top to bottom; the solution as
            it would be handed in; the checks, with the hidden tests.
        """
        name = self.name
        cells = []
        for index, cell in enumerate(self.cells):
            text = cell.text
            if cell.kind == "checks":
                continue
            if cell.kind == "module":
                text = _without_markers(text)
            elif cell.kind != "[markdown]":  # the functions are the notebook's own here
                text = re.sub(rf"^import {name}\n", "", text, flags=re.M)
                text = re.sub(rf"\b{name}\.(?=\w)", "", text)
            cells.append(_notebook_cell(f"{name}-{index:02}", cell, text, {}))
        checks = self._text("checks", _without_markers)
        return {
            f"{name}.ipynb": _notebook(cells),
            f"{name}.py": self.solution(),
            f"{name}_checks.py": f'{checks}\ncheck.module = "__main__"\n',
        }

    def nbgrader_notebook(self) -> str:
        """The file as a source notebook of nbgrader: everything in its cells.

        Students then write into the notebook, not into a file of their own;
        hidden tests and partial credit work as nbgrader's.

        Returns
        -------
        str
        """
        points = self.load().tasks
        cells = [self._nbgrader_cell(i, cell, points) for i, cell in enumerate(self.cells)]
        return _notebook(cells)

    def _text(self, kind: str, change: Callable[[str], str]) -> str:
        cells = [change(cell.text).strip("\n") for cell in self.cells if cell.kind == kind]
        return "\n\n\n".join(cells) + "\n"

    def _student_cell(self, index: int, cell: Cell) -> NotebookNode:
        # A result cell may end with NotImplementedError; "Run All" then goes on.
        tags = {"tags": ["raises-exception"]} if cell.kind == "result" else {}
        return _notebook_cell(f"{self.name}-{index:02}", cell, cell.text, tags)

    def _nbgrader_cell(self, index: int, cell: Cell, points: dict[str, float]) -> NotebookNode:
        text = cell.text.strip("\n")
        grade: dict[str, Any] = {
            "schema_version": 3,
            "grade": False,
            "solution": False,
            "locked": True,
        }
        grade |= {"task": False, "grade_id": f"{self.name}-{index:02}"}
        if cell.kind == "module":
            to_fill_in = bool(SOLUTION.search(cell.text))
            grade |= {"solution": to_fill_in, "locked": not to_fill_in}
        elif cell.kind == "checks":
            if "check = Assignment(" in text:
                # The functions are the notebook's own here, no module's.
                text += '\n\ncheck.module = "__main__"'
            tasks = dict.fromkeys(CHECKED_TASK.findall(cell.text))
            grade |= {"grade": True, "points": sum(points[task] for task in tasks)}
            if tasks:
                text += "\n" + " + ".join(f'check.points("{task}")' for task in tasks)
        else:
            text = _standing_alone(text, self.name)
        return _notebook_cell(grade["grade_id"], cell, text, {"nbgrader": grade})


def _cells(text: str, path: Path) -> Iterator[Cell]:
    """The cells as jupytext reads them, with comments as Markdown and magics, and their lines."""
    import jupytext  # a third of a second to load, which the other modules need not

    heads = [text.count("\n", 0, head.start()) + 2 for head in HEAD.finditer(text)]
    first = HEAD.search(text)
    notebook = jupytext.reads(text[first.start() :] if first else "", fmt="py:percent")
    for cell, line in zip(notebook.cells, heads, strict=True):
        kind = "[markdown]" if cell.cell_type == "markdown" else cell.metadata.get("title", "")
        if kind not in KINDS:
            raise ValueError(f"{path}, line {line - 1}: no cell kind {kind!r}; known: {KINDS}")
        yield Cell(kind, cell.source.strip("\n") + "\n", line)


def _released(text: str) -> str:
    """Text without solutions and hidden tests."""
    return HIDDEN.sub("", SOLUTION.sub(r"\1raise NotImplementedError\n", text))


def _without_markers(text: str) -> str:
    return "".join(line for line in text.splitlines(True) if not MARKER.search(line))


def _standing_alone(text: str, name: str) -> str:
    """Notebook code for functions of the notebook itself instead of a module's."""
    imports = rf"^(import {name}|from {name}_checks import .*|%(load_ext|autoreload).*)\n?"
    return re.sub(rf"\b{name}\.(?=\w)", "", re.sub(imports, "", text, flags=re.M)).strip("\n")


def _notebook_cell(
    identifier: str, cell: Cell, text: str, metadata: dict[str, Any]
) -> NotebookNode:
    from nbformat.v4 import new_code_cell, new_markdown_cell

    new = new_markdown_cell if cell.kind == "[markdown]" else new_code_cell
    return new(text.strip("\n"), id=identifier, metadata=metadata)


def _notebook(cells: Iterable[NotebookNode]) -> str:
    import nbformat
    from nbformat.v4 import new_notebook

    return nbformat.writes(new_notebook(cells=list(cells), metadata=METADATA)) + "\n"
