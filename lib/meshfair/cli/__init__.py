"""The command ``meshfair``: one module of this package for each subcommand.

A subcommand's module has a docstring (its help), ``add_arguments(parser)``
and ``run(arguments)``, which returns the exit code. What a module needs
beyond argparse it imports in ``run``, so that ``--help`` is quick.
"""

import argparse
import sys
from importlib import import_module

from meshfair import __version__

COMMANDS = ("grade",)


def main(arguments=None):
    """Run a subcommand and return its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        The words after ``meshfair``; the process's own by default.

    Returns
    -------
    int
        0 for success, 1 for an error (one line on standard error), 2 for
        wrong usage, 130 where the user interrupted.
    """
    parser = argparse.ArgumentParser(prog="meshfair", description="Denoise triangulated meshes.")
    parser.add_argument("--version", action="version", version=f"meshfair {__version__}")
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    modules = {name: import_module(f"meshfair.cli.{name}") for name in COMMANDS}
    for name, module in modules.items():
        summary = module.__doc__.partition("\n")[0]
        module.add_arguments(subparsers.add_parser(name, help=summary, description=module.__doc__))
    options = parser.parse_args(arguments)
    try:
        return modules[options.command].run(options) or 0
    except (ValueError, OSError) as error:  # MeshError is a ValueError
        print(f"meshfair {options.command}: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print(f"meshfair {options.command}: interrupted", file=sys.stderr)
        return 130
