"""Say how far a mesh is from another one, by every metric that fits the two, or why it does not.

A is the mesh in question, B the ground truth that it is compared with. SNR and normal
angle need two meshes of the same faces, in any order. The SNR depends on where the
origin lies: compare SNRs of meshes in one place only. The vertex distance is the mean over A's
vertices; the surface distance the mean over 20,000 points on each surface, with two
standard errors; the Hausdorff distance that of any points of the surfaces, between bounds
that are certain. The volume needs closed meshes.
"""

import argparse
from typing import TYPE_CHECKING, Any

from meshfair.cli import files, pictures, printing
from meshfair.cli.words import in_words_of_the_command

if TYPE_CHECKING:
    from meshfair.metrics import Measure

UNITS = {
    "snr": "dB",
    "normal_angle": "degrees",
    "vertex_distance": "mean edge lengths",
    "surface_distance": "mean edge lengths",
    "hausdorff": "mean edge lengths",
    "volume_change": "of B's volume",
    "area_change": "of B's area",
}
ROUNDING = 1e-9  # of a value, or of an edge, below which a bound is nothing to speak of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the subcommand's arguments."""
    files.add_input(parser, "a", "the noisy or denoised mesh")
    files.add_input(parser, "b", "the ground truth")
    pictures.add_picture(parser)
    parser.add_argument("--force", action="store_true", help="replace the picture if it is there")
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

    both = [options.a, options.b]
    pictures.check_picture(options.picture, both, options.force)
    a, b = (files.read(path, options) for path in both)
    found = metrics.compare(*a, *b)
    if options.picture:
        from meshfair.viewer import by_distance

        shown = by_distance(
            [a, b],
            [b, a],
            titles=pictures.titles(both),
            label="distance from the other mesh, in its unit",
        )
        pictures.write_picture(options.picture, shown, both, options.force)
    if options.json:
        facts = {name: _as_json(name, measure) for name, measure in found.items()}
        printing.print_json(facts | ({"picture": options.picture} if options.picture else {}))
    else:
        rows = [(name, _in_words(name, measure)) for name, measure in found.items()]
        printing.print_table(rows + ([("picture", options.picture)] if options.picture else []))
    return 0


def _in_words(name: str, measure: "Measure") -> str:
    """A metric with its unit and the bound on its error, or why there is none."""
    value, bound = measure.value, measure.bound
    if value is None:
        return f"cannot be compared: {in_words_of_the_command(measure.reason, {})}"
    if value == float("inf"):
        return "infinite: the meshes are equal"
    text = printing.shortened(value)
    if bound > ROUNDING * max(value, 1.0):
        error = printing.shortened(bound, 2)
        upper = printing.shortened(value + bound)
        text += f" to {upper}" if name == "hausdorff" else f" ± {error}"
    return f"{text} {UNITS[name]}"


def _as_json(name: str, measure: "Measure") -> dict[str, Any]:
    """A metric for programs."""
    return {
        "value": measure.value,
        "bound": None if measure.value is None else measure.bound,
        "unit": UNITS[name],
        "reason": in_words_of_the_command(measure.reason, {}) or None,
    }
