"""Add noise to a mesh, to have something to denoise.

Sizes are in mean edge lengths of the mesh, but for the uniform model's amplitude,
which is in the mesh's own units. The same seed gives the same noise.
"""

from meshfair.cli import files, printing

MODELS = ("along-normals", "gaussian", "uniform", "impulsive")


def add_arguments(parser):
    """Declare the subcommand's arguments."""
    files.add_input(parser, "in")
    files.add_output(parser)
    parser.add_argument("--model", choices=MODELS, default=MODELS[0], help=f"(default {MODELS[0]})")
    parser.add_argument(
        "--sigma", type=float, default=0.2, help="standard deviation (default 0.2), not for uniform"
    )
    parser.add_argument("--amplitude", type=float, help="of the uniform model, which needs it")
    parser.add_argument(
        "--fraction", type=float, default=0.1, help="of vertices hit, if impulsive (default 0.1)"
    )
    parser.add_argument(
        "--snr", type=float, metavar="DB", help="scale the noise to this signal-to-noise ratio"
    )
    parser.add_argument("--seed", type=int, default=0, help="of the random numbers (default 0)")
    files.add_reading(parser)
    files.add_json(parser)


def run(options):
    """Read, move the vertices, write, and print the SNR.

    Returns
    -------
    int
        0 where the mesh was written.
    """
    import numpy as np

    from meshfair import metrics, noise

    source = vars(options)["in"]
    files.check_output(options.out, [source], options.force)
    if options.seed < 0:
        raise ValueError(f"--seed is {options.seed}; give a number of at least 0")
    if options.model == "uniform" and options.amplitude is None:
        raise ValueError("--model uniform needs --amplitude, in the units of the mesh")
    V, F = files.read(source, options)
    rng = np.random.default_rng(options.seed)
    if options.model == "uniform":
        V_noisy = noise.uniform(V, options.amplitude, rng)
    elif options.model == "impulsive":
        V_noisy = noise.impulsive(V, F, options.sigma, options.fraction, rng)
    else:
        model = noise.gaussian if options.model == "gaussian" else noise.along_normals
        V_noisy = model(V, F, options.sigma, rng)
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
