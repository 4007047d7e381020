"""The notebooks in JupyterLab, in a real browser: sliders, pointer, frames, errors.

Leaves pictures of what a reader sees in ``screenshots/``: look at them.
"""

import json
import os
import secrets
import shutil
import socket
import statistics
import subprocess
import sys
import time
import urllib.request
from contextlib import suppress
from pathlib import Path

import pytest

from meshfair import viewer

ROOT = Path(__file__).parents[1]
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
QUIET = [
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]


def missing():
    """What the browser tests lack here, in words; nothing where they can run."""
    if CHROMIUM is None:
        return "no chromium is installed (Debian: apt-get install chromium)"
    for library in ("playwright", "jupyterlab", "anywidget"):
        try:
            __import__(library)
        except ImportError:
            return f"{library} is not installed (pip install 'meshfair[test]')"
    if not viewer.has_egl():
        return "polyscope cannot draw here: no EGL"
    return None


pytestmark = [
    pytest.mark.skipif(missing() is not None, reason=f"no browser test: {missing()}"),
    # One lab and one browser at a time: they share two cores with the kernel.
    pytest.mark.xdist_group("browser"),
]

# Runs in the page: notes when each frame of a panel arrives, and what its caption says then.
WATCH = """panel => {
    window.seen = [];
    const caption = panel.parentElement.querySelector("figcaption");
    new MutationObserver(() => window.seen.push({
        time: performance.now(), caption: caption.textContent,
        draft: panel.dataset.draft === "true",
    })).observe(panel, { attributeFilter: ["data-frame"] });
    for (const name of ["keydown", "pointermove", "change"]) {
        document.addEventListener(name, () => (window.moved = performance.now()), true);
    }
}"""


class Lab:
    """JupyterLab on this machine alone, with its own settings and a copy of the notebooks."""

    def __init__(self, folder):
        self.notebooks = folder / "notebooks"
        shutil.copytree(
            ROOT / "notebooks", self.notebooks, ignore=shutil.ignore_patterns("assignments", ".*")
        )
        self.token = secrets.token_hex(16)
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.url = f"http://127.0.0.1:{port}"
        settings = folder / "settings" / "@jupyterlab" / "apputils-extension"
        settings.mkdir(parents=True)
        quiet = {"fetchNews": "false", "checkForUpdates": False}
        (settings / "notification.jupyterlab-settings").write_text(json.dumps(quiet))
        # A dialog would stand before the notebook where some package brings an old extension.
        page = folder / "config" / "labconfig"
        page.mkdir(parents=True)
        (page / "page_config.json").write_text(json.dumps({"buildCheck": False}))
        own = {
            "JUPYTERLAB_SETTINGS_DIR": "settings",
            "JUPYTERLAB_WORKSPACES_DIR": "workspaces",
            "JUPYTER_CONFIG_DIR": "config",
            "JUPYTER_RUNTIME_DIR": "runtime",
            "IPYTHONDIR": "ipython",
        }
        self._log = (folder / "lab.log").open("w")
        self._process = subprocess.Popen(
            [
                *(sys.executable, "-m", "jupyter", "lab", "--no-browser", "--allow-root"),
                *("--ServerApp.ip=127.0.0.1", f"--ServerApp.port={port}"),
                f"--IdentityProvider.token={self.token}",
                f"--ServerApp.root_dir={self.notebooks}",
                "--LabApp.expose_app_in_browser=True",
            ],
            env={
                **os.environ,
                **{name: str(folder / part) for name, part in own.items()},
                "OPENBLAS_NUM_THREADS": "1",  # the browser needs the other core
            },
            stdout=self._log,
            stderr=subprocess.STDOUT,
        )
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline:
            with suppress(OSError), urllib.request.urlopen(f"{self.url}/api?token={self.token}"):
                return
            time.sleep(0.1)
        raise RuntimeError(f"JupyterLab did not start; see {folder / 'lab.log'}")

    def set_parameters(self, name, values):
        """Give the copy of a notebook other parameters."""
        path = self.notebooks / name
        notebook = json.loads(path.read_text(encoding="utf-8"))
        (cell,) = [c for c in notebook["cells"] if "parameters" in c["metadata"].get("tags", [])]
        cell["source"] = [*cell["source"], "\n", values]
        path.write_text(json.dumps(notebook), encoding="utf-8")

    def stop(self):
        """End the server and its kernels."""
        self._process.terminate()
        self._process.wait(30)
        self._log.close()


class Student:
    """Someone at a notebook in the browser."""

    def __init__(self, browser, lab, name, width, height):
        self.lab, self.name = lab, name
        self.page = browser.new_page(viewport={"width": width, "height": height})
        self.complaints = []
        self.page.on("pageerror", lambda error: self.complaints.append(f"page: {error}"))
        self.page.on("console", self._heard)
        # A workspace of its own: JupyterLab would open the last student's notebook, too.
        workspace = Path(name).stem
        self.page.goto(f"{lab.url}/lab/workspaces/{workspace}/tree/{name}?token={lab.token}")
        self.page.wait_for_function(
            "window.jupyterapp?.shell.currentWidget?.sessionContext"
            "?.kernelDisplayStatus === 'idle'",
            timeout=60_000,
        )

    def _heard(self, message):
        if message.type == "error":
            self.complaints.append(f"console: {message.text}")

    def run(self, command, **arguments):
        """Carry out one of JupyterLab's commands."""
        return self.page.evaluate(
            "([command, options]) => window.jupyterapp.commands.execute(command, options)"
            ".then(result => result === true)",
            [command, arguments],
        )

    def run_all(self):
        """Run all cells; returns the seconds that it took."""
        began = time.monotonic()
        assert self.run("notebook:run-all-cells"), "a cell failed"
        return time.monotonic() - began

    def output_errors(self):
        """Error outputs of all cells."""
        return self.page.evaluate(
            """() => window.jupyterapp.shell.currentWidget.content.widgets
                .flatMap(cell => cell.model.sharedModel.outputs ?? [])
                .filter(output => output.output_type === "error")
                .map(output => output.evalue)"""
        )

    def go_to(self, cell_id):
        """Scroll to a cell; returns its place in the page."""
        k = self.page.evaluate(
            """async id => {
                const notebook = window.jupyterapp.shell.currentWidget.content;
                const k = notebook.widgets.findIndex(cell => cell.model.id === id);
                notebook.activeCellIndex = k;
                await notebook.scrollToItem(k, "start");
                return k;
            }""",
            cell_id,
        )
        cell = self.page.locator(f".jp-Notebook .jp-Cell[data-windowed-list-index='{k}']")
        cell.locator(".meshfair-view .stage[data-frame]").first.wait_for(timeout=30_000)
        return cell

    def slider(self, cell, label):
        """The handle of a slider by its label, ready for the arrow keys."""
        row = cell.locator(".widget-inline-hbox", has=self.page.get_by_text(label, exact=True))
        return row.locator(".noUi-handle")

    def settle(self, cell):
        """Wait until all panels show good frames."""
        self.page.wait_for_function(
            "cell => [...cell.querySelectorAll('.stage')].every(s => s.dataset.draft === 'false')",
            arg=cell.element_handle(),
            timeout=30_000,
        )

    def frame_times(self, moves, wanted):
        """Milliseconds from each move to the first frame that shows it.

        Parameters
        ----------
        moves : sequence of callables
        wanted : sequence of str
            What the caption then says.
        """
        times = []
        for move, caption in zip(moves, wanted, strict=True):
            self.page.evaluate("window.seen.length = 0")
            move()
            self.page.wait_for_function(
                "text => window.seen.some(frame => frame.caption.includes(text))",
                arg=caption,
                timeout=20_000,
            )
            times.append(
                self.page.evaluate(
                    "text => window.seen.find(f => f.caption.includes(text)).time - window.moved",
                    caption,
                )
            )
            self.page.wait_for_timeout(100)  # a hand is not quicker
        return times

    def picture(self, name):
        """Take a screenshot for people to look at."""
        folder = ROOT / "screenshots"
        folder.mkdir(exist_ok=True)
        self.page.screenshot(path=folder / f"{name}.png")

    def drag(self, stage, moves=20):
        """Drag across a panel; returns the milliseconds from each move to the next frame."""
        box = stage.bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        mouse, times = self.page.mouse, []
        mouse.move(x, y)
        mouse.down()
        for k in range(moves):
            self.page.evaluate("window.seen.length = 0")
            mouse.move(x + 4 * (k + 1), y + (k % 5))
            self.page.wait_for_function("window.seen.length > 0", timeout=20_000)
            times.append(self.page.evaluate("window.seen[0].time - window.moved"))
        mouse.up()
        return times


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    lab = Lab(tmp_path_factory.mktemp("lab"))
    lab.set_parameters("03-heat-flow.ipynb", "SECTIONS, SIDES = 360, 42")
    lab.set_parameters("05-the-jet.ipynb", "DETAIL = 1.4")
    yield lab
    lab.stop()


@pytest.fixture(scope="module")
def browser():
    from playwright.sync_api import sync_playwright

    sandbox = ["--no-sandbox"] if os.geteuid() == 0 else []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=[*QUIET, *sandbox])
        yield browser
        browser.close()


def report(capsys, text):
    with capsys.disabled():
        print(f"\n  {text}")


def summary(times):
    return f"median {statistics.median(times):.0f} ms, longest {max(times):.0f} ms"


def test_heat_flow_of_30000_triangles(lab, browser, capsys):
    student = Student(browser, lab, "03-heat-flow.ipynb", 1366, 900)
    seconds = student.run_all()
    cell = student.go_to("heat-explorer")
    stages = cell.locator(".stage")
    student.settle(cell)
    assert stages.count() == 3
    before = [stages.nth(k).screenshot() for k in range(3)]
    student.picture("03-heat-light-wide")
    stages.nth(2).evaluate(WATCH)

    # The step slider chooses among computed steps, the time step computes the flow anew.
    step = student.slider(cell, "iteration")
    step.focus()
    right = [lambda: student.page.keyboard.press("ArrowRight")] * 20
    steps = student.frame_times(right, [f"t = {0.2 * k:.2f}," for k in range(1, 21)])
    student.slider(cell, "time step τ").focus()
    left = [lambda: student.page.keyboard.press("ArrowLeft")] * 3
    right = [lambda: student.page.keyboard.press("ArrowRight")] * 6
    values = [0.15, 0.10, 0.05, 0.10, 0.15, 0.20, 0.25, 0.30, 0.35]
    taus = student.frame_times(left + right, [f"t = {20 * tau:.2f}," for tau in values])

    # Twenty moves as fast as they can be made: the last is what stays on the screen.
    step.focus()
    for _ in range(20):
        student.page.keyboard.press("ArrowLeft")
    student.page.wait_for_function("window.seen.at(-1).caption.includes('t = 0.00,')")
    student.settle(cell)
    assert "t = 0.00," in cell.locator("figcaption").nth(2).inner_text()

    drags = student.drag(stages.nth(0))
    student.settle(cell)
    after = [stages.nth(k).screenshot() for k in range(3)]
    assert all(a != b for a, b in zip(after, before, strict=True)), "the cameras are not linked"

    # The reset button brings the first picture back, and play moves the step.
    cell.get_by_text("Reset view").click()
    student.settle(cell)
    cell.locator(".widget-play button").first.click()
    student.page.wait_for_function(
        "parseFloat(window.seen.at(-1).caption.match(/t = ([\\d.]+)/)[1]) > 1", timeout=30_000
    )
    cell.locator(".widget-play button").first.click()

    student.go_to("stability-explorer")
    student.picture("03-stability-light-wide")
    assert student.output_errors() == []
    assert student.complaints == []
    report(capsys, f"03 with 30,240 triangles: all cells in {seconds:.1f} s")
    report(capsys, f"step slider to frame: {summary(steps)}")
    report(capsys, f"time-step slider to frame (a new flow): {summary(taus)}")
    report(capsys, f"drag to frame (three panels): {summary(drags)}")
    student.page.close()


def test_jet_in_both_themes_and_on_a_narrow_page(lab, browser, capsys):
    student = Student(browser, lab, "05-the-jet.ipynb", 1366, 900)
    seconds = student.run_all()
    cell = student.go_to("explorer")
    student.settle(cell)
    stages = cell.locator(".stage")
    stages.nth(1).evaluate(WATCH)
    before = [stages.nth(k).screenshot() for k in range(3)]

    student.slider(cell, "iteration").focus()
    right = [lambda: student.page.keyboard.press("ArrowRight")] * 10
    steps = student.frame_times(right, [f"t = {0.2 * k:.2f}," for k in range(1, 11)])
    for _ in range(20):
        student.page.keyboard.press("ArrowLeft")
        student.page.keyboard.press("ArrowRight")
    student.settle(cell)
    assert "t = 2.00," in cell.locator("figcaption").nth(1).inner_text()
    drags = student.drag(stages.nth(1))
    student.settle(cell)
    after = [stages.nth(k).screenshot() for k in range(3)]
    assert all(a != b for a, b in zip(after, before, strict=True))
    student.picture("05-jet-light-wide")

    student.page.evaluate("window.seen.length = 0")
    cell.get_by_role("combobox").first.select_option("a wing-tip missile")
    student.page.wait_for_function("window.seen.length > 0", timeout=20_000)
    cell.get_by_label("with missiles").uncheck()
    cell.get_by_label("with missiles").check()
    student.run("apputils:change-theme", theme="JupyterLab Dark")
    student.page.wait_for_timeout(1000)
    student.settle(cell)
    student.picture("05-missile-dark-wide")

    student.page.set_viewport_size({"width": 700, "height": 900})
    student.run("application:toggle-left-area")
    student.page.wait_for_timeout(1000)
    cell = student.go_to("explorer")
    student.settle(cell)
    student.picture("05-missile-dark-narrow")
    student.run("apputils:change-theme", theme="JupyterLab Light")
    student.page.wait_for_timeout(1000)
    student.settle(cell)
    student.picture("05-missile-light-narrow")

    assert student.output_errors() == []
    assert student.complaints == []
    report(capsys, f"05 with 29,020 triangles in each panel: all cells in {seconds:.1f} s")
    report(capsys, f"step slider to frame (three panels): {summary(steps)}")
    report(capsys, f"drag to frame (three panels): {summary(drags)}")
    student.page.close()


def test_filters_by_name_and_cancelled_by_the_next_choice(lab, browser, capsys):
    student = Student(browser, lab, "07-which-filter.ipynb", 1366, 900)
    seconds = student.run_all()
    cell = student.go_to("explorer")
    student.settle(cell)
    stages, captions = cell.locator(".stage"), cell.locator("figcaption")
    assert stages.count() == 3
    student.picture("07-box-light-wide")
    stages.nth(1).evaluate(WATCH)

    def choose(menu, entry, caption):
        began = time.monotonic()
        student.page.evaluate("window.seen.length = 0")
        cell.get_by_role("combobox").nth(menu).select_option(entry)
        student.page.wait_for_function(
            "text => window.seen.some(frame => frame.caption.startsWith(text))",
            arg=caption,
            timeout=30_000,
        )
        return time.monotonic() - began

    mesh, method = 0, 1
    heat = choose(method, "heat", "heat: ")
    torus = choose(mesh, "torus", "heat: ")
    student.settle(cell)
    student.picture("07-torus-light-wide")

    # l0 on the jet takes seconds: the noisy jet is there meanwhile, and the bar; heat ends it.
    cell.get_by_role("combobox").nth(method).select_option("l0")
    choose(mesh, "jet", "l0: at work")
    cell.get_by_role("button", name="Cancel").wait_for(timeout=10_000)
    student.picture("07-at-work-light-wide")
    jet = choose(method, "heat", "heat: ")
    student.settle(cell)
    assert "noisy: " in captions.nth(0).inner_text()
    assert "mean normal angle" in cell.inner_text()
    student.run("apputils:change-theme", theme="JupyterLab Dark")
    student.page.wait_for_timeout(1000)
    student.settle(cell)
    student.picture("07-jet-dark-wide")
    student.page.set_viewport_size({"width": 700, "height": 900})
    student.run("application:toggle-left-area")
    student.page.wait_for_timeout(1000)
    cell = student.go_to("explorer")
    student.settle(cell)
    student.picture("07-jet-dark-narrow")
    student.run("apputils:change-theme", theme="JupyterLab Light")

    assert student.output_errors() == []
    assert student.complaints == []
    report(capsys, f"07: all cells in {seconds:.1f} s")
    report(
        capsys, f"another method, mesh, and one that cancels: {heat:.1f}, {torus:.1f}, {jet:.1f} s"
    )
    student.page.close()
