"""Say what a mesh is, what is wrong with it, and which methods that affects.

FILE may be -, which is standard input and needs --format.
"""

import argparse

from meshfair.cli import files, printing


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the subcommand's arguments."""
    files.add_input(parser, standard=True)
    files.add_format(parser)
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

    files.check_standard(options, options.file)
    inspection = mesh.inspect(*files.read(options.file, options))
    words = options.messages.in_words
    if options.json:
        facts = inspection.as_dict()
        for finding in facts["findings"]:
            finding |= {name: words(finding[name]) for name in ("affects", "remedy")}
        printing.print_json({"file": str(options.file)} | facts)
    else:
        print("standard input" if options.file == files.STANDARD else options.file)
        print(inspection.as_text(words, printing.width()))
    return 0
