"""JupyterLab in a real browser, and someone who works there: what browser tests share."""

import base64
import io
import json
import os
import secrets
import shutil
import socket
import subprocess
import sys
import time
import urllib.request
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
from PIL import Image

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
    """Someone at a notebook in the browser; one after the other at the same page."""

    def __init__(self, page, complaints, name):
        self.page, self.complaints = page, complaints
        complaints.clear()
        page.set_viewport_size({"width": 1366, "height": 900})
        page.evaluate(
            """async path => {
                const { commands, shell } = window.jupyterapp;
                for (const old of [...shell.widgets("main")]) {
                    await old.sessionContext?.shutdown();
                    old.dispose();
                }
                shell.expandLeft();
                await commands.execute("apputils:change-theme", { theme: "JupyterLab Light" });
                const opened = await commands.execute("docmanager:open", { path });
                await opened.sessionContext.ready;
            }""",
            name,
        )
        self.wait_for(
            "window.jupyterapp.shell.currentWidget?.sessionContext?.kernelDisplayStatus === 'idle'",
            timeout=60_000,
        )

    def wait_for(self, condition, arg=None, timeout=30_000):
        """Wait until something holds in the page."""
        self.page.wait_for_function(condition, arg=arg, timeout=timeout)

    def run_cells(self, *ids):
        """Run some cells one after the other; returns the seconds that it took."""
        began = time.monotonic()
        done = self.page.evaluate(
            """async ids => {
                const { commands, shell } = window.jupyterapp;
                const notebook = shell.currentWidget.content;
                for (const id of ids) {
                    const k = notebook.widgets.findIndex(cell => cell.model.id === id);
                    notebook.activeCellIndex = k;
                    if (k < 0 || await commands.execute("notebook:run-cell") !== true) return id;
                }
                return "all";
            }""",
            ids,
        )
        assert done == "all", f"cell {done} failed"
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
        """Scroll to a cell with a view; returns its place in the page."""
        cell = self.go_to_output(cell_id)
        cell.locator(".meshfair-view .stage[data-frame]").first.wait_for(timeout=30_000)
        return cell

    def go_to_output(self, cell_id):
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
        return self.page.locator(f".jp-Notebook .jp-Cell[data-windowed-list-index='{k}']")

    def slider(self, cell, label):
        """The handle of a slider by its label, ready for the arrow keys."""
        row = cell.locator(".widget-inline-hbox", has=self.page.get_by_text(label, exact=True))
        return row.locator(".noUi-handle")

    def frames(self, cell):
        """The panels' pictures as they came from Python."""
        encoded = cell.evaluate(
            """async cell => {
                const bytes = async image => (await fetch(image.src)).arrayBuffer();
                const frames = [...cell.querySelectorAll(".stage img")].map(bytes);
                return (await Promise.all(frames)).map(
                    frame => btoa(String.fromCharCode(...new Uint8Array(frame))));
            }"""
        )
        return [np.array(Image.open(io.BytesIO(base64.b64decode(text)))) for text in encoded]

    def settle(self, cell):
        """Wait until all panels show good frames."""
        self.wait_for(
            "cell => [...cell.querySelectorAll('.stage')].every(s => s.dataset.draft === 'false')",
            cell.element_handle(),
        )

    def redrawn(self, cell, change):
        """Change something that redraws all panels, and wait until good frames show it."""
        stages = "[...cell.querySelectorAll('.stage')]"
        before = cell.evaluate(f"cell => {stages}.map(s => s.dataset.frame)")
        change()
        self.wait_for(
            f"([cell, old]) => {stages}.every((s, k) => "
            "s.dataset.frame !== old[k] && s.dataset.draft === 'false')",
            [cell.element_handle(), before],
        )

    def theme(self, cell, name):
        """Put JupyterLab into its light or dark theme."""
        self.redrawn(
            cell,
            lambda: self.page.evaluate(
                "theme => window.jupyterapp.commands.execute('apputils:change-theme', { theme })",
                f"JupyterLab {name}",
            ),
        )

    def narrow(self, cell):
        """Make the page as narrow as half a laptop's screen."""

        def change():
            self.page.set_viewport_size({"width": 700, "height": 900})
            self.page.evaluate("window.jupyterapp.shell.collapseLeft()")

        self.redrawn(cell, change)

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
            self.wait_for("text => window.seen.some(f => f.caption.includes(text))", caption)
            times.append(
                self.page.evaluate(
                    "text => window.seen.find(f => f.caption.includes(text)).time - window.moved",
                    caption,
                )
            )
        return times

    def picture(self, name):
        """Take a screenshot for people to look at."""
        folder = ROOT / "screenshots"
        folder.mkdir(exist_ok=True)
        self.page.screenshot(path=folder / f"{name}.png")

    def drag(self, stage, moves=8):
        """Drag across a panel; returns the milliseconds from each move to the next frame."""
        box = stage.bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        mouse, times = self.page.mouse, []
        mouse.move(x, y)
        mouse.down()
        for k in range(moves):
            self.page.evaluate("window.seen.length = 0")
            mouse.move(x + 4 * (k + 1), y + (k % 5))
            self.wait_for("window.seen.length > 0")
            times.append(self.page.evaluate("window.seen[0].time - window.moved"))
        mouse.up()
        return times


@contextmanager
def browser_at(lab):
    """JupyterLab in a browser, and what the page complained of."""
    from playwright.sync_api import sync_playwright

    sandbox = ["--no-sandbox"] if os.geteuid() == 0 else []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=[*QUIET, *sandbox])
        page, complaints = browser.new_page(), []
        page.on("pageerror", lambda error: complaints.append(f"page: {error}"))
        page.on(
            "console",
            lambda message: message.type == "error" and complaints.append(message.text),
        )
        page.goto(f"{lab.url}/lab?token={lab.token}")
        page.wait_for_function("window.jupyterapp", timeout=60_000)
        page.evaluate("window.jupyterapp.restored.then(() => true)")
        yield page, complaints
        browser.close()
