"""The repository: its shape, its dependencies, the direction of its imports."""

import ast
import csv
import graphlib
import re
import subprocess
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
import yaml
from packaging.specifiers import SpecifierSet

import conftest
import meshfair
from meshfair import checks

ROOT = Path(__file__).resolve().parent.parent
LIB = ROOT / "lib"
PACKAGE = LIB / "meshfair"
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))

# Each module may import those before it; the order is written in the package alone.
ORDER = meshfair._ORDER


def tracked():
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode:
        pytest.skip("not a git checkout")
    return [ROOT / name for name in listed.stdout.splitlines() if (ROOT / name).exists()]


def imported(path):
    """Dotted names that a file imports anywhere, inside functions too."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path.relative_to(ROOT)}: a relative import"
            yield from (f"{node.module}.{name.name}" for name in node.names)


def module_of(name):
    """The package's module in which a dotted name lies: `meshfair.mesh.elements` of `Edges`."""
    parts = name.split(".")
    while parts:
        place = LIB.joinpath(*parts)
        if place.with_suffix(".py").exists() or (place / "__init__.py").exists():
            return ".".join(parts)
        parts.pop()
    return None


def arrows(top):
    """Which module imports which: those of `ORDER` for ``top``, otherwise every file."""
    found = set()
    for path in PACKAGE.rglob("*.py"):
        parts = path.relative_to(LIB).with_suffix("").parts
        start = ".".join(parts).removesuffix(".__init__")
        ends = {module_of(name) for name in imported(path)} - {None}
        if top:
            start, *ends = (".".join(name.split(".")[:2]) for name in [start, *ends])
        inside = {end for end in ends if end.startswith("meshfair.") and end != start}
        if start not in ("meshfair", "meshfair.__main__"):  # the package itself, not in the order
            found |= {(start, end) for end in inside}
    return found


def test_the_order_names_every_module():
    rooms = {p.relative_to(PACKAGE).parts[0].removesuffix(".py") for p in PACKAGE.rglob("*.py")}
    assert sorted(ORDER) == sorted(rooms - {"__init__", "__main__"})


def test_imports_go_one_way():
    place = {f"meshfair.{name}": k for k, name in enumerate(ORDER)}
    upwards = {(start, end) for start, end in arrows(top=True) if place[start] < place[end]}
    assert not upwards


def test_imports_between_files_close_no_circle():
    graph = {}
    for start, end in arrows(top=False):
        graph.setdefault(start, set()).add(end)
    assert len(list(graphlib.TopologicalSorter(graph).static_order())) > 50


def test_there_are_not_more_arrows_than_before():
    # 100 at version 0.1, counted in the same way.
    assert 30 < len(arrows(top=True)) < 100


def test_contributing_gives_the_same_order():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    block = re.search(r"^    checks.*(\n    .*)*", text, re.M)[0]
    assert re.findall(r"\w+", block) == list(ORDER)


def test_what_grading_imports_does_not_import_it():
    for path in PACKAGE.rglob("*.py"):
        assert not [name for name in imported(path) if name.startswith("meshfair_grading")], path


def test_numba_is_asked_for_in_one_place():
    allowed = {PACKAGE / "_fast", PACKAGE / "cli" / "doctor.py"}
    for path in LIB.rglob("*.py"):
        if any(name.split(".")[0] == "numba" for name in imported(path)):
            assert allowed & {path, *path.parents}, path


def test_import_is_quick_because_it_loads_little():
    code = "import sys, meshfair; print(*sorted({m.split('.')[0] for m in sys.modules}))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    loaded = set(done.stdout.split())
    assert {"meshfair", "numpy"} <= loaded
    heavy = {
        "numba",
        "scipy",
        "pandas",
        "matplotlib",
        "igl",
        "polyscope",
        "ipywidgets",
        "anywidget",
    }
    assert heavy.isdisjoint(loaded)


# Modules that packages of other names provide.
DISTRIBUTIONS = {
    "PIL": "pillow",
    "jupyter_cache": "jupyter-cache",
    "collada": "pycollada",
    "igl": "libigl",
    "yaml": "pyyaml",
}


def requirements(*groups):
    """The packages of extras, with those of the extras that these name."""
    found = set()
    for text in (line for group in groups for line in EXTRAS[group]):
        inner = re.fullmatch(r"meshfair\[(.*)\]", text)
        found |= requirements(*inner[1].split(",")) if inner else names([text])
    return found


EXTRAS = PYPROJECT["project"]["optional-dependencies"]


def test_every_import_is_of_a_package_that_some_extra_installs():
    known = names(PYPROJECT["project"]["dependencies"]) | requirements("site")
    there = {"a1_checks", "meshfair", "meshfair_grading", *sys.stdlib_module_names}
    there |= {"markupsafe"}  # what Jinja2 writes, imported for its type alone
    there |= {path.stem for path in (ROOT / "report").rglob("*.py")}
    for path in [*LIB.rglob("*.py"), *(ROOT / "report").rglob("*.py")]:
        modules = {name.split(".")[0] for name in imported(path)} - there
        missing = {DISTRIBUTIONS.get(name, name).lower() for name in modules} - known
        assert not missing, f"{path.relative_to(ROOT)} imports {missing}, in no extra"


def test_a_missing_library_is_said_to_be_in_an_extra_that_installs_it():
    for extra, modules in checks.EXTRAS.items():
        packages = {DISTRIBUTIONS.get(name, name).lower() for name in modules}
        assert packages - {"polyscope_bindings"} <= requirements(extra), extra


def test_the_core_is_three_packages():
    assert names(PYPROJECT["project"]["dependencies"]) == {"numpy", "scipy", "libigl"}
    assert "numba" in requirements("report")  # whose bytes are those of the compiled loops


def test_one_version():
    assert PYPROJECT["project"]["dynamic"] == ["version"]
    attribute = PYPROJECT["tool"]["setuptools"]["dynamic"]["version"]["attr"]
    assert attribute == "meshfair.__version__"
    assert meshfair.__version__ == citation()["version"]


def citation():
    return yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))


def test_citation_has_what_the_format_asks_for():
    # Of the schema of version 1.2.0: the keys without which it is not valid, and their types.
    facts = citation()
    assert facts["cff-version"] == "1.2.0"
    assert facts["type"] == "software"
    for key in ("message", "title", "version", "abstract", "license"):
        assert isinstance(facts[key], str), key
        assert facts[key], key
    assert facts["license"] == PYPROJECT["project"]["license"]
    assert facts["authors"] == PYPROJECT["project"]["authors"]
    assert len(facts["keywords"]) == len(set(facts["keywords"]))


def test_hosted_runners_call_makes_targets():
    workflow = yaml.safe_load((ROOT / ".github/workflows/ci.yml").read_text(encoding="utf-8"))
    targets = re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M)
    commands = [
        step["run"] for job in workflow["jobs"].values() for step in job["steps"] if "run" in step
    ]
    assert {"make check", "make test", "make report", "make site"} == set(commands)
    assert {command.removeprefix("make ") for command in commands} <= set(targets)
    matrix = workflow["jobs"]["check"]["strategy"]["matrix"]
    least = PYPROJECT["project"]["requires-python"].removeprefix(">=")
    assert matrix["python"][0] == least
    classifiers = PYPROJECT["project"]["classifiers"]
    assert [text.split(" :: ")[-1] for text in classifiers if re.search(r":: 3\.", text)] == (
        matrix["python"]
    )


def names(requirements):
    return {re.match(r"[A-Za-z0-9._-]+", text)[0].lower() for text in requirements}


def test_environment_yml_names_the_same_dependencies():
    wanted = names(PYPROJECT["project"]["dependencies"]) | requirements("all")
    listed = yaml.safe_load((ROOT / "environment.yml").read_text(encoding="utf-8"))["dependencies"]
    conda = [item for item in listed if isinstance(item, str)]
    pip = next(item["pip"] for item in listed if isinstance(item, dict))
    there = {"igl": "libigl", "typst-py": "typst", "matplotlib-base": "matplotlib"}
    found = {there.get(name, name) for name in names(conda)} - {"python", "pip"}
    found |= names(pip) - {"-e"}
    assert found == wanted


def test_constraints_pin_everything_and_name_no_address():
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pins = [line for line in lines if line and not line.startswith("#")]
    assert all(re.fullmatch(r"[A-Za-z0-9._-]+==[A-Za-z0-9.+!_-]+", pin) for pin in pins)
    pinned = {re.sub(r"[-_.]+", "-", pin.split("==")[0]).lower() for pin in pins}
    wanted = names(PYPROJECT["project"]["dependencies"]) | requirements(*EXTRAS)
    assert {re.sub(r"[-_.]+", "-", name) for name in wanted} <= pinned


def test_every_pin_is_for_the_first_python_that_is_promised():
    first = PYPROJECT["project"]["requires-python"].removeprefix(">=") + ".0"
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pins = dict(line.split("==") for line in lines if "==" in line and not line.startswith("#"))
    there = [each for each in metadata.distributions() if pins.get(each.name) == each.version]
    assert len(there) > 100  # those of the test extra
    asked = {each.name: each.metadata.get("Requires-Python") or "" for each in there}
    assert [name for name, spec in asked.items() if first not in SpecifierSet(spec)] == []


def test_top_level():
    folders = {path.relative_to(ROOT).parts[0] for path in tracked()}
    assert folders <= {
        ".ci", ".github", ".gitignore", ".pre-commit-config.yaml", "CHANGELOG.md", "CITATION.cff",
        "CONTRIBUTING.md", "LICENSE", "Makefile", "README.md", "apt-bench.txt", "apt.txt",
        "constraints.txt", "data_scripts", "environment.yml", "lib", "notebooks", "pyproject.toml",
        "report", "tests",
    }  # fmt: skip


def test_the_style_holds():
    for command in (["check"], ["format", "--check"]):
        finished = subprocess.run(
            [sys.executable, "-m", "ruff", *command, "."], cwd=ROOT, capture_output=True, text=True
        )
        assert finished.returncode == 0, finished.stdout[-2000:]


def test_only_sources_are_kept():
    for path in tracked():
        assert path.suffix not in {".ply", ".obj", ".off", ".stl", ".pdf", ".pyc"}, path
        assert path.stat().st_size < 1_000_000, path


def test_links_of_the_readme_lead_somewhere():
    for page in ROOT.glob("*.md"):
        text = re.sub(r"```.*?```|`[^`\n]*`", "", page.read_text(encoding="utf-8"), flags=re.S)
        for target in re.findall(r"\]\(([^)#:]+)\)", text):
            assert (ROOT / target).exists(), f"{page.name}: {target}"


# Rows of README's table of times: task and contender of ours in report/results/bench.csv.
TIMES = {
    "cotangent weights": ("weights", "ours, from nothing"),
    "the same, edges known from before": ("weights", "ours, edges known"),
    "one averaging step": ("step", "ours"),
    "one step on the reordered mesh": ("step in order", "ours"),
    "each of twenty steps in one call": ("steps", "ours"),
    "the same on the reordered mesh": ("steps in order", "ours"),
    "one implicit step": ("implicit", "ours"),
}

# What README calls contenders whose names in it have a comma, or need words.
NAMES = {
    "SciPy's CG": "SciPy CG, diagonal",
    "SciPy's product": "SciPy product",
    "tuned PyAMG": "PyAMG, tuned",
}


def test_readme_gives_the_times_that_were_measured():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    with open(ROOT / "report" / "results" / "bench.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    seconds = {(row["task"], row["contender"]): float(row["seconds"]) for row in rows}
    table = re.findall(r"^\| ([a-z][^|]*) \| ([\d.]+) \| ([^|]+) \|$", readme, re.M)
    assert [row[0] for row in table] == list(TIMES)
    for what, ours, others in table:
        task, name = TIMES[what]
        assert float(ours) == two_digits(1e3 * seconds[task, name]), what
        for other, times in re.findall(r"([^,]+?) ([\d.]+)(?:, |$)", others):
            other = NAMES.get(other, other)
            expected = two_digits(seconds[task, other] / seconds[task, name])
            assert float(times) == expected, (what, other)
    vertices = {row["vertices"] for row in rows if row["task"] == "step"}
    assert f"({int(*vertices):,}\nvertices)" in readme


def test_every_source_of_a_docstring_is_in_the_reports_bibliography():
    bibliography = (ROOT / "report" / "references.bib").read_text(encoding="utf-8")
    keys = set(re.findall(r"^@\w+\{(\w+),", bibliography, re.M))
    for path in LIB.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        given = set(re.findall(r"^ *\.\. \[(\w+)\] ", text, re.M))
        cited = set(re.findall(r"\[([A-Z][A-Za-z]*\d\d)\]_?", text))
        assert given <= keys, path
        assert cited == given - {"libigl"}, path


def test_the_pictures_are_small():
    pictures = [path for path in tracked() if path.suffix in {".png", ".webp", ".svg"}]
    assert pictures
    assert sum(path.stat().st_size for path in pictures) < 300_000


def two_digits(x):
    return float(f"{x:.2g}")


def test_every_file_called_slow_exists():
    assert {path.stem for path in (ROOT / "tests").glob("test_*.py")} >= conftest.SLOW
