"""Denoise a mesh, or many.

IN is a mesh file, and so is OUT; either may be -, which is standard input or output
and needs --format: nothing but the mesh is then printed on standard output. With --out,
each IN is denoised into a file of its name in the folder, and one that fails stops none.
What the file holds beside positions stays as it is.

Without --method one is chosen from the mesh alone, with its parameters, and a line says why.
Parameters of a --method that are not given have its defaults; a method refuses
those that it does not have, and names its own. An SNR depends on where the origin lies:
compare SNRs of meshes in one place only.
"""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from meshfair.checks import Floats, Integers
from meshfair.cli import files, many, parameters, printing
from meshfair.cli.parser import Parser


def add_arguments(parser: Parser) -> None:
    """Declare the subcommand's arguments."""
    parser.usage = "%(prog)s [options] IN OUT\n       %(prog)s [options] IN [IN ...] --out FOLDER"
    parser.list_of = "places"
    parser.add_argument("places", metavar="IN ... OUT", nargs="+", help="the meshes; see above")
    parser.add_argument("--out", dest="folder", metavar="FOLDER", type=Path, help="for many meshes")
    files.add_force(parser)
    parser.add_argument(
        "--method",
        default=parameters.DEFAULT_METHOD,
        help=f"how (default {parameters.DEFAULT_METHOD}: {parameters.AUTO}; see --methods)",
    )
    parser.add_argument(
        "--methods",
        action=parameters.ListMethods,
        nargs=0,
        help="list the methods and their parameters",
    )
    parser.add_argument(
        "--noise",
        dest="sigma",
        type=float,
        metavar="SIZE",
        help="the size of the noise, if it is known: its standard deviation, as a fraction of "
        "the mean edge length",
    )
    parser.add_argument("--weights", help="combinatorial, distance or cotangent, for diffusion")
    parser.add_argument("--time", type=float, help="how long to flow, for heat")
    parser.add_argument(
        "--strength",
        type=float,
        metavar="PART",
        help="the part of the way, 0 to 1, from IN to where the method leads: less keeps more "
        "detail, and noise (default 1, or what is chosen)",
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        type=parameters.assignment,
        metavar="NAME=VALUE",
        help="any other parameter; may be repeated",
    )
    parser.add_argument(
        "--auto",
        dest="parameters",
        action="store_const",
        const="auto",
        default="default",
        help="choose the parameters of --method that are not given from the mesh itself",
    )
    parser.add_argument(
        "--fix-boundary",
        dest="fixed",
        action="store_true",
        help="keep the boundary's vertices in place",
    )
    parser.add_argument(
        "--ground-truth",
        metavar="MESH",
        type=files.file,
        help="the noise-free mesh, to say how much closer the result is; its faces have to be "
        "those of IN",
    )
    files.add_format(parser)
    files.add_reading(parser)
    files.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Read, denoise, write, and say what was done.

    Returns
    -------
    int
        0 where every mesh was written.
    """
    try:
        places = [files.place(text) for text in options.places]
    except argparse.ArgumentTypeError as error:
        options.wrong_usage(str(error))
    if options.folder is None and len(places) == 1:
        options.wrong_usage("OUT is missing; name the mesh to write, or give --out FOLDER")
    if options.folder is None and len(places) > 2:
        options.wrong_usage(
            f"there are {len(places)} meshes; give IN and OUT alone, or --out FOLDER for many"
        )
    if options.folder is not None:
        return many.run(_Task(options), places, options)
    source, out = places
    files.check_standard(options, source, out)
    files.check_output(out, _inputs(source, options), options.force)
    task = _Task(options)
    with printing.progress() as advance:
        facts = task(source, out, advance)
    if options.json:
        printing.print_json(facts, printing.beside(out))
    else:
        rows = [("out", out), ("method", facts["method"]), *facts["parameters"].items()]
        if facts["reason"]:
            rows.append(("why", facts["reason"]))
        rows += [*gains(facts["history"]), ("seconds", round(facts["seconds"], 3))]
        printing.print_table(rows, printing.beside(out))
    return 0


class _Task:
    """What is done to each mesh."""

    def __init__(self, options: argparse.Namespace) -> None:
        from meshfair.checks import check_number

        if options.sigma is not None:
            check_number(options.sigma, "--noise", 0)
        self.options, self.chosen = options, parameters.chosen(options)
        if options.ground_truth:
            self.ground_truth = files.read(options.ground_truth, options)

    def _matched(self, V: Floats, F: Integers) -> Floats:
        """The ground truth's vertices, in the order of a mesh's own."""
        from meshfair.checks import MeshError
        from meshfair.metrics import matched

        try:
            return matched(V, F, *self.ground_truth)
        except MeshError as error:
            raise MeshError(
                f"--ground-truth {self.options.ground_truth}: {error}; give the mesh that the "
                "noise was added to, or compare surfaces, with meshfair compare"
            ) from None

    def inputs(self, source: files.Place) -> list[files.Place]:
        """The files that are read."""
        return _inputs(source, self.options)

    def __call__(
        self, source: files.Place, out: files.Place, advance: Callable[[float], None]
    ) -> dict[str, Any]:
        """Denoise a mesh, and return what there is to say of it."""
        import numpy as np

        from meshfair.denoising import denoise
        from meshfair.mesh import boundary_vertices, join

        options, chosen = self.options, dict(self.chosen)
        V, F, attributes = files.read_whole(source, options)
        files.warn_of_problems(source, V, F)
        if options.fixed:
            joined = join(V, F)  # a seam is no boundary
            chosen["fixed"] = np.isin(joined.copies, boundary_vertices(joined.F))
        if options.ground_truth:
            chosen["ground_truth"] = self._matched(V, F)
        result = denoise(
            V,
            F,
            options.method,
            parameters=options.parameters,
            sigma=options.sigma,
            callback=advance,
            **chosen,
        )
        files.write(out, result.V, F, attributes, self.inputs(source), options)
        return {
            "out": out,
            "method": result.method,
            "vertices": len(V),
            "parameters": {n: v for n, v in result.parameters.items() if n != "fixed"},
            "reason": result.reason,
            "expected_ratio": result.ratio,
            "fixed_vertices": np.sum(chosen.get("fixed", 0)),
            "seconds": result.seconds,
            "history": None if result.history is None else result.history.to_dict("records"),
        }

    def told(self, facts: dict[str, Any]) -> str:
        """What was done, in a few words."""
        if (facts["reason"] or "").startswith("left as it is"):
            return "left as it is"
        defaults = parameters.known(facts["method"])
        chosen = [
            f"{name}={printing.shortened(value, 3)}"
            for name, value in facts["parameters"].items()
            if value != defaults.get(name)  # the strength has none
        ]
        closer = [gain for _, gain in gains(facts["history"], 3)]
        return ", ".join([*chosen, *closer]) or f"{facts['vertices']:,} vertices"


def _inputs(source: files.Place, options: argparse.Namespace) -> list[files.Place]:
    return [source, options.ground_truth] if options.ground_truth else [source]


def gains(history: list[dict[str, float]] | None, digits: int = 6) -> list[tuple[str, str]]:
    """How much closer to the ground truth a mesh has come, by each measure."""
    if history is None:
        return []
    first, last = history[0], history[-1]
    return [
        (name, f"{first[name]:.{digits}g} -> {last[name]:.{digits}g} {unit}")
        for name, unit in (("snr", "dB"), ("normal_angle", "degrees"))
    ]
