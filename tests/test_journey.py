"""Every real mesh and every built-in shape, from its file through the package and back."""

import numpy as np
import pytest

from meshfair import datasets, io, mesh, noise, shapes, weights
from meshfair.flow import heat
from meshfair.operators import averaging

SHAPES = {
    "knot": shapes.knot,
    "icosphere": shapes.icosphere,
    "torus": shapes.torus,
    "box": shapes.box,
    "jet": shapes.jet,
    "jet without missiles": lambda: shapes.jet(missiles=False),
}
WEIGHTS = {
    "combinatorial": lambda V, F: weights.combinatorial(F, len(V)),
    "distance": weights.distance,
    "cotangent": weights.cotangent,
}


def journey(V, F, folder, endings):
    """Inspect, repair, add noise, flow with each weight, write, read."""
    assert mesh.inspect(V, F).faces == len(F)
    repaired = mesh.repair(
        V, F, degenerate=True, duplicates=True, orient="consistent", split=True, unreferenced=True
    )
    V, F = repaired.V, repaired.F
    found = mesh.inspect(V, F)
    assert found.manifold
    assert {"degenerate_faces", "duplicate_faces", "unreferenced_vertices"}.isdisjoint(
        finding.kind for finding in found.findings
    )
    V_noisy = noise.along_normals(V, F, 0.2, np.random.default_rng(7))
    for build in WEIGHTS.values():
        *_, (time, X) = heat(V_noisy, averaging(build(V_noisy, F)), 0.2, 1)
        assert time == 1
        assert np.isfinite(X).all()
        assert mesh.mean_edge_length(X, F) < mesh.mean_edge_length(V_noisy, F)  # it is smoother
        for ending in endings:
            path = folder / f"mesh{ending}"
            io.write(path, X, F)
            again, faces = io.read(path)
            assert np.array_equal(again, X)  # bit by bit
            assert np.array_equal(faces, F)


@pytest.mark.parametrize("make", SHAPES.values(), ids=SHAPES)
def test_a_shape_goes_through(make, tmp_path):
    V, F = make()
    io.write(tmp_path / "shape.ply", V, F)
    V_read, F_read = io.read(tmp_path / "shape.ply")
    assert np.array_equal(V_read, V)
    assert np.array_equal(F_read, F)
    journey(V_read, F_read, tmp_path, [".ply", ".obj", ".off"])


@pytest.mark.filterwarnings("ignore:.*copies of others:meshfair.MeshWarning")
@pytest.mark.parametrize("file", [source.file for source in datasets.SOURCES.values()])
def test_a_real_mesh_goes_through(file, mirror, tmp_path):
    path = mirror / file
    if not path.is_file():
        pytest.skip(f"{file} is not in the folder of real meshes")
    V, F = io.read(path)
    journey(V, F, tmp_path, [".ply"] if len(F) > 50_000 else [".ply", ".obj.gz", ".off"])


def test_a_soup_from_an_stl_file_goes_through_when_it_is_welded(tmp_path):
    V, F = shapes.box(segments=4)
    io.write(tmp_path / "box.stl", V, F)
    soup, triangles = io.read(tmp_path / "box.stl", weld=False)
    assert mesh.inspect(soup, triangles).counts["duplicate_vertices"] == 3 * len(F) - len(V)
    welded = mesh.repair(soup, triangles, weld=0)
    assert mesh.inspect(welded.V, welded.F).closed
    journey(welded.V, welded.F, tmp_path, [".ply"])
