"""An instructor's file, and the files for students that are made from it.

The file is Python in the percent format (jupytext's): cells that begin with a
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

import hashlib
import json
import re
import types
from dataclasses import dataclass
from pathlib import Path

KINDS = ("[markdown]", "", "result", "module", "checks")
HEAD = re.compile(r"^# %%[ ]*(.*?)[ ]*$")
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
    cells: tuple
    digest: str
    """Fingerprint of the file's bytes."""

    @classmethod
    def read(cls, path):
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

    def load(self):
        """Run the checks, hidden ones included.

        Returns
        -------
        meshfair_grading.assignment.Assignment
            The object that the checks call ``check``.
        """
        return self._run("checks", f"{self.name}_checks").check

    def solution(self):
        """The student's file as the instructor would hand it in.

        Returns
        -------
        str
        """
        return self._text("module", _without_markers)

    def stub(self):
        """The student's file as it is handed out.

        Returns
        -------
        str
        """
        return self._text("module", _released)

    def student_files(self):
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

    def nbgrader_notebook(self):
        """The file as a source notebook of nbgrader: everything in its cells.

        Students then write into the notebook, not into a file of their own;
        hidden tests and partial credit work as nbgrader's.

        Returns
        -------
        str
        """
        points = self.load().tasks
        cells = [self._nbgrader_cell(place, cell, points) for place, cell in enumerate(self.cells)]
        return _notebook(cells)

    def _text(self, kind, change):
        cells = [change(cell.text).strip("\n") for cell in self.cells if cell.kind == kind]
        return "\n\n\n".join(cells) + "\n"

    def _run(self, kind, name):
        """Run the cells of a kind as a module, with the file's own line numbers."""
        module = types.ModuleType(name)
        module.__file__ = str(self.path)
        for cell in self.cells:
            if cell.kind == kind:
                code = "\n" * (cell.line - 1) + cell.text
                exec(compile(code, str(self.path), "exec"), module.__dict__)
        return module

    def _student_cell(self, place, cell):
        # A result cell may end with NotImplementedError; "Run All" then goes on.
        tags = {"tags": ["raises-exception"]} if cell.kind == "result" else {}
        return _json_cell(f"{self.name}-{place:02}", cell, _notebook_text(cell), tags)

    def _nbgrader_cell(self, place, cell, points):
        text = _notebook_text(cell)
        grade = {"schema_version": 3, "grade": False, "solution": False, "locked": True}
        grade |= {"task": False, "grade_id": f"{self.name}-{place:02}"}
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
        return _json_cell(grade["grade_id"], cell, text, {"nbgrader": grade})


def _cells(text, path):
    kind, start, lines = None, 0, []
    for number, line in enumerate([*text.splitlines(), "# %% end"], 1):
        head = HEAD.match(line)
        if not head:
            lines.append(line)
            continue
        if kind is not None:
            yield Cell(kind, "\n".join(lines).strip("\n") + "\n", start)
        kind, start, lines = head[1], number + 1, []
        if kind not in (*KINDS, "end"):
            raise ValueError(f"{path}, line {number}: no cell kind {kind!r}; known: {KINDS}")


def _released(text):
    """Text without solutions and hidden tests."""
    return HIDDEN.sub("", SOLUTION.sub(r"\1raise NotImplementedError\n", text))


def _without_markers(text):
    return "".join(line for line in text.splitlines(True) if not MARKER.search(line))


def _notebook_text(cell):
    """A cell's text as it stands in a notebook: comments become Markdown and magics."""
    if cell.kind == "[markdown]":
        return "\n".join(
            line.removeprefix("#").removeprefix(" ") for line in cell.text.splitlines()
        )
    return re.sub(r"^# %(?=\w)", "%", cell.text, flags=re.M).strip("\n")


def _standing_alone(text, name):
    """Notebook code for functions of the notebook itself instead of a module's."""
    imports = rf"^(import {name}|from {name}_checks import .*|%(load_ext|autoreload).*)\n?"
    return re.sub(rf"\b{name}\.(?=\w)", "", re.sub(imports, "", text, flags=re.M)).strip("\n")


def _json_cell(identifier, cell, text, metadata):
    lines = text.splitlines(True)
    if cell.kind == "[markdown]":
        return {"cell_type": "markdown", "id": identifier, "metadata": metadata, "source": lines}
    return {
        "cell_type": "code",
        "execution_count": None,
        "id": identifier,
        "metadata": metadata,
        "outputs": [],
        "source": lines,
    }


def _notebook(cells):
    content = {"cells": cells, "metadata": METADATA, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"
