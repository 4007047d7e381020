"""Fair marks, and what the teacher gets: a mistake costs once, right code keeps its points."""

import ast
import importlib.util
import json
import re
import subprocess
import sys
import types
import zipfile

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import issparse

from meshfair import weights
from meshfair.mesh import is_closed, volume
from meshfair_grading import answers, command, expect, handout, marking, similar
from meshfair_grading.answers import Failure, ask, plain
from meshfair_grading.assignment import Assignment
from meshfair_grading.explain import explain
from meshfair_grading.feedback import Report
from meshfair_grading.gradebook import Gradebook
from meshfair_grading.isolation import Isolation, Limits
from meshfair_grading.loading import load
from meshfair_grading.meshes import sphere, tower, unseen
from meshfair_grading.outcomes import Outcome
from meshfair_grading.overview import Overview, write_overview
from meshfair_grading.rules import Rules, reached, read
from meshfair_grading.students import NotebookStudent, Student
from test_assignments import LOADED, NAMES, SOURCES

SEED = 4321


@pytest.fixture(scope="module")
def isolation():
    return Isolation.detect(Limits(call=5.0, total=40.0))


@pytest.fixture
def marked(isolation, tmp_path):
    """Mark a right solution followed by some code, in a process of its own."""

    def marked(name, code, kind="utf-8"):
        path = tmp_path / f"{name}.py"
        path.write_bytes((SOURCES[name].solution() + "\n\n" + code).encode(kind))
        return marking.mark(marking.Submission("anna", path), LOADED[name], isolation, SEED)

    return marked


def points(mark):
    """Points lost, by task."""
    lost = {}
    for outcome in mark.outcomes:
        if outcome.earned < outcome.points:
            lost[outcome.task] = lost.get(outcome.task, 0) + outcome.points - outcome.earned
    return lost


# --- A mistake costs once --------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "code", "lost"),
    [
        # Wrong edges, which the next two tasks call.
        ("a2", "def edges(F):\n    return np.sort(F[:, :2], axis=1)\n", {"edges": 3}),
        ("a2", "def edges(F):\n    raise NotImplementedError\n", {"edges": 3}),
        # Right values, but the caller's triangles are sorted in place.
        (
            "a2",
            "right = edges\n\n\ndef edges(F):\n    E = right(F)\n    F.sort()\n    return E\n",
            {"edges": 1.5},
        ),
        # Two mistakes, the second in a function that calls the first.
        (
            "a2",
            "def edges(F):\n    return np.sort(F[:, :2], axis=1)\n\n\n"
            "def combinatorial_weights(F, n):\n"
            "    E = edges(F)\n"
            "    return coo_array((np.ones(len(E)), E.T), shape=(n, n)).tocsr()\n",
            {"edges": 3, "combinatorial_weights": 4},
        ),
        # Heat in place: the best moment is another task.
        (
            "a3",
            "def heat(V, A, tau, steps):\n    for _ in range(steps):\n"
            "        V += tau * (A @ V - V)\n    return V\n",
            {"heat": 2.5},
        ),
        ("a3", "def heat(V, A, tau, steps):\n    return V\n", {"heat": 5}),
        # A wrong fit, which the honest measure calls; wrong hats, on which all else rests.
        ("a6", "def fit(G, N_true, ridge):\n    return G.sum(axis=(0, 2))\n", {"fit": 4}),
        ("a6", "def hats(x, nodes):\n    return np.ones((len(x), len(nodes)))\n", {"hats": 4}),
    ],
)
def test_a_mistake_costs_where_it_was_made(name, code, lost, marked):
    mark = marked(name, code)
    assert points(mark) == lost, mark.report(LOADED[name]).text()
    for outcome in mark.outcomes:
        if outcome.task not in lost:
            assert not outcome.hint
    noted = {outcome.task for outcome in mark.outcomes if "in place of yours" in outcome.note}
    assert noted
    assert noted.isdisjoint({next(iter(lost))})


def test_the_note_stands_once_in_each_task(marked):
    report = marked("a2", "def edges(F):\n    return F\n").report(LOADED["a2"])
    assert report.text().count("Marked with a right `edges`") == 2
    assert "Marked with a right" in report.page()


def test_in_a_notebook_the_note_says_what_to_mend_first(tmp_path, monkeypatch):
    text = SOURCES["a2"].solution() + "\n\ndef edges(F):\n    return F[:, :2]\n"
    student = notebook_student("a2", text, tmp_path, monkeypatch)
    outcomes = LOADED["a2"].mark(student, SEED)
    notes = {outcome.task: outcome.note for outcome in outcomes if outcome.note}
    assert set(notes) == {"combinatorial_weights", "distance_weights"}
    assert "mend that first" in notes["distance_weights"]


def notebook_student(name, text, folder, monkeypatch):
    path = folder / f"{name}.py"
    path.write_text(text, encoding="utf-8")
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setitem(sys.modules, name, module)
    return NotebookStudent(name, LOADED[name].rules)


def test_the_right_functions_bring_no_others_along():
    from meshfair_grading.standin import stand_in

    text = stand_in(LOADED["a2"], ["combinatorial_weights"])
    defined = {node.name for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef)}
    assert defined == {"_right_functions", "combinatorial_weights", "edges"}
    assert text.isascii()


@given(st.dictionaries(st.sampled_from("abcde"), st.lists(st.sampled_from("abcde"), max_size=3)))
def test_calls_through_others_are_found(calls):
    expected, before = set(calls.get("a", [])), None
    while expected != before:
        before = set(expected)
        expected |= {name for one in before for name in calls.get(one, [])}
    assert reached(calls, "a") == expected


# --- What the rules forbid costs what needs it ------------------------------------------


@pytest.mark.parametrize(
    "code",
    [
        "def f(W):\n    inv = 1 / W\n    return inv * W\n",
        "def inv(d):\n    return 1 / d\n\n\ndef f(W):\n    return inv(W)\n",
        "def f(W, inv=2):\n    return [inv for inv in W]\n",
        "class Scaled:\n    def __init__(self):\n        self.inv = 2\n\n\n"
        "def f(W):\n    return Scaled().inv\n",
        "import os, sys, pathlib, subprocess\n",
        "if __name__ == '__main__':\n    import igl\n    print(igl.inv(1))\n",
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from igl import cotmatrix\n",
    ],
)
def test_harmless_code_breaks_no_rule(code):
    reading = read(code, Rules(forbidden=("inv", "toarray")))
    assert not reading.failures
    assert not reading.remarks


@pytest.mark.parametrize(
    ("code", "what", "line"),
    [
        ("import numpy as np\ndef f(W):\n    return np.linalg.inv(W)\n", "the use of inv", 3),
        ("def f(W):\n    return W.toarray()\n", "the use of toarray", 2),
        ("from numpy.linalg import inv as i\ndef f(W):\n    return i(W)\n", "numpy.linalg.inv", 1),
        ("from numpy.linalg import *\ndef f(W):\n    return inv(W)\n", "the use of inv", 3),
        ("import numpy as np\ninverse = np.linalg.inv\ndef f(W):\n    return inverse(W)\n", "inv", 2),  # noqa: E501
        ("import igl\ndef f(W):\n    return igl.cotmatrix(W)\n", "the import of igl", 1),
        ("import igl as math, os\ndef f(W):\n    return math.pi\n", "the import of igl", 1),
        ("def f(W):\n    import igl\n", "the import of igl", 2),
        ("import igl\n@igl.fast\ndef f(W):\n    return W\n", "the import of igl", 1),
        ("import helper\nK = helper.K\nL = K + 1\ndef f(W):\n    return L\n", "helper", 1),
        ("\x0cimport igl\r\ndef f(W):\r\n    return igl\r\n", "the import of igl", 1),
    ],
)  # fmt: skip
def test_what_is_forbidden_costs_the_function_that_uses_it(code, what, line):
    code += "\n\ndef g(W):\n    return W\n"
    reading = read(code, Rules(forbidden=("inv", "toarray")))
    assert set(reading.failures) == {"f"}
    assert what in reading.failures["f"].message
    assert reading.failures["f"].line == line


def test_what_is_forbidden_and_not_used_costs_nothing(marked):
    code = (
        "import os, igl\nfrom meshfair import shapes\n\nV, F = shapes.knot()\n"
        "print(len(edges(F)))\n\nif __name__ == '__main__':\n    import polyscope\n"
    )
    mark = marked("a2", code)
    assert points(mark) == {}
    assert mark.status == "graded"
    remarks = "\n".join(mark.remarks)
    assert "import igl" in remarks
    assert "shapes.knot()" in remarks
    assert "polyscope" not in remarks


def test_a_line_outside_the_functions_that_fails_costs_nothing(marked):
    mark = marked("a2", "V = np.load('my_mesh.npy')\nassert False\nraise SystemExit\n")
    assert points(mark) == {}
    assert "FileNotFoundError" in mark.remarks[0]
    assert len(mark.remarks) == 3


def test_remarks_do_not_grow_without_end(tmp_path):
    path = tmp_path / "a9.py"
    path.write_text("1 / 0\n" * 500)
    assert len(load(str(path), Rules())[1].remarks) == 5


def test_the_last_definition_counts_and_the_future_holds(tmp_path):
    path = tmp_path / "a9.py"
    path.write_text(
        "from __future__ import annotations\nimport igl\n\n\ndef f(x: igl.Mesh):\n    return 1\n"
        "\n\ndef f(x: nowhere):\n    return 2\n"
    )
    module, reading = load(str(path), Rules())
    assert module.f(0) == 2
    assert reading.failures == {}


@pytest.mark.parametrize(
    ("text", "encoding"),
    [("# -*- coding: latin-1 -*-\n# caf\xe9\n", "latin-1"), ("# caf\xe9\n", "utf-8-sig")],
)
def test_files_in_the_encoding_that_they_declare_are_taken(text, encoding, isolation, tmp_path):
    path = tmp_path / "a2.py"
    path.write_bytes((text + SOURCES["a2"].solution()).encode(encoding))
    mark = marking.mark(marking.Submission("anna", path), LOADED["a2"], isolation, SEED)
    assert points(mark) == {}


# --- Answers ----------------------------------------------------------------------------


def test_a_librarys_not_implemented_error_is_an_error_with_its_line(marked):
    mark = marked("a2", "def averaging(W):\n    return W + 1e-12\n")
    outcome = mark.outcomes[-1]
    assert outcome.status == "wrong"
    assert "adding a nonzero scalar" in outcome.hint
    assert "return W + 1e-12" in outcome.got


def test_what_the_code_printed_has_no_traceback_of_ours(isolation, tmp_path):
    path = tmp_path / "a1.py"
    path.write_text(
        "import os\n\n\ndef snr(V, V_noisy):\n    print('here', flush=True)\n"
        "    os.closerange(3, 64)\n    return 1.0\n"
    )
    mark = marking.mark(marking.Submission("anna", path), LOADED["a1"], isolation, SEED)
    assert "here" in mark.printed
    assert "Traceback" not in mark.printed


def test_a_stub_is_named_by_whoever_meets_it(tmp_path):
    path = tmp_path / "a9.py"
    path.write_text("def g(x):\n    raise NotImplementedError\n\n\ndef f(x):\n    return g(x)\n")
    module, _ = load(str(path), Rules())
    assert ask(module.f, [1], str(path)).failure == Failure("not done", "g")


def test_numbers_in_objects_are_numbers():
    from fractions import Fraction

    for value in (
        np.array([[0, 1], [1, 2]], dtype=object),
        np.array([np.int32(1), 2.5], dtype=object),
        [Fraction(1, 2), 3],
    ):
        assert plain(value).dtype.kind in "if"
    assert plain(np.array([1, None], dtype=object)).type == "ndarray"
    assert plain(np.array([2**70, 1], dtype=object)).tolist() == [2.0**70, 1.0]


def in_single_precision(value):
    if isinstance(value, tuple):
        return tuple(map(in_single_precision, value))
    if issparse(value) or (isinstance(value, np.ndarray) and value.dtype == float):
        return value.astype(np.float32)
    return np.float32(value) if isinstance(value, float) else value


class SinglePrecision(Student):
    """The solution, which gets and gives float32."""

    def __init__(self, name):
        super().__init__()
        self.module = types.ModuleType(name)
        exec(SOURCES[name].solution(), self.module.__dict__)

    def _ask(self, name, arguments):
        def function(*given):
            function = getattr(self.module, name)
            return in_single_precision(function(*map(in_single_precision, given)))

        answer = ask(function, arguments, "")
        return answers.Answer(answer.value, (), answer.failure)


@pytest.mark.parametrize(
    ("name", "seed"),
    [(name, seed) for name in NAMES for seed in (SEED, 5) if (name, seed) != ("a5", 5)],
)
def test_single_precision_is_right_within_its_own(name, seed):
    report = Report(name, LOADED[name].mark(SinglePrecision(name), seed))
    lost = {outcome.title: outcome.hint for outcome in report.outcomes if outcome.status != "right"}
    if name == "a4":  # the one place where the task asks for more, and says so
        assert "float32" in lost.pop(next(iter(lost)))
    assert lost == {}


@given(st.floats(-1e6, 1e6, allow_subnormal=False), st.floats(1e-12, 1e-3), st.integers(2, 9))
def test_different_numbers_are_shown_as_different(expected, relative, digits):
    got = expected * (1 + relative) if expected else relative
    if got != expected:
        shown = expect.differing(expected, got, digits)
        assert float(shown[0]) != float(shown[1])
        assert float(shown[0]) == pytest.approx(expected, rel=10.0 ** (1 - digits), abs=1e-300)


def test_a_hint_must_explain_every_case():
    check = Assignment("a9", "Test")
    values = np.arange(1.0, 5.0)

    @check.part("f", 1, lambda seed: [("one", values), ("two", 2 * values)])
    def is_doubled(student, x):
        """Twice."""
        mistakes = [("constant", 3 * values), ("three times", lambda: 3 * x)]
        expect.close(student.f(x), 2 * x, "x", mistakes=mistakes)

    class Scripted(Student):
        def __init__(self, function):
            super().__init__()
            self.function = function

        def _ask(self, name, arguments):
            return answers.Answer(self.function(*arguments))

    # On the first case both mistakes give the same; only one gives the second case too.
    assert "three times" in check.mark(Scripted(lambda x: 3 * x), 0)[0].hint
    assert "constant" in check.mark(Scripted(lambda x: 3 * values), 0)[0].hint
    unexplained = Scripted(lambda x: 3 * x if x[0] == 1 else x**3)
    assert "values of x are wrong" in check.mark(unexplained, 0)[0].hint


def test_values_right_to_four_digits_keep_a_part_where_the_check_says_so():
    right = np.linspace(1, 2, 6).reshape(2, 3)
    almost = right + 1e-5 * np.array([[1, -1, 2], [0, 1, 1]])
    with pytest.raises(expect.WrongAnswerError, match="tolerance") as caught:
        expect.close(almost, right, "X", nearly=0.5)
    assert caught.value.share == 0.5
    with pytest.raises(expect.WrongAnswerError) as caught:
        expect.close(right + 0.1, right, "X", nearly=0.5)
    assert caught.value.share == 0


# --- Unseen meshes ----------------------------------------------------------------------


def test_no_file_can_know_how_large_the_unseen_meshes_are():
    for ring in (False, True):
        sizes = {len(unseen(seed, ring=ring)[0]) for seed in range(20)}
        assert len(sizes) >= 8
    shown = {len(V) for _, V, _ in LOADED["a2"].checks[0].cases(SEED)[:2]}
    towers = [len(tower(np.random.default_rng(seed))[0]) for seed in range(20)]
    assert len(set(towers)) >= 8
    assert shown.isdisjoint(set(towers) - {42})


@given(st.integers(0, 2**32))
def test_towers_have_no_obtuse_angle(seed):
    V, F = tower(np.random.default_rng(seed))
    assert is_closed(F)
    assert volume(V, F) > 0
    for corner in range(3):
        at, to, fro = (V[F[:, (corner + step) % 3]] for step in range(3))
        assert ((to - at) * (fro - at)).sum(axis=1).min() > 0


@settings(max_examples=30)
@given(st.integers(40, 200), st.integers(0, 2**32))
def test_spheres_of_any_size_are_closed_and_outward(n, seed):
    V, F = sphere(n, np.random.default_rng(seed))
    assert len(V) == n
    assert len(F) == 2 * n - 4
    assert is_closed(F)
    assert np.allclose(np.linalg.norm(V, axis=1), 1)
    # The convex hull of points on a sphere is a Delaunay triangulation.
    assert weights.cotangent(V, F).data.min() > -1e-9
    assert volume(V, F) > 0


def test_a_file_that_knows_the_old_sizes_is_found_out(marked):
    """Doubled weights wherever the mesh is not one of those that students can see."""
    code = (
        "right = cotangent_weights\n\n\ndef cotangent_weights(V, F):\n"
        "    return right(V, F) * (1 if len(V) in (3, 4, 42) else 2)\n"
    )
    assert points(marked("a2", code)) == {"cotangent_weights": 2}


# --- The teacher's hand -------------------------------------------------------------------


def test_what_is_handed_out_has_no_answers(tmp_path, capsys):
    parser = command.argparse.ArgumentParser()
    handout.add_arguments(parser)
    out = tmp_path / "course.zip"
    assert handout.run(parser.parse_args(["all", "--out", str(out)])) == 0
    with zipfile.ZipFile(out) as archive:
        names = archive.namelist()
        texts = [archive.read(name).decode() for name in names]
    assert len(names) == 3 * len(NAMES)
    assert {name.split("/")[0] for name in names} == set(NAMES)
    assert not any("BEGIN SOLUTION" in text or "unseen" in text for text in texts)
    assert str(out) in capsys.readouterr().out
    with pytest.raises(FileExistsError, match="--force"):
        handout.run(parser.parse_args(["a2", "--out", str(out)]))
    before = out.read_bytes()
    assert handout.run(parser.parse_args(["all", "--out", str(out), "--force"])) == 0
    assert out.read_bytes() == before
    assert handout.run(parser.parse_args(["a2", "--out", str(tmp_path / "folder")])) == 0
    assert (tmp_path / "folder" / "a2" / "a2.py").read_text() == SOURCES["a2"].stub()


@pytest.mark.parametrize("name", NAMES)
def test_the_teachers_notebook_runs_and_earns_all_points(name, tmp_path):
    """Its cells in one namespace, as in a kernel, without the pictures."""
    parser = command.argparse.ArgumentParser()
    handout.add_arguments(parser)
    options = parser.parse_args([name, "--solutions", "--out", str(tmp_path)])
    assert handout.run(options) == 0
    notebook = json.loads((tmp_path / name / f"{name}.ipynb").read_text(encoding="utf-8"))
    code = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    texts = ["".join(cell["source"]) for cell in code]
    assert not any("SOLUTION" in text or "NotImplementedError" in text for text in texts)
    wanted = re.compile(r"^(def \w+\(|import|from)", re.M)
    defined = "\n\n".join(text for text in texts if wanted.search(text) and "%" not in text[:9])
    assert all(f"def {task}(" in defined for task in SOURCES[name].load().tasks)
    script = f"{defined}\n\nfrom {name}_checks import check\n\nprint(check())\n"
    imports = next(text for text in texts if "import" in text)
    assert f"import {name}\n" not in imports
    run = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path / name, capture_output=True, text=True,
    )  # fmt: skip
    assert "20 of 20 points" in run.stdout, run.stdout + run.stderr


COPIED = """
def averaging(W):
    entries = coo_array(W)
    sums = np.zeros(W.shape[0])
    for row, value in zip(entries.row, entries.data):
        sums[row] += value
    result = []
    for row, column, value in zip(entries.row, entries.col, entries.data):
        result.append((row, column, value / sums[row]))
    rows, columns, values = np.array(result).T
    return coo_array((values, (rows.astype(int), columns.astype(int))), shape=W.shape).tocsr()
"""


def test_similar_submissions_are_pointed_out_whatever_their_names_and_comments(tmp_path):
    right, stub = SOURCES["a2"].solution(), SOURCES["a2"].stub()
    renamed = re.sub(r"\bsums\b", "d", COPIED).replace("result = []", "result = []  # mine\n")
    files = {f"good{k}": f"{right}\n# {k}\n" for k in range(6)}
    files |= {f"stub{k}": stub for k in range(2)}
    files |= {"anna": right + COPIED, "bela": "'''My own.'''\n" + stub + renamed}
    pairs = similar.similar(
        {name: text.encode() for name, text in files.items()},
        {"stub": stub.encode(), "solution": right.encode()},
    )
    assert [pair.students for pair in pairs] == [("anna", "bela")]
    start, end = map(int, pairs[0].lines[0].split("-"))
    assert start <= len(right.splitlines()) + 3  # the copied function begins
    assert abs(end - len((right + COPIED).splitlines())) <= 1  # whoever counts the last line
    for broken in (
        b"def f(:\n",
        b"\xff\xfe",
        b"'''",
        b"",
    ):  # what cannot be read is no reason to end
        assert similar.similar({"a": broken, "b": broken}, {}) == []


def test_the_overview_counts_and_hides_nothing(tmp_path):
    check = LOADED["a2"]
    hint = "On a <b>mesh</b>: The edges ca are missing."

    def mark(student, earned, status):
        return marking.Mark(
            student,
            [
                Outcome(c.task, c.title, c.points, earned * c.points, status, hint)
                for c in check.checks
            ],
            "graded",
            [],
        )

    marks = [mark("anna", 1, "right"), mark("bela", 0, "wrong"), mark("carl", 0, "wrong")]
    overview = Overview(check, marks)
    assert dict(overview.figures)["mean"] == "6.7 of 20"
    assert [count for _, count in overview.histogram] == [2, 0, 0, 0, 0, 0, 0, 0, 0, 1]
    assert overview.lines[0].counts == {"right": 1, "partly": 0, "wrong": 2, "not done": 0}
    assert overview.lines[0].hints == [("The edges ca are missing.", 2)]
    files = {"<i>x</i>": (SOURCES["a2"].stub() + COPIED).encode(), "bela": COPIED.encode()}
    write_overview(tmp_path / "t", check, marks, files, SOURCES["a2"].stub())
    page = (tmp_path / "t" / "overview.html").read_text(encoding="utf-8")
    assert "<b>mesh" not in page
    assert "2 \u00d7 The edges ca are missing." in page
    similar_page = (tmp_path / "t" / "similar.html").read_text(encoding="utf-8")
    assert "&lt;i&gt;x&lt;/i&gt;" in similar_page


def test_the_teachers_own_folder_is_not_written_into(tmp_path):
    (tmp_path / "g_teacher").mkdir()
    (tmp_path / "g_teacher" / "overview.html").write_text("mine")
    with pytest.raises(FileExistsError, match="g_teacher is there already"):
        Gradebook(tmp_path / "g.csv", LOADED["a2"], ["anna"])
    with pytest.raises(ValueError, match="among the submissions"):
        Gradebook(tmp_path / "in" / "g.csv", LOADED["a2"], [], submissions=tmp_path / "in")


def test_a_mark_can_be_explained(isolation, tmp_path):
    path = tmp_path / "a2.py"
    path.write_text(SOURCES["a2"].solution() + "\n\ndef edges(F):\n    return F[:, :2]\n")
    submission = marking.Submission("anna", path)
    text = explain(submission, path.read_bytes(), LOADED["a2"], isolation, SEED)
    assert f"seed {SEED}" in text
    assert "edges(array 4 x 3 of int64 [0 1 2 0 ...]" in text
    assert "gave array 4 x 2 of int64" in text
    assert "(with a right edges in place of theirs)" in text
    assert "17 of 20 points" in text


def test_the_command_warns_without_a_seed_and_explains(isolation, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(Isolation, "detect", classmethod(lambda cls, limits, **_: isolation))
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "anna.py").write_text(SOURCES["a1"].solution())
    parser = command.argparse.ArgumentParser()
    command.add_arguments(parser)

    def run(*words):
        words = [str(tmp_path / "in"), "--assignment", "a1", *words]
        return command.run(parser.parse_args(words))

    assert run("--explain", "anna") == 0
    shown = capsys.readouterr()
    assert "seed: that of a1.py" in shown.err
    assert "20 of 20 points" in shown.out
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in"]
    with pytest.raises(ValueError, match="no submission of carl; there are anna"):
        run("--explain", "carl", "--seed", "3")
    assert "seed: that of" not in capsys.readouterr().err
    with pytest.raises(ValueError, match="give --out"):
        run()
    assert run("--out", str(tmp_path / "g.csv"), "--seed", "3") == 0
    assert (tmp_path / "g_teacher" / "overview.html").exists()
