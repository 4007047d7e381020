"""Marking a class: hostile submissions, their isolation, going on, feedback."""

import csv
import dataclasses
import io
import json
import os
import socket
import struct
import subprocess
import sys
import threading
import time
import tomllib
from importlib.metadata import EntryPoint

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array, csr_array

from meshfair import cli
from meshfair.mesh import is_closed, volume
from meshfair_grading import command, expect, generate, gradebook, marking, protocol
from meshfair_grading.answers import Answer, Failure, Other, Seeded, ask, plain
from meshfair_grading.assignment import Assignment
from meshfair_grading.feedback import Report
from meshfair_grading.generate import ASSIGNMENTS
from meshfair_grading.isolation import Isolation, Limits
from meshfair_grading.marking import grade
from meshfair_grading.meshes import unseen
from meshfair_grading.outcomes import Graded, Outcome
from meshfair_grading.rules import Rules, violations
from meshfair_grading.students import IsolatedStudent
from submissions import HOSTILE, RIGHT, SOURCE, build

SEED = 99


@pytest.fixture(scope="module")
def isolation():
    """What holds on this system, with limits that do not let a test wait for long."""
    if os.name != "posix":
        pytest.skip("grading needs Linux or macOS")
    return Isolation.detect(Limits(call=2.0, total=20.0), without_walls=True)


def run(isolation, code, function="f", arguments=(), rules=None):
    """What one function of a submission answers."""
    with IsolatedStudent(code.encode(), "a9", rules or Rules(), isolation) as student:
        return student._ask(function, arguments)


# --- A class ---------------------------------------------------------------------------


@pytest.mark.slow
def test_a_class_with_hostile_students_gets_its_marks(isolation, tmp_path, monkeypatch):
    expected = build(tmp_path / "submissions", len(HOSTILE) + 1)
    out = tmp_path / "grades.csv"
    grade(tmp_path / "submissions", SOURCE, out, isolation, seed=SEED)

    table = out.read_text()
    rows = {row["student"]: row for row in csv.DictReader(io.StringIO(table))}
    points = {name: points for name, (points, _) in expected.items()}
    assert {name: float(row["points"]) for name, row in rows.items()} == points
    assert {row["of"] for row in rows.values()} == {"20"}
    assert rows["good_000"]["cotangent_weights"] == "7"
    assert rows["good_000"]["status"] == "graded"
    assert rows["syntax_error"]["status"] == "syntax error"

    feedback = tmp_path / "grades_feedback"
    for name, (_, phrase) in expected.items():
        assert phrase in (feedback / f"{name}.md").read_text(encoding="utf-8"), name
        assert "<!doctype html>" in (feedback / f"{name}.html").read_text(encoding="utf-8")

    # A second run marks nobody again, and the table stays as it is.
    monkeypatch.setattr(marking, "mark", lambda *_: pytest.fail("marked again"))
    grade(tmp_path / "submissions", SOURCE, out, isolation, seed=SEED)
    assert out.read_text() == table


def fake_mark(submission, assignment, isolation, seed):
    """A mark without running anything: the length of the file decides."""
    earned = float(len(submission.path.read_bytes()) % 7)
    return marking.Mark(
        submission.student, [Outcome("edges", "t", 7, earned, "partly")], "graded", []
    )


def test_an_interrupted_run_goes_on_where_it_stopped(tmp_path, isolation, monkeypatch):
    done = []

    def counted(submission, *rest):
        done.append(submission.student)
        return fake_mark(submission, *rest)

    monkeypatch.setattr(marking, "mark", counted)
    monkeypatch.setattr(marking, "dry_run", lambda *_: None)
    submissions = tmp_path / "in"
    for number in range(8):
        (submissions / f"s{number}").mkdir(parents=True)
        (submissions / f"s{number}" / "a2.py").write_text("#" * number)

    def interrupted(marks, total):
        for index, one in enumerate(marks):
            if index == 3:
                raise KeyboardInterrupt
            yield one

    with pytest.raises(KeyboardInterrupt):
        grade(submissions, SOURCE, tmp_path / "a.csv", isolation, progress=interrupted, jobs=1)
    first = len((tmp_path / "a.csv").read_text().splitlines()) - 1
    assert first == 3
    done.clear()
    (submissions / "s0" / "a2.py").write_text("changed")
    grade(submissions, SOURCE, tmp_path / "a.csv", isolation, jobs=1)
    assert "s0" in done
    assert len(done) == 8 - first + 1
    grade(submissions, SOURCE, tmp_path / "b.csv", isolation, jobs=2)
    assert (tmp_path / "a.csv").read_text() == (tmp_path / "b.csv").read_text()
    done.clear()
    grade(submissions, SOURCE, tmp_path / "b.csv", isolation, seed=5)
    assert len(done) == 8


def test_a_broken_record_is_marked_again(tmp_path):
    book = marking.Gradebook(tmp_path / "g.csv", SOURCE.load(), ["anna"])
    mark = marking.Mark("anna", [Outcome("edges", "t", 3, 1.5, "partly")], "graded", ["late"])
    book.add(mark, "key")
    assert book.known("anna", "key") == mark
    assert book.known("anna", "other") is None
    (tmp_path / "g_feedback" / gradebook.RECORDS / "anna.json").write_text('{"key": "key"')
    assert book.known("anna", "key") is None


@pytest.mark.slow
def test_nobody_is_marked_by_checks_that_the_solution_fails(isolation, tmp_path):
    text = SOURCE.path.read_text(encoding="utf-8").replace(
        "cotangent / 2, (i, j)", "cotangent, (i, j)"
    )
    (tmp_path / "a2.py").write_text(text, encoding="utf-8")
    (tmp_path / "in" / "anna").mkdir(parents=True)
    (tmp_path / "in" / "anna" / "a2.py").write_text(RIGHT)
    with pytest.raises(ValueError, match="the solution itself gets only 18 of 20"):
        grade(tmp_path / "in", type(SOURCE).read(tmp_path / "a2.py"), tmp_path / "g.csv", isolation)
    assert not (tmp_path / "g_feedback" / "anna.md").exists()


# --- The command -------------------------------------------------------------------------


@pytest.fixture
def meshfair(monkeypatch):
    """The command line with the entry points of pyproject.toml, installed or not."""
    text = (ASSIGNMENTS.parents[1] / "pyproject.toml").read_text(encoding="utf-8")
    declared = tomllib.loads(text)["project"]["entry-points"][cli.GROUP]
    points = [EntryPoint(name, module, cli.GROUP) for name, module in declared.items()]
    monkeypatch.setattr(cli, "entry_points", lambda group: points if group == cli.GROUP else [])
    return lambda *words: cli.main([str(word) for word in words])


@pytest.mark.parametrize(
    ("submissions", "assignment", "message"),
    [
        ("no", "a5", "no is no folder"),
        ("in", "a9", "there is no assignment a9; there are a1, a2, a3, a4, a5, a6"),
        ("in", "no.py", "there is no file no.py"),
        ("in", __file__, "no instructor's file"),
    ],
)
def test_what_the_command_cannot_do_it_says_in_a_line(
    submissions, assignment, message, meshfair, tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(Isolation, "detect", classmethod(lambda cls, limits, **_: cls(limits)))
    (tmp_path / "in").mkdir()
    words = tmp_path / submissions, "--assignment", assignment, "--out", tmp_path / "g.csv"
    assert meshfair("grade", *words) == 1
    shown = capsys.readouterr().err.splitlines()
    assert message in shown[-1]
    assert not (tmp_path / "g.csv").exists()


def test_the_command_names_what_is_not_installed(meshfair, tmp_path, monkeypatch, capsys):
    words = tmp_path, "--assignment", "a2", "--out", tmp_path / "g.csv"
    monkeypatch.setattr(generate, "ASSIGNMENTS", tmp_path / "site-packages")
    assert meshfair("grade", *words) == 1
    assert "notebooks/assignments/source/a2.py of the repository" in capsys.readouterr().err
    monkeypatch.setattr(command, "find_spec", lambda name: None if name == "jinja2" else name)
    assert meshfair("grade", *words) == 1
    assert 'grading needs jinja2; run: pip install "meshfair[grading]"' in capsys.readouterr().err


@pytest.mark.slow
def test_the_command_marks_the_open_assignment_and_ranks(meshfair, tmp_path, capsys):
    submissions = tmp_path / "in"
    submissions.mkdir()
    averaged = "from meshfair import operators, weights\n\n\ndef denoise(V, F):\n" + (
        "    return 0.8 * V + 0.2 * operators.averaging(weights.combinatorial(F, len(V))) @ V\n"
    )
    (submissions / "bela.py").write_text(averaged)
    (submissions / "carl.py").write_text("def denoise(V, F):\n    return -V\n")
    out = tmp_path / "grades.csv"
    assert meshfair("grade", submissions, "--assignment", "a5", "--out", out) == 0
    rows = {row["student"]: row for row in csv.DictReader(io.StringIO(out.read_text()))}
    assert 4 < float(rows["bela"]["denoise"]) < 10
    assert float(rows["carl"]["denoise"]) == 0
    assert float(rows["bela"]["leaderboard"]) > 0.2
    board = (tmp_path / "grades_feedback" / "leaderboard.md").read_text()
    assert board.index("bela") < board.index("carl")
    shown = capsys.readouterr()
    assert "2 submissions" in shown.out
    assert "walls: " in shown.err


# --- Isolation ---------------------------------------------------------------------------


PROBES = """
import numpy as np

def change(a, b):
    b += 1
    return a

def draw(rng):
    return rng.random(3)
"""


@pytest.fixture(scope="module")
def probe(isolation):
    """One process for all tests that leave it alive: ``probe(function, *arguments)``."""
    with IsolatedStudent(PROBES.encode(), "a9", Rules(), isolation) as student:
        yield lambda name, *arguments: student._ask(name, arguments)


@pytest.mark.slow
def test_changed_arguments_are_reported(probe):
    assert probe("change", np.ones(3), np.ones(3)).changed == (1,)


@pytest.mark.slow
def test_a_generator_arrives_as_a_generator(probe):
    value = probe("draw", Seeded(4)).value
    np.testing.assert_array_equal(value, np.random.default_rng(4).random(3))


@pytest.mark.slow
def test_a_dead_process_costs_only_the_function_that_killed_it(isolation):
    code = "def f():\n    __import__('os')._exit(3)\n\n\ndef g():\n    return 5\n"
    with IsolatedStudent(code.encode(), "a9", Rules(), isolation) as student:
        with pytest.raises(expect.WrongAnswerError, match="exit code 3"):
            student.f()
        assert student.g() == 5
        with pytest.raises(expect.WrongAnswerError, match="exit code 3"):
            student.f()


@pytest.mark.slow
def test_an_endless_loop_on_loading_is_named(isolation):
    slow = dataclasses.replace(isolation, limits=dataclasses.replace(isolation.limits, call=0.5))
    answer = run(slow, "while True:\n    pass\n")
    assert "longer than 0.5 s" in answer.failure.message


@pytest.mark.slow
def test_an_invalid_message_is_no_answer(isolation):
    code = """
os = __import__("os")

def f():
    for channel in range(3, 64):
        try:
            os.write(channel, b"20 of 20 points " * 10)
        except OSError:
            pass
    return 1
"""
    assert "disturbed its channel" in run(isolation, code).failure.message


# --- Plain data ------------------------------------------------------------------------


def exchanged(data):
    ours, theirs = socket.socketpair()
    with ours, theirs:
        sender = threading.Thread(target=protocol.send, args=(ours, data))
        sender.start()
        received = protocol.receive(theirs, time.monotonic() + 10)
        sender.join()
    return received


numbers = st.floats(allow_nan=False) | st.integers(-(2**53), 2**53) | st.booleans() | st.none()
arrays = st.lists(st.floats(allow_nan=False), max_size=9).map(np.array)
trees = st.recursive(
    numbers | st.text(max_size=9) | arrays | st.integers(0, 99).map(Seeded),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text("abc", max_size=4), inner, max_size=3)
    ),
    max_leaves=8,
)


@settings(max_examples=60, deadline=None)
@given(trees)
def test_plain_data_arrives_as_it_was_sent(data):
    def same(x, y):
        if isinstance(x, np.ndarray):
            return x.dtype == y.dtype and np.array_equal(x, y)
        if isinstance(x, list):
            return len(x) == len(y) and all(map(same, x, y))
        if isinstance(x, dict):
            return x.keys() == y.keys() and all(same(x[k], y[k]) for k in x)
        return type(x) is type(y) and x == y

    assert same(data, exchanged(data))


def test_matrices_and_answers_arrive_as_they_were_sent():
    W = csr_array(coo_array((np.array([1.5, -2.0]), ([0, 2], [1, 0])), shape=(3, 4)))
    answer = exchanged(Answer([W, None], (1,), Failure("raised", "x", 3, "y")))
    assert answer.failure == Failure("raised", "x", 3, "y")
    assert answer.changed == (1,)
    assert (answer.value[0] != W).nnz == 0
    assert answer.value[0].shape == W.shape


@pytest.mark.parametrize(
    "head",
    [
        b"not json",
        b'{"$": "array", "dtype": "|O8", "shape": [1], "start": 0}',
        b'{"$": "array", "dtype": "<f8", "shape": [4611686018427387904, 4], "start": 0}',
        b'{"$": "array", "dtype": "<f8", "shape": [-1], "start": 0}',
        b'{"$": "array", "dtype": "<f8", "shape": [1], "start": -8}',
        b'{"$": "sparse", "shape": [2, 2], "parts": [1, 2, 3]}',
        b'{"$": "Answer", "value": 1, "changed": [], "failure": 7}',
        b'{"$": "os.system"}',
        b"[" * 100_000,
    ],
)
def test_messages_that_make_no_sense_are_refused(head):
    ours, theirs = socket.socketpair()
    with ours, theirs:
        ours.sendall(protocol.LENGTHS.pack(len(head), 8) + head + bytes(8))
        with pytest.raises(protocol.ProtocolError):
            protocol.receive(theirs, time.monotonic() + 10)


def test_matrices_with_entries_outside_are_refused():
    row, data = np.array([5]), np.array([1.0])
    with pytest.raises(protocol.ProtocolError, match="larger"):
        protocol._sparse(10**12, 3, row, row, data)
    ours, theirs = socket.socketpair()
    with ours, theirs:
        parts = []
        sparse = {"$": "sparse", "shape": [2, 2]}
        sparse["parts"] = [protocol._pack(part, parts) for part in (row, row, data)]
        head, body = json.dumps(sparse).encode(), b"".join(parts)
        ours.sendall(protocol.LENGTHS.pack(len(head), len(body)) + head + body)
        with pytest.raises(protocol.ProtocolError, match="outside"):
            protocol.receive(theirs, time.monotonic() + 10)


def test_a_message_that_is_too_large_or_never_comes():
    ours, theirs = socket.socketpair()
    with ours, theirs:
        with pytest.raises(TimeoutError):
            protocol.receive(theirs, time.monotonic() + 0.05)
        ours.sendall(struct.pack("<QQ", 2**40, 0))
        with pytest.raises(protocol.ProtocolError, match="larger"):
            protocol.receive(theirs, time.monotonic() + 10)
        ours.close()
        with pytest.raises(EOFError):
            protocol.receive(theirs, time.monotonic() + 10)


class Equal:
    """Claims to be equal to everything, and to be everything."""

    def __eq__(self, other):
        return True

    def __repr__(self):
        raise RuntimeError

    __hash__ = None


def test_what_is_no_number_becomes_a_name():
    assert plain(Equal()).type == "Equal"
    assert plain("20 of 20 points").type == "str"
    assert plain(np.array([Equal()], dtype=object)).type == "ndarray"
    assert plain((np.ones(2), np.ones(3)))[1].shape == (3,)
    assert plain((1.0, 2)).tolist() == [1.0, 2.0]
    assert plain(None) is None
    assert plain(np.float32(2)).dtype == np.float64
    for huge in (np.broadcast_to(1.0, 10**8), coo_array((1, 10**9))):
        with pytest.raises(ValueError, match="far larger"):
            plain(huge)


def test_failures_name_the_line_of_the_student(tmp_path):
    path = tmp_path / "a9.py"
    path.write_text("def f(x):\n    y = 1 / x\n    return y\n")
    namespace = {}
    exec(compile(path.read_text(), str(path), "exec"), namespace)
    failure = ask(namespace["f"], [0], str(path)).failure
    assert failure == Failure("raised", "ZeroDivisionError: division by zero", 2, "y = 1 / x")


# --- Comparisons -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("got", "hint"),
    [
        (Other("Equal", "<Equal>"), "no array of numbers"),
        ([np.ones(2), np.ones(2)], "2 objects came back"),
        (np.ones((3, 2)), "that of the transpose"),
        (np.full((2, 3), np.nan), "0 / 0"),
        (np.full((2, 3), 1j), "complex"),
        (-np.arange(6.0).reshape(2, 3), "The sign of X is wrong"),
        (2 * np.arange(6.0).reshape(2, 3), "2 times the right one"),
        (np.arange(6.0).reshape(2, 3) + 1, "plus one"),
        (np.arange(6.0).reshape(2, 3) ** 2, "squares of the right numbers"),
        (np.arange(6.0).reshape(2, 3) ** 3, "The values of X are wrong"),
        (csr_array((60_000, 60_000)), "The shape of X is wrong"),
    ],
)
def test_a_wrong_array_is_explained(got, hint):
    right = np.arange(6.0).reshape(2, 3)
    with pytest.raises(expect.WrongAnswerError, match=hint):
        expect.close(got, right, "X", mistakes=[("plus one", lambda: right + 1)])


def test_right_values_pass_in_every_form():
    right = np.array([[0.0, 2.0], [1.0, 0.0]])
    for got in (right, csr_array(right), right.astype(complex), right * (1 + 1e-9)):
        expect.close(got, right, "X")
    expect.close(np.array([2.0]), 2.0, "x")
    expect.proportional(csr_array(right) * 7, csr_array(right), "X")
    with pytest.raises(expect.WrongAnswerError):
        expect.proportional(csr_array(-right), csr_array(right), "X")


def test_only_right_values_keep_their_points_when_an_argument_was_changed():
    check = Assignment("a9", "Test")
    student = ScriptedStudent(Answer(np.ones(2), changed=(0,)), Answer(np.zeros(2), changed=(0,)))

    @check.part("f", 3, lambda seed: [("one", np.ones(2))])
    def is_one(student, x):
        """All ones."""
        expect.close(student.f(x), np.ones(2), "x")

    right, wrong = check.mark(student, 0)[0], check.mark(student, 0)[0]
    assert (right.earned, right.status) == (1.5, "partly")
    assert "in place" in right.hint
    assert (wrong.earned, wrong.status) == (0, "wrong")


def test_a_check_that_trips_costs_only_its_points():
    check = Assignment("a9", "Test")
    check.part("f", 1, lambda seed: [("one",)])(tripping)
    check.part("f", 2, lambda seed: [("two",)])(half)
    outcomes = check.mark(ScriptedStudent(), 0)
    assert [outcome.earned for outcome in outcomes] == [0, 1]
    assert "ZeroDivisionError" in outcomes[0].hint
    with pytest.raises(ValueError, match="no task 'g'"):
        check("g")


def tripping(student):
    """Trips."""
    return 1 / 0


def half(student):
    """Half of it."""
    return Graded(0.5, metric=3.0)


class ScriptedStudent(IsolatedStudent):
    """Gives answers from a list."""

    def __init__(self, *answers):
        self.changed, self.calls, self._answers, self._script = [], {}, {}, list(answers)

    def _ask(self, name, arguments):
        return self._script.pop(0)


# --- Rules, meshes, feedback -------------------------------------------------------------


@pytest.mark.parametrize(
    ("source", "what"),
    [
        ("import igl\n", "igl"),
        ("def f():\n    from meshfair.weights import cotangent\n", "meshfair.weights.cotangent"),
        ("from numpy.linalg import inv\n", "numpy.linalg.inv"),
        ("import numpy as np\nx = np.linalg.inv(np.eye(2))\n", "inv"),
        ("from . import helper\n", ".helper"),
    ],
)
def test_what_the_rules_forbid_is_found(source, what):
    found = violations(source, Rules(forbidden=("inv",)))
    assert what in found[0].what
    assert source.splitlines()[found[0].line - 1]


def test_ordinary_code_breaks_no_rule():
    source = "import numpy as np\nfrom scipy.sparse.linalg import splu\nimport math\n"
    assert violations(source, Rules(forbidden=("inv",))) == []
    assert violations("from meshfair import mesh\n", Rules(allowed=("meshfair.mesh",))) == []


@pytest.mark.parametrize("ring", [False, True])
def test_unseen_meshes_are_meshes_and_repeatable(ring):
    V, F = unseen(3, ring=ring)
    again, _ = unseen(3, ring=ring)
    other, _ = unseen(4, ring=ring)
    assert np.array_equal(V, again)
    assert not np.array_equal(V, other)
    assert is_closed(F)
    assert volume(V, F) > 0
    V_open, F_open = unseen(3, ring=ring, opened=True)
    assert not is_closed(F_open)
    assert np.array_equal(np.unique(F_open), np.arange(len(V_open)))


def test_feedback_cannot_be_markup():
    evil = "<script>alert(1)</script> [x](javascript:1) \x1b[31m"
    report = Report("r", [Outcome("f", "t", 1, 0, "wrong", hint=evil, got=evil)], [evil], evil)
    assert "<script>" not in report.page()
    assert "\x1b" not in report.page()
    text, printed = report.markdown().split("## What the code printed\n")
    assert text.count("alert(1)") == 3  # remark, answer and hint are there
    for markup in ("<script>", "[x](", "\x1b"):
        assert markup not in text
    # What was printed stands indented: as code, in which nothing is markup.
    assert all(line.startswith("    ") for line in printed.splitlines() if line)
    assert "0 of 1 points" in repr(report)


def test_importing_the_command_is_quick():
    """The teacher's ``--help`` must not wait for any of this."""
    code = "import sys, meshfair_grading.command; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert "meshfair_grading" in loaded
    assert loaded.isdisjoint({"numpy", "scipy", "jupytext", "jinja2", "tqdm"})
