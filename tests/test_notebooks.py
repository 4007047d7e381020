"""The notebooks: committed clean, executed whole, their results and explorers checked."""

import json
import os
import re
import runpy
from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat", reason="needs the notebooks extra")
nbclient = pytest.importorskip("nbclient", reason="needs the notebooks extra")

TESTS = Path(__file__).parent
FOLDER = TESTS.parent / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("0*.ipynb"))

# For each notebook: small parameters, and what must hold when all of its cells have run.
CHECKS = {
    "00": (
        "SECTIONS, SIDES = 60, 8",
        """
        assert (n, k, m) == (480, 1440, 960) and euler == 0
        assert same
        assert abs(mesh.volume(corners, sides) - 1 / 6) < 1e-12
        assert view.panels[0].edges and coloured.scale.high == areas.max()
        """,
    ),
    "01": (
        "SECTIONS, SIDES = 60, 8",
        """
        assert abs(by_hand - snr_noisy) < 1e-10
        slope = np.polyfit(np.log10(sizes), curve, 1)[0]
        assert abs(slope + 20) < 0.1  # ten times the noise, twenty decibels less
        for noisy in scaled.values():
            assert abs(metrics.snr(V, noisy) - 28) < 1e-9
        assert snr_without_mean > snr_uniform + 3
        assert np.ptp(angles) < 1e-6 and np.ptp(decibels) > 6
        """,
    ),
    "02": (
        "SECTIONS, SIDES, SIZE, ITERATIONS = 120, 12, 0.9, 8",
        """
        assert abs(difference).max() == 0 and abs(by_hand - w_edge) < 1e-12
        assert all(largest < 1e-12 for largest in differences.values())
        assert "E.sums(T.cotangents) / 2" in source(weights.cotangent)
        assert all(abs(A[name].sum(axis=1) - 1).max() < 1e-12 for name in A)
        assert all(max(curve) > curve[0] for curve in curves.values())
        assert all(change < 0 for change in volumes.values())
        """,
    ),
    "03": (
        "SECTIONS, SIDES, ITERATIONS = 60, 8, 6",
        """
        assert abs(by_hand - second).max() < 1e-12
        assert all(best[name].snr == curves[name][:, 1].max() for name in best)
        assert abs(eigenvalues[0] - 1) < 1e-9 and eigenvalues.min() > -2
        slow = eigenvalues > 0.5
        assert of_shape[slow].max() > 10 * of_shape[~slow].max()
        assert of_noise[slow].max() < 10 * of_noise[~slow].max()
        assert bounds["combinatorial"] >= 1 and bounds["distance"] >= 1
        assert 2 / 3 < bounds["cotangent"]
        assert 1.49 < largest[0] < 1.51 and 2.9 < largest[-1] < 3
        assert len(caught) == 1 and "the bound on this mesh" in str(caught[0].message)
        assert np.ptp(stable) < np.ptp(noisy_coarse) < np.ptp(blown_up)
        """,
    ),
    "04": (
        "DRAWS, ITERATIONS = 1, 5",
        """
        assert abs(metrics.snr(V, noisy) - 22.71) < 1e-9
        for weights in plotting.WEIGHT_COLORS:
            assert metrics.snr(V, meshes[weights, 10]) < 22.71
            angle = metrics.normal_angle(meshes[weights, 10], V, F)
            assert angle < metrics.normal_angle(noisy, V, F)
        assert len(table) == 24 and len(uniform) == len(normals) == 12
        average = uniform[uniform["weights"] == "combinatorial"]
        assert (abs(average["snr_mean"] - average["original_snr"]) < 0.3).all()
        assert gains["normals"].to_numpy().min() > gains["uniform"].to_numpy().max()
        """,
    ),
    "05": (
        "DETAIL, ITERATIONS = 0.5, 3",
        """
        assert 0.05 < missile.mean() < 0.6 and len(missile) == len(V)
        assert abs(metrics.snr(V, states[0.0]) - 22.7) < 1e-9
        assert metrics.snr(V, states[0.6]) > metrics.snr(V, states[4.0])
        flown = errors[errors["weights"] == "combinatorial"].pivot(
            index="time", columns="part", values="error"
        )
        assert flown["missiles"].idxmin() < flown["aircraft"].idxmin()
        assert flown["missiles"].iloc[-1] > flown["missiles"].iloc[0]
        assert flown["aircraft"].iloc[-1] < flown["aircraft"].iloc[0]
        """,
    ),
    "06": (
        "SECTIONS, SIDES, ITERATIONS = 60, 8, 5",
        """
        assert not found.ok and after.ok and after.closed
        assert (V_file[vertex_map] == V).all() and len(V) == len(V_true)
        assert [step.changed for step in report] == [180, 0, 20, 30, 1]
        assert volume[-1] < 0 and angle[-1] < angle[0] / 3
        assert (V_again == V_denoised).all()
        shown, _ = explorer.mesh()
        assert shown.shape == V.shape
        """,
    ),
    "07": (
        "SEGMENTS, SECTIONS, SIDES, DETAIL = 6, 40, 16, 0.5; JET_METHODS = ('learned',)",
        """
        assert list(by_default.index) == ["noisy", *methods]
        assert (by_default.loc["heat"] < by_default.loc["noisy"]).all()
        normals = ["sun", "bilateral-normal", "guided-normal", "feature-convinced", "l0"]
        assert by_default["box"][normals].max() < by_default["box"][list(flows)].min() / 2
        assert by_auto["torus"].drop("learned").idxmin() in flows
        for name in ("box", "torus"):
            true, *estimated = curves[name, "heat"].T
            assert all(true[curve.argmin()] < true[0] / 1.3 for curve in estimated)
        assert best_snr < best_angle / 2
        smooth_torus, stairs = cases["heat, best normals"], cases["l0"]
        V_torus, F_torus = meshes["torus"]
        assert metrics.snr(V_torus, stairs) > metrics.snr(V_torus, smooth_torus) + 3
        turned = [metrics.normal_angle(X, V_torus, F_torus) for X in (stairs, smooth_torus)]
        assert turned[0] > 2 * turned[1]
        kept = part_errors(on_jet["learned"])
        for table in flown.values():
            assert table["missiles"].iloc[-1] > table["missiles"].min()
            assert kept[0] < table["aircraft"].min()
        assert set(denoising.methods()) == {*methods, "leashed"}
        long, short = (
            metrics.normal_angle(own["box", m].V, *meshes["box"]) for m in ("averaging", "leashed")
        )
        assert short < long
        assert explorer.result.finished and "dB" in explorer.table.value
        """,
    ),
    "08": (
        "SEGMENTS, SECTIONS, SIDES, SPLITS, DETAIL = 8, 40, 16, 2, 0.5",
        """
        assert difference < 1e-12 and abs(once @ once.T).max() < 1 + 1e-9
        assert turn > 1.2  # on a smooth shape the weight rises with the angle
        on_box = dict(zip(angles, across(tables["box"][0]), strict=True))
        assert on_box[90] < on_box[60] / 2  # 90 degrees: the box's edges
        assert by_pass["cascade"][-1] < by_pass["first table again and again"][-1] / 2
        of_box, of_torus = errors.loc["learned from the box"], errors.loc["learned from the torus"]
        assert of_box["box"] < of_torus["box"] / 2 and of_torus["torus"] < of_box["torus"]
        assert on_own < on_others
        assert near_edge["learned"] == min(near_edge.values())
        assert missile_error(on_jet["learned"]) < missile_error(on_jet["heat"]) / 2
        assert comparison["crystal", "white"]["learned"] > best_of_others["crystal", "white"]
        ball_angles = [metrics.normal_angle(Y, ball, F_ball) for Y in (X, states["learned"])]
        assert ball_angles[1] > 1.5 * ball_angles[0]  # the dimples are taken away
        assert (comparison.loc["learned"] < comparison.loc["noisy"]).all()
        """,
    ),
    "09": (
        "DRAWS = 1",
        """
        assert list(np.round(ratios, 2)) == [2.01, 2.0, 1.57]
        close = np.abs(np.subtract(given["uniform in [0, a)"], given["printed"]))
        assert close.max() < 0.1
        for name in ("along the normals, deviation a", "Gaussian, deviation a"):
            assert np.abs(np.subtract(given[name], given["printed"])).min() > 1
        assert abs(best.snr - 23.36) < 0.1  # of the last suspect
        difference = uniform.pivot(index="row", columns="weights", values="SNR, printed minus ours")
        assert abs(difference["combinatorial"]).max() < 0.15
        assert difference["distance"].max() < -0.2  # the column that nobody can reproduce
        assert reduced["duplicates"].iloc[0] == 180
        """,
    ),
}

# Words of the field, as they begin: to be explained (in italics, bold or a heading, or by a link
# to the glossary) in the first cell of the course that uses them.
TERMS = [
    "averaging operator", "cascade", "combinatorial", "correlated", "cotangent", "crease",
    "decibel", "displacement", "duplicate", "eigenmode", "eigenvalue", "faces", "fixed vert",
    "forward Euler", "gain", "ground truth", "handle", "hat function", "heat equation", "kernel",
    "Laplacian", "least squares", "low-pass", "mean edge length", "normal angle",
    "original report", "orthonormal", "prior", "probe", "procedural", "risk", "signal-to-noise",
    "spectral coefficient", "spectrum", "stable", "SURE", "time step", "training",
    "transfer function", "vertices", "weld", "white noise",
]  # fmt: skip


@pytest.mark.parametrize("term", TERMS)
def test_a_term_is_explained_where_it_first_appears(term):
    for path in NOTEBOOKS:
        for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
            text = "".join(cell["source"])
            if cell["cell_type"] == "code":  # what it shows
                text = " ".join(re.findall(r'"([^"]*)"', text))
            if cell["id"] == "title" or not re.search(rf"\b{term}", text, re.I):
                continue
            explained = rf"\*[^*]*\b{term}[^*]*\*|^#+ .*\b{term}|CONTRIBUTING.md#glossary"
            assert re.search(explained, text, re.I | re.M), f"{path.stem}, cell {cell['id']}"
            return
    raise AssertionError(f"no notebook speaks of {term}: take it from the list")


each_notebook = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)


def cells(notebook, kind):
    return [cell for cell in notebook["cells"] if cell["cell_type"] == kind]


@pytest.fixture
def notebook(path):
    return json.loads(path.read_text(encoding="utf-8"))


@each_notebook
def test_committed_clean(notebook):
    for cell in cells(notebook, "code"):
        assert cell["outputs"] == [], f"clear the outputs of {cell['id']}"
        assert cell["execution_count"] is None
    for cell in notebook["cells"]:
        assert set(cell["metadata"]) <= {"tags"}, f"metadata of {cell['id']}"
        assert re.fullmatch(r"[a-z0-9-]{3,}", cell["id"])
    assert len({cell["id"] for cell in notebook["cells"]}) == len(notebook["cells"])
    assert set(notebook["metadata"]) == {"kernelspec", "language_info"}
    assert notebook["metadata"]["language_info"] == {"name": "python"}
    tags = [tag for cell in notebook["cells"] for tag in cell["metadata"].get("tags", [])]
    assert tags.count("parameters") == 1


@each_notebook
def test_tells_its_goal_and_leads_on(notebook, path):
    text = ["".join(cell["source"]) for cell in cells(notebook, "markdown")]
    assert re.match(rf"# {int(path.stem[:2])} · .*\n\n\*\*Goal\.\*\* ", text[0])
    assert any("## Try\n" in cell for cell in text)
    assert any("## A question\n" in cell for cell in text)
    linked = set(re.findall(r"\]\(([^)]+\.ipynb)\)", "\n".join(text)))
    assert linked
    for name in linked:
        assert (FOLDER / name).is_file(), name


@each_notebook
def test_begins_with_the_links_that_make_links_writes(notebook, path):
    write_links = runpy.run_path(str(TESTS.parent / "data_scripts" / "write_links.py"))
    text = "".join(notebook["cells"][0]["source"])
    assert text == write_links["with_links"](text, path.name, write_links["addresses"]())


def test_links_lead_to_the_addresses_of_the_project():
    write_links = runpy.run_path(str(TESTS.parent / "data_scripts" / "write_links.py"))
    urls = {"Repository": "https://github.com/a/b", "Documentation": "https://a.example/b/"}
    assert write_links["line"]("01-x.ipynb", urls) == (
        "[This notebook as a page](https://a.example/b/notebooks/01-x.html) · [run it on Binder]"
        "(https://mybinder.org/v2/gh/a/b/main?urlpath=lab%2Ftree%2Fnotebooks%2F01-x.ipynb)"
    )
    elsewhere = {"Repository": "https://git.example/a/b"}
    assert "/v2/git/https%3A%2F%2Fgit.example%2Fa%2Fb/main?" in write_links["line"](
        "01-x.ipynb", elsewhere
    )


# Third parties' own: jupyter_client's and zmq's, on their way to newer versions.
@pytest.mark.filterwarnings("ignore::DeprecationWarning:(jupyter_client|nbclient|zmq|traitlets)")
@pytest.mark.filterwarnings("ignore::ResourceWarning")
@pytest.mark.slow
@each_notebook
def test_runs_top_to_bottom(path, tmp_path):
    notebook = nbformat.read(path, as_version=4)
    small, check = CHECKS[path.stem[:2]]
    (at,) = [
        i for i, cell in enumerate(notebook.cells) if "parameters" in cell.metadata.get("tags", [])
    ]
    notebook.cells.insert(at + 1, nbformat.v4.new_code_cell(small))
    lines = [f"import sys; sys.path.insert(0, {str(TESTS)!r})", "from drive import drive_all"]
    notebook.cells.append(nbformat.v4.new_code_cell("\n".join([*lines, "drive_all(globals())"])))
    notebook.cells.append(nbformat.v4.new_code_cell(re.sub(r"^        ", "", check, flags=re.M)))
    # One thread each: two tests run at a time, and BLAS threads would wait for each other.
    one = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"), "1")
    client = nbclient.NotebookClient(
        notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}
    )
    client.execute(env={**os.environ, **one})

    for cell in notebook.cells:
        for output in cell.get("outputs", []):
            warns = "warns" in cell.metadata.get("tags", [])
            complaint = output.get("name") == "stderr" and not warns
            assert not complaint, f"{cell.id}: {output.text}"
    moved = notebook.cells[-2].outputs
    if path.stem[:2] not in ("00", "09"):  # these have none
        assert int(moved[0]["data"]["text/plain"]) >= 4, "no explorer was driven"
    assert (*tmp_path.iterdir(),) == (), "the notebook left files in its folder"
