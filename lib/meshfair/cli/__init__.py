"""The command ``meshfair``: one module for each subcommand, of this package or of another.

A subcommand's module has a docstring (its help), ``add_arguments(parser)``
and ``run(options)``, which returns the exit code. What a module needs beyond
argparse it imports in ``run``, so that ``--help`` is quick.
"""

import argparse
import io
import os
import sys
import warnings
from collections.abc import Callable, Sequence
from importlib import import_module
from importlib.metadata import entry_points
from types import ModuleType

from meshfair import __version__
from meshfair.checks import NotInstalledError

COMMANDS = ("info", "repair", "noise", "denoise", "compare", "sweep", "doctor")
# Other packages bring further ones as entry points of this group.
GROUP = "meshfair.commands"
TRACEBACK_VARIABLE = "MESHFAIR_TRACEBACK"

EXIT_CODES = """\
exit codes:
  0    done
  1    an error, in one line on standard error
  2    wrong usage
  70   an error of meshfair itself
  130  interrupted
  141  whoever read the output went away
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a subcommand and return its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        The words after ``meshfair``; the process's own by default.

    Returns
    -------
    int
        See `EXIT_CODES`. With the environment variable MESHFAIR_TRACEBACK
        set, errors are raised instead.
    """
    name = "meshfair"
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a file's name may hold anything
    try:
        options, run = _parse(arguments)
        name = f"meshfair {options.command}"
        with warnings.catch_warnings():
            warnings.simplefilter("default", UserWarning)  # the package's own, each once
            warnings.showwarning = lambda message, *_, **__: _report(f"{name}: warning: {message}")
            code = run(options) or 0
        sys.stdout.flush()  # so that a closed pipe shows here
        return code
    except BrokenPipeError:
        # Nobody is left to read it; Python's own flush at the end must not fail again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except KeyboardInterrupt:
        _report(f"{name}: interrupted")
        return 130
    except Exception as error:
        if os.environ.get(TRACEBACK_VARIABLE):
            raise
        return _explain(name, error)


def _modules() -> dict[str, ModuleType]:
    """The modules of all subcommands by name."""
    modules = {name: import_module(f"meshfair.cli.{name}") for name in COMMANDS}
    return modules | {entry.name: entry.load() for entry in entry_points(group=GROUP)}


def _parse(
    arguments: Sequence[str] | None,
) -> tuple[argparse.Namespace, Callable[[argparse.Namespace], int]]:
    """The options, and the function that runs the subcommand."""
    parser = argparse.ArgumentParser(
        prog="meshfair",
        description="Denoise triangulated meshes.",
        epilog=EXIT_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"meshfair {__version__}")
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    modules = _modules()
    for name, module in modules.items():
        summary, _, details = (module.__doc__ or "").partition("\n")
        subparser = subparsers.add_parser(
            name,
            help=summary,
            description=f"{summary}\n{details}",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        module.add_arguments(subparser)
    try:
        options = parser.parse_args(arguments)
    except SystemExit:
        sys.stdout.flush()  # help, too, can meet a closed pipe
        raise
    return options, modules[options.command].run


def _explain(name: str, error: Exception) -> int:
    """Say in one line what went wrong; return the exit code."""
    if isinstance(error, MemoryError):
        _report(f"{name}: not enough memory; use a smaller mesh or free some")
        return 1
    if isinstance(error, NotInstalledError):
        _report(f"{name}: {error}")
        return 1
    if isinstance(error, ModuleNotFoundError) and not (error.name or "").startswith("meshfair."):
        _report(f"{name}: this needs {error.name}, which is not installed; see meshfair doctor")
        return 1
    if isinstance(error, (ValueError, ArithmeticError, OSError)):  # the package's own are of these
        _report(f"{name}: {error}")
        return 1
    _report(
        f"{name}: {type(error).__name__}: {error}. This is an error of meshfair; please report it "
        f"with what {TRACEBACK_VARIABLE}=1 shows"
    )
    return 70


def _report(message: str) -> None:
    """Print one line on standard error, whatever the message holds."""
    print(" ".join(str(message).split()), file=sys.stderr)
