"""What becomes of docstrings on their way into the reference.

Their sources, written ``[MD99]_``, become citations of the report's bibliography, their formulas
are typeset (formulas.toml), and a section that is missing is a warning, which ends the build.
"""

import inspect
import re
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import public
from numpydoc.docscrape import NumpyDocString
from sphinx.application import Sphinx
from sphinx.util import logging

log = logging.getLogger(__name__)
FORMULAS = Path(__file__).with_name("formulas.toml")


def process(app: Sphinx, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Change the lines of a docstring in place, before numpydoc reads them."""
    text = "\n".join(lines)
    if name.startswith("meshfair."):
        for missing in missing_sections(obj, text):
            log.warning("%s: the docstring has no section %s", name, missing)
    text = re.sub(r"\nReferences\n-+\n(\.\. \[\w+\].*\n(   .*\n)*)+", "\n", text + "\n")
    text = re.sub(r"\[([A-Za-z]\w*)\]_", r":cite:t:`\1`", text)
    lines[:] = [without_substitutions(line) for line in typeset(text).splitlines()]


def without_substitutions(line: str) -> str:
    """A line in which |x| is a norm, not a substitution of Sphinx's."""
    if line.lstrip().startswith(">>>"):
        return line
    parts = line.split("`")
    return "`".join(part if i % 2 else part.replace("|", r"\|") for i, part in enumerate(parts))


def missing_sections(obj: Any, text: str) -> list[str]:
    """Sections that a docstring should have, beyond those that numpydoc's validation asks for."""
    if not inspect.isfunction(obj):
        return []
    there = NumpyDocString(text)
    missing = []
    if inspect.isgeneratorfunction(obj) and not there["Yields"]:
        missing.append("Yields")
    if public.raises(inspect.unwrap(obj)) and not there["Raises"]:
        missing.append("Raises")
    return missing


@cache
def formulas() -> dict[str, str]:
    """TeX for each formula, by the plain text that docstrings have."""
    with open(FORMULAS, "rb") as file:
        return {entry["plain"]: entry["tex"] for entry in tomllib.load(file)["formula"]}


def typeset(text: str, form: str = ":math:`{}`") -> str:
    """Docstring text with each known formula as TeX, also where it goes on in the next line."""
    for plain, tex in formulas().items():
        words = r"\s+".join(map(re.escape, plain.split()))
        text = re.sub(rf"(?<![\w`]){words}(?![\w`])", lambda _, t=tex: form.format(t), text)
    return text


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.connect("autodoc-process-docstring", process, priority=400)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
