"""The site: built whole, without warnings; its pages opened in a browser, from their files."""

import base64
import io
import os
import re
import subprocess
import sys
import tempfile
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from filelock import FileLock
from PIL import Image

from lab import CHROMIUM

pytest.importorskip("sphinx", reason="needs the site extra")
playwright = pytest.importorskip("playwright.sync_api", reason="needs the test extra")

ROOT = Path(__file__).resolve().parent.parent
PAGES = ROOT / "report" / "pages"
SITE = ROOT / "report" / "site"

sys.path.insert(0, str(PAGES))
import docstrings  # noqa: E402
import execution  # noqa: E402
import gallery  # noqa: E402
import nbformat  # noqa: E402
import public  # noqa: E402

pytestmark = pytest.mark.xdist_group("report")  # one worker builds both, into one folder


@pytest.fixture(scope="session")
def site():
    """The folder of the built site."""
    # Two workers were seen to build in spite of the group, the one while the other read.
    run = os.environ.get("PYTEST_XDIST_TESTRUNUID", str(os.getpid()))
    done = Path(tempfile.gettempdir()) / f"meshfair-site-{run}"
    with FileLock(done.with_suffix(".lock")):
        if done.exists():
            return SITE
        built = subprocess.run(
            [sys.executable, str(PAGES / "assemble.py")], capture_output=True, text=True, cwd=ROOT
        )
        assert built.returncode == 0, (built.stdout + built.stderr)[-4000:]
        assert "WARNING: /" not in built.stderr
        done.touch()
    return SITE


def test_a_picture_goes_by_the_name_of_its_own_mesh():
    notebook = nbformat.reads(gallery.notebook("l0"), as_version=4)
    cells = [cell for cell in notebook.cells if "picture" in cell.metadata.get("tags", ())]
    assert [cell.metadata.mesh for cell in cells] == list(gallery.MESHES)
    for k, cell in enumerate(cells[1:]):  # the first one's has not come about
        written = io.BytesIO()
        Image.new("RGB", (640, 480), (0, 0, 250 * k)).save(written, "png")
        png = base64.b64encode(written.getvalue()).decode()
        cell.outputs = [nbformat.v4.new_output("display_data", {"image/png": png})]
    found = gallery.thumbnails("l0", notebook)
    assert list(found) == ["l0-torus.webp", "l0-jet.webp"]
    pictures = [Image.open(io.BytesIO(picture)) for picture in found.values()]
    assert {picture.size for picture in pictures} == {(320, 240)}
    assert [picture.getpixel((9, 9))[2] > 200 for picture in pictures] == [False, True]


class Found(HTMLParser):
    """What a page leads to, and its own anchors."""

    def __init__(self, page):
        super().__init__()
        self.links, self.anchors, self.used = [], set(), []
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        facts = dict(attributes)
        self.anchors |= {facts.get("id"), facts.get("name")}
        if tag == "a" and facts.get("href"):
            self.links.append(facts["href"])
        for key in ("src", "data") if tag != "a" else ():
            if facts.get(key):
                self.used.append(facts[key])
        if tag == "link" and facts.get("rel") == "stylesheet":
            self.used.append(facts["href"])


def pages(site):
    return sorted(page for page in site.rglob("*.html") if "_static" not in page.parts)


def test_every_link_leads_somewhere(site):
    found = {page: Found(page) for page in pages(site)}
    dead = []
    for page, facts in found.items():
        for target in [*facts.links, *facts.used]:
            parts = urlsplit(target)
            if parts.scheme or parts.netloc or target.startswith("data:"):
                continue
            file = (page.parent / unquote(parts.path)).resolve() if parts.path else page
            if file.is_dir():
                file = file / "index.html"
            anchor = unquote(parts.fragment)
            lost = anchor and file in found and anchor not in found[file].anchors
            if lost or not file.exists():
                dead.append(f"{page.relative_to(site)} -> {target}")
    assert not dead, dead[:20]


def test_nothing_is_taken_from_elsewhere(site):
    for page in pages(site):
        for target in Found(page).used:
            assert not re.match(r"(https?:)?//", target), (page.name, target)


class Prose(HTMLParser):
    """The text of a page outside of code."""

    CODE = ("pre", "code", "script", "style", "textarea")

    def __init__(self, page):
        super().__init__()
        self.inside, self.said = 0, []
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        self.inside += tag in self.CODE

    def handle_endtag(self, tag):
        self.inside -= tag in self.CODE

    def handle_data(self, text):
        if not self.inside:
            self.said.append(text)


def test_no_formula_is_left_as_text_and_no_kernel_file_is_named(site):
    for page in pages(site):
        # Typeset ones stand between \( and \), or \[ and \].
        dollars = [text for text in Prose(page).said if "$" in text]
        assert not dollars, (page.name, dollars[:3])
        assert "ipykernel_" not in page.read_text(encoding="utf-8"), page.name


def test_every_public_function_is_in_the_reference(site):
    for module in public.MODULES:
        page = site / "reference" / f"{module}.html"
        # What Python says of a field that has no docstring.
        assert "Alias for field number" not in page.read_text(encoding="utf-8"), module
        anchors = Found(page).anchors
        missing = {
            name for name in public.members(module) if f"meshfair.{module}.{name}" not in anchors
        }
        assert not missing, (module, missing)


def test_every_notebook_and_filter_has_its_page(site):
    for path in (ROOT / "notebooks").glob("[0-9][0-9]-*.ipynb"):
        page = (site / "notebooks" / path.name).with_suffix(".html")
        assert "prev-next" in page.read_text(encoding="utf-8"), path.name


# Third parties' own: jupyter_client's and zmq's, on their way to newer versions.
@pytest.mark.filterwarnings("ignore::DeprecationWarning:(jupyter_client|nbclient|zmq|traitlets)")
@pytest.mark.filterwarnings("ignore::ResourceWarning")
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_notebook_is_run_again_only_if_the_package_or_its_cells_have_changed(tmp_path):
    nbformat = pytest.importorskip("nbformat")
    module = tmp_path / "module.py"
    module.write_text("1")
    folder = execution.cache_folder(tmp_path / "executed", [module])
    path = tmp_path / "a.ipynb"

    def outcome(code, folder):
        cell = nbformat.v4.new_code_cell(code, id="only")
        notebook = nbformat.v4.new_notebook(cells=[cell])
        notebook.metadata["kernelspec"] = {"name": "python3", "display_name": "Python 3"}
        path.write_text(nbformat.writes(notebook))
        done = execution.execute([path], folder, tmp_path / "scratch")
        return done[path].cells[0].outputs[0].data["text/plain"]

    first = outcome("import random\nrandom.random()", folder)
    assert outcome("import random\nrandom.random()", folder) == first
    assert outcome("import random\nrandom.random() + 0", folder) != first
    module.write_text("2")
    other = execution.cache_folder(tmp_path / "executed", [module])
    assert outcome("import random\nrandom.random()", other) != first
    assert not folder.exists()


def test_formulas_are_those_of_docstrings():
    text = " ".join(
        path.read_text(encoding="utf-8") for path in (ROOT / "lib" / "meshfair").rglob("*.py")
    )
    text = " ".join(text.split())
    assert [plain for plain in docstrings.formulas() if plain not in text] == []


@pytest.mark.parametrize(
    ("text", "missing"),
    [
        ("Say.\n\nRaises\n------\nValueError\n    Always.", []),
        ("Say.", ["Raises"]),
    ],
)
def test_a_docstring_that_lacks_a_section_is_found(text, missing):
    def refuse(n):
        if n < 0:
            raise ValueError("no")

    assert docstrings.missing_sections(refuse, text) == missing


# A width of a laptop and of a telephone, each in light and in dark.
LOOKS = [(width, scheme) for width in (1440, 390) for scheme in ("light", "dark")]


def listen(tab, complaints):
    """Note errors of a page, and what it asks of other machines."""

    def console(message):
        if message.type == "error":
            complaints.append((tab.url, message.text))

    def request(asked):
        if asked.url.startswith("http"):
            complaints.append((tab.url, asked.url))

    tab.on("console", console)
    tab.on("request", request)
    tab.on("pageerror", lambda error: complaints.append((tab.url, str(error))))


@pytest.mark.skipif(CHROMIUM is None, reason="no chromium is installed")
@pytest.mark.filterwarnings("ignore::ResourceWarning")
def test_no_page_complains_in_a_browser(site):
    with playwright.sync_playwright() as library:
        browser = library.chromium.launch(
            executable_path=CHROMIUM,
            args=["--no-sandbox", "--disable-background-networking", "--disable-sync"],
        )
        complaints = []
        for width, scheme in LOOKS:
            context = browser.new_context(
                viewport={"width": width, "height": 900}, color_scheme=scheme
            )
            tab = context.new_page()
            listen(tab, complaints)
            for page in pages(site):
                # The pages of sources are all made alike: one look at each is enough.
                if "_modules" in page.parts and (width, scheme) != LOOKS[0]:
                    continue
                tab.goto(page.as_uri(), wait_until="load")
                wide = tab.evaluate("document.documentElement.scrollWidth")
                if wide > width + 1:
                    complaints.append((tab.url, f"{wide} pixels wide in {width}, {scheme}"))
            context.close()
        browser.close()
    assert not complaints, complaints[:20]
