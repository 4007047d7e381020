"""The package as others get it: a wheel, in a new environment, with its three dependencies."""

import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from packaging.requirements import Requirement

import meshfair

ROOT = Path(__file__).resolve().parent.parent
pytestmark = pytest.mark.xdist_group("install")


def run(*command, **options):
    """What a command prints; it must not fail."""
    options = {"capture_output": True, "text": True, "timeout": 600} | options
    done = subprocess.run([str(word) for word in command], **options)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-4000:]
    return done.stdout


def outside():
    """Environment variables without those by which this checkout could be found."""
    return {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}


@pytest.fixture(scope="session")
def wheel(tmp_path_factory):
    """A wheel of the files that git knows, so that nothing else is needed or gets into it."""
    if not (ROOT / ".git").exists():
        pytest.skip("not a git checkout")
    folder = tmp_path_factory.mktemp("wheel")
    for name in run("git", "ls-files", "-z", cwd=ROOT).split("\0"):
        if (ROOT / name).is_file():
            (folder / "source" / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / name, folder / "source" / name)
    options = ["--quiet", "--no-deps", "--no-build-isolation", "--wheel-dir", folder]
    run(sys.executable, "-m", "pip", "wheel", *options, folder / "source")
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="session")
def installed(wheel, tmp_path_factory):
    """The `python` of an environment with the wheel, and nothing but what it cannot do without."""
    folder = tmp_path_factory.mktemp("installed")
    run(sys.executable, "-m", "venv", folder)
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    command = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    command += ["--only-binary", ":all:", "--constraint", ROOT / "constraints.txt", wheel]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=600)
    if re.search("NewConnectionError|ConnectTimeout|Network is unreachable", done.stderr):
        pytest.skip("pip reaches no index to install NumPy, SciPy and libigl from")
    assert done.returncode == 0, done.stderr[-4000:]
    return python


def test_data_files_are_in_the_wheel(wheel):
    there = set(zipfile.ZipFile(wheel).namelist())
    kept = run("git", "ls-files", "lib", cwd=ROOT).splitlines()
    expected = {name.removeprefix("lib/") for name in kept if (ROOT / name).exists()}
    assert {"meshfair/py.typed", "meshfair/experiments/table1.csv"} <= expected
    assert {Path(name).suffix for name in expected} >= {".py", ".typed", ".csv", ".js", ".css"}
    metadata = {name for name in there if ".dist-info/" in name}
    assert there - metadata == expected


def test_the_wheels_metadata(wheel):
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        metadata = archive.read(name).decode("utf-8")
    assert re.search(r"^Version: (.*)$", metadata, re.M)[1] == meshfair.__version__
    needed = map(Requirement, re.findall(r"^Requires-Dist: (.*)$", metadata, re.M))
    core = {line.name for line in needed if "extra" not in str(line.marker)}
    assert core == {"numpy", "scipy", "libigl"}


def test_it_installs_three_packages_and_what_these_need(installed):
    lines = run(installed, "-m", "pip", "list", "--format", "freeze", env=outside()).splitlines()
    there = {line.partition("==")[0].lower() for line in lines} - {"pip", "setuptools", "wheel"}
    assert {"meshfair", "numpy", "scipy", "libigl"} <= there
    assert there.isdisjoint({"numba", "pandas", "matplotlib", "polyscope", "tqdm", "pooch"})
    code = "import meshfair; print(meshfair.__version__, meshfair.__file__)"
    version, file = run(installed, "-c", code, env=outside(), cwd=installed.parent).split()
    assert version == meshfair.__version__
    assert not Path(file).is_relative_to(ROOT)


def test_the_readmes_first_example_runs(installed, tmp_path):
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    example = re.search(r"```python\n(.*?)```", readme, re.S)[1]
    printed = run(installed, "-W", "error", "-c", example, env=outside(), cwd=tmp_path)
    before, after = map(float, re.findall(r"([\d.]+) dB", printed))
    assert before < after


def test_every_module_of_the_core_is_imported(installed, tmp_path):
    optional = {"_fast", "experiments", "plotting", "viewer", "explorers"}
    core = [f"meshfair.{name}" for name in meshfair._ORDER if name not in optional]
    run(installed, "-W", "error", "-c", f"import {', '.join(core)}", env=outside(), cwd=tmp_path)


def test_the_command_works(installed, tmp_path):
    def command(*words):
        return run(installed.parent / "meshfair", *words, env=outside(), cwd=tmp_path)

    write = "from meshfair import io, shapes; io.write('knot.ply', *shapes.knot())"
    run(installed, "-c", write, env=outside(), cwd=tmp_path)
    assert "1440" in command("info", "knot.ply").replace(",", "")
    command("noise", "knot.ply", "noisy.obj", "--sigma", "0.3", "--seed", "7")
    command("repair", "noisy.obj", "repaired.off", "--unreferenced")
    command("denoise", "repaired.off", "denoised.stl", "--method", "taubin")
    command("denoise", "noisy.obj", "denoised.ply", "--method", "taubin")
    before, after = (
        float(re.search(r"^snr\s+([\d.]+)", command("compare", name, "knot.ply"), re.M)[1])
        for name in ("noisy.obj", "denoised.ply")
    )
    assert before < after
    words = ["denoise", "noisy.obj", "compared.ply", "--ground-truth", "knot.ply"]
    done = subprocess.run(
        [installed.parent / "meshfair", *words],
        env=outside(),
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1
    assert done.stderr.endswith('pip install "meshfair[experiments]"\n')
    assert not (tmp_path / "compared.ply").exists()


# Uses of optional libraries, and the extra that installs them.
OPTIONAL = {
    "import meshfair.explorers": "notebooks",
    "from meshfair import viewer, shapes; viewer.View(*shapes.knot())": "notebooks",
    "from meshfair import datasets; datasets.find('f16')": "data",
    "from meshfair import experiments; experiments.published_table_1()": "experiments",
    "from meshfair import denoise, shapes; V, F = shapes.knot()\n"
    "denoise(V, F, 'taubin', ground_truth=V)": "experiments",
    "from meshfair import io, shapes; io.write('a.glb', *shapes.knot())": "formats",
    "from meshfair import plotting\nwith plotting.figure('x.svg'): pass": "viewer",
}


@pytest.mark.parametrize("code", OPTIONAL)
def test_what_needs_an_extra_names_it(installed, code, tmp_path):
    command = [str(installed), "-c", code]
    done = subprocess.run(command, env=outside(), cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].endswith(f'pip install "meshfair[{OPTIONAL[code]}]"')
