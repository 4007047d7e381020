"""Show meshes side by side in the browser, coloured by their distance from the first.

The page needs neither a kernel nor a network: it can be kept, and sent to others. Turning
one mesh turns all. Distances are in the unit of the files.
"""

import argparse
import webbrowser
from pathlib import Path

from meshfair.cli import files, pictures, printing

ENDINGS = (".html", ".htm")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the subcommand's arguments."""
    parser.add_argument(
        "files", metavar="FILE", nargs="+", type=files.file, help="the meshes to show"
    )
    color = parser.add_mutually_exclusive_group()
    color.add_argument(
        "--compare",
        metavar="MESH",
        type=files.file,
        help="what distances are from, which is not shown (default: the first FILE)",
    )
    color.add_argument("--plain", action="store_true", help="no colours")
    parser.add_argument(
        "--out", metavar="PAGE", type=files.file, help="keep the page, an .html file"
    )
    pictures.add_picture(parser)
    parser.add_argument("--no-open", action="store_true", help="do not open the browser")
    parser.add_argument("--force", action="store_true", help="replace PAGE and picture")
    files.add_reading(parser)
    files.add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Read, write the page and the picture, open the browser.

    Returns
    -------
    int
        0 where all was written, whether or not there is a browser.
    """
    from meshfair.viewer import by_distance

    inputs = [*options.files, *([options.compare] if options.compare else [])]
    _check(options, inputs)
    meshes = [files.read(path, options) for path in options.files]
    names = pictures.titles(options.files)
    name = names[0]
    references = [None if options.plain or k == 0 else meshes[0] for k in range(len(meshes))]
    if options.compare:
        name = options.compare.name
        reference = files.read(options.compare, options)
        references = [reference for _ in meshes]
    shown = by_distance(
        meshes, references, titles=names, label=f"distance from {name}, in its unit"
    )
    facts: dict[str, object] = {}
    if options.picture:
        pictures.write_picture(options.picture, shown, inputs, options.force)
        facts["picture"] = options.picture
    if options.out or not options.no_open:
        page = options.out or _temporary(options.files[0])
        if options.out:
            files.check_free(page, inputs, options.force)
        shown.save(page, ", ".join(names))
        opened = not options.no_open and _open(page)
        facts |= {"page": page, "opened": opened}
    if options.json:
        printing.print_json(facts)
    else:
        printing.print_table(_rows(facts, options))
    return 0


def _check(options: argparse.Namespace, inputs: list[Path]) -> None:
    """Refuse before the work what could not be done after it."""
    if options.no_open and not (options.out or options.picture):
        raise ValueError("--no-open leaves nothing to do; keep the page by --out, or a --picture")
    pictures.check_picture(options.picture, inputs, options.force)
    if options.out:
        if options.out.suffix.lower() not in ENDINGS:
            raise ValueError(f"{options.out}: name the page {' or '.join(ENDINGS)}")
        files.check_free(options.out, inputs, options.force)


def _temporary(first: Path) -> Path:
    """A place for a page that nobody keeps: the browser reads it when this process has ended."""
    import tempfile

    return Path(tempfile.mkdtemp(prefix="meshfair-")) / f"{first.name}.html"


def _open(page: Path) -> bool:
    """Open the browser on a page, where there is a screen for it; whether it did."""
    from meshfair.viewer.window import has_screen

    return has_screen() and webbrowser.open(page.absolute().as_uri())


def _rows(facts: dict[str, object], options: argparse.Namespace) -> list[tuple[str, object]]:
    """What is printed for people."""
    rows = [(name, fact) for name, fact in facts.items() if name != "opened"]
    if facts.get("opened") is False and not options.no_open:
        rows.append(("browser", "none could be opened here; open the page in one"))
    return rows
