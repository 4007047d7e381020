"""Denoise a mesh.

Parameters that are not given have the method's defaults; a method refuses
those that it does not have, and names its own.
"""

import argparse
import ast
from collections.abc import Sequence
from typing import Any

from meshfair.cli import files, printing


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the subcommand's arguments."""
    files.add_input(parser, "in")
    files.add_output(parser)
    parser.add_argument("--method", help="how (see --methods)")
    parser.add_argument(
        "--methods", action=_ListMethods, nargs=0, help="list the methods and their parameters"
    )
    parser.add_argument("--weights", help="combinatorial, distance or cotangent, for diffusion")
    parser.add_argument("--time", type=float, help="how long to flow, for heat")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        type=_parameter,
        metavar="NAME=VALUE",
        help="any other parameter; may be repeated",
    )
    parser.add_argument(
        "--auto", action="store_true", help="choose what is not given from the mesh itself"
    )
    parser.add_argument(
        "--fix-boundary", action="store_true", help="keep the boundary's vertices in place"
    )
    parser.add_argument(
        "--ground-truth",
        metavar="MESH",
        type=files.Path,
        help="the noise-free mesh, to say how much closer the result is",
    )
    files.add_reading(parser)
    files.add_json(parser)


class _ListMethods(argparse.Action):
    """Print every method with its parameters and their defaults, and stop."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        from meshfair import denoising

        for method in denoising.methods():
            defaults = denoising.defaults(method)
            defaults.pop("fixed", None)
            print(method, *(f"{name}={value}" for name, value in defaults.items()))
        parser.exit()


def _parameter(text: str) -> tuple[str, Any]:
    """A name and a value from NAME=VALUE: a number, True, False or None, else a word."""
    name, equals, value = text.partition("=")
    if not (name.isidentifier() and equals and value):
        raise argparse.ArgumentTypeError(f"{text!r} is not of the form NAME=VALUE")
    try:
        return name, ast.literal_eval(value)
    except (ValueError, SyntaxError):
        return name, value


def run(options: argparse.Namespace) -> int:
    """Read, denoise, write, and say what was done.

    Returns
    -------
    int
        0 where the mesh was written.
    """
    from meshfair.denoising import denoise
    from meshfair.mesh import boundary_vertices

    source = vars(options)["in"]
    inputs = [source, options.ground_truth] if options.ground_truth else [source]
    files.check_output(options.out, inputs, options.force)
    V, F = files.read(source, options)
    chosen = dict(options.set)
    for name in ("method", "weights", "time"):
        if getattr(options, name) is not None:
            chosen[name] = getattr(options, name)
    if options.fix_boundary:
        chosen["fixed"] = boundary_vertices(F)
    if options.ground_truth:
        chosen["ground_truth"] = files.read(options.ground_truth, options)[0]
    with printing.progress() as advance:
        result = denoise(
            V, F, parameters="auto" if options.auto else "default", callback=advance, **chosen
        )
    files.write(options.out, result.V, F, inputs, options.force)

    parameters = {name: value for name, value in result.parameters.items() if name != "fixed"}
    history = None if result.history is None else result.history.to_dict("records")
    if options.json:
        printing.print_json(
            {
                "out": options.out,
                "method": result.method,
                "parameters": parameters,
                "fixed_vertices": len(chosen.get("fixed", ())),
                "seconds": result.seconds,
                "history": history,
            }
        )
    else:
        rows: list[tuple[str, Any]] = [
            ("out", options.out),
            ("method", result.method),
            *parameters.items(),
        ]
        if history:
            for name, unit in (("snr", "dB"), ("normal_angle", "degrees")):
                rows.append((name, f"{history[0][name]:.6g} -> {history[-1][name]:.6g} {unit}"))
        printing.print_table([*rows, ("seconds", round(result.seconds, 3))])
    return 0
