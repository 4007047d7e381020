"""The command line: in this process where that is quick, as a process where it must be one."""

import ast
import importlib
import inspect
import json
import os
import re
import signal
import subprocess
import sys
import tomllib
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from packaging.requirements import Requirement

from broken import bow_tie
from meshes import grid
from meshfair import _fast, cli, denoising, io, mesh, metrics, noise, shapes
from meshfair.cli import doctor, files, printing
from meshfair.cli import noise as noise_command
from meshfair.cli.parser import Parser
from meshfair.cli.words import in_words_of_the_command
from meshfair.mesh.advice import ADVICE


@pytest.fixture
def knot(tmp_path):
    path = tmp_path / "knot.ply"
    io.write(path, *shapes.knot())
    return path


@pytest.fixture
def run(capsys):
    """Run ``meshfair`` with some words: its exit code, and what it printed."""

    def run(*words):
        code = cli.main([str(word) for word in words])
        out, err = capsys.readouterr()
        return code, out, err

    return run


def process(*words, **named):
    """The same as a process of its own."""
    command = [sys.executable, "-m", "meshfair", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, **named)


def one_line(err):
    assert err.endswith("\n")
    assert err.count("\n") == 1
    assert "Traceback" not in err
    return err


# --- info ---------------------------------------------------------------------------------


def test_info_prints_the_inspection(run, knot):
    code, out, err = run("info", knot)
    assert code == 0
    assert err == ""
    facts = str(mesh.inspect(*shapes.knot())).partition("\nnote: ")[0]
    assert out.startswith(f"{knot}\n{facts}\nnote: ")


def test_info_as_json(run, tmp_path):
    path = tmp_path / "bow tie.obj"
    io.write(path, *bow_tie())
    code, out, _ = run("info", path, "--json")
    assert code == 0  # a broken mesh is an answer, no error
    facts = json.loads(out)
    assert facts["file"] == str(path)
    assert facts["counts"]["nonmanifold_vertices"] == 1
    assert facts["findings"][0]["first"] == [2]
    assert facts["ok"] is False


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("missing.ply", None, "missing.ply"),
        ("empty.ply", b"", "empty.ply"),
        ("rubbish.obj", bytes(range(256)) * 9, "rubbish.obj"),
        ("mesh.txt", b"v 0 0 0\n", ".txt"),
        ("cut.off", b"OFF\n3 1 0\n0 0 0\n1 0 0\n", "cut.off"),
    ],
)
def test_what_is_no_mesh_is_refused_in_one_line(run, tmp_path, name, content, message):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    code, out, err = run("info", tmp_path / name)
    assert code == 1
    assert out == ""
    assert one_line(err).startswith("meshfair info: ")
    assert message in err


def test_a_folder_is_no_mesh(run, tmp_path):
    code, _, err = run("info", tmp_path)
    assert code == 1
    one_line(err)


def test_the_corners_of_an_stl_are_merged_unless_told_not_to(run, tmp_path):
    path = tmp_path / "box.stl"
    io.write(path, *shapes.box(segments=2))
    code, out, err = run("info", path)
    assert code == 0
    assert err == ""
    assert "no problems found" in out
    code, out, _ = run("info", path, "--no-weld")
    assert code == 0
    assert "duplicate vertices, in the place of another" in out


# --- repair -------------------------------------------------------------------------------


def test_repair_does_what_is_asked_and_reports(run, tmp_path):
    source, out = tmp_path / "in.off", tmp_path / "out.off"
    io.write(source, *bow_tie())
    code, text, _ = run("repair", source, out, "--split", "--unreferenced")
    assert code == 0
    assert "1 copies" in text
    assert "dropped 0 vertices" in text
    expected = mesh.repair(*bow_tie(), split=True)
    V, F = io.read(out)
    assert np.array_equal(V, expected.V)
    assert np.array_equal(F, expected.F)


def test_repair_does_nothing_unasked(run, knot, tmp_path):
    code, text, _ = run("repair", knot, tmp_path / "same.ply")
    assert code == 0
    assert "nothing was asked for" in text
    assert (tmp_path / "same.ply").read_bytes() == knot.read_bytes()


def test_repair_as_json(run, knot, tmp_path):
    code, text, _ = run(
        "repair", knot, tmp_path / "o.obj", "--weld", 0, "--orient", "outward", "--json"
    )
    assert code == 0
    facts = json.loads(text)
    assert [step["name"] for step in facts["steps"]] == ["weld", "orient"]
    assert (facts["vertices"], facts["faces"]) == (1440, 2880)


# --- noise --------------------------------------------------------------------------------


def test_noise_is_that_of_the_package(run, knot, tmp_path):
    V, F = shapes.knot()
    sigma = ["--sigma", 0.3]
    models = {
        "normals": (sigma, lambda rng: noise.along_normals(V, F, 0.3, rng)),
        "gaussian": (sigma, lambda rng: noise.gaussian(V, F, 0.3, rng)),
        "uniform": (["--amplitude", 8], lambda rng: noise.uniform(V, 8, rng)),
        "correlated": (
            [*sigma, "--steps", 2],
            lambda rng: noise.correlated(V, F, 0.3, rng, steps=2),
        ),
        "impulsive": (
            [*sigma, "--fraction", 0.5],
            lambda rng: noise.impulsive(V, F, 0.3, 0.5, rng),
        ),
    }
    assert list(models) == [*noise.MODELS, "impulsive"] == list(noise_command.MODELS)
    for name, (words, model) in models.items():
        out = tmp_path / f"{name}.ply"
        code, text, _ = run("noise", knot, out, "--model", name, *words, "--seed", 5, "--json")
        assert code == 0
        X, T = io.read(out)
        expected = model(np.random.default_rng(5))
        assert np.array_equal(X, expected)
        assert np.array_equal(T, F)
        assert json.loads(text)["snr"] == metrics.snr(V, X)


def test_noise_at_an_snr(run, knot, tmp_path):
    code, _, _ = run("noise", knot, tmp_path / "o.ply", "--snr", 22.85)
    assert code == 0
    V, _ = io.read(tmp_path / "o.ply")
    assert metrics.snr(shapes.knot()[0], V) == pytest.approx(22.85, abs=1e-9)


def test_no_noise_has_an_infinite_snr_in_json_too(run, knot, tmp_path):
    code, text, _ = run("noise", knot, tmp_path / "o.ply", "--sigma", 0, "--json")
    assert code == 0
    assert json.loads(text)["snr"] == "Infinity"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--model", "uniform"], "--amplitude"),
        (["--sigma", "-1"], "sigma"),
        (["--sigma", "nan"], "sigma"),
        (["--seed", "-3"], "--seed is -3"),
        (["--model", "impulsive", "--fraction", "2"], "fraction"),
        (["--model", "correlated", "--steps", "-1"], "--steps is -1"),
    ],
)
def test_wrong_noise_is_refused_and_nothing_is_written(run, knot, tmp_path, words, message):
    out = tmp_path / "o.ply"
    code, _, err = run("noise", knot, out, *words)
    assert code == 1
    assert message in one_line(err)
    assert not out.exists()


# --- compare ------------------------------------------------------------------------------


def test_compare_prints_every_metric(run, knot, tmp_path):
    V, F = shapes.knot()
    noisy = tmp_path / "noisy.ply"
    io.write(noisy, noise.along_normals(V, F, 0.2, np.random.default_rng(3)), F)
    code, text, _ = run("compare", noisy, knot, "--json")
    assert code == 0
    X, _ = io.read(noisy)
    found = json.loads(text)
    for name, measure in metrics.compare(X, F, V, F).items():
        assert (found[name]["value"], found[name]["bound"]) == (measure.value, measure.bound)
    assert found["snr"]["value"] == metrics.snr(V, X)
    code, text, _ = run("compare", noisy, knot)
    assert code == 0
    assert f"{metrics.snr(V, X):.6g} dB" in text


def test_compare_meshes_of_different_connectivity(run, knot, tmp_path):
    io.write(tmp_path / "other.obj", *shapes.knot(sections=240))
    code, text, _ = run("compare", tmp_path / "other.obj", knot)
    assert code == 0
    assert text.count("cannot be compared: the meshes have 2880 and 1440 vertices") == 2
    assert "mean edge lengths" in text


# --- denoise ------------------------------------------------------------------------------


@pytest.fixture
def noisy(tmp_path):
    V, F = shapes.knot()
    path = tmp_path / "noisy.ply"
    io.write(path, noise.along_normals(V, F, 0.3, np.random.default_rng(8)), F)
    return path


def test_denoise_is_that_of_the_package(run, noisy, tmp_path):
    V, F = io.read(noisy)
    for k, (words, chosen) in enumerate(
        [
            (["--method", "heat", "--weights", "cotangent", "--time", 1],
             {"method": "heat", "weights": "cotangent", "time": 1}),
            (["--method", "heat", "--set", "tau=0.5"], {"method": "heat", "tau": 0.5}),
            (["--method", "implicit", "--set", "keep_volume=True"],
             {"method": "implicit", "keep_volume": True}),
            (["--method", "averaging", "--set", "iterations=3", "--set", "weights=distance"],
             {"method": "averaging", "iterations": 3, "weights": "distance"}),
            (
            ["--method", "feature-convinced", "--auto"],
            {"method": "feature-convinced", "parameters": "auto"},
        ),
            ([], {}),
        ]
    ):  # fmt: skip
        out = tmp_path / f"{k}.ply"
        code, text, err = run("denoise", noisy, out, "--json", *words)
        assert (code, err) == (0, "")
        expected = denoising.denoise(V, F, **chosen)
        assert np.array_equal(io.read(out)[0], expected.V)
        assert np.array_equal(io.read(out)[1], F)
        facts = json.loads(text)
        assert facts["method"] == expected.method
        del expected.parameters["fixed"]
        assert facts["parameters"] == expected.parameters


def test_denoise_says_how_much_closer_the_result_is(run, noisy, knot, tmp_path):
    words = ["denoise", noisy, tmp_path / "o.ply", "--method", "heat", "--ground-truth", knot]
    code, text, _ = run(*words)
    assert code == 0
    V, _ = shapes.knot()
    before, after = (metrics.snr(V, io.read(p)[0]) for p in (noisy, tmp_path / "o.ply"))
    assert f"{before:.6g} -> {after:.6g} dB" in text
    code, text, _ = run(*words, "--json", "--force")
    history = json.loads(text)["history"]
    assert history[0]["snr"] == pytest.approx(before)
    assert history[-1]["snr"] == pytest.approx(after)


def test_denoise_fixes_the_boundary(run, tmp_path, rng):
    V, F = grid(6)
    V = V + 0.1 * rng.standard_normal(V.shape)
    io.write(tmp_path / "in.off", V, F)
    out = tmp_path / "out.off"
    words = ["--method", "heat", "--fix-boundary", "--json"]
    code, text, _ = run("denoise", tmp_path / "in.off", out, *words)
    assert code == 0
    rim = mesh.boundary_vertices(F)
    assert json.loads(text)["fixed_vertices"] == len(rim)
    moved = np.any(io.read(out)[0] != V, axis=1)
    assert not moved[rim].any()
    assert moved.sum() == len(V) - len(rim)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--method", "magic"], "magic"),
        (["--method", "heat", "--set", "force=1"], "--set force=1: no such parameter"),
        (["--method", "heat", "--set", "strength=1"], "parameter; it is the option --strength"),
        (["--strength", "2"], "--strength is 2.0; give a number of at least 0 and at most 1"),
        (["--method", "heat", "--weights", "heavy"], "weights is 'heavy'"),
        (["--method", "heat", "--time", "-1"], "time"),
        (["--method", "heat", "--set", "tau=fast"], "tau is 'fast'"),
        (["--ground-truth", "missing.ply"], "missing.ply"),
    ],
)
def test_wrong_denoising_is_refused_in_one_line(run, noisy, tmp_path, words, message):
    code, _, err = run("denoise", noisy, tmp_path / "o.ply", *words)
    assert code == 1
    assert message in one_line(err)
    assert not (tmp_path / "o.ply").exists()


@pytest.mark.parametrize("words", [[], ["--method", "heat", "--time", 2]])
def test_a_part_of_the_way_on_the_command_line(run, noisy, tmp_path, words):
    out = tmp_path / "o.ply"
    code, said, _ = run("denoise", noisy, out, "--strength", 0.5, *words)
    assert code == 0
    assert re.search(r"^strength +0\.5$", said, re.MULTILINE)
    assert run("denoise", noisy, "--out", tmp_path / "many", "--strength", 0.5, *words)[0] == 0
    V = io.read(noisy)[0]
    assert not np.array_equal(V, io.read(out)[0])
    code, _, _ = run("denoise", noisy, out, "--force", "--strength", 0, *words)
    assert code == 0
    assert np.array_equal(io.read(out)[0], V)


def test_a_known_size_of_the_noise_is_used(run, noisy, tmp_path):
    V, F = io.read(noisy)
    for words, named in (
        (["--method", "feature-convinced"], {"method": "feature-convinced"}),
        (
            ["--method", "feature-convinced", "--auto"],
            {"method": "feature-convinced", "parameters": "auto"},
        ),
    ):
        code, _, _ = run("denoise", noisy, tmp_path / "o.ply", "--force", "--noise", 0.05, *words)
        assert code == 0
        expected = denoising.denoise(V, F, sigma=0.05, **named).V
        assert np.array_equal(io.read(tmp_path / "o.ply")[0], expected)
        assert not np.array_equal(expected, denoising.denoise(V, F, **named).V)


def test_fixing_the_boundary_leaves_seams_free(run, tmp_path):
    V, F = grid(6)
    soup = V[F].reshape(-1, 3)
    soup[:, 2] = 0.1 * np.sin(40 * soup[:, 0] + 70 * soup[:, 1])
    io.write(tmp_path / "soup.off", soup, np.arange(F.size).reshape(-1, 3))
    words = ["--method", "heat", "--fix-boundary", "--json"]
    code, text, _ = run("denoise", tmp_path / "soup.off", tmp_path / "o.off", *words)
    assert code == 0
    on_rim = np.isin(F.ravel(), mesh.boundary_vertices(F))
    assert json.loads(text)["fixed_vertices"] == on_rim.sum()
    moved = np.any(io.read(tmp_path / "o.off")[0] != soup, axis=1)
    assert np.array_equal(moved, ~on_rim)


@pytest.mark.parametrize("how", ["faces in another order", "renumbered", "corners turned"])
def test_the_same_ground_truth_in_another_file(run, noisy, tmp_path, how, rng):
    V, F = shapes.knot()
    words = ["denoise", noisy, tmp_path / "o.ply", "--force", "--method", "taubin", "--json"]
    io.write(tmp_path / "truth.ply", V, F)
    _, expected, _ = run(*words, "--ground-truth", tmp_path / "truth.ply")
    if how == "renumbered":
        new = rng.permutation(len(V))
        F = new[F]
        V = V[np.argsort(new)]
    F = np.roll(F, 1, axis=1) if how == "corners turned" else F[rng.permutation(len(F))]
    io.write(tmp_path / "other.ply", V, F)
    code, text, _ = run(*words, "--ground-truth", tmp_path / "other.ply")
    assert code == 0
    assert json.loads(text)["history"] == json.loads(expected)["history"]


def test_another_mesh_is_no_ground_truth(run, noisy, tmp_path):
    V, F = shapes.knot()
    for name, other in (("fewer.off", (V, F[1:])), ("other.off", shapes.knot(sections=240))):
        io.write(tmp_path / name, *other)
        words = ["--ground-truth", tmp_path / name]
        code, _, err = run("denoise", noisy, tmp_path / "o.ply", *words)
        assert code == 1
        assert f"--ground-truth {tmp_path / name}: the meshes have " in one_line(err)
        assert "meshfair compare" in err
        assert not (tmp_path / "o.ply").exists()


@pytest.mark.parametrize("text", ["tau", "=1", "tau=", "1=2", "a b=3"])
def test_a_parameter_without_name_or_value_is_wrong_usage(noisy, tmp_path, text, capsys):
    with pytest.raises(SystemExit) as stop:
        cli.main(["denoise", str(noisy), str(tmp_path / "o.ply"), "--set", text])
    assert stop.value.code == 2
    assert "NAME=VALUE" in capsys.readouterr().err


def test_the_ground_truth_is_never_written_over(run, noisy, knot):
    before = knot.read_bytes()
    code, _, err = run("denoise", noisy, knot, "--force", "--ground-truth", knot)
    assert code == 1
    assert "input" in one_line(err)
    assert knot.read_bytes() == before


def test_methods_are_listed_with_their_defaults(capsys):
    with pytest.raises(SystemExit) as stop:
        cli.main(["denoise", "--methods"])
    assert stop.value.code == 0
    lines = capsys.readouterr().out.splitlines()
    heads = [line for line in lines if not line.startswith(" ")]
    named = [line.split(" (")[0].split(":")[0] for line in heads]
    assert named == [denoising.DEFAULT, *denoising.methods()]
    assert [line.split(" (")[0] for line in heads if "(the default)" in line] == [
        inspect.signature(denoising.denoise).parameters["method"].default
    ]
    assert "    weights=combinatorial tau=0.2 time=2.0" in lines
    assert "taubin: Taubin's filter: smoothing without shrinking" in lines


@pytest.mark.skipif(os.name != "posix", reason="needs a terminal as POSIX has them")
def test_progress_on_a_terminal_and_an_interrupt_that_leaves_nothing(noisy, tmp_path):
    import pty
    import select
    import termios

    terminal, stderr = pty.openpty()
    termios.tcsetwinsize(stderr, (24, 80))  # a new one has no columns to draw a bar in
    out = tmp_path / "o.ply"
    command = [sys.executable, "-m", "meshfair", "denoise", str(noisy), str(out)]
    command += ["--method", "heat", "--time", "1e5", "--set", "tau=0.001"]
    there = set(tmp_path.iterdir())
    child = subprocess.Popen(command, stderr=stderr, stdout=subprocess.PIPE, text=True)
    os.close(stderr)
    readable, _, _ = select.select([terminal], [], [], 60)
    shown = os.read(terminal, 1000).decode() if readable else ""
    child.send_signal(signal.SIGINT)
    text, _ = child.communicate(timeout=60)
    while True:
        try:
            shown += os.read(terminal, 1000).decode()
        except OSError:  # the other end is closed
            break
    os.close(terminal)
    assert "0% |" in shown
    assert child.returncode == 130
    assert text == ""
    assert "meshfair denoise: interrupted" in shown
    assert "Traceback" not in shown
    assert set(tmp_path.iterdir()) == there


# --- what a file holds beside its mesh -----------------------------------------------------

COLOURED = b"""ply
format ascii 1.0
comment a tetrahedron
element vertex 4
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
property float quality
element face 4
property list uchar int vertex_indices
end_header
0 0 0 255 0 0 0.5
1 0 0 0 255 0 0.25
0 1 0 0 0 255 1
0 0 1 9 9 9 2
3 0 2 1
3 0 1 3
3 1 2 3
3 0 3 2
"""


@pytest.mark.parametrize(
    "words", [["denoise", "--method", "taubin"], ["noise"], ["repair", "--orient", "outward"]]
)
def test_everything_but_the_positions_stays(run, tmp_path, words):
    (tmp_path / "in.ply").write_bytes(COLOURED)
    out = tmp_path / "o.ply"
    command, *options = words
    code, _, err = run(command, tmp_path / "in.ply", out, *options)
    assert (code, err) == (0, "")
    old, new = COLOURED.decode().splitlines(), out.read_text().splitlines()
    rows = slice(14, 18)
    assert [line.split()[3:] for line in new[rows]] == [line.split()[3:] for line in old[rows]]
    assert (new[:14], new[18:]) == (old[:14], old[18:])
    assert (new == old) == (command == "repair")  # which had nothing to do


@pytest.mark.parametrize(
    ("ending", "lost"),
    [("obj", ["quality"]), ("off", ["quality"]), ("stl", ["colours", "quality"])],
)
@pytest.mark.parametrize("command", ["denoise", "noise", "repair"])
def test_what_another_format_cannot_hold_is_told_in_one_line(run, tmp_path, command, ending, lost):
    (tmp_path / "in.ply").write_bytes(COLOURED)
    code, _, err = run(command, tmp_path / "in.ply", tmp_path / f"o.{ending}")
    assert code == 0
    assert one_line(err).startswith(f"meshfair {command}: warning: ")
    assert all(word in err for word in lost)


# --- many meshes --------------------------------------------------------------------------


@pytest.fixture
def scans(tmp_path):
    """Three noisy meshes, of which the second one is cut."""
    V, F = shapes.icosphere(1)
    paths = [tmp_path / f"{name}.ply" for name in ("first", "second", "third")]
    for seed, path in enumerate(paths):
        io.write(path, noise.along_normals(V, F, 0.2, np.random.default_rng(seed)), F)
    paths[1].write_bytes(paths[1].read_bytes()[:-9])
    return paths


def test_many_meshes_go_on_where_one_fails(run, scans, tmp_path):
    out = tmp_path / "out"
    code, text, err = run("denoise", *scans, "--method", "taubin", "--out", out)
    assert (code, err) == (1, "")
    assert {path.name for path in out.iterdir()} == {"first.ply", "third.ply"}
    for path in (scans[0], scans[2]):
        V, F = io.read(path)
        expected = denoising.denoise(V, F, "taubin").V
        assert np.array_equal(io.read(out / path.name)[0], expected)
    lines = text.splitlines()
    assert lines[0].split() == ["file", "method", "done", "seconds"]
    assert lines[1].split()[:2] == [str(scans[0]), "taubin"]
    assert f"{scans[1]}: failed: " in text
    assert "bytes are left" in " ".join(text.split())
    assert lines[-1] == f"2 of 3 meshes written to {out}; 1 failed"


def test_the_table_says_what_was_left_as_it_is(run, tmp_path):
    io.write(tmp_path / "clean.ply", *shapes.box(segments=4))
    code, text, _ = run("denoise", tmp_path / "clean.ply", "--out", tmp_path / "out")
    assert code == 0
    assert text.splitlines()[1].split()[2:-1] == ["left", "as", "it", "is"]


def test_many_meshes_as_json_and_none_written_over(run, scans, tmp_path):
    words = ["denoise", scans[0], scans[2], "--method", "taubin", "--out", tmp_path / "o", "--json"]
    code, text, _ = run(*words)
    assert code == 0
    facts = json.loads(text)
    assert (facts["done"], facts["failed"], facts["interrupted"]) == (2, 0, False)
    assert [one["in"] for one in facts["files"]] == [str(scans[0]), str(scans[2])]
    assert facts["files"][0]["parameters"] | {"fixed": None} == denoising.defaults("taubin")
    before = (tmp_path / "o" / "first.ply").read_bytes()
    code, text, _ = run(*words, "--set", "iterations=1")
    assert code == 1
    assert all("--force" in one["error"] for one in json.loads(text)["files"])
    assert (tmp_path / "o" / "first.ply").read_bytes() == before
    code, _, _ = run(*words, "--set", "iterations=1", "--force")
    assert code == 0
    assert (tmp_path / "o" / "first.ply").read_bytes() != before


def test_meshes_after_an_option_belong_to_the_others(run, scans, tmp_path):
    out = tmp_path / "out"
    code, text, _ = run("denoise", scans[0], "--out", out, "--method", "taubin", scans[2])
    assert code == 0
    assert "2 of 2 meshes" in text
    code, _, _ = run("denoise", scans[0], "--method", "taubin", tmp_path / "one.ply")
    assert code == 0
    assert (tmp_path / "one.ply").exists()


def test_many_meshes_are_refused_before_the_work(run, scans, tmp_path):
    (tmp_path / "other").mkdir()
    twin = tmp_path / "other" / "first.ply"
    twin.write_bytes(scans[0].read_bytes())
    for words, message in (
        ([scans[0], twin, "--out", tmp_path / "o"], "would both be written"),
        ([scans[0], scans[0], "--out", tmp_path / "o"], "would both be written"),
        ([scans[0], "-", "--out", tmp_path / "o"], "standard input"),
        ([scans[0], "--out", twin], "is a file"),
        ([scans[0], "--out", tmp_path / "no" / "o"], "is not there"),
        ([scans[0], "--out", tmp_path / "o", "--method", "tubin"], "'taubin'"),
        ([scans[0], "--out", tmp_path / "o", "--ground-truth", "no.ply"], "no.ply"),
        ([scans[0], "--out", tmp_path / "o", "--format", "ply"], "--format"),
    ):
        code, out, err = run("denoise", *words)
        assert (code, out) == (1, "")
        assert message in one_line(err)
        assert not (tmp_path / "o").exists()


def test_a_warning_about_one_of_many_names_it(run, scans, tmp_path):
    V, F = shapes.icosphere(1)
    io.write(scans[1], V[F].reshape(-1, 3), np.arange(F.size).reshape(-1, 3))
    code, _, err = run("denoise", *scans, "--method", "taubin", "--out", tmp_path / "o")
    assert code == 0
    assert one_line(err).startswith(f"meshfair denoise: warning: {scans[1]}: ")


def test_an_interrupt_of_many_says_what_is_done(run, scans, tmp_path, monkeypatch):
    whole = denoising.denoise
    calls = []

    def interrupted(*args, **named):
        calls.append(named)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return whole(*args, **named)

    monkeypatch.setattr(denoising, "denoise", interrupted)
    words = ["denoise", scans[0], scans[2], "--out", tmp_path / "o"]
    code, text, err = run(*words)
    assert code == 130
    assert str(scans[0]) in text
    assert text.splitlines()[-1] == f"1 of 2 meshes written to {tmp_path / 'o'}"
    assert err == "meshfair denoise: interrupted after 1 of 2 meshes\n"
    assert [path.name for path in (tmp_path / "o").iterdir()] == ["first.ply"]
    calls.clear()
    code, text, _ = run(*words, "--json", "--force")
    assert code == 130
    assert json.loads(text)["interrupted"] is True


# --- standard input and output ------------------------------------------------------------


class Pipe:
    """Standard input as a pipe that holds these bytes."""

    def __init__(self, data, terminal=False):
        self.buffer, self.isatty = BytesIO(data), lambda: terminal


@pytest.mark.parametrize("format", ["ply", "obj", "off", "stl", "vtu"])
@pytest.mark.parametrize(
    "words",
    [
        ["denoise", "--method", "taubin"],
        ["denoise", "--method", "taubin", "--json"],
        ["noise"],
        ["repair", "--weld", "0"],
    ],
    ids=" ".join,
)
def test_a_mesh_through_pipes_is_that_of_files(tmp_path, capsysbinary, monkeypatch, words, format):
    if format == "vtu":
        pytest.importorskip("meshio")
    source, out = tmp_path / f"in.{format}", tmp_path / f"out.{format}"
    io.write(source, *shapes.icosphere(1))
    command, *options = words
    assert cli.main([command, str(source), str(out), *options]) == 0
    capsysbinary.readouterr()
    monkeypatch.setattr(sys, "stdin", Pipe(source.read_bytes()))
    assert cli.main([command, "-", "-", "--format", format, *options]) == 0
    printed, said = capsysbinary.readouterr()
    assert printed == out.read_bytes()
    assert b"-" in said  # what was done is told beside the mesh
    # What comes out has the format of what went in, where nothing else is said.
    assert cli.main([command, str(source), "-", *options]) == 0
    assert capsysbinary.readouterr().out == out.read_bytes()


def test_every_format_goes_through_pipes():
    assert [f".{name}" for name in files.FORMATS] == list(io.FORMATS)


def test_info_of_standard_input(run, knot, monkeypatch):
    monkeypatch.setattr(sys, "stdin", Pipe(knot.read_bytes()))
    code, out, _ = run("info", "-", "--format", "ply")
    assert code == 0
    assert out.startswith("standard input\nvertices                    1,440\n")


def test_pipes_of_a_process_carry_any_byte(tmp_path):
    path = tmp_path / "in.stl"
    io.write(path, *shapes.icosphere(1))
    command = [sys.executable, "-m", "meshfair", "repair", "-", "-", "--format", "stl"]
    done = subprocess.run(command, input=path.read_bytes(), capture_output=True, timeout=60)
    assert done.returncode == 0
    assert done.stdout == path.read_bytes()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["denoise", "-", "-"], "give its --format, one of obj, off, ply, stl, glb, "),
        (["denoise", "-", "o.obj"], "give its --format"),
        (["info", "-"], "give its --format"),
        (["info", "-", "--format", "obj"], "standard input: byte 0: the file looks like PLY"),
        (["info", "knot.ply", "--format", "ply"], "--format is for standard input"),
    ],
)
def test_wrong_pipes(run, knot, monkeypatch, words, message):
    monkeypatch.chdir(knot.parent)
    monkeypatch.setattr(sys, "stdin", Pipe(knot.read_bytes()))
    code, out, err = run(*words)
    assert (code, out) == (1, "")
    assert message in one_line(err)
    assert "name it" not in err


def test_a_mesh_is_neither_typed_nor_shown(run, knot, monkeypatch):
    monkeypatch.setattr(sys, "stdin", Pipe(b"", terminal=True))
    code, _, err = run("info", "-", "--format", "ply")
    assert code == 1
    assert "by < or a pipe" in one_line(err)
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    code, _, err = run("noise", knot, "-")
    assert code == 1
    assert "by > or a pipe" in one_line(err)


def test_nothing_is_written_to_a_pipe_where_the_work_fails(run, tmp_path):
    io.write(tmp_path / "big.off", 1e70 * shapes.icosphere(0)[0], shapes.icosphere(0)[1])
    code, out, err = run("noise", tmp_path / "big.off", "-", "--sigma", "1e9")
    assert (code, out) == (1, "")
    assert "beyond 1e+75" in one_line(err)


# --- wrong usage, and what the command says to it -----------------------------------------


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("", "meshfair: COMMAND is missing; see meshfair --help"),
        ("denoize a b", "no command 'denoize'; there are info, repair,"),
        ("denoize a b", "(did you mean 'denoise'?)"),
        ("--vesion", "(did you mean '--version'?)"),
        ("info", "meshfair info: FILE is missing"),
        ("info -x", "there is no option -x"),
        ("info a.ply b.ply", "'b.ply' is too much"),
        ("info a.ply --jsn", "there is no option --jsn (did you mean '--json'?)"),
        ("compare - b.ply", "A: - is standard input"),
        ("repair a.ply b.ply --weld", "--weld needs a value"),
        ("repair a.ply b.ply --weld much", "--weld: give a number, not 'much'"),
        ("repair a.ply b.ply --orient outwards", "--orient is 'outwards'; give one of"),
        ("repair a.ply b.ply --d", "could match --degenerate, --duplicates"),
        ("noise a.ply b.ply --model gausian", "(did you mean 'gaussian'?)"),
        ("noise a.ply b.ply --seed 1.5", "--seed: give a whole number, not '1.5'"),
        ("denoise", "IN ... OUT is missing"),
        ("denoise a.ply", "OUT is missing; name the mesh to write, or give --out FOLDER"),
        ("denoise a.ply b.ply c.ply", "there are 3 meshes; give IN and OUT alone, or --out"),
        ("denoise a.ply --methode taubin b.ply", "no option --methode (did you mean '--method'?)"),
        ("denoise a.ply b.ply --sigma 0.2", "no option --sigma (did you mean '--noise'?)"),
        ("denoise a.ply b.ply --noise 30%", "--noise: give a number, not '30%'"),
        ("denoise a.ply b.ply --ground-truth -", "--ground-truth: - is standard input"),
    ],
)
def test_wrong_usage_is_told_in_one_line(capsys, words, message):
    with pytest.raises(SystemExit) as stop:
        cli.main(words.split())
    assert stop.value.code == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert message in one_line(err)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--weights distance", "--weights is no parameter of feature-convinced; feature-convinced"),
        ("--method tubin", "(did you mean 'taubin'?)"),
        ("--method taubin --set callback=3",
         "--set callback=3: no such parameter; taubin has weights, lam, mu, iterations"),
        ("--method taubin --set V=3", "--set V=3: no such parameter; taubin has"),
        ("--method taubin --set F=3", "--set F=3: no such parameter; taubin has"),
        ("--method taubin --set rng=3", "--set rng=3: no such parameter; taubin has"),
        ("--method taubin --set itrations=3", "(did you mean 'iterations'?)"),
        ("--set fixed=3", "--set fixed=3: no such parameter; it is the option --fix-boundary"),
        ("--set sigma=3", "--set sigma=3: no such parameter; it is the option --noise"),
        ("--set method=heat", "it is the option --method"),
        ("--set parameters=auto", "it is the option --auto"),
        ("--set ground_truth=x.ply", "it is the option --ground-truth"),
        ("--set iterations=many", "--set iterations is 'many'; give a number or None"),
        ("--set iterations=2.5", "--set iterations is 2.5; give a whole number of at least 0"),
        ("--set gap=2.5", "--set gap is '2.5'; give a whole number"),
        ("--set sigma_normal=nan", "--set sigma_normal is nan; give a number above 0"),
        ("--method implicit --set keep_volume=maybe", "keep_volume is 'maybe'; give True or False"),
        ("--method implicit --set keep_volume=true --fix-boundary", "--set keep_volume scales"),
        ("--method regularised --set order=3", "--set order is 3; give one of 1, 2"),
        ("--method heat --time 1 --set time=2", "given twice"),
        ("--noise 0.1 --set noise=0.1", "given twice, by --noise and by --set"),
        ("--noise -1e-3", "--noise is -0.001; give a number of at least 0"),
        ("--noise nan", "--noise is nan; give a number"),
        ("--method taubin --noise 0.1", "--noise is given, but taubin with default parameters does "
         "not use it; leave it out, or let --auto choose"),
        ("--method taubin --set mu=-1e200", "outgrown all numbers in iteration 1; take mu"),
    ],
)  # fmt: skip
def test_wrong_parameters_are_told_in_the_words_of_the_command(run, tmp_path, words, message):
    io.write(tmp_path / "in.off", *shapes.icosphere(1))
    words = words.split()
    if "--method" not in words:
        words += ["--method", "feature-convinced"]
    code, out, err = run("denoise", tmp_path / "in.off", tmp_path / "o.off", *words)
    assert (code, out) == (1, "")
    assert message in one_line(err)
    assert not (tmp_path / "o.off").exists()


def test_wrong_parameters_are_told_before_a_mesh_is_read(run, tmp_path):
    code, _, err = run(
        *("denoise", tmp_path / "no.ply", tmp_path / "o.ply"),
        *("--method", "feature-convinced", "--set", "sigma_normal=0"),
    )
    assert code == 1
    assert "--set sigma_normal is 0" in one_line(err)


def test_parameters_without_a_method_are_told(run, tmp_path):
    io.write(tmp_path / "in.off", *shapes.icosphere(1))
    for words in (["--weights", "distance"], ["--set", "iterations=3"]):
        code, _, err = run("denoise", tmp_path / "in.off", tmp_path / "o.off", *words)
        assert code == 1
        assert "auto chooses all of them; name a --method, too" in one_line(err)


def test_the_front_says_what_it_chose_and_why(run, noisy, tmp_path):
    code, out, _ = run("denoise", noisy, tmp_path / "o.ply")
    assert code == 0
    expected = denoising.denoise(*io.read(noisy))
    assert f"method  {expected.method}" in re.sub(r"(method) +", r"\1  ", out)
    assert expected.reason in out
    assert np.array_equal(io.read(tmp_path / "o.ply")[0], expected.V)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            "--sigma 1 --model uniform --amplitude 1",
            "--sigma is for normals, gaussian, correlated, impulsive, and not for uniform",
        ),
        ("--steps 2", "--steps is for correlated, and not for normals"),
        ("--fraction 0.5", "--fraction is for impulsive, and not for normals"),
        ("--sigma -1e-3", "--sigma is -0.001; give a number of at least 0"),
        ("--sigma 0 --snr 20", "the noise is zero everywhere; no scale gives it an SNR"),
        ("--snr nan", "--snr is nan; give a number of at least -300 and at most 300"),
        ("--snr -7000", "--snr is -7000.0; give a number"),
    ],
)
def test_wrong_noise_is_told_in_the_words_of_the_command(run, tmp_path, words, message):
    io.write(tmp_path / "in.off", *shapes.icosphere(1))
    code, _, err = run("noise", tmp_path / "in.off", tmp_path / "o.off", *words.split())
    assert code == 1
    assert message in one_line(err)
    assert not (tmp_path / "o.off").exists()


def test_an_assignment_that_is_almost_one(run, tmp_path):
    words = ["--assignment", "a11", "--out", tmp_path / "grades.csv"]
    code, _, err = run("grade", tmp_path, *words)
    assert code == 1
    assert "there is no assignment a11; there are a1, " in one_line(err)
    assert "(did you mean 'a1'?)" in err


def parser_of(command):
    parser = Parser(prog=command)
    importlib.import_module(f"meshfair.cli.{command}").add_arguments(parser)
    return parser


def test_advice_is_in_the_words_of_the_command():
    known = {option for name in cli.COMMANDS for option in parser_of(name)._option_string_actions}
    for affects, remedy in ADVICE.values():
        for text in (affects, remedy):
            told = in_words_of_the_command(text, parser_of("info").option_of)
            python = re.sub(r"meshfair\.[a-z_.]+ in Python", "", told)
            assert not re.search(r"\(V, F|\w\.\w|\w=", python), told
            assert {word.rstrip(",;:") for word in python.split() if word[:2] == "--"} <= known
    told = in_words_of_the_command(ADVICE["degenerate_faces"].remedy, {})
    assert told.startswith("meshfair repair --weld 0 --degenerate, or ")


@pytest.mark.parametrize(
    "name", ["mesh.stl", "mesh.area.stl", "mesh.repair.ply", "weights.obj", "noise.off", "V.ply"]
)
def test_names_of_files_are_no_words_of_python(run, tmp_path, name):
    for path in (tmp_path / name, name):
        code, _, err = run("info", path)
        assert code == 1
        assert one_line(err).startswith(f"meshfair info: {path}: opening: ")


def messages_of(folder):
    """The text of every error and warning in the modules of a folder; values in it are 7."""
    for path in sorted(folder.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Raise):
                node = node.exc
            if isinstance(node, ast.Call):
                name = ast.unparse(node.func)
                if name.endswith(("Error", "warn", "file_error")):
                    for text in node.args:
                        yield f"{path.name}: {name}", spelled(text)


def spelled(node):
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(spelled(value) or "7" for value in node.values)
    return ""


# What no command can meet: arrays and arguments that it makes itself.
UNMET = (
    "callback is", "fixed has", "fixed is", "rng is", "the mesh has faces that", "a stream has no",
    "give format=", "V has ",
)  # fmt: skip


def test_no_message_that_a_command_can_meet_speaks_python():
    folder = Path(cli.__file__).parents[1]
    option_of = {}
    for command in ("info", "repair", "noise", "denoise"):
        option_of |= parser_of(command).option_of
    seen = 0
    for part in ("io", "mesh", "filters"):
        for place, text in messages_of(folder / part):
            if text.startswith(UNMET):
                continue
            told = in_words_of_the_command(text, option_of)
            seen += bool(text)
            assert not re.search(r"\(V, F|mesh\.\w|=True|=False|=\"|\w_\w+=", told), (place, told)
    assert seen > 60


# --- outputs ------------------------------------------------------------------------------


def test_an_output_is_not_written_over_without_force(run, knot, tmp_path):
    out = tmp_path / "there.ply"
    out.write_text("precious")
    code, _, err = run("noise", knot, out)
    assert code == 1
    assert "--force" in one_line(err)
    assert out.read_text() == "precious"
    code, _, _ = run("noise", knot, out, "--force")
    assert code == 0
    assert len(io.read(out)[0]) == 1440


@pytest.mark.parametrize("how", ["same", "dotted", "symlink", "hard link"])
def test_an_input_is_never_written_over(run, knot, tmp_path, how):
    out = tmp_path / "other.ply"
    if how == "same":
        out = knot
    elif how == "dotted":
        (tmp_path / "d").mkdir()
        out = tmp_path / "d" / ".." / knot.name
    elif how == "symlink":
        out.symlink_to(knot)
    else:
        os.link(knot, out)
    before = knot.read_bytes()
    code, _, err = run("noise", knot, out, "--force")
    assert code == 1
    assert "input" in one_line(err)
    assert knot.read_bytes() == before


def test_outputs_that_cannot_be_written_are_found_before_the_work(run, tmp_path):
    # The input is missing, but the output is looked at first.
    for out, message in [
        (tmp_path / "o.txt", ".ply"),
        (tmp_path / "nowhere" / "o.ply", "is not there"),
        (tmp_path, ".ply"),
    ]:
        code, _, err = run("noise", tmp_path / "missing.ply", out)
        assert code == 1
        assert message in one_line(err)
    (tmp_path / "folder.ply").mkdir()
    code, _, err = run("noise", tmp_path / "missing.ply", tmp_path / "folder.ply", "--force")
    assert code == 1
    assert "is a folder" in one_line(err)


def test_an_output_that_appears_during_the_work_is_kept(run, knot, tmp_path, monkeypatch):
    out = tmp_path / "o.ply"

    def slow(V, F, sigma, rng):
        out.write_text("someone else's")
        return V

    monkeypatch.setitem(noise.MODELS, "normals", slow)
    code, _, err = run("noise", knot, out)
    assert code == 1
    assert "--force" in one_line(err)
    assert out.read_text() == "someone else's"


# --- doctor -------------------------------------------------------------------------------


def test_doctor_looks_at_everything(run, monkeypatch, tmp_path):
    monkeypatch.setenv("MESHFAIR_DATA", str(tmp_path))
    code, out, _ = run("doctor", "--json")
    facts = json.loads(out)
    checks = {check["name"]: check for check in facts["checks"]}
    assert {"python", "meshfair", "numpy", "libigl", "cores", "numba cache", "EGL"} <= set(checks)
    assert checks["numpy"]["found"] == np.__version__
    assert checks["numpy"]["state"] == "ok"
    assert f"pytest {pytest.__version__}" in checks["extra test"]["found"]
    assert checks["real meshes"]["state"] == "note"
    assert str(tmp_path) in checks["real meshes"]["found"]
    assert facts["ok"] == (code == 0) == all(c["state"] != "problem" for c in facts["checks"])
    for check in checks.values():
        assert check["state"] == "ok" or check["advice"]


def test_doctor_tells_what_is_needed_from_what_is_optional(run, monkeypatch):
    import importlib.metadata
    from email.message import Message

    about = Message()
    about["Requires-Python"] = ">=99"
    for extra in ("fast", "viewer", "all"):
        about["Provides-Extra"] = extra
    requires = [
        "numpy>=2.1", "scipy>=1.14", "absent>=1", "elsewhere; sys_platform == 'nowhere'",
        "numba>=0.61; extra == 'fast'", "numpy; extra == 'viewer'", "missing>2; extra == 'viewer'",
        "meshfair[fast,viewer]; extra == 'all'",
    ]  # fmt: skip
    versions = {"numpy": "2.4.6", "scipy": "1.9.0", "numba": "0.61.0"}

    def version(package):
        if package not in versions:
            raise importlib.metadata.PackageNotFoundError(package)
        return versions[package]

    monkeypatch.setattr(importlib.metadata, "metadata", lambda _: about)
    monkeypatch.setattr(importlib.metadata, "requires", lambda _: requires)
    monkeypatch.setattr(importlib.metadata, "version", version)
    code, out, _ = run("doctor", "--json")
    assert code == 1
    checks = {check["name"]: check for check in json.loads(out)["checks"]}
    states = {name: check["state"] for name, check in list(checks.items())[:7]}
    assert states == {
        "python": "problem", "meshfair": "ok", "numpy": "ok", "scipy": "problem",
        "absent": "problem", "extra fast": "ok", "extra viewer": "note",
    }  # fmt: skip
    assert checks["scipy"]["found"] == "scipy 1.9.0 is not >=1.14"
    assert checks["absent"]["advice"] == 'pip install "absent>=1"'
    assert checks["extra fast"]["found"] == "numba 0.61.0"
    assert checks["extra viewer"]["found"] == "missing is not installed"
    assert "meshfair[viewer]" in checks["extra viewer"]["advice"]


@pytest.mark.parametrize(
    ("found", "wanted", "state"),
    [
        ("1.14", ">=1.14", "ok"),
        ("1.9.3", ">=1.14", "problem"),
        ("2.0", ">=1.14", "ok"),
        ("2.0", ">=2.0.0", "ok"),
        ("1.14.0rc1", ">=1.14", "problem"),
        ("1.15rc1", ">=1.14", "ok"),
        ("2.0rc1", ">=2.0.1", "problem"),
        ("0.18.0", "", "ok"),
        (None, "", "problem"),
    ],
)
def test_versions_are_compared_as_python_does(found, wanted, state):
    assert doctor._core(Requirement(f"x{wanted}"), found).state == state


def test_doctor_without_numba_is_no_problem(monkeypatch):
    monkeypatch.setattr(_fast, "available", lambda: False)
    (check,) = doctor._compiled_loops()
    assert check.state == "note"
    assert "meshfair[fast]" in check.advice


@pytest.mark.parametrize(
    ("error", "state", "words"),
    [
        (ImportError("libX11.so.6: cannot open shared object file"), "problem", "libX11"),
        (ModuleNotFoundError("No module named 'pooch'", name="pooch"), "note", "without pooch"),
    ],
)
def test_a_check_that_fails_is_itself_a_finding(error, state, words):
    def look():
        raise error

    (check,) = doctor._attempt("real meshes", look)
    assert check.state == state
    assert words in check.found
    assert check.advice


# --- the frame ----------------------------------------------------------------------------


def broken_mesh():
    """A sphere with fins: many non-manifold edges, so that what is found is a long line."""
    V, F = shapes.icosphere(1)
    fins = [[*F[0, :2], len(V) + k] for k in range(6)] + [[*f[:2], len(V)] for f in F[1:7]]
    return np.vstack([V, 3 * V[:6]]), np.vstack([F, fins])


@pytest.mark.parametrize("columns", [60, 80])
def test_info_fits_the_terminal(run, tmp_path, monkeypatch, columns):
    io.write(tmp_path / "s.off", *broken_mesh())
    monkeypatch.setenv("COLUMNS", str(columns))
    monkeypatch.chdir(tmp_path)
    code, out, _ = run("info", "s.off")
    assert code == 0
    assert "problem: " in out
    assert max(map(len, out.splitlines())) <= columns
    monkeypatch.setenv("COLUMNS", "1000")
    wide = run("info", "s.off")[1]
    assert out.split() == wide.split()  # no word, and nothing that is to be typed, is broken


@pytest.mark.parametrize("columns", [60, 80])
def test_a_table_of_many_meshes_fits_the_terminal(run, tmp_path, monkeypatch, columns):
    monkeypatch.chdir(tmp_path)
    names = [f"a_rather_long_name_of_a_scan_of_a_sphere_number_{k}.ply" for k in range(2)]
    for name in [*names, "short.ply"]:
        io.write(name, *shapes.icosphere(1))
    monkeypatch.setenv("COLUMNS", str(columns))
    words = "denoise", *names, "short.ply", "--method", "guided-normal"
    piped = run(*words, "--out", "a")[1]
    assert all(name in piped for name in names)  # to programs names are told whole
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    code, shown, _ = run(*words, "--out", "b")
    assert code == 0
    lines = shown.splitlines()
    assert len(lines) == 5
    assert max(map(len, lines)) <= columns
    assert [line.split()[0][-5:] for line in lines[1:4]] == ["0.ply", "1.ply", "t.ply"]
    assert lines[3].startswith("short.ply ")


def test_a_clipped_name_has_its_beginning_and_its_end():
    assert printing.clipped("0123456789abcdefghij", 20) == "0123456789abcdefghij"
    assert printing.clipped("0123456789abcdefghij", 17) == "0123456...defghij"
    assert printing.clipped("0123456789abcdefghij", -5) == "012345...defghij"


@pytest.mark.parametrize("command", cli.COMMANDS)
def test_help_of_each_command(command, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit) as stop:
        cli.main([command, "--help"])
    assert stop.value.code == 0
    out = capsys.readouterr().out
    assert f"usage: meshfair {command}" in out
    assert max(map(len, out.splitlines())) <= 80


@pytest.mark.parametrize("columns", ["60", "200"])
def test_the_grid_in_the_help_can_be_copied(capsys, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", columns)
    with pytest.raises(SystemExit):
        cli.main(["sweep", "--help"])
    lines = capsys.readouterr().out.splitlines()
    grid = tomllib.loads("\n".join(x for x in lines if re.match(r" {4}\w+ = ", x)))
    assert grid["seed"] == {"from": 0, "to": 199}
    assert grid["experiment"] == "stopping"


@pytest.mark.parametrize("command", ["noise", "denoise", "compare"])
def test_help_says_that_an_snr_depends_on_the_origin(command, capsys):
    with pytest.raises(SystemExit):
        cli.main([command, "--help"])
    assert re.search(r"SNR \w+.* origin", " ".join(capsys.readouterr().out.split()))


def test_help_names_the_default_method(capsys):
    with pytest.raises(SystemExit):
        cli.main(["denoise", "--help"])
    assert f"(default {denoising.DEFAULT}: one of these" in " ".join(
        capsys.readouterr().out.split()
    )


def test_wrong_usage_is_2(capsys):
    for words in ([], ["mend"], ["info"], ["info", "a", "b"], ["noise", "a"]):
        with pytest.raises(SystemExit) as stop:
            cli.main(words)
        assert stop.value.code == 2
    capsys.readouterr()


NOT_IN_CORE = {"numba", "pandas", "matplotlib", "polyscope", "tqdm", "pooch", "IPython"}


@pytest.mark.parametrize(
    ("words", "unneeded"),
    [
        (["--help"], {*NOT_IN_CORE, "scipy", "igl"}),
        (["info", "knot.ply"], {*NOT_IN_CORE, "igl"}),
        (["repair", "knot.ply", "o.ply", "--weld", "0.1", "--split"], {*NOT_IN_CORE, "igl"}),
        (["noise", "knot.ply", "o.ply"], {*NOT_IN_CORE, "igl"}),
        (["denoise", "knot.ply", "o.ply"], {*NOT_IN_CORE, "igl"}),
        (["compare", "knot.ply", "knot.ply"], NOT_IN_CORE),
    ],
    ids=lambda words: words[0] if isinstance(words, list) else "",
)
def test_commands_are_quick_because_they_load_little(words, unneeded, knot):
    code = (
        "import sys; from meshfair.cli import main\n"
        f"try: code = main({words})\n"
        "except SystemExit as stop: code = stop.code\n"
        "print(*{m.split('.')[0] for m in sys.modules}, file=sys.stderr)\n"
        "sys.exit(code)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=knot.parent
    )
    assert done.returncode == 0, done.stderr
    loaded = set(done.stderr.split())
    assert {"meshfair", "numpy"} <= loaded
    assert loaded.isdisjoint(unneeded)


def test_what_is_not_installed_is_named(run, knot, monkeypatch):
    def needs(V, F):
        raise ModuleNotFoundError("No module named 'pandas'", name="pandas")

    monkeypatch.setattr(mesh, "inspect", needs)
    code, _, err = run("info", knot)
    assert code == 1
    assert "needs pandas, which is not installed; see meshfair doctor" in one_line(err)


def test_an_error_of_the_package_is_reported_as_such(run, knot, monkeypatch):
    def broken(V, F):
        raise TypeError("unexpected\nthings")

    monkeypatch.setattr(mesh, "inspect", broken)
    code, _, err = run("info", knot)
    assert code == 70
    assert "TypeError: unexpected things" in one_line(err)
    assert "MESHFAIR_TRACEBACK" in err
    monkeypatch.setenv("MESHFAIR_TRACEBACK", "1")
    with pytest.raises(TypeError):
        cli.main(["info", str(knot)])


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [
        (MemoryError(), 1, "not enough memory"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (FloatingPointError("the residual stays at 3"), 1, "residual"),
        (OSError(28, "No space left on device"), 1, "No space left"),
    ],
)
def test_errors_are_one_line(run, knot, monkeypatch, error, code, message):
    def fail(V, F):
        raise error

    monkeypatch.setattr(mesh, "inspect", fail)
    found, out, err = run("info", knot)
    assert found == code
    assert out == ""
    assert message in one_line(err)


def test_as_a_process_with_an_odd_name_in_a_plain_locale(tmp_path):
    path = tmp_path / "Häse x.off"
    io.write(path, *shapes.icosphere(0))
    plain = {**os.environ, "PYTHONIOENCODING": "ascii", "LC_ALL": "C"}
    done = process("info", tmp_path / "Höse.off", env=plain)
    assert done.returncode == 1
    one_line(done.stderr)
    done = process("info", path, env=plain)
    assert done.returncode == 0, done.stderr
    assert "no problems found" in done.stdout


@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.parametrize("words", [["info", "s.off"], ["info", "s.off", "--json"], ["--help"]])
def test_a_reader_that_goes_away_is_no_error(tmp_path, unbuffered, words):
    io.write(tmp_path / "s.off", *shapes.icosphere(0))
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run(
        [sys.executable, "-m", "meshfair", *words],
        stdout=writer,
        stderr=subprocess.PIPE,
        text=True,
        timeout=60,
        cwd=tmp_path,
        env={**os.environ, "PYTHONUNBUFFERED": unbuffered},
    )
    os.close(writer)
    assert done.stderr == ""
    # argparse looks over it where it can.
    assert done.returncode in ((0, 141) if words == ["--help"] else (141,))


def test_json_has_no_numbers_that_json_has_not(capsys):
    printing.print_json(
        {"a": np.float64("nan"), "b": [np.inf, 1], "c": np.arange(2), "d": np.True_}
    )
    assert json.loads(capsys.readouterr().out) == {
        "a": None,
        "b": ["Infinity", 1],
        "c": [0, 1],
        "d": True,
    }
