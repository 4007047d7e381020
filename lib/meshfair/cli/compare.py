"""Say how far a mesh is from another one, by every metric that fits the two.

A is the mesh in question, B the ground truth that it is compared with. SNR and
normal angle need two meshes of the same faces and number of vertices.
"""

import argparse

from meshfair.cli import files, printing

UNITS = {
    "snr": "dB",
    "normal_angle": "degrees",
    "surface_distance": "mean edge lengths",
    "hausdorff": "mean edge lengths",
    "volume_change": "of B's volume",
    "area_change": "of B's area",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the subcommand's arguments."""
    files.add_input(parser, "a", "the noisy or denoised mesh")
    files.add_input(parser, "b", "the ground truth")
    files.add_reading(parser)
    files.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Read both, compare, print.

    Returns
    -------
    int
        0, whatever the difference is.
    """
    from meshfair import metrics

    V, F = files.read(options.a, options)
    V_true, F_true = files.read(options.b, options)
    found = metrics.compare(V, F, V_true, F_true)
    if options.json:
        printing.print_json(found)
    else:
        printing.print_table(
            (name, "cannot be compared" if value is None else f"{value:.6g} {UNITS[name]}")
            for name, value in found.items()
        )
    return 0
