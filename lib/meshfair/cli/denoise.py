"""Denoise a mesh by diffusion, with one of the three weights.

averaging makes whole steps V <- W~ V, heat smaller ones of size --tau, and
implicit one stable backward Euler step, whose time is in squared mean edge
lengths. Weights are built once, from the noisy mesh.
"""

from pathlib import Path

from meshfair.cli import files, printing

METHODS = ("averaging", "heat", "implicit")
WEIGHTS = ("combinatorial", "distance", "cotangent", "intrinsic")


def add_arguments(parser):
    """Declare the subcommand's arguments."""
    files.add_input(parser, "in")
    files.add_output(parser)
    parser.add_argument("--method", choices=METHODS, default="heat", help="(default heat)")
    parser.add_argument(
        "--weights", choices=WEIGHTS, default="cotangent", help="(default cotangent)"
    )
    parser.add_argument("--time", type=float, default=1.0, help="how long to flow (default 1)")
    parser.add_argument("--tau", type=float, default=0.2, help="time step of heat (default 0.2)")
    parser.add_argument(
        "--hold-boundary", action="store_true", help="keep boundary vertices where they are"
    )
    parser.add_argument(
        "--clean", type=Path, metavar="MESH", help="the clean mesh, to stop where the SNR is best"
    )
    files.add_reading(parser)
    files.add_json(parser)


def run(options):
    """Read, flow, write, and print what was done.

    Returns
    -------
    int
        0 where the mesh was written.
    """
    from meshfair import mesh

    source = vars(options)["in"]
    inputs = [source] if options.clean is None else [source, options.clean]
    files.check_output(options.out, inputs, options.force)
    V, F = files.read(source, options)
    fixed = mesh.boundary_vertices(F) if options.hold_boundary else None
    facts = {"out": str(options.out), "method": options.method, "weights": options.weights}
    if options.method == "implicit":
        if options.clean is not None:
            raise ValueError(
                "--clean wants the best of many steps; implicit makes one, so use heat"
            )
        V_new, time = _implicit(V, F, options, fixed), options.time
    else:
        V_new, time, snr = _explicit(V, F, options, fixed)
        facts |= snr
    files.write(options.out, V_new, F, inputs, options.force)
    facts["time"] = time
    if options.json:
        printing.print_json(facts)
    else:
        printing.print_table(facts.items())
    return 0


def _weights(V, F, options):
    from meshfair import weights

    if options.weights == "combinatorial":
        return weights.combinatorial(F, len(V))
    return getattr(weights, options.weights)(V, F)


def _explicit(V, F, options, fixed):
    """The last state of the flow, or where a clean mesh is given the one with the best SNR."""
    from tqdm import tqdm

    from meshfair import flow, metrics, operators

    tau = 1.0 if options.method == "averaging" else options.tau
    A = operators.averaging(_weights(V, F, options))
    steps = flow.heat(V, A, tau, options.time, fixed=fixed)
    steps = tqdm(steps, unit="step", leave=False, disable=None)  # None: on a terminal only
    if options.clean is None:
        for time, state in steps:
            last = state, time
        return *last, {}
    V_clean, _ = files.read(options.clean, options)
    best = max(
        ((metrics.snr(V_clean, state), -time, state) for time, state in steps),
        key=lambda found: found[:2],
    )
    return best[2], -best[1], {"noisy_snr": metrics.snr(V_clean, V), "snr": best[0]}


def _implicit(V, F, options, fixed):
    from meshfair import mesh, operators, solve

    L = operators.laplacian(_weights(V, F, options))
    if options.weights == "distance":
        L = L / mesh.mean_edge_length(V, F)  # so that no weights have a unit
    t = options.time * mesh.mean_edge_length(V, F) ** 2
    return solve.implicit_step(V, L, operators.mass(V, F), t, fixed=fixed)
