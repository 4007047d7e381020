"""The grid that choices are judged by, and what is computed from it."""

import importlib.util
import json
import statistics
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from meshfair import denoising, experiments, io, mesh, metrics, noise
from meshfair.experiments import choices, draws, grids, specimens
from meshfair.experiments.meshes import load_mesh


@pytest.mark.parametrize("name", choices.SHAPES)
def test_shapes_are_sound_and_small(name):
    V, F = load_mesh(name)
    found = {finding.kind for finding in mesh.inspect(V, F).findings}
    # Obtuse triangles have negative cotangent weights; the landscape is open.
    allowed = {"negative_weights"} | ({"boundary_edges"} if name == "landscape" else set())
    assert found <= allowed
    assert 1500 <= len(F) <= 6000
    corners = V[F]
    if name == "landscape":
        assert np.all(mesh.face_normals(V, F)[:, 2] > 0)
    else:
        assert np.linalg.det(corners).sum() > 0  # outward: the volume is positive


def test_specimens_are_what_they_say():
    V, F = specimens.plate()
    assert np.ptp(V[:, 2]) == pytest.approx(mesh.mean_edge_length(V, F), rel=0.15)
    V, F = specimens.pulley()
    N = mesh.face_normals(V, F)
    # A turned profile of straight lines along and across the axis: no slanted faces.
    assert np.all((np.abs(N[:, 2]) < 1e-9) | (np.abs(N[:, 2]) > 1 - 1e-9))
    # By Pappus: two rims and a groove between r = 0.5 and its outer radius; a polygon of 64
    # corners in place of the circle has sin(x) / x of its area.
    x = 2 * np.pi / 64
    round_volume = np.pi * (2 * 0.25 * (1 - 0.25) + 0.3 * (0.8**2 - 0.25))
    assert np.linalg.det(V[F]).sum() / 6 == pytest.approx(round_volume * np.sin(x) / x)
    for make in (specimens.boulder, specimens.golf_ball):
        (V, F), again = make(), make()
        assert np.array_equal(V, again[0])
        assert np.array_equal(F, again[1])
        assert len(V) - 3 * len(F) // 2 + len(F) == 2  # Euler: spheres


def test_the_conditions_are_all_combinations(monkeypatch):
    monkeypatch.setattr(choices.datasets, "find", lambda name: None)
    assert len(choices.conditions()) == len(set(choices.conditions())) == 9 * 5 * 4
    monkeypatch.setattr(choices.datasets, "find", lambda name: name)
    assert choices.conditions()[-1] == ("bunny pair", "published", 0.2)
    assert len(choices.conditions()) == 9 * 5 * 4 + 2


@pytest.mark.parametrize("kind", choices.KINDS)
def test_each_kind_of_noise_has_its_size_and_no_mean(kind):
    sizes, means = [], []
    V, F = load_mesh("golf ball")
    unit = mesh.mean_edge_length(V, F)
    for seed in range(3):
        V_noisy, V_true, G = choices.noisy_mesh("golf ball", kind, 0.2, seed)
        assert np.array_equal(V_true, V)
        assert np.array_equal(G, F)
        moved = (V_noisy - V) / unit
        sizes.append(np.mean(np.sum(moved**2, axis=1)))
        means.append(moved.mean(axis=0))
    # Squared sizes: sigma^2 along the normals, 3 sigma^2 in all directions, half of the vertices.
    expected = 0.04 * {"gaussian": 3, "uniform": 3, "impulsive": 0.5}.get(kind, 1)
    # Four standard errors of 3 x 2562 squares; correlated ones count for about a tenth.
    share = 10 if kind == "correlated" else 1
    assert np.mean(sizes) == pytest.approx(expected, rel=4 * np.sqrt(2 * share / (3 * len(V))))
    assert np.abs(np.mean(means, axis=0)).max() < 4 * 0.2 * np.sqrt(share / (3 * len(V)))


def test_draws_differ_from_cell_to_cell_and_come_again():
    drawn = {
        (kind, size, seed): choices.noisy_mesh("plate", kind, size, seed)[0]
        for kind, size, seed in product(choices.KINDS, (0.1, 0.2), (0, 1))
    }
    V, _ = load_mesh("plate")
    moved = np.array([(X - V)[:, 2] for X in drawn.values()])
    moved /= np.linalg.norm(moved, axis=1, keepdims=True)
    alike = moved @ moved.T - np.eye(len(moved))
    assert np.abs(alike).max() < 0.5  # the same draw on another scale would have 1
    again = choices.noisy_mesh("plate", "gaussian", 0.1, 1)[0]
    assert np.array_equal(again, drawn["gaussian", 0.1, 1])


def test_half_of_the_vertices_are_moved_by_impulsive_noise():
    X, V, _ = choices.noisy_mesh("torus", "impulsive", 0.4, 1)
    assert np.any(X != V, axis=1).mean() == 0.5


def test_a_pair_has_its_published_noise_alone():
    with pytest.raises(ValueError, match=r"kind \(of fandisk\) is 'normals'; give one of publ"):
        choices.noisy_mesh("fandisk", "normals", 0.3, 1)
    with pytest.raises(ValueError, match="kind is 'published'; give one of normals, gaussian"):
        choices.noisy_mesh("knot", "published", 0.3, 1)


def test_pairs_are_the_public_files(mirror, monkeypatch, tmp_path):
    from meshfair import datasets, io

    monkeypatch.setenv("MESHFAIR_DATA", str(tmp_path))
    for name in ("fandisk-clean", "fandisk-noisy"):
        datasets.fetch(name)
    X, V, F = choices.noisy_mesh("fandisk", "published", 0.3, 1)
    assert np.array_equal(X, io.read(mirror / "GuidedDenoising-Fandisk0.3-Noisy.obj")[0])
    assert np.array_equal(V, io.read(mirror / "GuidedDenoising-Fandisk0.3-Original.obj")[0])
    assert len(F) == 12946
    assert ("fandisk", "published", 0.3) in choices.conditions()


CELLS = [("plate", "normals", 0.2), ("plate", "correlated", 0.4)]


@pytest.fixture(scope="module")
def table():
    return experiments.compare_choices(CELLS, 3, methods=["taubin", "implicit"])


def test_the_table_scores_what_it_names(table):
    assert len(table) == 2 * (2 + 2 * 3)
    for row in table.itertuples():
        noisy, V, F = choices.noisy_mesh(row.mesh, row.kind, row.size, row.seed)
        X = noisy
        if row.method == "auto":
            X = denoising.denoise(noisy, F).V
        elif row.method != "none":
            assert row.chosen == row.method
            X = denoising.denoise(noisy, F, row.method, **json.loads(row.used)).V
        assert row.normal_angle == metrics.normal_angle(X, V, F)
        assert row.snr == metrics.snr(V, X)
        assert row.vertex_distance == metrics.vertex_distance(X, V, F)


def test_tuned_is_the_best_that_a_method_can(table):
    angle = table.pivot(
        index=["kind", "method"], columns="parameters", values="normal_angle"
    ).dropna()
    assert len(angle) == 4
    # Candidates of "auto" and of "tuned" are the same ones, and the noisy mesh is among them.
    assert (angle["tuned"] <= angle["auto"]).all()


def made_up():
    """A table of two cells with two methods, one of them the better one in each."""
    rows = []
    for kind, angles in {
        "normals": {"none": 20, "auto": 5.5, "a": (8, 6, 5), "b": (10, 12, 9)},
        "impulsive": {"none": 10, "auto": 12, "a": (8, 6, 6), "b": (3, 4, 2)},
    }.items():
        for method, found in angles.items():
            ways = ("default", "auto", "tuned") if isinstance(found, tuple) else ("default",)
            for way, angle in zip(ways, np.atleast_1d(found), strict=True):
                rows.append((method, way, float(angle), "m", kind, 0.2, 1))
    columns = ["method", "parameters", "normal_angle", "mesh", "kind", "size", "seed"]
    return pd.DataFrame(rows, columns=columns)


def test_regret_by_hand():
    found = experiments.regrets(made_up())
    regret = found.set_index(["kind", "contender"])["regret"]
    assert dict(regret["normals"]) == {
        "noisy mesh": 4, "own choice": 1.1, "a": 1.6, "a, auto": 1.2, "b": 2, "b, auto": 2.4,
    }  # fmt: skip
    assert dict(regret["impulsive"]) == {
        "noisy mesh": 5, "own choice": 6, "a": 4, "a, auto": 3, "b": 1.5, "b, auto": 2,
    }  # fmt: skip
    assert list(found.groupby("kind", sort=False)["best_default"].first()) == [8, 3]
    assert list(found.groupby("kind", sort=False)["noisy"].first()) == [20, 10]


def test_regret_does_not_depend_on_the_order_of_rows_and_their_labels():
    table = made_up()
    other = pd.concat([table.iloc[7:], table.iloc[:7]]).set_axis([0] * len(table))
    found = [
        experiments.regrets(rows).set_index(["kind", "contender"])["regret"].sort_index()
        for rows in (table, other)
    ]
    pd.testing.assert_series_equal(*found)


def test_the_summary_by_hand():
    regrets = experiments.regrets(made_up())
    whole = experiments.summary(regrets).set_index("contender")
    assert whole.loc["own choice"].to_dict() == {"cells": 2, "median": 3.55, "worst": 6}
    assert whole.index[0] == "b"  # median 1.75
    by_kind = experiments.summary(regrets, ["kind"]).set_index(["kind", "contender"])
    assert by_kind.loc[("impulsive", "a, auto"), "median"] == 3
    assert (by_kind["cells"] == 1).all()


def test_the_published_grid_is_that_of_the_experiment():
    found = [axes for axes in grids.read_grids("choices")]
    for axes in found:
        assert axes["experiment"] is choices.choice
        assert tuple(axes["mesh"]) == choices.SHAPES
        assert tuple(axes["kind"]) == tuple(choices.KINDS)
        assert tuple(axes["size"]) == choices.SIZES
    assert found[0]["method"] == ["none", "auto"]
    assert found[1]["method"] == denoising.methods()


def test_a_grid_with_a_wrong_kind_is_refused(tmp_path):
    path = tmp_path / "grid.toml"
    axes = 'mesh = "knot"\nsize = 0.2\nseed = 1\nmethod = "taubin"\nparameters = "default"\n'
    path.write_text(f'experiment = "choices"\nkind = "normal"\n{axes}')
    with pytest.raises(ValueError, match=r"kind is 'normal'; .*did you mean 'normals'"):
        grids.read_grids(path)


def test_missiles_over_draws(monkeypatch):
    def quick(V, F, method, parameters):
        return denoising.denoise(V, F, "averaging" if method == "auto" else method)

    monkeypatch.setattr(draws, "by_front", quick)
    table = experiments.missile_draws(2, 0.2, methods=["taubin"])
    assert list(table["seed"].unique()) == [0, 1]
    rows = table.set_index(["seed", "method", "parameters"])
    flows = experiments.averaging_for_missiles(0.2, 1)
    assert rows.loc[(1, draws.STOPPED, "default"), "missiles"] == flows["missile_error"].min()
    noisy, V, F = experiments.noisy_pair("jet", 0.2, 1)
    for method, X in {
        "none": noisy,
        "auto": denoising.denoise(noisy, F, "averaging").V,
        "taubin": denoising.denoise(noisy, F, "taubin").V,
    }.items():
        parts = experiments.part_errors(X, V, F)
        assert rows.loc[(1, method, "default"), "missiles"] == parts["missiles"]
        assert rows.loc[(1, method, "default"), "aircraft"] == parts["aircraft"]
    assert rows.loc[(1, "auto", "default"), "chosen"] == "averaging"
    assert (1, "taubin", "auto") in rows.index


def test_the_knot_over_draws(monkeypatch):
    monkeypatch.setattr(denoising, "methods", lambda: ["taubin"])
    table = experiments.knot_draws(2, (0.1,))
    assert list(table["method"]) == 2 * ["none", "auto", "taubin"]
    assert list(table["kind"].unique()) == ["normals"]
    noisy, V, _ = choices.noisy_mesh("knot", "normals", 0.1, 1)
    assert table["snr"][3] == metrics.snr(V, noisy)


ROOT = Path(__file__).resolve().parent.parent


def loaded(path):
    """A module of a script's folder."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_script_scores_pairs_of_a_folder(tmp_path, monkeypatch):
    monkeypatch.setattr(denoising, "methods", lambda: ["taubin"])
    V, F = load_mesh("plate")
    noisy = noise.along_normals(V, F, 0.2, np.random.default_rng(1))
    (tmp_path / "Some22").mkdir()
    for name, X in (("clean", V), ("noisy", noisy)):
        io.write(tmp_path / "Some22" / f"thing-{name}.ply", X, F)
    table = loaded(ROOT / "data_scripts/grid.py").pairs(tmp_path)
    assert list(table["method"]) == ["none", "auto", "taubin"]
    assert set(zip(table["source"], table["pair"], table["faces"], strict=True)) == {
        ("Some22", "thing", len(F))
    }
    size = np.sqrt(np.mean(np.sum((noisy - V) ** 2, axis=1))) / mesh.mean_edge_length(V, F)
    assert table["size"][0] == pytest.approx(size)
    expected = denoising.denoise(noisy, F, "taubin").V
    assert table["normal_angle"][2] == metrics.normal_angle(expected, V, F)


def test_the_numbers_of_the_report_by_going_through_the_rows():
    found = loaded(ROOT / "report/grid_results.py")
    table = pd.read_csv(ROOT / "report/results/choices.csv")
    angles = {}
    for row in table.itertuples():
        way = row.method if row.method in ("none", "auto") else row.parameters
        cell = angles.setdefault((row.mesh, row.kind, row.size), {})
        cell.setdefault(way, {})[row.method, row.parameters] = row.normal_angle
    own = ("auto", "default")
    regret = [cell["auto"][own] / min(cell["tuned"].values()) for cell in angles.values()]
    ratio = [cell["auto"][own] / min(cell["default"].values()) for cell in angles.values()]
    harm = [cell["auto"][own] / cell["none"]["none", "default"] for cell in angles.values()]
    numbers = found._grid(table)
    assert numbers["grid-cells"] == str(len(angles))
    assert numbers["own-median"] == f"{statistics.median(regret):.2f}"
    assert numbers["own-worst"] == f"{max(regret):.1f}"
    assert numbers["own-default-median"] == f"{statistics.median(ratio):.3f}"
    assert numbers["own-default-worst"] == f"{max(ratio):.1f}"
    assert numbers["own-harm"] == str(sum(x > 1.01 for x in harm))
    rows = found.regret().set_index("contender")
    assert list(rows) == ["median", "worst", *choices.KINDS, *map(str, choices.SIZES)]
    assert rows.loc["own choice", "median"] == pytest.approx(statistics.median(regret))
    drawn = pd.read_csv(ROOT / "report/results/missile_draws.csv")
    assert found._draws(
        {
            "missile_draws": drawn,
            "knot_draws": pd.read_csv(ROOT / "report/results/knot_draws.csv"),
        }
    )["missile-draws"] == str(drawn["seed"].nunique())
