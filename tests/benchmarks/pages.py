"""Pages without a kernel in headless Chromium: milliseconds from a hand's move to its frame.

`python tests/benchmarks/pages.py` makes pages of the notebooks' largest meshes and measures them,
beside a page on which a box follows the pointer: what this browser needs at the least, on this
machine and at this moment. Pages to measure instead may be named, such as those of the site.
"""

import json
import os
import shutil
import statistics
import sys
import tempfile
import time
from pathlib import Path

from playwright.sync_api import sync_playwright

from meshfair import explorers, shapes
from meshfair.viewer import SideBySide

WANTED = 50  # ms, the median
STEPS, BETWEEN = 20, 0.15  # of the pointer or a slider, and seconds between them
MOVES, EVERY = 60, 0.016  # of a fast drag
WIDTH = 900  # of the page: about what the site's theme leaves on a wide screen
ARGS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-first-run"]
READY = "document.querySelector('.stage')?.dataset.frame > 0"
LEAST = """<!doctype html><title>least</title>
<div class="stage" data-frame="1" style="width: 300px; height: 300px; background: #8ac"></div>
<div class="along"><input type="range"></div>
<script>
const box = document.querySelector(".stage");
let at = 0;
const move = () => requestAnimationFrame(() => {
  box.style.marginLeft = `${(at += 1)}px`;
  box.dataset.frame = at;
});
for (const kind of ["pointermove", "input"]) addEventListener(kind, move);
</script>"""


def write(folder):
    """Pages with the largest meshes of the notebooks, and the one to compare with."""
    folder = Path(folder)
    knot, jet = shapes.knot(240, 24), shapes.jet()
    heat = explorers.HeatExplorer(*knot, size=0.4, iterations=40)
    flown = explorers.JetExplorer(iterations=20)
    for explorer in (heat, flown):
        explorer.wait(600)
    pages = {
        "one knot, with edges": SideBySide(*knot, edges=True),
        "three jets": SideBySide([jet[0]] * 3, jet[1], values=[jet[0][:, 0]] * 3),
        "heat flow on knots": heat,
        "heat flow on jets": flown,
    }
    (folder / "a box that follows.html").write_text(LEAST)
    for name, page in pages.items():
        page.save(folder / f"{name}.html")
    return [folder / f"{name}.html" for name in ("a box that follows", *pages)]


def latencies(browser, tab, kind, work):
    """Milliseconds from events of a kind to the frames that show what they did."""
    browser.start_tracing(page=tab, categories=["benchmark", "input", "latencyInfo"])
    work()
    tab.wait_for_timeout(300)
    begun, found = {}, []
    for event in json.loads(browser.stop_tracing())["traceEvents"]:
        if event.get("name") != "EventLatency":
            continue
        key = event["pid"], event.get("id2", {}).get("local")
        if event["ph"] == "b":
            begun[key] = event
        elif event["ph"] == "e" and key in begun:
            one = begun.pop(key)
            said = one.get("args", {}) | event.get("args", {})
            if said.get("event_latency", {}).get("event_type") == kind:
                found.append((event["ts"] - one["ts"]) / 1000)
    return found


def measured(browser, path):
    """What the first meshes in a page need for a drag and for a slider's steps."""
    tab = browser.new_page(viewport={"width": WIDTH, "height": 900})
    tab.goto(path.resolve().as_uri())
    tab.locator(".meshfair-player, .stage").first.scroll_into_view_if_needed()
    tab.wait_for_function(READY)
    tab.wait_for_timeout(1000)
    stage, slider = tab.locator(".stage").first, tab.locator(".along input[type=range]")
    box = stage.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def drag(count, seconds):
        tab.mouse.move(x, y)
        tab.mouse.down()
        for k in range(count):
            tab.mouse.move(x + 4 * (k + 1), y + k)
            time.sleep(seconds)
        tab.mouse.up()

    def slide():
        for k in range(STEPS):
            slider.first.press("ArrowLeft" if k // 2 % 2 else "ArrowRight")
            time.sleep(BETWEEN)

    times = latencies(browser, tab, "MOUSE_DRAGGED", lambda: drag(STEPS, BETWEEN))
    said = [f"drag {statistics.median(times):4.0f} ms"]
    before, began = int(stage.get_attribute("data-frame")), time.perf_counter()
    drag(MOVES, EVERY)
    frames = int(stage.get_attribute("data-frame")) - before
    said.append(f"{frames / (time.perf_counter() - began):3.0f} frames/s")
    if slider.count():
        slider.first.focus()
        times = latencies(browser, tab, "KEY_PRESSED", slide)
        said.append(f"slider {statistics.median(times):4.0f} ms")
    tab.close()
    return said


def main(paths):
    sandbox = ["--no-sandbox"] if os.geteuid() == 0 else []
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as started:
        paths = [Path(path) for path in paths] or write(folder)
        browser = started.chromium.launch(executable_path=chromium, args=[*ARGS, *sandbox])
        print(f"hand to frame, median ms; wanted {WANTED}; load {os.getloadavg()[0]:.1f}")
        for path in paths:
            print(f"  {path.stem:22s}", *measured(browser, path), sep="  ", flush=True)
        print(f"load {os.getloadavg()[0]:.1f}")
        browser.close()


if __name__ == "__main__":
    main(sys.argv[1:])
