"""A page of the reference for each module."""

import inspect
import re
from pathlib import Path

import public
from docstrings import typeset
from notebooks import title

INTRODUCTION = """# Reference

Every public function of the package, from its docstring. The modules stand in the order in which
the data flows; each builds on those before it. `V` holds vertex positions (n, 3), `F` triangles
(m, 3); the [glossary](../glossary.md) has the other names. *Source* leads to the code, *Used in* to
the notebooks of the course that call it.

| module | holds |
|---|---|
"""


def pages(course: list[Path]) -> dict[str, str]:
    """The text of each page, by its name."""
    used: dict[str, list[Path]] = {}
    for notebook in course:
        for name in public.uses(notebook):
            used.setdefault(name, []).append(notebook)
    written = {f"reference/{name}.md": page(name, used) for name in public.MODULES}
    table = "".join(f"| [{name}]({name}.md) | {first_line(name)} |\n" for name in public.MODULES)
    contents = "\n".join(public.MODULES)
    toctree = f"\n```{{toctree}}\n:hidden:\n:maxdepth: 1\n\n{contents}\n```\n"
    written["reference/index.md"] = INTRODUCTION + table + toctree
    return written


def first_line(name: str) -> str:
    """What a module is, in a line."""
    return (inspect.getdoc(public.module(name)) or "").partition("\n")[0]


def page(name: str, used: dict[str, list[Path]]) -> str:
    """The page of one module: its docstring, a table, then every function and class."""
    members = public.members(name)
    lines = [f"# {name}", "", directive("automodule", f"meshfair.{name}", no_index=True)]
    lines += ["| | |", "|---|---|"]
    for member, value in members.items():
        summary = (inspect.getdoc(value) or "").partition("\n\n")[0].replace("\n", " ")
        lines.append(f"| [`{member}`](#meshfair.{name}.{member}) | {in_table(summary)} |")
    for member, value in members.items():
        kind = "class" if inspect.isclass(value) else "function"
        lines += ["", f"## {member}", ""]
        options = {"members": True, "show_inheritance": True} if kind == "class" else {}
        lines.append(directive(f"auto{kind}", f"meshfair.{name}.{member}", **options))
        where = used.get(f"{name}.{member}", [])
        if name == "denoising":
            where = [*where, *(x for x in used.get(member, []) if x not in where)]
        if where:
            links = " · ".join(f"[{title(x)}](../notebooks/{x.name})" for x in where)
            lines += ["", "{.used-in}", f"Used in {links}"]
    return "\n".join(lines) + "\n"


def in_table(text: str) -> str:
    """A line of a docstring as Markdown in a table, without its sources."""
    text = re.sub(r"\s*\[\w+\]_", "", text)
    return typeset(text, "${}$").replace("|", "\\|").replace("``", "`")


def directive(kind: str, target: str, **options: bool) -> str:
    """A directive of autodoc, within Markdown."""
    lines = [f"   :{key.replace('_', '-')}:" for key, wanted in options.items() if wanted]
    return "\n".join(["```{eval-rst}", f".. {kind}:: {target}", *lines, "```", ""])
