"""What several test files share, and which of them are slow."""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

# No deadline: a slow machine is no fault. In CI the examples are the same in every run.
settings.register_profile("meshfair", deadline=None, derandomize=bool(os.environ.get("CI")))
settings.load_profile("meshfair")


# What `make check` leaves out: what starts browsers, kernels, builds and other processes, or reads
# thousands of files. So do tests on real meshes. The rest are the numerical tests.
SLOW = {
    "test_assignments", "test_benchmarks", "test_browser", "test_browser_explorers",
    "test_browser_saved", "test_cli",
    "test_cli_view", "test_cluster", "test_fairness", "test_grading", "test_install", "test_io",
    "test_notebooks", "test_pages",
    "test_report", "test_site", "test_submissions", "test_sweep", "test_walls",
}  # fmt: skip


@pytest.hookimpl(tryfirst=True)  # before pytest itself selects by marker
def pytest_collection_modifyitems(items):
    for item in items:
        if item.path.stem in SLOW or "mirror" in item.fixturenames:
            item.add_marker(pytest.mark.slow)


def pytest_ignore_collect(collection_path, config):
    # Files of which nothing would run need not be imported.
    if config.option.markexpr == "not slow" and collection_path.stem in SLOW:
        return True
    return None


@pytest.fixture
def rng():
    """Random numbers, the same in every run."""
    return np.random.default_rng(20210123)


@pytest.fixture(scope="session")
def mirror():
    """The folder of real meshes; a test that needs them is skipped where there is none."""
    folder = os.environ.get("MESHFAIR_MIRROR")
    if not folder or not Path(folder).is_dir():
        pytest.skip("MESHFAIR_MIRROR names no folder of real meshes")
    return Path(folder)


@pytest.fixture(scope="module")
def browser():
    """A browser that draws by software, for pages on file."""
    from lab import CHROMIUM

    if CHROMIUM is None:
        pytest.skip("no chromium is installed (Debian: apt-get install chromium)")
    playwright = pytest.importorskip("playwright.sync_api")
    software = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-first-run"]
    sandbox = ["--no-sandbox"] if os.geteuid() == 0 else []
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=CHROMIUM, args=[*software, *sandbox])
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def page(lab):
    """JupyterLab in a browser, and what it complained of: one for all tests of a module's lab."""
    from lab import browser_at

    with browser_at(lab) as both:
        yield both
