"""Meshes of other libraries, in the place of V and F: theirs where installed, and look-alikes."""

from copy import deepcopy
from types import SimpleNamespace

import numpy as np
import pytest

from meshfair import MeshError, denoise, denoising, filters, io, mesh, noise, shapes, weights

V, F = shapes.icosphere(2)
V_NOISY = noise.along_normals(V, F, 0.2, np.random.default_rng(3))


def of_trimesh():
    trimesh = pytest.importorskip("trimesh")
    made = trimesh.Trimesh(V_NOISY, F, process=False)
    made.visual.vertex_colors = np.arange(4 * len(V)).reshape(-1, 4) % 256
    return made, lambda m: m.vertices, lambda m: np.asarray(m.visual.vertex_colors).tolist()


def of_pyvista():
    pyvista = pytest.importorskip("pyvista")
    made = pyvista.PolyData(V_NOISY, np.insert(F, 0, 3, axis=1).ravel())
    made.point_data["height"] = V[:, 2]
    return made, lambda m: m.points, lambda m: m.point_data["height"].tolist()


def of_open3d():
    open3d = pytest.importorskip("open3d")
    vectors = open3d.utility
    made = open3d.geometry.TriangleMesh(
        vectors.Vector3dVector(V_NOISY), vectors.Vector3iVector(F.astype(np.int32))
    )
    made.paint_uniform_color([0.2, 0.4, 0.6])
    return made, lambda m: np.asarray(m.vertices), lambda m: np.asarray(m.vertex_colors).tolist()


def of_open3d_tensors():
    open3d = pytest.importorskip("open3d")
    made = open3d.t.geometry.TriangleMesh(V_NOISY, F)
    return made, lambda m: m.vertex.positions.numpy(), lambda m: m.triangle.indices.numpy().tolist()


def of_meshio():
    meshio = pytest.importorskip("meshio")
    made = meshio.Mesh(V_NOISY, [("triangle", F)], point_data={"height": V[:, 2]})
    return made, lambda m: m.points, lambda m: m.point_data["height"].tolist()


def look_alike():
    """What has the attributes, and nothing else."""
    made = SimpleNamespace(vertices=V_NOISY.tolist(), triangles=F.tolist(), name="ball")
    return made, lambda m: np.asarray(m.vertices), lambda m: m.name


MAKERS = [of_trimesh, of_pyvista, of_open3d, of_open3d_tensors, of_meshio, look_alike]


@pytest.fixture(params=MAKERS, ids=lambda make: make.__name__)
def made(request):
    return request.param()


def test_denoise_gives_back_the_same_kind_with_all_it_holds(made):
    given, positions, rest = made
    before = np.array(positions(given)), deepcopy(rest(given))
    result = denoise(given, "taubin", iterations=3)
    want = denoise(V_NOISY, F, "taubin", iterations=3)
    np.testing.assert_array_equal(result.V, want.V)
    assert want.mesh is None
    assert type(result.mesh) is type(given)
    np.testing.assert_array_equal(positions(result.mesh), result.V)
    assert rest(result.mesh) == before[1]
    np.testing.assert_array_equal(positions(given), before[0])  # what was given stays as it is


def test_it_stands_for_both_arrays_wherever_they_are_asked_for(made):
    given, *_ = made
    for array, want in zip(mesh.arrays(given), (V_NOISY, F), strict=True):
        np.testing.assert_array_equal(array, want)
    assert mesh.inspect(given).faces == len(F)
    assert mesh.repair(given, unreferenced=True).F.shape == F.shape
    assert (weights.cotangent(given) != weights.cotangent(V_NOISY, F)).nnz == 0
    assert denoising.estimate_noise(given) == denoising.estimate_noise(V_NOISY, F)
    rng, same = np.random.default_rng(7), np.random.default_rng(7)
    np.testing.assert_array_equal(
        noise.along_normals(given, 0.1, rng), noise.along_normals(V_NOISY, F, 0.1, same)
    )
    np.testing.assert_array_equal(noise.uniform(given, 0.1, rng), noise.uniform(V_NOISY, 0.1, same))
    *_, (_, X) = filters.heat(given, time=1)
    *_, (_, Y) = filters.heat(V_NOISY, F, time=1)
    np.testing.assert_array_equal(X, Y)


def test_it_can_be_written(made, tmp_path):
    given, *_ = made
    io.write(tmp_path / "given.ply", given)
    for array, want in zip(io.read(tmp_path / "given.ply"), (V_NOISY, F), strict=True):
        np.testing.assert_array_equal(array, want)


def test_the_ground_truth_may_be_one_too(made):
    given, *_ = made
    result = denoising.tune(given, "taubin", given)
    assert result.parameters["iterations"] == 0  # nothing comes closer to itself
    table = denoise(given, "taubin", ground_truth=given).history
    assert table["normal_angle"].iloc[0] == 0


def test_stored_normals_follow():
    pyvista = pytest.importorskip("pyvista")
    given = pyvista.PolyData(V_NOISY, np.insert(F, 0, 3, axis=1).ravel())
    given.point_data["Normals"] = np.zeros((len(V), 3), np.float32)
    moved = denoise(given, "taubin").mesh
    want = mesh.vertex_normals(moved.points, F)
    np.testing.assert_allclose(moved.point_data["Normals"], want, atol=1e-6)  # float32


def test_open3d_computes_its_normals_anew():
    made, *_ = of_open3d()
    made.compute_vertex_normals()
    moved = denoise(made, "taubin").mesh
    want = deepcopy(moved)
    want.compute_vertex_normals()
    np.testing.assert_array_equal(moved.vertex_normals, want.vertex_normals)
    assert not np.array_equal(moved.vertex_normals, made.vertex_normals)


def test_faces_that_are_no_triangles_are_refused():
    quads = SimpleNamespace(points=V, faces=np.array([4, 0, 1, 2, 3]))
    with pytest.raises(MeshError, match=r"no triangles; take mesh.triangulate\(\)"):
        denoise(quads)
    cells = SimpleNamespace(points=V, cells_dict={"triangle": F, "quad": F, "line": F[:, :2]})
    with pytest.raises(MeshError, match=r"no triangles \(quad\)"):
        mesh.arrays(cells)
    del cells.cells_dict["quad"]
    np.testing.assert_array_equal(mesh.arrays(cells)[1], F)


def test_what_is_no_mesh_is_refused():
    with pytest.raises(MeshError, match=r"^dict is no mesh that is known; it needs vertices and"):
        mesh.arrays({})
    with pytest.raises(MeshError, match=r"V holds values of type object"):
        denoise(object(), F)
    with pytest.raises(MeshError, match=r"SimpleNamespace is no mesh of 3 vertices"):
        mesh.moved(look_alike()[0], V[:3])
