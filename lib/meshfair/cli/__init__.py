"""The command ``meshfair``: one module for each subcommand, of this package or of another.

A subcommand's module has a docstring (its help), ``add_arguments(parser)``
and ``run(options)``, which returns the exit code. What a module needs beyond
argparse it imports in ``run``, so that ``--help`` is quick. Where Python calls a parameter by
another name than the option, the option's ``dest`` is that name: messages then name the option.
"""

import argparse
import io
import os
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from importlib.metadata import entry_points
from types import ModuleType

from meshfair import __version__
from meshfair.cli import printing
from meshfair.cli.messages import Messages
from meshfair.cli.parser import Parser

COMMANDS = ("info", "repair", "noise", "denoise", "compare", "view", "sweep", "doctor")
# Other packages bring further ones as entry points of this group.
GROUP = "meshfair.commands"

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
    messages = Messages("meshfair", {})
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a file's name may hold anything
    try:
        options, run = _parse(arguments)
        messages = options.messages
        with messages.warnings():
            code = run(options) or 0
        sys.stdout.flush()  # so that a closed pipe shows here
        return code
    except BrokenPipeError:
        # Nobody is left to read it; Python's own flush at the end must not fail again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except KeyboardInterrupt as interrupt:
        messages.say(" ".join(["interrupted", *map(str, interrupt.args)]))
        return 130
    except Exception as error:
        message, code = messages.explained(error)
        messages.say(message)
        return code


def _modules() -> dict[str, ModuleType]:
    """The modules of all subcommands by name."""
    modules = {name: import_module(f"meshfair.cli.{name}") for name in COMMANDS}
    return modules | {entry.name: entry.load() for entry in entry_points(group=GROUP)}


def _laid_out(paragraph: str) -> str:
    """A paragraph in lines of the terminal's width; what is indented, to be copied, as it is."""
    return paragraph if paragraph.startswith(" ") else printing.wrapped(" ".join(paragraph.split()))


def _parse(
    arguments: Sequence[str] | None,
) -> tuple[argparse.Namespace, Callable[[argparse.Namespace], int]]:
    """The options, and the function that runs the subcommand."""
    parser = Parser(prog="meshfair", description="Denoise triangulated meshes.", epilog=EXIT_CODES)
    parser.add_argument("--version", action="version", version=f"meshfair {__version__}")
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    modules = _modules()
    for name, module in modules.items():
        paragraphs = (module.__doc__ or "").strip().split("\n\n")
        subparser = subparsers.add_parser(
            name,
            help=paragraphs[0],
            description="\n\n".join(map(_laid_out, paragraphs)),
        )
        module.add_arguments(subparser)
        messages = Messages(f"meshfair {name}", subparser.option_of)
        subparser.set_defaults(messages=messages, wrong_usage=subparser.error)
    try:
        options = parser.parse_args(arguments)
    except SystemExit:
        sys.stdout.flush()  # help, too, can meet a closed pipe
        raise
    return options, modules[options.command].run
