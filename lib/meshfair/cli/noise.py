"""Add noise to a mesh, to have something to denoise.

Sizes are in mean edge lengths of the mesh, but for the uniform model's amplitude,
which is in the mesh's own units. The same seed gives the same noise.
"""

import argparse

from meshfair.cli import files, printing

# Those of `meshfair.noise.MODELS`, which is not loaded for --help, and outliers.
MODELS = ("normals", "gaussian", "uniform", "impulsive")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the subcommand's arguments."""
    files.add_input(parser, "in")
    files.add_output(parser)
    parser.add_argument("--model", choices=MODELS, default=MODELS[0], help=f"(default {MODELS[0]})")
    parser.add_argument(
        "--sigma", type=float, default=0.2, help="standard deviation (default 0.2), not for uniform"
    )
    parser.add_argument("--amplitude", type=float, help="of the uniform model, which needs it")
    parser.add_argument(
        "--fraction", type=float, default=0.1, help="of vertices moved, if impulsive (default 0.1)"
    )
    parser.add_argument(
        "--snr", type=float, metavar="DB", help="scale the noise to this signal-to-noise ratio"
    )
    parser.add_argument("--seed", type=int, default=0, help="of the random numbers (default 0)")
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
    from meshfair.checks import check_count

    source = vars(options)["in"]
    files.check_output(options.out, [source], options.force)
    check_count(options.seed, "--seed")
    if options.model == "uniform" and options.amplitude is None:
        raise ValueError("--model uniform needs --amplitude, in the units of the mesh")
    V, F = files.read(source, options)
    rng = np.random.default_rng(options.seed)
    if options.model == "impulsive":
        V_noisy = noise.impulsive(V, F, options.sigma, options.fraction, rng)
    else:
        size = options.amplitude if options.model == "uniform" else options.sigma
        V_noisy = noise.MODELS[options.model](V, F, size, rng)
    if options.snr is not None:
        V_noisy = noise.at_snr(V, V_noisy - V, options.snr)
    files.write(options.out, V_noisy, F, [source], options.force)
    facts = {
        "out": options.out,
        "model": options.model,
        "seed": options.seed,
        "snr": metrics.snr(V, V_noisy),
    }
    if options.json:
        printing.print_json(facts)
    else:
        printing.print_table(facts.items())
    return 0
