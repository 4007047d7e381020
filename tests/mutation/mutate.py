"""Whether the tests find small errors that are planted in the formulas: `make mutate`.

    python tests/mutation/mutate.py [MODULE ...] [--jobs N] [--list]

Each mutant of `mutants.py` is loaded in place of its module, and those tests run that call the
function in which it lies, the quickest first, until one fails. Nothing is written: a process that
has loaded NumPy, SciPy and pytest, but nothing of ours, forks for every mutant, and the child
compiles the module from the changed syntax tree. Random examples are the same for each mutant and
are not shrunk. Small meshes are the business of the NumPy forms alone; the tests by which fast
equals plain load numba.

Prints a table and each survivor with its place and the change. Exit code 1 where less than 95 of
100 die, 2 where the tests fail without any mutant. (It forks: on Windows use WSL.)
"""

import argparse
import contextlib
import importlib.abc
import importlib.machinery
import importlib.util
import json
import os
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter, defaultdict
from pathlib import Path

# What children need and nothing of ours: loaded once.
import hypothesis
import hypothesis.strategies
import igl  # noqa: F401
import numpy as np  # noqa: F401
import pytest
import scipy.linalg
import scipy.sparse.csgraph
import scipy.sparse.linalg
import scipy.spatial  # noqa: F401
from mutants import Mutant, mutants

TESTS = Path(__file__).resolve().parents[1]
PACKAGE = TESTS.parent / "lib" / "meshfair"
MODULES = ["weights", "operators", "flow", "noise"]
MODULES += [f"metrics/{path.stem}" for path in sorted(PACKAGE.glob("metrics/[!_]*.py"))]
FILTERS = [f"filters/{path.stem}" for path in sorted(PACKAGE.glob("filters/[!_]*.py"))]
# Tests of the numerical modules; which of them concern a mutant is measured.
FILES = (
    "checks", "denoising", "fast_equals_plain", "fast_filters", "filters", "flow", "intrinsic",
    "kernel_table", "learned", "mesh", "metrics", "noise", "operators", "reference", "solve",
    "spectrum", "stability", "sure", "weights",
)  # fmt: skip
LEAST = 0.95
MEMORY = 6 * 2**30
SURVIVED, KILLED, BROKEN = 0, 1, 2


def main() -> int:
    """Plant every mutant, print what became of them."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("modules", nargs="*", metavar="MODULE", help=", ".join(MODULES + FILTERS))
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--list", action="store_true", help="print the mutants and stop")
    options = parser.parse_args()
    chosen = options.modules or MODULES + FILTERS
    if unknown := set(chosen) - {*MODULES, *FILTERS}:
        parser.error(f"no such modules: {', '.join(sorted(unknown))}")
    assert "meshfair" not in sys.modules, "children would not load the mutant"
    started = time.perf_counter()
    planted = [
        (module, mutant)
        for module in chosen
        for mutant in mutants(path(module).read_text(encoding="utf-8"), str(path(module)))
    ]
    if options.list:
        for module, mutant in planted:
            print(f"{module}.py:{mutant.line}: {mutant.change}")
        return 0
    tests = watch(chosen)
    print(f"{len(planted)} mutants, {len(tests)} tests", flush=True)
    outcomes = run_all(planted, tests, options.jobs)
    return report(chosen, planted, outcomes, time.perf_counter() - started)


def path(module: str) -> Path:
    """The file of a module."""
    return PACKAGE / f"{module}.py"


def report(chosen: list, planted: list, outcomes: list, seconds: float) -> int:
    """Print the table and the survivors; the exit code."""
    count = defaultdict(Counter)
    for (module, _), outcome in zip(planted, outcomes, strict=True):
        count[module][outcome] += 1
    print(f"\n{'module':28}{'mutants':>8}{'killed':>8}{'survivors':>10}{'killed':>9}")
    total = sum(count.values(), Counter())
    for name, row in [*((module, count[module]) for module in chosen), ("all", total)]:
        share = row[KILLED] / max(1, row.total())
        print(f"{name:28}{row.total():8}{row[KILLED]:8}{row[SURVIVED]:10}{share:9.1%}")
    print()
    for (module, mutant), outcome in zip(planted, outcomes, strict=True):
        if outcome == SURVIVED:
            print(f"survived: {module}.py:{mutant.line}: {mutant.change}")
    print(f"\n{seconds / 60:.1f} minutes")
    return int(total[KILLED] < LEAST * total.total())


def run_all(planted: list, tests: dict, jobs: int) -> list[int]:
    """Outcome of each mutant, ``jobs`` of them at a time."""
    outcomes = [BROKEN] * len(planted)
    running: dict[int, tuple[int, float]] = {}
    waiting = list(range(len(planted)))[::-1]
    while waiting or running:
        while waiting and len(running) < jobs:
            k = waiting.pop()
            module, mutant = planted[k]
            concerned = {
                name: seconds
                for name, (seconds, calls) in tests.items()
                if any(line in mutant.function for line in calls.get(module, ()))
            }
            if not concerned:
                outcomes[k] = SURVIVED
                continue
            child = fork(lambda m=module, x=mutant, c=concerned: run_tests(c, m, x))
            running[child] = k, time.monotonic() + 10 + 4 * sum(concerned.values())
        for child, (k, deadline) in list(running.items()):
            finished, status = os.waitpid(child, os.WNOHANG)
            if not finished and time.monotonic() > deadline:  # an endless loop is found, too
                os.killpg(child, signal.SIGKILL)
                finished, status = os.waitpid(child, 0)
            if finished:
                outcomes[k] = KILLED if status else SURVIVED
                del running[child]
                done = len(planted) - len(waiting) - len(running)
                if done % 50 == 0:
                    print(f"{done} of {len(planted)}", flush=True)
        time.sleep(0.005)
    return outcomes


def fork(work) -> int:
    """A silent child in a process group of its own that exits with what ``work()`` returns."""
    child = os.fork()
    if child:
        with contextlib.suppress(OSError):
            os.setpgid(child, child)  # here as well, lest it be too late for killpg
        return child
    code = BROKEN
    try:
        os.setpgid(0, 0)
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))  # what grows without end fails
        nothing = os.open(os.devnull, os.O_RDWR)
        for descriptor in (0, 1, 2):
            os.dup2(nothing, descriptor)
        code = work()
    finally:
        os._exit(code)


def run_tests(concerned: dict[str, float], module: str, mutant: Mutant) -> int:
    """In a child: 0 where all of these tests pass with the mutant."""
    sys.meta_path.insert(0, Planted(module, mutant))
    folder, _, name = module.rpartition("/")
    own = f"test_{folder or name}.py"
    # The module's own tests find most: others are not even collected then.
    first = [test for test in concerned if test.startswith(own)]
    for tests in (first, [test for test in concerned if test not in first]):
        if tests and pytest_run(Chosen(sorted(tests, key=concerned.get))):
            return KILLED
    return SURVIVED


def pytest_run(plugin: "Chosen") -> int:
    """Run pytest on the files that the plugin names."""
    files = [str(TESTS / name) for name in plugin.files()]
    options = ["-x", "-p", "no:cacheprovider", "-W", "ignore::pytest.PytestAssertRewriteWarning"]
    return int(pytest.main([*options, "--rootdir", str(TESTS.parent), *files], plugins=[plugin]))


class Planted(importlib.abc.MetaPathFinder):
    """Finds one module, and loads a mutant in its place."""

    def __init__(self, module, mutant):
        self.name = "meshfair." + module.replace("/", ".")
        self.mutant = mutant
        self.path = str(path(module))

    def find_spec(self, name, places, target=None):
        if name == self.name:
            loader = Loader(name, self.path, self.mutant.code)
            return importlib.util.spec_from_file_location(name, self.path, loader=loader)
        return None


class Loader(importlib.machinery.SourceFileLoader):
    """Loads code that is given."""

    def __init__(self, name, path, code):
        super().__init__(name, path)
        self.code = code

    def get_code(self, name):
        return self.code


class Chosen:
    """For pytest: which tests run, in which order, with the same random examples every time."""

    def __init__(self, names):
        self.names = {name: place for place, name in enumerate(names)}

    def files(self):
        return dict.fromkeys(name.partition("::")[0] for name in self.names)

    def pytest_sessionstart(self):
        hypothesis.settings.register_profile(
            "mutation",
            max_examples=30,
            database=None,
            deadline=None,
            derandomize=True,
            phases=[hypothesis.Phase.explicit, hypothesis.Phase.generate],
            suppress_health_check=list(hypothesis.HealthCheck),
        )
        hypothesis.settings.load_profile("mutation")

    def pytest_collection_modifyitems(self, items):
        items[:] = [item for item in items if name_of(item) in self.names]
        items.sort(key=lambda item: self.names[name_of(item)])


def name_of(item):
    """The test, from its file's name on."""
    return item.nodeid.rpartition("tests/")[2]


class Watch(Chosen):
    """All tests without a mutant: which functions each one calls, and how long it takes."""

    def __init__(self, chosen):
        self.modules = {str(path(module)): module for module in chosen}
        self.found = {}
        self.failed = []

    def files(self):
        return [f"test_{name}.py" for name in FILES if (TESTS / f"test_{name}.py").exists()]

    def pytest_collection_modifyitems(self, items):
        items[:] = [item for item in items if item.get_closest_marker("slow") is None]

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item):
        calls = defaultdict(set)

        def trace(frame, event, _):
            module = self.modules.get(frame.f_code.co_filename)
            if module:
                calls[module].add(frame.f_code.co_firstlineno)

        started = time.perf_counter()
        sys.settrace(trace)
        try:
            return (yield)
        finally:
            sys.settrace(None)
            seconds = time.perf_counter() - started
            lines = {module: sorted(found) for module, found in calls.items()}
            if lines:
                self.found[name_of(item)] = seconds, lines

    def pytest_runtest_logreport(self, report):
        if report.failed:
            self.failed.append(f"{report.nodeid}\n{report.longreprtext}")


def watch(chosen: list[str]) -> dict[str, tuple[float, dict[str, list[int]]]]:
    """Seconds of every test that concerns these modules, and the lines of functions it calls."""
    with tempfile.TemporaryDirectory() as folder:
        answer = Path(folder) / "watched.json"

        def work():
            plugin = Watch(chosen)
            try:
                code = pytest_run(plugin)
            except BaseException:
                plugin.failed.append(traceback.format_exc())
                raise
            finally:
                answer.write_text(json.dumps([plugin.found, plugin.failed]), encoding="utf-8")
            return code

        _, status = os.waitpid(fork(work), 0)
        found, failed = json.loads(answer.read_text(encoding="utf-8"))
    if status:
        print("\n".join(failed), "the tests fail without any mutant", sep="\n", file=sys.stderr)
        sys.exit(BROKEN)
    return found


if __name__ == "__main__":
    sys.exit(main())
