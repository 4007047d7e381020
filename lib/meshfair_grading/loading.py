"""Load a student's file: statement by statement, so that one that fails costs only itself."""

import __future__

import ast
import importlib.util
import sys
from pathlib import Path
from types import ModuleType

from meshfair_grading.answers import Failure, failure
from meshfair_grading.rules import Reading, Rules, read

FUTURES = [getattr(__future__, name) for name in __future__.all_feature_names]
# Remarks on what was left out: after so many the student has understood.
MOST_REMARKS = 5


def load(file: str, rules: Rules) -> tuple[ModuleType, Reading]:
    """Run a student's file, without what the rules forbid.

    A statement outside the functions that ends with an exception, such as one that
    reads a file which was not handed in, is left out with a remark.

    Parameters
    ----------
    file : str
    rules : meshfair_grading.rules.Rules

    Returns
    -------
    module : module
        With the functions that could be defined.
    reading : meshfair_grading.rules.Reading
        Why others could not, and what was left out.

    Raises
    ------
    SyntaxError, ValueError
        Not Python, or not in the encoding that it declares (UTF-8 by default).
    """
    source = Path(file).read_bytes()
    whole = compile(source, file, "exec", dont_inherit=True)
    flags = sum(future.compiler_flag & whole.co_flags for future in FUTURES)
    reading = read(source, rules)
    spec = importlib.util.spec_from_file_location(Path(file).stem, file)
    assert spec is not None  # it is a path that ends in .py
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    for statement in reading.statements:
        code = compile(ast.Module([statement], []), file, "exec", flags, dont_inherit=True)
        try:
            exec(code, module.__dict__)
        except BaseException as error:  # sys.exit() as well
            reading.remarks.append(_left_out(failure(error, file), statement.lineno))
    del reading.remarks[MOST_REMARKS:]
    return module, reading


def _left_out(why: Failure, line: int) -> str:
    inside = f" in line {why.line}" if why.line not in (0, line) else ""
    return (
        f"Line {line} stands outside all functions and was left out, because it ended with an "
        f"error{inside}, `{why.code}`: {why.message}"
    )
