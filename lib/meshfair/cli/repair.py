"""Repair a mesh: only what is asked for is done, in the order of the options.

`meshfair info` says what is wrong. IN and OUT may be -, which is standard input or
output and needs --format.
"""

import argparse

from meshfair.cli import files, printing


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the subcommand's arguments."""
    files.add_input(parser, "in", standard=True)
    files.add_output(parser)
    parser.add_argument(
        "--weld",
        type=float,
        metavar="DISTANCE",
        help="merge vertices up to this many mean edge lengths apart; 0: in the same place",
    )
    parser.add_argument("--degenerate", action="store_true", help="drop faces without area")
    parser.add_argument("--duplicates", action="store_true", help="drop duplicate faces")
    parser.add_argument(
        "--split", action="store_true", help="cut apart non-manifold edges and vertices"
    )
    parser.add_argument(
        "--orient", choices=("consistent", "outward"), help="flip faces until they agree"
    )
    parser.add_argument(
        "--unreferenced", action="store_true", help="drop vertices that no face uses"
    )
    files.add_format(parser)
    files.add_reading(parser)
    files.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Read, repair, write, and say what was done.

    Returns
    -------
    int
        0 where the mesh was written.
    """
    from meshfair import mesh

    source = vars(options)["in"]
    files.check_standard(options, source, options.out)
    files.check_output(options.out, [source], options.force)
    V, F, attributes = files.read_whole(source, options)
    steps = ("weld", "degenerate", "duplicates", "split", "orient", "unreferenced")
    repaired = mesh.repair(V, F, **{name: getattr(options, name) for name in steps})
    files.write(options.out, repaired.V, repaired.F, attributes, [source], options)
    if options.json:
        printing.print_json(
            {
                "out": options.out,
                "vertices": len(repaired.V),
                "faces": len(repaired.F),
                "steps": [step._asdict() for step in repaired.report],
            },
            printing.beside(options.out),
        )
    else:
        lines = [step.message for step in repaired.report]
        lines = lines or ["nothing was asked for, so nothing was changed"]
        lines.append(f"{options.out}: {len(repaired.V):,} vertices, {len(repaired.F):,} faces")
        print("\n".join(lines), file=printing.beside(options.out))
    return 0
