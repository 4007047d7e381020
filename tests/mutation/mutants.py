"""Small errors, one at a time, in the formulas of a module.

Of a syntax tree everything that computes is changed: operators, comparisons, numbers, bounds of
slices, functions that have a twin (maximum and minimum), functions and transposes that can be left
out, conditions, statements that can be left out. What computes nothing stays: texts, annotations,
imports, decorators, what is raised or warned of, and the dispatch to compiled loops, either branch
of which is right. So do two kinds of numbers that are a choice and no formula: a parameter's
default value, and one below 1e-5, a tolerance.
"""

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from types import CodeType


@dataclass
class Mutant:
    """One error in one module."""

    line: int
    change: str
    function: range
    """Lines of the function or the method in which it lies; of the module outside of any."""
    code: CodeType


TWINS_OF_OPERATORS: dict[type, list[type]] = {
    ast.Add: [ast.Sub],
    ast.Sub: [ast.Add],
    ast.Mult: [ast.Div],
    ast.Div: [ast.Mult],
    ast.Pow: [ast.Mult],
    ast.FloorDiv: [ast.Div],
    ast.Mod: [ast.Mult],
    ast.MatMult: [ast.Mult],
    ast.BitAnd: [ast.BitOr],
    ast.BitOr: [ast.BitAnd],
    ast.BitXor: [ast.BitAnd],
    ast.And: [ast.Or],
    ast.Or: [ast.And],
    ast.Lt: [ast.LtE, ast.GtE],
    ast.LtE: [ast.Lt, ast.Gt],
    ast.Gt: [ast.GtE, ast.LtE],
    ast.GtE: [ast.Gt, ast.Lt],
    ast.Eq: [ast.NotEq],
    ast.NotEq: [ast.Eq],
    ast.Is: [ast.IsNot],
    ast.IsNot: [ast.Is],
    ast.In: [ast.NotIn],
    ast.NotIn: [ast.In],
}
_PAIRS = (
    "maximum minimum, max min, argmax argmin, any all, ones zeros, ones_like zeros_like, sin cos, "
    "ceil floor, sqrt square, log10 log, degrees radians, logical_and logical_or"
)
TWINS_OF_FUNCTIONS = {
    name: twin
    for pair in (pair.split() for pair in _PAIRS.split(", "))
    for name, twin in (pair, reversed(pair))
}
LEFT_OUT = {"abs", "copy", "ceil", "exp", "floor", "log", "log10", "round", "sqrt", "square"}
"""Functions and methods that can be left out: f(x) becomes x, and x.f() does, too."""
NO_FORMULA = {"stacklevel", "strict"}
"""Keywords whose values compute nothing."""
TOLERANCE = 1e-5


def mutants(source: str, file: str) -> list[Mutant]:
    """Every mutant of a module's source, each of them once."""
    tree = ast.parse(source)
    whole = range(1, source.count("\n") + 2)
    found = {}
    for holder, field, index, node, function in _places(tree, whole):
        for other in _variants(node, holder):
            ast.copy_location(other, node)
            _put(holder, field, index, other)
            text = ast.unparse(tree)
            if text not in found:
                code = compile(ast.fix_missing_locations(tree), file, "exec")
                change = f"{_short(node)}  ->  {_short(other)}"
                line = source.splitlines()[node.lineno - 1].strip()
                found[text] = Mutant(node.lineno, f"{change}  in  {line}", function, code)
            _put(holder, field, index, node)
    return sorted(found.values(), key=lambda mutant: mutant.line)


def _short(node: ast.AST) -> str:
    text = ast.unparse(node).partition("\n")[0]
    return text if len(text) <= 60 else text[:57] + "..."


def _put(holder: ast.AST, field: str, index: int | None, node: ast.AST) -> None:
    if index is None:
        setattr(holder, field, node)
    else:
        getattr(holder, field)[index] = node


Place = tuple[ast.AST, str, int | None, ast.AST, range]


def _places(holder: ast.AST, function: range) -> Iterator[Place]:
    """Each node that computes something, with where it hangs in the tree."""
    for field, value in ast.iter_fields(holder):
        for index, node in enumerate(value if isinstance(value, list) else [value]):
            if not isinstance(node, ast.AST) or _computes_nothing(holder, field, node):
                continue
            inside = function
            if isinstance(node, ast.FunctionDef) and isinstance(holder, ast.Module | ast.ClassDef):
                first = min([node.lineno, *(line.lineno for line in node.decorator_list)])
                inside = range(first, node.end_lineno + 1)
            if hasattr(node, "lineno"):
                yield holder, field, index if isinstance(value, list) else None, node, inside
            if not _is(node, "warn"):
                yield from _places(node, inside)


def _computes_nothing(holder: ast.AST, field: str, node: ast.AST) -> bool:
    if isinstance(node, ast.Import | ast.ImportFrom | ast.Raise | ast.JoinedStr | ast.arguments):
        return True
    if field in ("annotation", "returns", "decorator_list", "bases"):
        return True
    if isinstance(holder, ast.ClassDef) and isinstance(node, ast.AnnAssign):
        return True  # a default value
    if isinstance(holder, ast.If) and field in ("test", "body") and _dispatches(holder):
        return True
    if isinstance(node, ast.keyword) and node.arg in NO_FORMULA:
        return True
    if isinstance(node, ast.stmt) and not hasattr(node, "body"):
        return _names(node, "_fast") or _names(node, "__all__")
    return False


def _dispatches(node: ast.If) -> bool:
    return any(_names(part, "_fast") for part in [node.test, *node.body])


def _names(node: ast.AST, name: str) -> bool:
    return any(isinstance(part, ast.Name) and part.id == name for part in ast.walk(node))


def _is(node: ast.AST, name: str) -> bool:
    """Whether it is a call of a function or a method of this name."""
    return isinstance(node, ast.Call) and _called(node) == name


def _called(call: ast.Call) -> str:
    return getattr(call.func, "attr", None) or getattr(call.func, "id", "")


def _variants(node: ast.AST, holder: ast.AST) -> Iterator[ast.AST]:
    """What may stand in a node's place."""
    match node:
        case ast.BinOp(left, op, right):
            for twin in TWINS_OF_OPERATORS.get(type(op), []):
                yield ast.BinOp(left, twin(), right)
        case ast.AugAssign(target, op, value):
            for twin in TWINS_OF_OPERATORS.get(type(op), []):
                yield ast.AugAssign(target, twin(), value)
            yield ast.Pass()
        case ast.BoolOp(op, values):
            yield ast.BoolOp(TWINS_OF_OPERATORS[type(op)][0](), values)
            if len(values) > 2:
                for left_out in values:
                    yield ast.BoolOp(op, [value for value in values if value is not left_out])
            else:
                yield from values
        case ast.Compare(left, [op], right):
            for twin in TWINS_OF_OPERATORS[type(op)]:
                yield ast.Compare(left, [twin()], right)
        case ast.UnaryOp(ast.USub() | ast.Not() | ast.Invert(), operand):
            yield operand
        case ast.Constant(bool() as value):
            yield ast.Constant(not value)
        case ast.Constant(0 | 1 as value) if getattr(holder, "arg", "") == "axis":
            yield ast.Constant(1 - value)
        case ast.Constant(int() as value):
            yield ast.Constant(value + 1)
        case ast.Constant(float() as value) if value == 0 or abs(value) >= TOLERANCE:
            yield ast.Constant(2 * value or 1.0)
        case ast.Slice(lower, upper, step):
            if lower is not None:
                yield ast.Slice(None, upper, step)
            if upper is not None:
                yield ast.Slice(lower, None, step)
        case ast.Attribute(value, "T", ast.Load()):
            yield value
        case ast.Call():
            yield from _variants_of_call(node)
            checks = _called(node).startswith("check_") and node.args
            if checks and ast.Pass not in map(type, _variants(holder, node)):
                yield node.args[0]
        case ast.If(test, body, orelse) if _can_be_negated(test) and not _dispatches(node):
            yield ast.If(ast.UnaryOp(ast.Not(), test), body, orelse)
        case ast.While(test, body, orelse) if _can_be_negated(test):
            yield ast.While(ast.UnaryOp(ast.Not(), test), body, orelse)
        case ast.IfExp(test, body, orelse) if _can_be_negated(test):
            yield ast.IfExp(test, orelse, body)
        case ast.Break():
            yield ast.Continue()
        case ast.Continue():
            yield ast.Break()
        case ast.Expr(value) if not isinstance(value, ast.Constant):
            yield ast.Pass()
        case ast.Assign(targets, value) if _can_be_left_out(targets, value):
            yield ast.Pass()


def _variants_of_call(call: ast.Call) -> Iterator[ast.AST]:
    name = _called(call)
    method = isinstance(call.func, ast.Attribute) and not _names(call.func.value, "np")
    if name in TWINS_OF_FUNCTIONS:
        twin = TWINS_OF_FUNCTIONS[name]
        if isinstance(call.func, ast.Attribute):
            function: ast.expr = ast.Attribute(call.func.value, twin, ast.Load())
        else:
            function = ast.Name(twin, ast.Load())
        yield ast.Call(ast.copy_location(function, call), call.args, call.keywords)
    if name in LEFT_OUT and method and not call.args:
        yield call.func.value
    elif name in LEFT_OUT and not method and call.args:
        yield call.args[0]


def _can_be_negated(test: ast.expr) -> bool:
    """Not where its comparison or its ``not`` is changed to the same effect."""
    return not isinstance(test, ast.Compare | ast.UnaryOp)


def _can_be_left_out(targets: list[ast.expr], value: ast.expr) -> bool:
    """Entries and attributes, and names that have a value before."""
    names = [part for target in targets for part in ast.walk(target)]
    if any(isinstance(part, ast.Subscript | ast.Attribute) for part in names):
        return True
    return all(_names(value, part.id) for part in names if isinstance(part, ast.Name))
