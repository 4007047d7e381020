"""Formats that other libraries read and write: the same checks, positions and words."""

import io as streams
import subprocess
import sys
import warnings

import meshio
import numpy as np
import pytest
import trimesh
from PIL import Image

from meshfair import io, mesh, shapes
from meshfair.checks import MeshError, MeshWarning, NotInstalledError
from meshfair.io.formats import FORMATS

SCENES = ["glb", "gltf", "3mf", "dae"]
GRIDS = ["vtk", "vtu"]


def exported(scene, format):
    if format == "dae":
        return trimesh.exchange.dae.export_collada(scene.dump())
    if format == "gltf":
        return trimesh.exchange.gltf.export_gltf(scene, embed_buffers=True)["model.gltf"]
    return scene.export(file_type=format)


def read(data, format, **options):
    """What is read, and the warnings."""
    with warnings.catch_warnings(record=True) as record:
        warnings.simplefilter("always")
        mesh_ = io.read(streams.BytesIO(data), format=format, **options)
    return *mesh_, [str(warning.message) for warning in record]


@pytest.mark.parametrize("format", [*SCENES, *GRIDS])
def test_what_is_written_is_read(format, tmp_path):
    V, F = shapes.icosphere(1)
    V = V.astype(np.float32).astype(np.float64)
    for path in tmp_path / f"a.{format}", tmp_path / f"a.{format}.gz":
        io.write(path, V, F)
        X, T = io.read(path)
        assert len(X) == len(V)
        np.testing.assert_allclose(X[T], V[F], atol=1e-6 if format == "dae" else 0)  # 7 digits


@pytest.mark.parametrize("format", SCENES)
def test_every_mesh_of_a_scene_is_where_the_scene_puts_it(format):
    V, F = shapes.icosphere(0)
    place = trimesh.transformations.rotation_matrix(1.0, [1, 2, 3], [0, 1, 0])
    place[:3, :3] *= 2.5
    scene = trimesh.Scene()
    one = trimesh.Trimesh(V, F, process=False)
    scene.add_geometry(one, node_name="here", geom_name="ball")
    scene.add_geometry(one, node_name="there", geom_name="ball", transform=place)
    X, T, (message,) = read(exported(scene, format), format)
    assert "its 2 meshes are read as one" in message
    both = np.concatenate([V[F], V[F] @ place[:3, :3].T + place[:3, 3]]).reshape(-1, 9)
    order = [np.lexsort(np.round(rows, 4).T) for rows in (X[T].reshape(-1, 9), both)]
    np.testing.assert_allclose(X[T].reshape(-1, 9)[order[0]], both[order[1]], atol=2e-6)


@pytest.mark.parametrize("format", ["glb", "gltf", "3mf"])
def test_a_scene_is_written_again_with_its_nodes_and_each_mesh_moves_alone(format):
    V, F = shapes.icosphere(0)
    scene = trimesh.Scene()
    one = trimesh.Trimesh(V, F, process=False)
    place = np.diag([2.0, 2, 2, 1])
    place[:3, 3] = 5, 0, 0
    scene.add_geometry(one, node_name="here", geom_name="ball")
    scene.add_geometry(one, node_name="there", geom_name="ball", transform=place)
    data = exported(scene, format)
    X, T, attributes, _ = read(data, format, attributes=True)
    out = streams.BytesIO()
    io.write(out, X, T, like=attributes, format=format)
    assert out.getvalue() == data
    moved = X.copy()
    moved[-1] += 0.25
    out = streams.BytesIO()
    io.write(out, moved, T, like=attributes, format=format)
    again, faces, _ = read(out.getvalue(), format)
    np.testing.assert_allclose(again[faces], moved[T], atol=1e-6)
    nodes = trimesh.load_scene(streams.BytesIO(out.getvalue()), file_type=format).graph
    assert set(nodes.nodes_geometry) == {"here", "there"}


def test_a_mesh_that_its_scene_puts_far_away_loses_nothing():
    V, F = shapes.icosphere(3)
    scene = trimesh.Scene()
    place = trimesh.transformations.translation_matrix([448250, 5411940, 212])
    scene.add_geometry(trimesh.Trimesh(V, F, process=False), transform=place)
    X, T, attributes, _ = read(exported(scene, "glb"), "glb", attributes=True)
    out = streams.BytesIO()
    io.write(out, X + 0.125, T, like=attributes, format="glb")  # a warning would be an error
    # In single precision there is the mesh, not its place; doubles end at 1e-9 there.
    np.testing.assert_allclose(read(out.getvalue(), "glb")[0], X + 0.125, atol=1e-6, rtol=0)


@pytest.mark.parametrize("format", SCENES)
def test_the_meshes_of_a_scene_keep_their_order(format):
    V, F = shapes.icosphere(0)
    scene = trimesh.Scene()
    for k in 2, 0, 3, 1:
        ball = trimesh.Trimesh(V + 10 * k, F, process=False)
        scene.add_geometry(ball, node_name=f"node {k}", geom_name=f"ball {k}")
    data = exported(scene, format)
    for _ in range(3):
        X, T, attributes, _ = read(data, format, attributes=True)
        out = streams.BytesIO()
        io.write(out, X + 0.25, T, like=attributes, format=format)
        data = out.getvalue()
        again, faces, _ = read(data, format)
        assert np.array_equal(faces, T)
        np.testing.assert_allclose(again, X + 0.25, atol=1e-5)


def test_a_mirror_turns_faces_as_it_turns_the_surface():
    V, F = shapes.icosphere(1)
    scene = trimesh.Scene()
    mirror = np.diag([-1.0, 1, 1, 1])
    scene.add_geometry(trimesh.Trimesh(V, F, process=False), transform=mirror)
    X, T, _ = read(exported(scene, "glb"), "glb")
    assert mesh.volume(X, T) == pytest.approx(mesh.volume(V, F), rel=1e-6)


@pytest.mark.parametrize("format", ["glb", "gltf"])
def test_a_textured_glb_keeps_image_coordinates_and_material(format):
    V, F = shapes.icosphere(1)
    pixels = np.arange(192, dtype=np.uint8).reshape(8, 8, 3)
    material = trimesh.visual.material.PBRMaterial(
        baseColorTexture=Image.fromarray(pixels), roughnessFactor=0.25, name="skin"
    )
    visual = trimesh.visual.TextureVisuals(uv=V[:, :2], material=material)
    one = trimesh.Trimesh(V, F, process=False, visual=visual, vertex_normals=V)
    data = exported(trimesh.Scene([one]), format)
    X, T, attributes, _ = read(data, format, attributes=True)
    Y = X * [1, 2, 3]
    out = streams.BytesIO()
    io.write(out, Y, T, like=attributes, format=format)
    scene = trimesh.load_scene(streams.BytesIO(out.getvalue()), file_type=format, process=False)
    (other,) = scene.geometry.values()
    np.testing.assert_allclose(other.vertices, Y, rtol=1e-6)
    np.testing.assert_allclose(other.visual.uv, V[:, :2], atol=1e-7)
    assert other.visual.material.roughnessFactor == 0.25
    assert other.visual.material.name == "skin"
    assert np.array_equal(np.asarray(other.visual.material.baseColorTexture)[..., :3], pixels)
    np.testing.assert_allclose(other.vertex_normals, mesh.vertex_normals(Y, T), atol=1e-6)


@pytest.mark.parametrize("format", GRIDS)
def test_a_grid_keeps_arrays_and_polygons(format, tmp_path):
    V, F = shapes.box(segments=1)
    pairs = [("triangle", F[:4]), ("quad", [[0, 1, 2, 3]]), ("polygon", [[0, 1, 2, 3, 4]])]
    cells = [np.arange(4.0), np.array([5.0]), np.array([6.0])]
    grid = meshio.Mesh(V, pairs, {"heat": V[:, 0], "Normals": V}, {"part": cells})
    path = tmp_path / f"a.{format}"
    grid.write(path)
    with pytest.warns(MeshWarning, match="more than three corners"):
        X, T, attributes = io.read(path, attributes=True)
    assert np.array_equal(X, V)
    io.write(tmp_path / f"b.{format}", V * 3, T, like=attributes)
    again = meshio.read(tmp_path / f"b.{format}")
    assert np.array_equal(again.points, 3 * V)
    assert [block.type for block in again.cells] == ["triangle", "quad", "polygon"]
    assert np.array_equal(again.point_data["heat"], V[:, 0])
    assert np.array_equal(np.concatenate(again.cell_data["part"]), np.concatenate(cells))
    np.testing.assert_allclose(
        again.point_data["Normals"], mesh.vertex_normals(3 * V, T), atol=1e-8
    )
    with pytest.warns(MeshWarning, match="array heat of points, array part of cells"):
        io.write(tmp_path / "c.ply", V, T, like=attributes)


def test_cells_that_are_no_faces_are_told_or_refused(tmp_path):
    V, F = shapes.box(segments=1)
    meshio.Mesh(V, [("triangle", F), ("line", [[0, 1]])]).write(tmp_path / "a.vtu")
    with pytest.warns(MeshWarning, match="those of the kinds line are no faces"):
        assert len(io.read(tmp_path / "a.vtu")[1]) == len(F)
    meshio.Mesh(V, [("tetra", [[0, 1, 2, 4]])]).write(tmp_path / "b.vtu")
    with pytest.raises(io.MeshFileError, match=r"faces: the cells are of the kinds \['tetra'\]"):
        io.read(tmp_path / "b.vtu")


SURFACE = """# vtk DataFile Version {version}
a title
ASCII
DATASET POLYDATA
POINTS 4 float
0 0 0 1 0 0 1 1 0
0 1 1
{polygons}
POINT_DATA 4
SCALARS heat float 1
LOOKUP_TABLE default
1 2 3 4
"""
OLD = "POLYGONS 2 8\n3 0 1 2\n3 0 2 3"
NEW = "POLYGONS 3 6\nOFFSETS vtktypeint64\n0 3 6\nCONNECTIVITY vtktypeint64\n0 1 2 0 2 3"


@pytest.mark.parametrize(("version", "polygons"), [("3.0", OLD), ("5.1", NEW)])
def test_a_surface_in_an_old_vtk_file_stays_one(version, polygons):
    data = SURFACE.format(version=version, polygons=polygons).encode()
    V, F, attributes, _ = read(data, "vtk", attributes=True)
    assert F.tolist() == [[0, 1, 2], [0, 2, 3]]
    out = streams.BytesIO()
    io.write(out, V + [0, 0, 2], F, like=attributes, format="vtk")
    points = b"0.0 0.0 2.0 1.0 0.0 2.0 1.0 1.0 2.0\n0.0 1.0 3.0"
    assert [float(x) for x in out.getvalue().split(b"float\n")[1].split(b"\nPOLY")[0].split()] == [
        float(x) for x in points.split()
    ]
    assert out.getvalue().split(b"POLYGONS")[1] == data.split(b"POLYGONS")[1]


def test_surfaces_as_pyvista_saves_them(tmp_path):
    pyvista = pytest.importorskip("pyvista", reason="only the benchmarks need it")
    ball = pyvista.Sphere(theta_resolution=6, phi_resolution=6)
    for binary in True, False:
        ball.save(tmp_path / "a.vtk", binary=binary)
        V, F, attributes = io.read(tmp_path / "a.vtk", attributes=True)
        assert np.array_equal(F, ball.regular_faces)
        io.write(tmp_path / "b.vtk", V * 2, F, like=attributes)
        again = pyvista.read(tmp_path / "b.vtk")
        np.testing.assert_allclose(again.points, 2 * V, rtol=1e-6)
        assert np.array_equal(again.regular_faces, F)


@pytest.mark.parametrize("format", [*SCENES, *GRIDS])
def test_damaged_files_are_refused_in_our_words(format, rng, tmp_path):
    io.write(tmp_path / f"a.{format}", *shapes.icosphere(0))
    sound = (tmp_path / f"a.{format}").read_bytes()
    damaged = [b"", b"\0" * 50, b"<html></html>", b"{}", sound[: len(sound) // 2], sound[:20]]
    for _ in range(20):
        changed = bytearray(sound)
        changed[rng.integers(len(sound))] ^= 1 << rng.integers(8)
        at = rng.integers(len(sound))
        damaged.append(bytes(changed[:at] + changed[at + rng.integers(4) :]))
    refused = []
    for data in damaged:
        try:
            V, F, *_ = read(data, format)
        except MeshError as error:
            refused.append(str(error))
        else:
            assert np.isfinite(V).all()
            assert F.min() >= 0
            assert F.max() < len(V)
    assert len(refused) >= 6
    for message in refused:
        assert message.startswith("the stream: ")
        assert message.isprintable()


@pytest.mark.parametrize("format", [*SCENES, *GRIDS])
def test_a_missing_library_names_its_extra(format, monkeypatch):
    for name in [name for name in sys.modules if name.split(".")[0] in ("trimesh", "meshio")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "trimesh", None)
    monkeypatch.setitem(sys.modules, "meshio", None)
    for action in (
        lambda: io.read(streams.BytesIO(b"x"), format=format),
        lambda: io.write(streams.BytesIO(), *shapes.icosphere(0), format=format),
    ):
        with pytest.raises(NotInstalledError, match=rf"a \.{format} file needs .*\[formats\]"):
            action()


def test_the_libraries_are_loaded_when_they_are_needed():
    assert set(FORMATS) == {".obj", ".off", ".ply", ".stl", *(f".{f}" for f in SCENES + GRIDS)}
    code = "import sys; from meshfair import io; print({'trimesh', 'meshio'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"
