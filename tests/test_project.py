"""The repository: its shape, its dependencies, the direction of its imports."""

import ast
import csv
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "lib/meshfair"
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))

# Each module may import those before it. `reference` and `cli` may import all of them.
ORDER = [
    "checks", "shapes", "io", "datasets", "mesh", "noise", "kernels", "pattern", "ordering",
    "intrinsic", "weights", "operators", "spectrum", "multigrid", "solve", "flow", "filters",
    "metrics", "risk", "denoising", "experiments", "plotting", "viewer", "explorers", "grading",
]  # fmt: skip


def tracked():
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode:
        pytest.skip("not a git checkout")
    return [ROOT / name for name in listed.stdout.splitlines() if (ROOT / name).exists()]


def imports(path):
    """Names of the package's modules that a file imports when it is loaded."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in tree.body:  # not inside functions: those run later
        if isinstance(node, ast.ImportFrom) and node.module == "meshfair":
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("meshfair."):
            yield node.module.split(".")[1]
        elif isinstance(node, ast.Import):
            yield from (
                name.name.split(".")[1] for name in node.names if name.name.startswith("meshfair.")
            )


def test_imports_go_one_way():
    for path in PACKAGE.rglob("*.py"):
        room = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
        if room in ORDER:
            later = {name for name in imports(path) if name in ORDER[ORDER.index(room) + 1 :]}
            assert not later, f"{path.relative_to(ROOT)} imports {later}, which come after {room}"


def test_every_module_has_its_place():
    rooms = {p.relative_to(PACKAGE).parts[0].removesuffix(".py") for p in PACKAGE.rglob("*.py")}
    assert rooms <= {*ORDER, "__init__", "__main__", "reference", "cli"}


def test_import_is_quick_because_it_loads_little():
    code = "import sys, meshfair; print(*sorted({m.split('.')[0] for m in sys.modules}))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout
    heavy = {"numba", "scipy", "pandas", "matplotlib", "igl", "polyscope", "ipywidgets", "k3d"}
    assert heavy.isdisjoint(loaded.split())


def names(requirements):
    return {re.match(r"[A-Za-z0-9._-]+", text)[0].lower() for text in requirements}


def test_environment_yml_names_the_same_dependencies():
    groups = PYPROJECT["project"]["optional-dependencies"]
    wanted = names(PYPROJECT["project"]["dependencies"])
    wanted |= names(groups["report"]) | names(groups["notebooks"])
    listed = yaml.safe_load((ROOT / "environment.yml").read_text(encoding="utf-8"))["dependencies"]
    conda = [item for item in listed if isinstance(item, str)]
    pip = next(item["pip"] for item in listed if isinstance(item, dict))
    there = {"igl": "libigl", "typst-py": "typst", "matplotlib-base": "matplotlib"}
    found = {there.get(name, name) for name in names(conda)} - {"python", "pip"}
    found |= names(pip) - {"-e"}
    assert found == wanted - {"meshfair"}


def test_constraints_pin_everything_and_name_no_address():
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    pins = [line for line in lines if line and not line.startswith("#")]
    assert all(re.fullmatch(r"[A-Za-z0-9._-]+==[A-Za-z0-9.+!_-]+", pin) for pin in pins)
    pinned = {re.sub(r"[-_.]+", "-", pin.split("==")[0]).lower() for pin in pins}
    groups = PYPROJECT["project"]["optional-dependencies"]
    wanted = names(PYPROJECT["project"]["dependencies"])
    for group in groups.values():
        wanted |= names(group)
    assert {re.sub(r"[-_.]+", "-", name) for name in wanted} - {"meshfair"} <= pinned


def test_top_level():
    folders = {path.relative_to(ROOT).parts[0] for path in tracked()}
    assert folders <= {
        ".ci", ".gitignore", ".pre-commit-config.yaml", "CHANGELOG.md", "CONTRIBUTING.md",
        "LICENSE", "Makefile", "README.md", "apt.txt", "binder", "constraints.txt", "data_scripts",
        "environment.yml", "lib", "notebooks", "postBuild", "pyproject.toml", "report", "tests",
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
        for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text(encoding="utf-8")):
            assert (ROOT / target).exists(), f"{page.name}: {target}"


# Rows of README's table of times: task and contender of ours in report/results/bench.csv.
TIMES = {
    "cotangent weights": ("weights", "ours, from nothing"),
    "the same, edges known from before": ("weights", "ours, pattern known"),
    "one averaging step": ("step", "ours"),
    "each of twenty steps in one call": ("steps", "ours"),
    "the same on the reordered mesh": ("steps in order", "ours"),
    "one implicit step": ("implicit", "ours"),
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
            other = {"SciPy's CG": "SciPy CG, diagonal"}.get(other, other)
            expected = two_digits(seconds[task, other] / seconds[task, name])
            assert float(times) == expected, (what, other)
    vertices = {row["vertices"] for row in rows if row["task"] == "step"}
    assert f"({int(*vertices):,}\nvertices)" in readme


def two_digits(x):
    return float(f"{x:.2g}")
