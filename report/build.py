"""Make the report: run every experiment, draw every figure, typeset the PDF.

Everything it makes stands in report/build/, and the PDF in report/report.pdf:

    tables/*.csv     what the experiments returned, one file each
    figures/*        curves as SVG, meshes as PNG
    numbers.json     every number that the text names
    *.jsonl          sweeps in progress, so that a killed run goes on where it stopped

A change of the package's or the report's code, or of the real meshes that are downloaded,
starts all of it anew.
"""

import argparse
import hashlib
import json
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd
import typst

import figures
import tables
from meshfair import datasets
from numbers_in_text import numbers

HERE = Path(__file__).resolve().parent
BUILD = HERE / "build"


def main() -> None:
    """Build the report; print a line for each part."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--draws", type=int, default=20, help="noise draws a cell of Table 1")
    parser.add_argument("--out", type=Path, default=HERE / "report.pdf")
    options = parser.parse_args()
    started = time.perf_counter()
    start_anew_if_changed(options.draws)

    data = {}
    for name, make in tables.TABLES.items():
        data[name] = step(f"experiment {name}", run_or_read, name, make, options.draws)
    data = {name: table for name, table in data.items() if table is not None}
    for path in (HERE / "results").glob("*.csv"):  # of `make bench`, `make grid`, `make train`
        data[path.stem] = pd.read_csv(path)
    (BUILD / "figures").mkdir(parents=True, exist_ok=True)
    for name, draw in figures.FIGURES.items():
        step(f"figure {name}", draw, BUILD / "figures", data)
    text = json.dumps(numbers(data), indent=1, sort_keys=True, ensure_ascii=False)
    (BUILD / "numbers.json").write_text(text, encoding="utf-8")
    step("report.pdf", typeset, options.out)
    print(f"{options.out}: done in {time.perf_counter() - started:.0f} s")


def step(title: str, function: Callable[..., Any], *arguments: Any) -> Any:
    """Call a function and say what it was and how long it took."""
    started = time.perf_counter()
    result = function(*arguments)
    print(f"  {title:32s}{time.perf_counter() - started:7.1f} s", flush=True)
    return result


def start_anew_if_changed(draws: int) -> None:
    """Drop what an earlier version of the code, other draws or other meshes have made."""
    downloaded = [name for name in datasets.SOURCES if datasets.find(name)]
    digest = hashlib.sha256(f"{draws} {downloaded}".encode())
    sources = [*(HERE.parent / "lib").rglob("*.py"), *HERE.glob("*.py"), *HERE.glob("results/*")]
    for source in sorted(sources):
        digest.update(source.read_bytes())
    stamp = BUILD / "made-from"
    if not stamp.exists() or stamp.read_text() != digest.hexdigest():
        shutil.rmtree(BUILD, ignore_errors=True)
        BUILD.mkdir(parents=True)
        stamp.write_text(digest.hexdigest())


def run_or_read(name: str, make: tables.Make, draws: int) -> pd.DataFrame | None:
    """The table of an experiment, run only where an earlier build has not; None without data."""
    path = BUILD / "tables" / f"{name}.csv"
    if not path.exists():
        table = make(draws=draws, journal=BUILD / f"{name}.jsonl")
        if table is None:
            return None
        path.parent.mkdir(parents=True, exist_ok=True)
        unfinished = path.with_suffix(".part")
        table.to_csv(unfinished, index=False)
        unfinished.replace(path)  # so that a table that is there is whole
    return pd.read_csv(path)


def typeset(out: Path) -> None:
    """Compile the PDF: the same input gives the same bytes."""
    pdf = typst.compile(
        str(HERE / "report.typ"),
        root=str(HERE),
        ignore_system_fonts=True,
        pdf_standards="ua-1",  # tagged, and refused where a picture or formula lacks its words
    )
    unfinished = out.with_suffix(".part")
    unfinished.write_bytes(pdf)
    unfinished.replace(out)


if __name__ == "__main__":
    main()
