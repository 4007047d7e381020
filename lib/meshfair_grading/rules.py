"""Which imports and calls an assignment allows, read from the source without running it.

This finds honest mistakes and names their lines. What a forbidden library has
given costs the functions that use it, and nothing else: at the top of a file it
is left out. `if __name__ == "__main__":` never runs, so nothing in it counts.
"""

import ast
import dis
import importlib.util
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from importlib.abc import MetaPathFinder
from types import CodeType, ModuleType
from typing import TypeGuard

from meshfair_grading.answers import Failure

# Python's own modules hold no answers.
ALWAYS_ALLOWED = (*sys.stdlib_module_names, "matplotlib")
# Libraries with the answers inside.
MESH_LIBRARIES = (
    "gpytoolbox", "igl", "meshio", "open3d", "pmp", "polyscope", "potpourri3d", "pymeshlab",
    "pyvista", "robust_laplacian", "trimesh", "vtk",
)  # fmt: skip
NOT_RUN = ("__name__ == '__main__'", "'__main__' == __name__", "TYPE_CHECKING",
           "typing.TYPE_CHECKING")  # fmt: skip
Function = ast.FunctionDef | ast.AsyncFunctionDef


@dataclass(frozen=True)
class Rules:
    """What a submission may use."""

    allowed: tuple[str, ...] = ("numpy", "scipy")
    """Modules that may be imported, beside Python's own."""
    forbidden: tuple[str, ...] = ()
    """Functions and methods of libraries that may not be used, such as ``inv``."""
    blocked: tuple[str, ...] = ("meshfair",)
    """Modules that the student's process cannot import, beside all mesh libraries."""


@dataclass(frozen=True)
class Violation:
    """One line that the rules forbid."""

    function: str
    """Top-level function in which it stands; empty outside all functions."""
    line: int
    what: str


@dataclass
class Reading:
    """What the rules make of a source file."""

    statements: list[ast.stmt]
    """The top level: what may be run."""
    failures: dict[str, Failure] = field(default_factory=dict)
    """By function: why it cannot be asked."""
    remarks: list[str] = field(default_factory=list)
    """What was left out, a sentence each."""
    calls: dict[str, list[str]] = field(default_factory=dict)
    """By function: the functions of the file that it names."""


def read(source: str | bytes, rules: Rules) -> Reading:
    """Apply the rules to a source file.

    Parameters
    ----------
    source : str or bytes
        Python source.
    rules : Rules

    Returns
    -------
    Reading

    Raises
    ------
    SyntaxError, ValueError
        Not Python, or not in the encoding that it declares (UTF-8 by default).
    """
    tree = ast.parse(source)
    lines, library = _lines(source), _Library(tree, rules)
    reading = Reading([])
    functions = {node.name for node in tree.body if isinstance(node, Function)}
    tainted: dict[str, Failure] = {}  # names that hang on something forbidden
    for statement in _one_by_one(tree.body):
        names = _names(statement)
        hanging = [tainted[name] for name in names.loaded if name in tainted]
        broken = [
            Failure("not allowed", found.what, found.line, lines[found.line - 1].strip())
            for found in _violations_in(statement, library)
        ]
        failure = next(iter(broken + hanging), None)
        kept = failure is None or isinstance(statement, ast.Try)  # which copes with what is missing
        if isinstance(statement, Function):
            kept = names.at_once.isdisjoint(tainted)
            reading.calls[statement.name] = sorted(names.loaded & functions - {statement.name})
            reading.failures.pop(statement.name, None)  # the last definition of a name counts
            if failure:
                reading.failures[statement.name] = failure
        elif failure and not kept:
            code = lines[statement.lineno - 1].strip()
            if isinstance(statement, ast.Import | ast.ImportFrom):
                code = ast.unparse(statement)
            reading.remarks.append(
                f"Line {statement.lineno}, `{code}`, was left out: the assignment does not allow "
                f"{failure.message}. Only functions that need it lose points."
            )
        if kept:
            reading.statements.append(statement)
        for name in names.bound:
            tainted.pop(name, None)
            if failure and not kept:
                tainted[name] = failure
    return reading


def _one_by_one(statements: Iterable[ast.stmt]) -> Iterator[ast.stmt]:
    """The statements that run, an import of several modules as several imports."""
    for statement in statements:
        match statement:
            case ast.If(orelse=orelse) if _never(statement):
                yield from _one_by_one(orelse)
            case ast.Import(names=names):
                yield from (ast.copy_location(ast.Import([name]), statement) for name in names)
            case ast.ImportFrom(module=module, names=names, level=level):
                for name in names:
                    yield ast.copy_location(ast.ImportFrom(module, [name], level), statement)
            case _:
                yield statement


def _lines(source: str | bytes) -> list[str]:
    """The lines as Python counts them."""
    if isinstance(source, bytes):
        source = importlib.util.decode_source(source)
    return source.replace("\r\n", "\n").replace("\r", "\n").split("\n")


@dataclass(frozen=True)
class _Names:
    """The global names of a statement."""

    loaded: set[str]
    """Used in it, functions inside included."""
    at_once: set[str]
    """Used when the statement runs: by a function's decorators and defaults, not its body."""
    bound: set[str]


def _names(statement: ast.stmt) -> _Names:
    """Ask the compiler, which knows what is local."""
    found = _Names(set(), set(), set())
    codes = [compile(ast.Module([statement], []), "<statement>", "exec", dont_inherit=True)]
    for place, code in enumerate(codes):
        codes += [constant for constant in code.co_consts if isinstance(constant, CodeType)]
        for step in dis.get_instructions(code):
            name, _, kind = step.opname.partition("_")
            if name == "LOAD" and ("NAME" in kind or "GLOBAL" in kind):
                found.loaded.add(step.argval)
                found.at_once.update({step.argval} if place == 0 else ())
            elif step.opname == "STORE_GLOBAL" or (step.opname == "STORE_NAME" and place == 0):
                found.bound.add(step.argval)
    return found


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
    tree = ast.parse(source)
    library = _Library(tree, rules)
    return [found for statement in tree.body for found in _violations_in(statement, library)]


def _violations_in(statement: ast.stmt, library: "_Library") -> Iterator[Violation]:
    function = statement.name if isinstance(statement, Function) else ""
    for node in _run(statement):
        if isinstance(node, ast.stmt | ast.expr) and (what := library.forbids(node)):
            yield Violation(function, node.lineno, what)


def _run(statement: ast.stmt) -> Iterator[ast.AST]:
    """A statement and all below it, without blocks that never run."""
    waiting: list[ast.AST] = [statement]
    while waiting:
        node = waiting.pop()
        yield node
        below = node.orelse if _never(node) else ast.iter_child_nodes(node)
        waiting += reversed(list(below))


def _never(node: ast.AST) -> TypeGuard[ast.If]:
    """Whether a node is an `if` whose first block never runs, such as that of ``__main__``."""
    if not isinstance(node, ast.If) or isinstance(node.test, ast.BinOp | ast.BoolOp):
        return False
    return ast.unparse(node.test) in NOT_RUN


class _Library:
    """Tells the libraries' own names from those that the file gives to something of its own."""

    def __init__(self, tree: ast.Module, rules: Rules) -> None:
        self.rules = rules
        nodes = list(ast.walk(tree))
        imports = [n for n in nodes if isinstance(n, ast.Import | ast.ImportFrom)]
        self.modules = {
            (alias.asname or alias.name).partition(".")[0] for n in imports for alias in n.names
        }
        self.star = "*" in self.modules
        self.own = {n.attr for n in nodes if isinstance(n, ast.Attribute)
                    and isinstance(n.ctx, ast.Store)}  # fmt: skip
        self.own |= {n.name for n in nodes if isinstance(n, Function)}
        self.assigned = {n.id for n in nodes if isinstance(n, ast.Name)
                         and isinstance(n.ctx, ast.Store)}  # fmt: skip
        self.assigned |= self.own | {n.arg for n in nodes if isinstance(n, ast.arg)}

    def forbids(self, node: ast.AST) -> str:
        """What a node uses against the rules, or nothing."""
        match node:
            case ast.Import(names=names):
                return self._imports([alias.name for alias in names])
            case ast.ImportFrom(module=module, names=names, level=level):
                # ``from meshfair import mesh`` may name a module or a function.
                return self._imports(
                    [f"{'.' * level}{module or ''}.{alias.name}" for alias in names]
                )
            case ast.Attribute(attr=name, ctx=ast.Load()) if name in self.rules.forbidden:
                library = name not in self.own or _root(node) in self.modules
                return f"the use of {name}" if library else ""
            case ast.Name(id=name, ctx=ast.Load()) if name in self.rules.forbidden and self.star:
                return "" if name in self.assigned else f"the use of {name}"
        return ""

    def _imports(self, modules: list[str]) -> str:
        allowed = (*ALWAYS_ALLOWED, *self.rules.allowed)
        outside = [module for module in modules if not within(module, allowed)]
        called = [m for m in modules if m.rpartition(".")[2] in self.rules.forbidden]
        found = outside + called
        return f"the import of {found[0].removesuffix('.*')}" if found else ""


def _root(node: ast.expr) -> str:
    """The name with which a chain of attributes begins."""
    while isinstance(node, ast.Attribute):
        node = node.value
    return node.id if isinstance(node, ast.Name) else ""


def reached(calls: dict[str, list[str]], function: str) -> set[str]:
    """The functions of a file that a function calls, itself or through others.

    Parameters
    ----------
    calls : dict of str to list of str
        See `Reading.calls`.
    function : str

    Returns
    -------
    set of str
    """
    found, waiting = set(), list(calls.get(function, ()))
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting += calls.get(name, ())
    return found


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
