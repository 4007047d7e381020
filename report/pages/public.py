"""What the package makes public, and which notebooks use it."""

import ast
import importlib
import inspect
import json
import textwrap
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import meshfair

# The command has a page of its own.
MODULES = [name for name in meshfair._PUBLIC if name != "cli"]


def module(name: str) -> ModuleType:
    """A module of the package by its short name."""
    return importlib.import_module(f"meshfair.{name}")


def members(name: str) -> dict[str, Any]:
    """The public functions and classes of a module, by name, in the order of its source."""
    found = module(name)
    listed = getattr(found, "__all__", None)
    if listed is None:
        listed = [
            key
            for key, value in vars(found).items()
            if not key.startswith("_") and getattr(value, "__module__", None) == found.__name__
        ]
    values = {key: getattr(found, key) for key in listed}
    return {k: v for k, v in values.items() if inspect.isfunction(v) or inspect.isclass(v)}


def described_by_fields() -> Iterator[str]:
    """Full names of records (and of their fields), and of widgets that take traits."""
    for name in MODULES:
        for key, value in members(name).items():
            fields = getattr(value, "_fields", getattr(value, "__dataclass_fields__", ()))
            if fields or hasattr(value, "class_trait_names"):
                yield f"meshfair.{name}.{key}"
            yield from (f"meshfair.{name}.{key}.{field}" for field in fields)


def raises(function: Any) -> bool:
    """Whether a function refuses arguments itself: by ``raise``, or by one of the checks."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    for node in ast.walk(tree):
        if isinstance(node, ast.Raise) and node.exc is not None:
            return True
        if isinstance(node, ast.Call) and getattr(node.func, "id", "").startswith("check_"):
            return True
    return False


def uses(notebook: Path) -> set[str]:
    """Names of ``meshfair``, such as ``weights.cotangent``, that a notebook's code uses."""
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    code = "\n".join("".join(c["source"]) for c in cells if c["cell_type"] == "code")
    tree = ast.parse("\n".join(line for line in code.splitlines() if not line.startswith("%")))
    names = {}  # in the notebook -> in the package
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "meshfair":
            inside = (node.module or "").removeprefix("meshfair").strip(".")
            for alias in node.names:
                full = f"{inside}.{alias.name}".strip(".")
                names[alias.asname or alias.name] = full
    return {full for full in _spelled(tree, names) if full}


def _spelled(tree: ast.AST, names: dict[str, str]) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and node.id in names:
            yield names[node.id]
        if isinstance(node, ast.Attribute) and getattr(node.value, "id", None) in names:
            yield f"{names[node.value.id]}.{node.attr}"
