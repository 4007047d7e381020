"""What a class hands in, whatever it is called; and results that destroy nothing."""

import csv
import io
import json
import os
import socket

import pytest
from hypothesis import given
from hypothesis import strategies as st

from meshfair_grading import marking
from meshfair_grading.gradebook import ABOUT, RECORDS, Gradebook, Mark
from meshfair_grading.isolation import Limits
from meshfair_grading.outcomes import Outcome
from meshfair_grading.printable import cell, file_names, printable
from meshfair_grading.submissions import Submission, find, read
from submissions import SOURCE

A2 = SOURCE.load()


def put(folder, *names, text="x = 1\n"):
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def one(folder):
    (found,) = find(folder, "a2")
    return found


def test_submissions_are_found_in_every_layout(tmp_path):
    put(tmp_path, "anna/a2.py", "bela/a2/a2.py", "carl.py", ".DS_Store", "__MACOSX/x.py")
    (tmp_path / "emil").mkdir()
    found = {submission.student: submission for submission in find(tmp_path, "a2")}
    assert list(found) == ["anna", "bela", "carl", "emil"]
    assert found["bela"].path.parent.name == "a2"
    assert found["emil"].path is None
    assert found["emil"].remark == "The folder is empty."
    assert [read(found[name]) for name in ("anna", "bela", "carl")] == 3 * [b"x = 1\n"]


@pytest.mark.parametrize(
    ("names", "taken"),
    [
        (["a2 (1).py"], "a2 (1).py"),
        (["A2.PY", "notes.txt"], "A2.PY"),
        (["a2-main/a2.py", "a2-main/README.md"], "a2-main/a2.py"),
        (["my solution.py"], "my solution.py"),
        (["a2.ipynb", "a2_final.py", "a2.py/x"], None),
        (["hand in/my a2/a2.py", "a2_checks_old.txt"], "hand in/my a2/a2.py"),
    ],
)
def test_the_likeliest_misplacement_is_taken_with_a_remark(names, taken, tmp_path):
    put(tmp_path / "dora", *names)
    found = one(tmp_path)
    if taken is None:
        assert found.path is None or found.path.name == "a2_final.py"
        return
    assert found.path == tmp_path / "dora" / taken
    assert found.remark == f"The file is {taken}; hand it in as a2.py, without a folder."


@pytest.mark.parametrize(
    ("names", "remark"),
    [
        (["a2 (1).py", "a2 (2).py"], "There is no a2.py, but a2 (1).py, a2 (2).py."),
        (["a1.py"], "There is no a2.py, but a1.py."),
        (["a20.py"], "There is no a2.py, but a20.py."),
        (["a2.ipynb"], "There is no a2.py, but a2.ipynb. A notebook holds none of your functions"),
        (["b.py", "c.py"], "There is no a2.py, but b.py, c.py."),
        ([f"{k}.txt" for k in range(9)], "but 0.txt, 1.txt, 2.txt, 3.txt, 4.txt, ..."),
    ],
)
def test_what_is_there_instead_is_told(names, remark, tmp_path):
    put(tmp_path / "dora", *names)
    found = one(tmp_path)
    assert found.path is None
    assert remark in found.remark
    with pytest.raises(ValueError, match="nothing handed in"):
        read(found)


@pytest.mark.skipif(os.name != "posix", reason="names of bytes are POSIX's")
@pytest.mark.parametrize(
    "name",
    [b"Andr\xe9", b"two\nlines", b"-x", b"=cmd|'C calc'!A0", b"CON", b"leaderboard", b"x" * 250,
     b"tab\there", "\u202egnp.exe".encode(), b"a|b <i>[x](y)", "名前".encode(), b"..hidden"],
)  # fmt: skip
def test_no_name_stops_the_class(name, tmp_path):
    submissions = tmp_path / "in"
    put(submissions, "anna/a2.py")
    folder = os.path.join(os.fsencode(submissions), name)
    os.mkdir(folder)
    with open(os.path.join(folder, b"a2.py"), "w") as file:
        file.write("y = 2\n")
    found = find(submissions, "a2")
    if name.startswith(b".."):
        assert [submission.student for submission in found] == ["anna"]
        return
    assert len(found) == 2
    (odd,) = (submission for submission in found if submission.student != "anna")
    assert odd.student.isprintable()
    assert read(odd) == b"y = 2\n"
    book = Gradebook(tmp_path / "g.csv", A2, [submission.student for submission in found])
    marks = [
        Mark(submission.student, [Outcome("edges", "t", 3, 3, "right", metric=1.0)], "graded", [])
        for submission in found
    ]
    for mark in marks:
        book.add(mark, "key")
        assert book.known(mark.student, "key") == mark
    book.write_tables(marks)
    files = [path.name for path in (tmp_path / "g_feedback").iterdir()]
    assert len(files) == 2 * 2 + 2  # two kinds of feedback each, the leaderboard, the records
    assert all(file.isprintable() and len(os.fsencode(file)) < 120 for file in files)
    rows = list(csv.reader(io.StringIO((tmp_path / "g.csv").read_text(encoding="utf-8"))))
    assert len(rows) == 3
    assert not any(cell.startswith(("=", "+", "-", "@")) for row in rows[1:] for cell in row)
    board = (tmp_path / "g_feedback" / "leaderboard.md").read_text(encoding="utf-8")
    assert len(board.splitlines()) == 6
    assert "<i>" not in board
    assert all(line.count("|") == 4 for line in board.splitlines()[2:])


@pytest.mark.skipif(os.name != "posix", reason="links and pipes are POSIX's")
@pytest.mark.parametrize(
    "kind", ["folder", "file", "flat", "loop", "dangling", "pipe", "socket", "device", "directory",
             "large", "closed folder"]
)  # fmt: skip
def test_what_is_no_file_of_ones_own_costs_that_student_alone(kind, tmp_path):
    put(tmp_path, "alice/a2.py", text="right = 20\n")
    bob = tmp_path / "bob"
    if kind not in ("folder", "flat"):
        bob.mkdir()
    path = bob / "a2.py"
    match kind:
        case "folder":
            bob.symlink_to(tmp_path / "alice")
        case "file":
            path.symlink_to(tmp_path / "alice" / "a2.py")
        case "flat":
            (tmp_path / "bob.py").symlink_to(tmp_path / "alice" / "a2.py")
        case "loop":
            path.symlink_to(path)
        case "dangling":
            path.symlink_to("nowhere")
        case "pipe":
            os.mkfifo(path)
        case "socket":
            here = os.getcwd()
            os.chdir(bob)  # (a socket's path has to be short)
            with socket.socket(socket.AF_UNIX) as listening:
                listening.bind("a2.py")
            os.chdir(here)
        case "device":
            path.symlink_to("/dev/zero")
        case "directory":
            path.mkdir()
        case "large":
            path.write_bytes(b"#" * 1_000_001)
        case "closed folder":
            bob.chmod(0)
    alice, him = find(tmp_path, "a2")
    assert read(alice) == b"right = 20\n"
    if kind == "closed folder" and os.geteuid() == 0:
        bob.chmod(0o755)
        return  # nothing is closed to root
    with pytest.raises(ValueError, match=r"link|regular|read|handed in|more than 1 MB"):
        read(him)
    mark = marking.mark(him, A2, None, 1)
    assert sum(outcome.earned for outcome in mark.outcomes) == 0
    assert mark.status
    bob.exists() and not bob.is_symlink() and bob.chmod(0o755)


def test_a_link_within_ones_own_folder_is_taken(tmp_path):
    put(tmp_path, "anna/final version.py")
    (tmp_path / "anna" / "a2.py").symlink_to("final version.py")
    assert read(one(tmp_path)) == b"x = 1\n"


def test_a_file_that_vanishes_costs_that_student_alone(tmp_path):
    put(tmp_path, "anna/a2.py")
    found = one(tmp_path)
    found.path.unlink()
    with pytest.raises(ValueError, match="cannot be read"):
        read(found)


def test_a_folder_and_a_file_of_one_student_are_told(tmp_path):
    put(tmp_path, "anna/a2.py", "anna.py", "bela.py")
    anna, bela = find(tmp_path, "a2")
    assert anna.path is None
    assert "a folder and a file" in anna.remark
    assert bela.path is not None


def test_no_submissions_at_all(tmp_path):
    with pytest.raises(ValueError, match="is no folder"):
        find(tmp_path / "none", "a2")
    with pytest.raises(ValueError, match="neither folders of students nor"):
        find(tmp_path, "a2")


# --- Results -------------------------------------------------------------------------------


@pytest.mark.parametrize("out", ["in/anna/a2.py", "in/grades.csv", "in/deep/../grades.csv", "in"])
def test_results_never_lie_among_the_submissions(out, tmp_path):
    put(tmp_path / "in", "anna/a2.py")
    (tmp_path / "in" / "deep").mkdir()
    with pytest.raises(ValueError, match="lies among the submissions"):
        Gradebook(tmp_path / out, A2, ["anna"], submissions=tmp_path / "in", force=True)
    assert (tmp_path / "in" / "anna" / "a2.py").read_text() == "x = 1\n"


def test_nothing_is_written_over_but_its_own(tmp_path):
    out = tmp_path / "grades.csv"
    out.write_text("the teacher's own\n")
    with pytest.raises(FileExistsError, match="was not written by this command"):
        Gradebook(out, A2, ["anna"])
    assert out.read_text() == "the teacher's own\n"
    Gradebook(out, A2, ["anna"], force=True).write_tables([])
    Gradebook(out, A2, ["anna"]).write_tables([])  # its own
    out.write_text(out.read_text() + "anna,20\n")
    with pytest.raises(FileExistsError, match="has been changed since"):
        Gradebook(out, A2, ["anna"])
    put(tmp_path / "other_feedback", "letter.txt")
    with pytest.raises(FileExistsError, match="is not from this command"):
        Gradebook(tmp_path / "other.csv", A2, ["anna"])


def test_results_of_another_assignment_stay(tmp_path):
    Gradebook(tmp_path / "g.csv", A2, ["anna"]).write_tables([])
    about = tmp_path / "g_feedback" / RECORDS / ABOUT
    about.write_text(json.dumps({**json.loads(about.read_text()), "assignment": "a1"}))
    with pytest.raises(ValueError, match="holds the results of a1"):
        Gradebook(tmp_path / "g.csv", A2, ["anna"])


def test_what_this_machine_could_not_mark_is_tried_again(tmp_path):
    class Broken:
        def start(self, *_):
            raise OSError("no memory")

        limits = Limits()

    put(tmp_path, "anna/a2.py")
    mark = marking.mark(one(tmp_path), A2, Broken(), 1)
    assert (mark.status, mark.final) == ("not marked", False)
    assert "start the command again" in mark.remarks[-1]
    book = Gradebook(tmp_path / "g.csv", A2, ["anna"])
    book.add(mark, "key")
    assert book.known("anna", "key") is None


# --- Texts ---------------------------------------------------------------------------------


@given(st.text(st.characters(), max_size=40))
def test_what_is_printable_changes_nothing_around_it(text):
    shown = printable(text)
    assert shown.isprintable()
    assert printable(shown) == shown
    assert shown.isascii() or any(not c.isascii() and c.isprintable() for c in text)
    assert not cell(shown).startswith(("=", "+", "-", "@"))


@given(st.lists(st.text(max_size=130), unique=True, max_size=6))
def test_every_student_has_a_file_of_their_own(students):
    names = file_names(map(printable, students))
    lowered = [name.lower() for name in names.values()]
    assert len(set(lowered)) == len(lowered)
    for name in lowered:
        assert name not in ("leaderboard", "records", "summary", "con", "nul", "")
        assert not set(name) & set('/\\:*?"<>|\0\n')


def test_plain_names_stay_as_they_are():
    assert file_names(["anna", "m.muster@uni", "B 12"]) == {
        "anna": "anna", "m.muster@uni": "m.muster@uni", "B 12": "B 12",
    }  # fmt: skip
    assert Submission("anna", None).status == "nothing handed in"
