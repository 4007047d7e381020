"""The report: every number in it comes from an experiment, and two runs give the same bytes."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parent.parent
REPORT = ROOT / "report"
LAYOUT = {"template.typ"}
SECTIONS = [
    path
    for path in sorted(REPORT.glob("*.typ"))
    if path.name not in LAYOUT and not path.stem.endswith("_tables")
]
TEXT = "\n".join(path.read_text(encoding="utf-8") for path in SECTIONS)

# Numbers that are part of a name or of a definition, not measured.
NAMES = re.compile(r"F-16|Open3D|potpourri3d|L0\b")
# In formulas: exponents, halves, the 20 log10 of decibels, the bounds 2/3 and 3 with their proof.
FORMULA_NUMBERS = {"-1", "0", "1", "2", "3", "10", "20"}


def without(pattern, text):
    return re.sub(pattern, " ", text, flags=re.S)


def prose(text):
    """The text without calls of functions, labels, references, formulas and code."""
    text = without(r"//[^\n]*", text)
    text = without(r"`[^`]*`", text)
    text = without(r"\$[^$]*\$", text)
    text = without(r'#n\("[^"]*"\)', text)
    text = without(r'"[^"\n]*"', text)  # file names and keys, and quotations
    text = without(r"[@<][\w-]+>?", text)
    text = without(r"(width|columns|spacing): (if has\( *\) )?[\w.%()*{} ]+", text)
    text = without(r"\b(meshes|v)\(\d+(pt)?|\bgallery\([ ,\d]+\)", text)
    return NAMES.sub(" ", text)


def typed_numbers(text):
    """Numbers typed by hand: any digit in the prose, any measured-looking one in a formula."""
    found = re.findall(r"\d[\d.,]*", prose(text))
    for formula in re.findall(r"\$[^$]*\$", text):
        numbers = re.findall(r"\d+(?:\.\d+)?", without(r'"[^"]*"', formula))
        found += [number for number in numbers if number not in FORMULA_NUMBERS]
    return found


def test_no_number_is_typed_by_hand():
    assert typed_numbers(TEXT) == []


@pytest.mark.parametrize(
    "typed", ["the best is 23.4 dB", "with $tau = 0.2$ it", "after 7 steps", "of 1,440 vertices"]
)
def test_a_typed_number_is_found(typed):
    assert typed_numbers(TEXT + typed)


def test_numbers_are_not_hidden_in_other_files():
    template = (REPORT / "template.typ").read_text(encoding="utf-8")
    assert not re.search(r"\d+\.\d+ *(dB|%\])", template)
    code = (REPORT / "numbers_in_text.py").read_text(encoding="utf-8")
    assert not re.search(r'"[a-z0-9-]+": f?"[^"{]*\d', code)  # a key with a written-out number


def test_the_learned_filters_numbers_are_those_of_its_validation(monkeypatch):
    monkeypatch.syspath_prepend(str(REPORT))
    import pandas as pd

    from numbers_of_learning import _training, _validation

    scores = pd.read_csv(REPORT / "results/validation.csv")
    won, lost, cells = [], 0, scores.groupby(["shape", "noise", "size"])
    for _, rows in cells:  # row by row, where the report pivots
        angle = dict(zip(rows["method"], rows["normal_angle"], strict=True))
        snr = dict(zip(rows["method"], rows["snr"], strict=True))
        learned, noisy = angle.pop("learned"), angle.pop("noisy")
        won.append(learned < min(angle.values()))
        lost += snr["learned"] < snr["noisy"] - 0.1
        assert learned < noisy
    found = _validation({"validation": scores})
    assert found["learned-cells"] == str(len(won))
    assert found["learned-won"] == f"{100 * sum(won) / len(won):.0f}"
    assert found["learned-lost"] == str(lost)
    assert found["learned-rougher"] == "0"
    names = {name for column in ("noise", "shape") for name in scores[column]}
    assert {key[8:-4] for key in found if key.endswith("-won")} == names | {""}
    curve = pd.read_csv(REPORT / "results/training.csv")
    found = _training({"training": curve})
    last = curve[curve["stage"] == 2].iloc[-1]
    assert found["learned-2-steps"] == f"{last['step']:,.0f}"
    assert found["learned-2-sharp"] == f"{last['sharp']:.2f}"


# Every source has the place where it appeared, and where it is found today.
PLACES = {
    "article": {"journal", "volume", "pages"},
    "inproceedings": {"booktitle", "pages"},
    "incollection": {"booktitle", "publisher", "pages"},
    "misc": set(),
}


def sources():
    """Kind and fields of each entry of the bibliography, by key."""
    text = (REPORT / "references.bib").read_text(encoding="utf-8")
    entries = re.findall(r"@(\w+)\{(\w+),(.*?)\n\}", text, re.S)
    return {key: (kind, set(re.findall(r"(\w+) *= *\{", body))) for kind, key, body in entries}


def test_the_bibliography_is_complete():
    for key, (kind, fields) in sources().items():
        assert {"author", "title", "year"} | PLACES[kind] <= fields, key
        assert fields & {"doi", "url"} or key == "original", key  # which was never published


def test_every_source_is_cited_in_the_report_or_in_the_code():
    cited = set(re.findall(r"@(\w+)", TEXT))
    for path in (ROOT / "lib").rglob("*.py"):
        cited |= set(re.findall(r"\.\. \[(\w+)\]", path.read_text(encoding="utf-8")))
    assert sources().keys() <= cited


def test_meshes_that_are_downloaded_later_start_the_report_anew(monkeypatch, tmp_path):
    monkeypatch.syspath_prepend(str(REPORT))
    build = pytest.importorskip("build")
    monkeypatch.setattr(build, "BUILD", tmp_path / "build")
    found = set()
    monkeypatch.setattr(build.datasets, "find", lambda name: name in found)
    build.start_anew_if_changed(2)
    table = tmp_path / "build" / "quality.csv"
    table.write_text("without Fandisk")
    build.start_anew_if_changed(2)
    assert table.exists()
    found |= {"fandisk-clean", "fandisk-noisy"}
    build.start_anew_if_changed(2)
    assert not table.exists()


def blank(page, paper=842, margin=76.5):
    """How much of a page's text area is blank: rows without ink, in gaps above 24 points.

    Less are the gaps around formulas, headings and figures. ``page`` is an array of grey
    values, 255 white; paper and margin are heights in points.
    """
    point = len(page) / paper
    area = page[round(margin * point) : round((paper - margin) * point)]
    rows = np.concatenate([[True], (area < 250).any(axis=1), [True]])
    gaps = np.diff(np.flatnonzero(rows)) - 1
    return gaps[gaps > 24 * point].sum() / len(area)


def test_a_gap_on_a_page_is_measured():
    page = np.full((842, 595), 255)
    page[77:765:12, 80:500] = 0  # lines of text
    assert blank(page) == 0
    page[400:538] = 255
    assert blank(page) == pytest.approx(0.2, abs=24 / 689)  # with the space to the lines around
    assert blank(page[:, ::-1]) == blank(page)
    page[:] = 255
    assert blank(page) == 1


# The report with few noise draws and four of its filters, one of each sort.
BUILD = """
import sys

sys.path.insert(0, "report")

import build
from meshfair import denoising

denoising.methods = lambda: ["averaging", "taubin", "bilateral-normal", "learned"]
build.main()
"""


# Of meshes that are not there.
UNMEASURED = ("f16", "bunny", "fandisk", "pair-", "learned-fandisk", "learned-pair")


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """A build of the report from a copy of its sources."""
    copy = tmp_path_factory.mktemp("project")
    shutil.copytree(ROOT / "lib", copy / "lib", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(REPORT, copy / "report", ignore=shutil.ignore_patterns("build", "report.pdf"))
    build(copy, "first.pdf")
    return copy


def build(copy, name):
    command = [sys.executable, "-c", BUILD, "--draws", "2", "--out", name]
    finished = subprocess.run(command, cwd=copy, capture_output=True, text=True, timeout=900)
    assert finished.returncode == 0, finished.stderr[-3000:]
    assert (copy / name).read_bytes().startswith(b"%PDF")


@pytest.mark.slow
@pytest.mark.xdist_group("report")
def test_the_numbers_are_those_of_the_tables(built):
    import pandas as pd

    folder = built / "report/build"
    numbers = json.loads((folder / "numbers.json").read_text(encoding="utf-8"))
    used = set(re.findall(r'#n\("([^"]*)"\)', without(r"//[^\n]*", TEXT)))
    missing = {key for key in used if key not in numbers} - {
        key for key in used if key.startswith(UNMEASURED)
    }
    assert missing == set()
    knot = pd.read_csv(folder / "tables/knot.csv").set_index(["weights", "time"])
    assert numbers["knot-comb-10"] == f"{knot.loc[('combinatorial', 10.0), 'snr']:.2f}"
    kernels = pd.read_csv(folder / "tables/kernel_transfer.csv").set_index(
        ["learned_from", "tried_on"]
    )
    assert numbers["transfer-box-torus"] == f"{kernels.loc[('torus', 'box'), 'normal_angle']:.1f}"
    table = pd.read_csv(folder / "tables/table_1.csv")
    cell = table.query("noise == 'normals' and weights == 'combinatorial'").iloc[0]
    assert numbers["t1-first-normals-comb"] == f"{cell['snr_mean']:.1f}"


@pytest.mark.slow
@pytest.mark.xdist_group("report")
def test_a_killed_build_goes_on_and_gives_the_same_bytes(built):
    folder = built / "report/build"
    finished = folder / "tables/jet.csv"  # the one table that the kill has left
    before = finished.stat().st_mtime_ns
    for table in folder.glob("tables/*.csv"):
        if table != finished:
            table.unlink()
    journal = folder / "quality.jsonl"
    rows = journal.read_bytes().splitlines(keepends=True)
    kept = b"".join(rows[: len(rows) // 2]) + rows[-1][:50]  # killed while it wrote a row
    journal.write_bytes(kept)
    shutil.rmtree(folder / "figures")
    (folder / "numbers.json").unlink()
    build(built, "second.pdf")
    assert finished.stat().st_mtime_ns == before
    assert journal.read_bytes().startswith(kept)
    assert (built / "second.pdf").read_bytes() == (built / "first.pdf").read_bytes()


# Another process typesets the pages as pictures: as the PDF is, by the same compiler.
PAGES = """
import typst

options = {"root": "report", "ignore_system_fonts": True, "format": "png", "ppi": 48}
for k, page in enumerate(typst.compile("report/report.typ", **options)):
    open(f"page-{k:02d}.png", "wb").write(page)
"""


@pytest.mark.slow
@pytest.mark.xdist_group("report")
def test_no_page_but_the_last_is_more_than_a_sixth_blank(built):
    from PIL import Image

    subprocess.run([sys.executable, "-c", PAGES], cwd=built, check=True)
    pages = sorted(built.glob("page-*.png"))
    assert len(pages) > 10
    shares = [blank(np.asarray(Image.open(page).convert("L"))) for page in pages]
    assert max(shares[:-1]) <= 1 / 6, shares


@pytest.mark.slow
@pytest.mark.xdist_group("report")
def test_the_pdf_can_be_read_aloud(built):
    pdf = (built / "first.pdf").read_bytes()
    # The compiler refuses this standard's name where a picture or a formula has no words.
    assert re.search(rb"pdfuaid:part[^\d]{1,3}1", pdf)
    assert b"/MarkInfo" in pdf
    assert b"/StructTreeRoot" in pdf
