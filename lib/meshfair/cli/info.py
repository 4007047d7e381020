"""Say what a mesh is, what is wrong with it, and which methods that affects."""

import argparse

from meshfair.cli import files, printing


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the subcommand's arguments."""
    files.add_input(parser)
    files.add_reading(parser)
    files.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Read, inspect, print.

    Returns
    -------
    int
        0, whatever was found: the findings are the answer.
    """
    from meshfair import mesh

    inspection = mesh.inspect(*files.read(options.file, options))
    if options.json:
        printing.print_json({"file": str(options.file)} | inspection.as_dict())
    else:
        print(options.file)
        print(inspection)
    return 0
