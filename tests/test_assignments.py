"""The six assignments: what students get, and what right and wrong answers earn."""

import importlib.util
import json
import os
import re
import shutil
import sys
import types
import warnings
from functools import cache
from pathlib import Path

import pytest

from meshfair_grading import source as source_module
from meshfair_grading.feedback import Report
from meshfair_grading.generate import ASSIGNMENTS, drifted, main
from meshfair_grading.source import HIDDEN, MARKER, SOLUTION, Source
from meshfair_grading.students import NotebookStudent

NAMES = ("a1", "a2", "a3", "a4", "a5", "a6")
SOURCES = {name: Source.read(ASSIGNMENTS / "source" / f"{name}.py") for name in NAMES}
LOADED = {name: source.load() for name, source in SOURCES.items()}
WRONG = sorted((Path(__file__).parent / "wrong_solutions").glob("*.py"))
SEED = 1234


@pytest.fixture
def mark(tmp_path, monkeypatch):
    """Mark a source text in this process, as the notebook does, on the unseen meshes."""

    def marked(name, text, task=None):
        path = tmp_path / f"{name}.py"
        path.write_text(text, encoding="utf-8")
        spec = importlib.util.spec_from_file_location(name, path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        monkeypatch.setitem(sys.modules, name, module)
        student = NotebookStudent(name, LOADED[name].rules)
        return Report(name, LOADED[name].mark(student, SEED, task))

    return marked


@pytest.mark.parametrize("name", NAMES)
def test_the_stub_scores_nothing_and_says_what_to_do(name, mark):
    report = mark(name, SOURCES[name].stub())
    assert report.earned == 0
    assert {outcome.status for outcome in report.outcomes} == {"not done"}
    assert "is not done yet" in report.text()


@pytest.mark.parametrize("name", NAMES)
def test_the_solution_scores_everything(name, mark):
    report = mark(name, SOURCES[name].solution())
    assert report.earned == report.points == 20, report.text()


@pytest.mark.parametrize("name", NAMES)
def test_the_checks_that_students_get_need_nothing_that_is_hidden(name, mark):
    checks = types.ModuleType(f"{name}_checks")
    exec(SOURCES[name].student_files()[f"{name}_checks.py"], checks.__dict__)
    mark(name, SOURCES[name].solution())  # the module is there now
    report = checks.check()
    assert report.earned == report.points == 20, report.text()


@cache
def header(path):
    """What the first lines of a wrong solution say: task, points, hint, and other hints."""
    text = path.read_text(encoding="utf-8")
    return {"also": ""} | dict(re.findall(r"^# (task|points|hint|also): (.*)$", text, re.M))


@pytest.fixture(scope="session")
def wrong_report(tmp_path_factory):
    """The report of a wrong solution, made once."""

    @cache
    def report(path):
        name, expected = path.stem[:2], header(path)
        file = tmp_path_factory.mktemp("wrong") / f"{name}.py"
        # The last definition of a function counts, so that the rest of the file is right.
        text = SOURCES[name].solution() + path.read_text(encoding="utf-8")
        file.write_text(text, encoding="utf-8")
        with pytest.MonkeyPatch.context() as patch, warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # they divide by zero
            spec = importlib.util.spec_from_file_location(name, file)
            module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
            patch.setitem(sys.modules, name, module)
            student = NotebookStudent(name, LOADED[name].rules)
            return Report(name, LOADED[name].mark(student, SEED, expected["task"]))

    return report


@pytest.mark.parametrize("path", WRONG, ids=lambda path: path.stem)
def test_a_typical_mistake_gets_its_points_and_its_hint(path, wrong_report):
    report, expected = wrong_report(path), header(path)
    assert report.earned == float(expected["points"]), report.text()
    assert report.earned < report.points
    assert any(expected["hint"] in outcome.hint for outcome in report.outcomes), report.text()


@pytest.mark.parametrize("path", WRONG, ids=lambda path: path.stem)
def test_no_mistake_gets_the_hint_of_another(path, wrong_report):
    report, own = wrong_report(path), header(path)
    others = {header(other)["hint"] for other in WRONG if other.stem[:2] == path.stem[:2]}
    others = {one for one in others if one not in own["hint"] and own["hint"] not in one}
    hints = [outcome.hint for outcome in report.outcomes]
    got = {one for one in others if any(one in hint for hint in hints)}
    assert got == set(filter(None, own["also"].split("; "))), report.text()


@pytest.mark.parametrize("path", WRONG, ids=lambda path: path.stem)
def test_feedback_never_shows_two_equal_numbers(path, wrong_report):
    for outcome in wrong_report(path).outcomes:
        expected, got = (
            re.findall(r"-?\d+\.\d+(?:e[+-]\d+)?", text) for text in (outcome.expected, outcome.got)
        )
        if outcome.status != "right":
            assert not (expected and expected[-1:] == got[:1]), outcome
            assert outcome.expected != outcome.got, outcome


# So many of the checks that a wrong solution fails say what the mistake is, and not only that
# there is one. What is left needs a look at the code, not at the values.
LEAST_RATE = 0.95
GENERIC = re.compile(r"The values of .* are wrong|entries that are not finite|cannot make sense")


def test_most_failed_checks_name_the_mistake(wrong_report):
    failed = [
        outcome.hint
        for path in WRONG
        for outcome in wrong_report(path).outcomes
        if outcome.status in ("wrong", "partly")
    ]
    named = [hint for hint in failed if not GENERIC.search(hint)]
    print(
        f"{len(WRONG)} wrong solutions: {len(named)} of {len(failed)} failed checks are explained"
    )
    assert len(named) >= LEAST_RATE * len(failed)


def test_there_are_wrong_solutions_of_every_assignment():
    assert len(WRONG) >= 100
    tasks = {(path.stem[:2], header(path)["task"]) for path in WRONG}
    assert tasks == {(name, task) for name in NAMES for task in LOADED[name].tasks}


@pytest.mark.parametrize("name", NAMES)
def test_headings_name_the_points_that_the_checks_give(name):
    text = SOURCES[name].path.read_text(encoding="utf-8")
    headings = re.findall(r"^# ## Task \d: `(\w+)` \((\d+) points\)$", text, re.M)
    assert [(task, float(points)) for task, points in headings] == list(LOADED[name].tasks.items())


@pytest.mark.parametrize("name", NAMES)
def test_the_committed_student_version_is_what_the_source_makes(name):
    assert drifted(SOURCES[name], ASSIGNMENTS / "student") == [], "run make assignments"


LONG = 25  # characters: a shorter line may stand anywhere


def secrets(source):
    """Lines of an instructor's file that no student may see, and that stand nowhere else in it."""
    text = source.path.read_text(encoding="utf-8")
    blocks = [*SOLUTION.finditer(text), *HIDDEN.finditer(text)]
    lines = {line.strip() for block in blocks for line in block[0].splitlines()}
    for block in blocks:
        text = text.replace(block[0], "")
    public = {line.strip() for line in text.splitlines()}
    return {x for x in lines - public if len(x) >= LONG and not MARKER.search(x)}


def leaks(source):
    """What a student's files give away: secret lines, markers, the makers of unseen meshes."""
    files = source.student_files()
    text = "\n".join([files[f"{source.name}.py"], files[f"{source.name}_checks.py"]])
    cells = json.loads(files[f"{source.name}.ipynb"])["cells"]
    text += "\n" + "\n".join("".join(cell["source"]) for cell in cells)
    shown = {line.strip() for line in text.splitlines()}
    return sorted(secrets(source) & shown) + re.findall(r"### (?:BEGIN|END)|\bunseen\b", text)


@pytest.mark.parametrize("name", NAMES)
def test_students_get_neither_solutions_nor_hidden_tests(name):
    assert len(secrets(SOURCES[name])) >= 10  # there is something to find
    assert leaks(SOURCES[name]) == []
    assert "raise NotImplementedError" in SOURCES[name].stub()


@pytest.mark.parametrize("name", NAMES)
def test_a_leak_would_be_found(name, monkeypatch):
    """Were hidden tests or solutions handed out, the test above would fail."""
    without_markers = source_module._without_markers
    monkeypatch.setattr(source_module, "_released", without_markers)
    assert len(leaks(SOURCES[name])) >= 10
    monkeypatch.undo()
    monkeypatch.setattr(Source, "stub", Source.solution)
    assert len(leaks(SOURCES[name])) >= 3
    monkeypatch.undo()
    with_hidden_tests = Source._text(SOURCES[name], "checks", without_markers)
    files = {**SOURCES[name].student_files(), f"{name}_checks.py": with_hidden_tests}
    monkeypatch.setattr(Source, "student_files", lambda self: files)
    assert len(leaks(SOURCES[name])) >= 2


def test_drift_is_found_and_repaired(tmp_path, capsys):
    shutil.copytree(ASSIGNMENTS / "source", tmp_path / "source")
    assert main(["--assignments", str(tmp_path)]) == 0
    assert main(["--assignments", str(tmp_path), "--check"]) == 0
    stub = tmp_path / "student" / "a2" / "a2.py"
    stub.write_text(stub.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    (tmp_path / "student" / "a3" / "a3.ipynb").unlink()
    assert main(["--assignments", str(tmp_path), "--check"]) == 1
    shown = capsys.readouterr().err
    assert "a2/a2.py" in shown
    assert "a3/a3.ipynb" in shown


@pytest.mark.parametrize(
    ("text", "message"),
    [("# %% markdwon\n", "no cell kind"), ("# %% module\n### BEGIN SOLUTION\n", "partner")],
)
def test_a_faulty_source_is_refused(text, message, tmp_path):
    path = tmp_path / "a9.py"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=message):
        Source.read(path)


@pytest.fixture(scope="module")
def in_kernel(tmp_path_factory):
    """All that students get in one folder, and a client whose kernel runs there."""
    nbclient = pytest.importorskip("nbclient", reason="needs the notebooks extra")
    nbformat = pytest.importorskip("nbformat", reason="needs the notebooks extra")
    pytest.importorskip("ipykernel", reason="needs the notebooks extra")
    folder = tmp_path_factory.mktemp("students")
    for source in SOURCES.values():
        for file, text in source.student_files().items():
            (folder / file).write_text(text, encoding="utf-8")
    client = nbclient.NotebookClient(
        nbformat.v4.new_notebook(), timeout=120, resources={"metadata": {"path": str(folder)}}
    )
    with client.setup_kernel():
        yield client, folder


@pytest.mark.slow
@pytest.mark.xdist_group("kernel")  # to start it once
@pytest.mark.parametrize("name", NAMES)
def test_the_students_notebook_runs(name, in_kernel):
    """With the stub, and after the solution was saved."""
    import nbformat

    client, folder = in_kernel
    client.nb = nbformat.read(folder / f"{name}.ipynb", 4)
    # What another notebook has defined must not help this one.
    client.nb.cells.insert(0, nbformat.v4.new_code_cell("%reset -f"))
    errors, text, _ = run_all(client)
    assert errors == set()
    assert "0 of 20 points" in text
    assert "is not done yet" in text
    # The notebook loads it anew by itself, as it does for students.
    (folder / f"{name}.py").write_text(SOURCES[name].solution(), encoding="utf-8")
    errors, text, pictures = run_all(client)
    assert errors == set()
    assert "20 of 20 points" in text
    assert pictures >= 1


def run_all(client):
    """Run all cells: errors shown (not those that are said in a line), texts, pictures."""
    for index, cell in enumerate(client.nb.cells):
        client.execute_cell(cell, index)
    outputs = [output for cell in client.nb.cells for output in cell.get("outputs", [])]
    shown = [output["data"] for output in outputs if "data" in output]
    errors = {output["ename"] for output in outputs if output["output_type"] == "error"}
    text = "\n".join(data.get("text/plain", "") for data in shown)
    return errors, text, sum("image/png" in data for data in shown)


@pytest.fixture
def nbgrader_course(tmp_path, monkeypatch):
    """A course of nbgrader with all six sources, and its interface."""
    # It calls a program of its environment, which need not be the active one.
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}:{os.environ['PATH']}")
    pytest.importorskip("nbgrader", reason="nbgrader is not installed")
    from nbgrader.apps import NbGraderAPI
    from traitlets.config import Config

    main(["--nbgrader", str(tmp_path)])
    return NbGraderAPI(config=Config({"CourseDirectory": {"root": str(tmp_path)}})), tmp_path


@pytest.mark.filterwarnings("ignore")  # nbgrader's own, about its database
def test_nbgrader_accepts_the_sources(nbgrader_course):
    interface, course = nbgrader_course
    for name in NAMES:
        done = interface.generate_assignment(name)
        assert done["success"], done["log"]
        released = json.loads((course / "release" / name / f"{name}.ipynb").read_text("utf-8"))
        code = "".join("".join(cell["source"]) for cell in released["cells"])
        assert "BEGIN SOLUTION" not in code
        assert "BEGIN HIDDEN" not in code
        assert "raise NotImplementedError" in code
        cells = [cell["metadata"].get("nbgrader", {}) for cell in released["cells"]]
        assert sum(cell.get("points", 0) for cell in cells) == 20
    assert nbgrader_points(interface, course, "cotangent / 2", "cotangent") == 18


def nbgrader_points(interface, course, right, wrong):
    """What nbgrader gives for a2's solution with one text replaced by another."""
    source, release = (
        json.loads((course / folder / "a2" / "a2.ipynb").read_text("utf-8"))
        for folder in ("source", "release")
    )
    for mine, theirs in zip(source["cells"], release["cells"], strict=True):
        if mine["metadata"].get("nbgrader", {}).get("solution"):
            theirs["source"] = "".join(mine["source"]).replace(right, wrong)
    submission = course / "submitted" / "bela" / "a2" / "a2.ipynb"
    submission.parent.mkdir(parents=True)
    submission.write_text(json.dumps(release), "utf-8")
    done = interface.autograde("a2", "bela")
    assert done["success"], done["log"]
    with interface.gradebook as gradebook:
        return gradebook.find_submission("a2", "bela").score
