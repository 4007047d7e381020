"""Make the site: `make site` calls this.

Sphinx reads one folder, report/site-build/source; what it needs of the repository is written
there: the pages of this folder with their tables filled in, the notebooks, a page for each module
and for each filter. A file whose text stays the same is not written again, so that Sphinx and the
notebooks' cache do only what has changed. The site itself goes to report/site.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import gallery
import jinja2
import measured
import notebooks
import reference
from execution import KERNEL, cache_folder, execute
from links import Links

from meshfair import viewer

PAGES = Path(__file__).resolve().parent
REPORT = PAGES.parent
ROOT = REPORT.parent
BUILD = REPORT / "site-build"
SOURCE = BUILD / "source"
SITE = REPORT / "site"
HTML = BUILD / "html"  # what becomes the site once it is without faults
PDF = REPORT / "report.pdf"
PLAYER = BUILD / "player"


def main() -> None:
    """Build the site, and say where it is."""
    make_report()
    links = Links(ROOT)
    written = {}

    def write(name: str, text: str | bytes) -> None:
        path = SOURCE / name
        data = text.encode() if isinstance(text, str) else text
        if not path.exists() or path.read_bytes() != data:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        written[path] = True

    course = notebooks.course(ROOT / "notebooks")
    for path in course:
        write(f"notebooks/{path.name}", notebooks.of_course(path, links))
    assignments = sorted((ROOT / "notebooks/assignments/student").glob("*/*.ipynb"))
    for path in assignments:
        write(f"assignments/{path.name}", notebooks.of_assignment(path, links))
    methods = gallery.methods()
    for method in methods:
        write(f"gallery/{method}.ipynb", gallery.notebook(method))
    for name, text in reference.pages(course).items():
        write(name, text)

    runs = [SOURCE / "notebooks" / path.name for path in course]
    runs += [SOURCE / "gallery" / f"{method}.ipynb" for method in methods]
    cache = cache_folder(BUILD / "executed", package_sources())
    executed = execute(runs, cache, BUILD / "scratch")
    for method in methods:
        notebook = executed[SOURCE / "gallery" / f"{method}.ipynb"]
        for name, picture in gallery.thumbnails(method, notebook).items():
            write(f"gallery/{name}", picture)

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(PAGES),
        undefined=jinja2.StrictUndefined,
        keep_trailing_newline=True,
        variable_start_string="<<",
        variable_end_string=">>",
        block_start_string="<%",
        block_end_string="%>",
        comment_start_string="<#",
        comment_end_string="#>",
    )
    facts = {
        "course": [(path.stem, notebooks.title(path), notebooks.goal(path)) for path in course],
        "assignments": [(path.stem, notebooks.title(path)) for path in assignments],
        "methods": methods,
        "summaries": {method: gallery.summary(method) for method in methods},
        "meshes": gallery.MESHES,
        "section": links.section,
        "whole": links.whole,
        "measured": measured,
        "repository": links.repository,
    }
    with_cells = []
    for path in sorted(PAGES.rglob("*.md")):
        name = path.relative_to(PAGES).as_posix()
        page = environment.get_template(name).render(facts)
        write(name, page)
        if "{code-cell}" in page:
            with_cells.append(SOURCE / name)
    execute(with_cells, cache, BUILD / "scratch")
    write("CITATION.cff", (ROOT / "CITATION.cff").read_bytes())
    for path in SOURCE.rglob("*"):  # what an earlier build had
        if path.is_file() and path not in written:
            path.unlink()
    write_player()
    sphinx(cache)
    shutil.copyfile(PDF, HTML / PDF.name)
    shutil.rmtree(SITE, ignore_errors=True)
    shutil.copytree(HTML, SITE, ignore=shutil.ignore_patterns(".buildinfo", "objects.inv"))
    print(f"{SITE / 'index.html'}\nto look at it: python -m http.server -d {os.path.relpath(SITE)}")


def package_sources() -> list[Path]:
    """Every file of the package that a notebook's outputs may depend on."""
    kept = {".py", ".js", ".css", ".npz", ".toml", ".csv"}
    return [path for path in (ROOT / "lib").rglob("*.*") if path.suffix in kept]


def write_player() -> None:
    """Write the script and the styles of meshes that move, which all pages share."""
    shutil.rmtree(PLAYER, ignore_errors=True)
    PLAYER.mkdir(parents=True)
    for name, text in viewer.page_files().items():
        (PLAYER / name).write_text(text, encoding="utf-8")


def make_report() -> None:
    """Make the report and its tables anew where they are missing, or older than their sources."""
    sources = [*REPORT.glob("*.*"), *REPORT.glob("results/*"), *(ROOT / "lib").rglob("*.py")]
    newest = max(path.stat().st_mtime for path in sources if path != PDF)
    tables = REPORT / "build" / "tables"
    if not PDF.exists() or not tables.exists() or PDF.stat().st_mtime < newest:
        subprocess.run([sys.executable, str(REPORT / "build.py")], check=True)


def sphinx(cache: Path) -> None:
    """Run Sphinx; a warning ends it."""
    environment = {
        **os.environ,
        **KERNEL,
        "MESHFAIR_EXECUTED": str(cache),
        "MESHFAIR_PLAYER": str(PLAYER),
        "PYTHONPATH": os.pathsep.join(
            [str(ROOT / "lib"), *filter(None, [os.environ.get("PYTHONPATH")])]
        ),
    }
    command = [sys.executable, "-m", "sphinx", "-b", "html", "-W", "--keep-going", "-q", "-j", "2"]
    command += ["-c", str(PAGES), "-d", str(BUILD / "doctrees"), str(SOURCE), str(HTML)]
    if subprocess.run(command, env=environment).returncode:
        raise SystemExit("the site has faults, named above; they have to be mended first")


if __name__ == "__main__":
    if "--anew" in sys.argv:
        shutil.rmtree(BUILD, ignore_errors=True)
        shutil.rmtree(SITE, ignore_errors=True)
    main()
