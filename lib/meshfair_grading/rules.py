"""Which imports and calls an assignment allows, read from the source without running it.

This finds honest mistakes and names their lines. The modules that hold the
answers are blocked in the student's process as well, see `ImportBlocker`.
"""

import ast
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from importlib.abc import MetaPathFinder
from types import ModuleType

from meshfair_grading.answers import Failure

ALWAYS_ALLOWED = (
    "__future__", "collections", "copy", "dataclasses", "enum", "functools", "itertools", "math",
    "matplotlib", "numbers", "operator", "random", "sys", "time", "typing", "warnings",
)  # fmt: skip
# Libraries with the answers inside.
MESH_LIBRARIES = (
    "gpytoolbox", "igl", "meshio", "open3d", "pmp", "polyscope", "potpourri3d", "pymeshlab",
    "pyvista", "robust_laplacian", "trimesh", "vtk",
)  # fmt: skip


@dataclass(frozen=True)
class Rules:
    """What a submission may use."""

    allowed: tuple[str, ...] = ("numpy", "scipy")
    """Modules that may be imported, beside a few of the standard library."""
    forbidden: tuple[str, ...] = ()
    """Names that may not be called or used, such as ``inv``."""
    blocked: tuple[str, ...] = ("meshfair",)
    """Modules that the student's process cannot import, beside all mesh libraries."""


@dataclass(frozen=True)
class Violation:
    """One line that the rules forbid."""

    function: str
    """Top-level function in which it stands; empty outside all functions."""
    line: int
    what: str


def violations(source: str | bytes, rules: Rules) -> list[Violation]:
    """Lines of a source file that break the rules.

    Parameters
    ----------
    source : str or bytes
        Python source.
    rules : Rules

    Returns
    -------
    list of Violation

    Raises
    ------
    SyntaxError, ValueError
        Not Python, or not in the encoding that it declares (UTF-8 by default).
    """
    found = []
    for statement in ast.parse(source).body:
        function = ""
        if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef):
            function = statement.name
        for node in ast.walk(statement):
            if isinstance(node, ast.stmt | ast.expr) and (what := _forbidden(node, rules)):
                found.append(Violation(function, node.lineno, what))
    return found


def _forbidden(node: ast.AST, rules: Rules) -> str:
    match node:
        case ast.Import(names=names):
            modules = [alias.name for alias in names]
        case ast.ImportFrom(module=module, names=names, level=level):
            # ``from meshfair import mesh`` may name a module or a function.
            modules = [f"{'.' * level}{module or ''}.{alias.name}" for alias in names]
        case ast.Name(id=name) | ast.Attribute(attr=name):
            return f"the use of {name}" if name in rules.forbidden else ""
        case _:
            return ""
    allowed = (*ALWAYS_ALLOWED, *rules.allowed)
    outside = [module for module in modules if not within(module, allowed)]
    called = [m for m in modules if m.rpartition(".")[2] in rules.forbidden]
    return f"the import of {(outside + called)[0]}" if outside or called else ""


def broken_rules(source: str | bytes, rules: Rules) -> dict[str, Failure]:
    """The failures of functions in which a source file breaks the rules.

    Parameters
    ----------
    source : str or bytes
    rules : Rules

    Returns
    -------
    dict of str to Failure
        By function; the key "" is for the whole file.
    """
    lines = source.decode().splitlines() if isinstance(source, bytes) else source.splitlines()
    return {
        found.function: Failure(
            "not allowed", found.what, found.line, lines[found.line - 1].strip()
        )
        for found in reversed(violations(source, rules))  # so that the first one stays
    }


def within(module: str, packages: Iterable[str]) -> bool:
    """Whether a dotted name is one of the packages or lies in one."""
    return any(module == package or module.startswith(f"{package}.") for package in packages)


class ImportBlocker(MetaPathFinder):
    """Import hook that blocks the modules which hold the answers.

    Parameters
    ----------
    rules : Rules
    """

    def __init__(self, rules: Rules) -> None:
        self.blocked = (*rules.blocked, *MESH_LIBRARIES)

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> None:
        """Raise for a blocked module; leave every other to the usual finders."""
        if within(fullname, self.blocked):
            raise ImportError(f"{fullname} is not available to submissions of this assignment")
