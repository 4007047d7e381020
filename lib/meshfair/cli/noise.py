"""Add noise to a mesh, to have something to denoise.

Sizes are in mean edge lengths of the mesh, but for the uniform model's amplitude,
which is in the mesh's own units. The same seed gives the same noise.

The SNR compares the noise with the distances of the vertices from the origin, as the
original report defines it: the same noise on a mesh further away has a higher SNR.
IN and OUT may be -, which is standard input or output and needs --format.
"""

import argparse
from math import inf
from typing import Any

from meshfair.cli import files, printing

# Those of `meshfair.noise.MODELS`, which is not loaded for --help, and outliers; and what
# each of them takes, with the value where it is not given.
MODELS: dict[str, dict[str, float | None]] = {
    "normals": {"sigma": 0.2},
    "gaussian": {"sigma": 0.2},
    "uniform": {"amplitude": None},
    "correlated": {"sigma": 0.2, "steps": 3},
    "impulsive": {"sigma": 0.2, "fraction": 0.1},
}
DEFAULT_MODEL = "normals"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the subcommand's arguments."""
    files.add_input(parser, "in", standard=True)
    files.add_output(parser)
    parser.add_argument(
        "--model", choices=MODELS, default=DEFAULT_MODEL, help=f"(default {DEFAULT_MODEL})"
    )
    parser.add_argument(
        "--sigma", type=float, help="standard deviation (default 0.2), not for uniform"
    )
    parser.add_argument("--amplitude", type=float, help="of the uniform model, which needs it")
    parser.add_argument(
        "--fraction", type=float, help="of vertices moved, for impulsive (default 0.1)"
    )
    parser.add_argument(
        "--steps", type=int, help="of averaging neighbours, for correlated (default 3)"
    )
    parser.add_argument(
        "--snr",
        dest="decibels",
        type=float,
        metavar="DB",
        help="scale the noise to this signal-to-noise ratio",
    )
    parser.add_argument("--seed", type=int, default=0, help="of the random numbers (default 0)")
    files.add_format(parser)
    files.add_reading(parser)
    files.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Read, move the vertices, write, and print the SNR.

    Returns
    -------
    int
        0 where the mesh was written.
    """
    import numpy as np

    from meshfair import metrics, noise
    from meshfair.checks import check_count, check_number

    source, out = vars(options)["in"], options.out
    files.check_standard(options, source, out)
    files.check_output(out, [source], options.force)
    check_count(options.seed, "--seed")
    sizes = _sizes(options)
    if options.decibels is not None:
        check_number(options.decibels, "--snr", *noise.SNR_RANGE)
    V, F, attributes = files.read_whole(source, options)
    files.warn_of_problems(source, V, F)
    rng = np.random.default_rng(options.seed)
    if options.model == "impulsive":
        V_noisy = noise.impulsive(V, F, sizes["sigma"], sizes["fraction"], rng)
    elif options.model == "correlated":
        V_noisy = noise.correlated(V, F, sizes["sigma"], rng, steps=int(sizes["steps"]))
    else:
        (size,) = sizes.values()
        V_noisy = noise.MODELS[options.model](V, F, size, rng)
    if options.decibels is not None:
        V_noisy = noise.at_snr(V, V_noisy - V, options.decibels)
    files.write(out, V_noisy, F, attributes, [source], options)
    facts: dict[str, Any] = {
        "out": out,
        "model": options.model,
        "seed": options.seed,
        "snr": metrics.snr(V, V_noisy),
    }
    if options.json:
        printing.print_json(facts, printing.beside(out))
    else:
        printing.print_table(facts.items(), printing.beside(out))
    return 0


def _sizes(options: argparse.Namespace) -> dict[str, float]:
    """What the model takes; an error where an option is not for it, or one is missing."""
    from meshfair.checks import check_count, check_number

    takes = MODELS[options.model]
    for name in ("sigma", "amplitude", "fraction", "steps"):
        if getattr(options, name) is not None and name not in takes:
            right = ", ".join(model for model, names in MODELS.items() if name in names)
            raise ValueError(f"--{name} is for {right}, and not for {options.model}")
    if options.model == "uniform" and options.amplitude is None:
        raise ValueError("--model uniform needs --amplitude, in the units of the mesh")
    sizes: dict[str, float] = {}
    for name, default in takes.items():
        given = getattr(options, name)
        size = default if given is None else given
        if name == "steps":
            sizes[name] = check_count(size, "--steps")
        else:
            sizes[name] = check_number(size, f"--{name}", 0, 1 if name == "fraction" else inf)
    return sizes
