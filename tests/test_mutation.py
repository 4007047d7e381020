"""What `make mutate` plants: errors, each once, and only in what computes something."""

import ast
from pathlib import Path

from mutation.mutants import mutants

SOURCE = '''
"""A module's text."""
from numpy import pi
__all__ = ["f"]
SMALL = 1e-9

def f(V: "2", n: int = 3) -> "4":
    """Texts stay."""
    V = check_vertices(V)
    if _fast.wanted(len(V)):
        return _fast.f(V + 1)
    if not n < 2:
        raise ValueError(f"n is {n + 1}" + "; give another")
    warnings.warn("now " + "this", stacklevel=3)
    return abs(V[1:]) / 2
'''


def changes(source):
    return [mutant.change.partition("  in  ")[0] for mutant in mutants(source, "f.py")]


def test_every_error_in_what_computes_something_and_no_other():
    assert sorted(changes(SOURCE)) == sorted(
        [
            "V = check_vertices(V)  ->  pass",
            "not n < 2  ->  n < 2",
            "n < 2  ->  n <= 2",
            "n < 2  ->  n >= 2",
            "2  ->  3",
            "warnings.warn('now ' + 'this', stacklevel=3)  ->  pass",
            "abs(V[1:]) / 2  ->  abs(V[1:]) * 2",
            "abs(V[1:])  ->  V[1:]",
            "1:  ->  :",
            "1  ->  2",
            "2  ->  3",
        ]
    )


def test_the_code_is_that_of_the_change():
    source = "def f(a, b):\n    return a * b + 1\n"
    results = set()
    for mutant in mutants(source, "f.py"):
        names = {}
        exec(mutant.code, names)
        results.add((mutant.line, names["f"](6, 3)))
        assert mutant.function == range(1, 3)
    assert results == {(2, 6 / 3 + 1), (2, 6 * 3 - 1), (2, 6 * 3 + 2)}


def test_each_mutant_once_and_the_tree_is_put_back():
    source = Path(ast.__file__).with_name("bisect.py").read_text(encoding="utf-8")
    found = mutants(source, "bisect.py")
    assert len(found) > 30
    assert len({mutant.code for mutant in found}) == len(found)
