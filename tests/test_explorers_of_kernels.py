"""The explorer of learned kernels: it shows what the tables and the package's filter make."""

import numpy as np
import pytest

from meshfair import explorers, filters, metrics, noise, shapes, viewer
from meshfair.filters import kernel_table
from meshfair.filters.kernel_table import ANGLES

V, F = shapes.box(segments=3)
NOISY = noise.along_normals(V, F, 0.3, np.random.default_rng(1))
MESHES = {"box": (V, F), "torus": shapes.torus(sections=12, sides=8), "ball": shapes.icosphere(1)}


@pytest.fixture
def explorer(monkeypatch):
    monkeypatch.setattr(viewer.live, "has_egl", lambda: True)  # nobody looks
    explorer = explorers.KernelExplorer(MESHES, size=0.3, passes=2)
    explorer.wait()
    return explorer


def test_the_kernel_explorer_shows_what_the_tables_make(explorer):
    V_test, F_test = MESHES["torus"]
    X = noise.along_normals(V_test, F_test, 0.3, np.random.default_rng(2))
    tables = list(kernel_table.cascade([(NOISY, V, F)], 2))
    N = kernel_table.normals_by_tables(X, F_test, tables)[-1]
    *_, (_, by_gaussian) = filters.bilateral_normal(
        X, F_test, normal_iterations=2, vertex_iterations=20
    )
    expected = [X, by_gaussian, kernel_table.fit_vertices(X, F_test, N)]
    for panel, mesh in zip(explorer.view.panels, expected, strict=True):
        np.testing.assert_allclose(panel.V, mesh, atol=1e-12)
    errors = {curve["name"]: curve["y"] for curve in explorer.plots[1].series}
    assert explorer.view.titles[2] == f"table: {errors['table'][-1]:.1f}°"
    assert [len(curve) for curve in errors.values()] == [3, 3]
    assert errors["table"][0] == pytest.approx(metrics.normal_angle(X, V_test, F_test))
    curves = {curve["name"]: np.array(curve["y"]) for curve in explorer.plots[0].series}
    at_one = tables[0].reshape(len(ANGLES), -1)[:, 1]
    np.testing.assert_allclose(curves["table"], at_one / np.abs(at_one).max())
    # exp(-|n_i - n_j|^2 / 2 s^2) at a right angle, where the difference is the root of 2.
    assert curves["Gaussian"][45] == pytest.approx(np.exp(-1 / 0.35**2))


def test_all_others_are_all_but_the_one_that_is_tried(explorer):
    explorer.controls["train"].value = "all others"
    explorer.wait()
    examples = [
        (noise.along_normals(*MESHES[name], 0.3, np.random.default_rng(1)), *MESHES[name])
        for name in ("box", "ball")
    ]
    (table,) = kernel_table.cascade(examples, 1)
    np.testing.assert_allclose(explorer._tables[1][0], table)
    explorer.controls["test"].value = "ball"
    explorer.wait()
    assert explorer._tables[0][0] == ["box", "torus"]
    assert explorer.error is None


def test_more_passes_need_no_new_tables(explorer, monkeypatch):
    monkeypatch.setattr(kernel_table, "cascade", None)
    explorer.controls["passes"].value = 5
    explorer.controls["width"].value = 1.0
    explorer.wait()
    assert explorer.error is None
    assert len(explorer.plots[1].series[0]["y"]) == 6


def test_one_mesh_is_not_enough():
    with pytest.raises(ValueError, match="give two"):
        explorers.KernelExplorer({"box": (V, F)})
