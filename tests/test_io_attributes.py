"""What a file holds beside its mesh: kept byte for byte, carried to other formats, or told."""

import gzip
import io as streams
import re
import warnings

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import mesh_files
from meshfair import io, mesh, shapes
from meshfair.checks import MeshWarning
from meshfair.io.formats import FORMATS
from test_io import any_plys

UTM = np.array([448250.0, 5411940.0, 212.0])


def read(data, format, **options):
    """V, F and attributes of the bytes of a file."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        return io.read(streams.BytesIO(data), attributes=True, format=format, **options)


def written(V, F, format, **options):
    """The bytes of a file."""
    file = streams.BytesIO()
    io.write(file, V, F, format=format, **options)
    return file.getvalue()


def told(V, F, format, **options):
    """The bytes of a file, and the one warning of its writing."""
    with pytest.warns(MeshWarning) as record:
        data = written(V, F, format, **options)
    (warning,) = record
    return data, str(warning.message)


def extras(attributes):
    return FORMATS[attributes.format].extras(attributes)


# ---- The same format


OBJ = b"""\
# exported by nobody \r
mtllib skin.mtl
o head % 100
v 0 0.10 0 0.5 0.25 1
v 1 0 0 1 0 0
  v  1 1 1e-1 0 1 0
vt 0 0
vt 1 0
vt 1 1
vt 0.5 1
vn 0 0 1
g face # the front
usemtl skin
s 1
f 1/1/1 2/2/1 3/3/1
v 0 \\
 1 0 0 0 1
f 1/1/1 3/4/1 -1/-1/-1
l 1 2 3
v 9 9 9 0 0 0
# the end"""


@pytest.mark.parametrize(
    ("name", "line", "others"),
    [
        ("a.obj", "mtllib skin.mtl", ["skin.mtl"]),
        ("a.obj.gz", "mtllib\tskin.mtl", ["skin.mtl"]),
        ("a.obj", "  mtllib my skin.mtl", ["my skin.mtl"]),
        ("a.obj", "mtllib one.mtl two.mtl", ["one.mtl", "two.mtl"]),
        ("a.ply", "comment TextureFile skin.png", ["skin.png"]),
        ("a.obj", "# mtllib skin.mtl", []),
        ("a.obj", "mtllib gone.mtl " + 300 * "long", []),
        ("a.ply", "comment made of skin.png", []),
    ],
)
def test_files_that_are_named_and_left_behind_are_told(tmp_path, name, line, others):
    head, rest = (mesh_files.SOUND[name[2:5]]).split(b"\n", 1)
    if name[2:5] == "ply":
        form, rest = rest.split(b"\n", 1)
        head += b"\n" + form
    data = head + b"\n" + line.encode() + b"\n" + rest
    before, after = tmp_path / "before", tmp_path / "after"
    for folder in before, after:
        folder.mkdir()
    (before / name).write_bytes(gzip.compress(data) if name.endswith(".gz") else data)
    for file in ("skin.mtl", "my skin.mtl", "one.mtl", "two.mtl", "skin.png"):
        (before / file).write_bytes(b"")
    V, F, more = io.read(before / name, attributes=True)
    io.write(before / f"b{name[1:]}", V + 1, F, like=more)  # beside them: nothing to tell
    if others:
        places = ", ".join(str(before / other) for other in others)
        message = f"{after / name}: names {places}: copy that beside it, with"
        with pytest.warns(MeshWarning, match=re.escape(message)) as record:
            io.write(after / name, V + 1, F, like=more)
        assert record[0].filename == __file__
        for other in others:
            (after / other).write_bytes(b"")
    io.write(after / name, V + 1, F, like=more)
    assert line.encode() in (gzip.decompress if name.endswith(".gz") else bytes)(
        (after / name).read_bytes()
    )


def test_an_obj_keeps_all_but_the_numbers_that_changed():
    V, F, attributes = read(OBJ, "obj")
    assert written(V, F, "obj", like=attributes) == OBJ
    X = V.copy()
    X[[2, 3], [2, 0]] = 0.25, -2.5  # of the third and the fourth vertex
    a, b = np.cross(X[1] - X[0], X[2] - X[0]), np.cross(X[2] - X[0], X[3] - X[0])
    normal = " ".join(f"{x:.9g}" for x in (a + b) / np.linalg.norm(a + b))
    expected = OBJ.replace(b"1 1 1e-1", b"1 1 0.25").replace(b"v 0 \\", b"v -2.5 \\")
    expected = expected.replace(b"vn 0 0 1", b"vn " + normal.encode())
    assert written(X, F, "obj", like=attributes) == expected


def words_alike(a, b):
    """Whether two texts have the same words, numbers being the same where they are as large."""
    pairs = list(zip(a.split(), b.split(), strict=True))
    return all(x == y or float(x) == float(y) for x, y in pairs)


def test_moved_and_moved_back_every_odd_file_is_what_it_was():
    for name, (data, *_) in mesh_files.odd().items():
        format = name.lower().removesuffix(".gz").rpartition(".")[2]
        data = gzip.decompress(data) if name.lower().endswith("gz") else data
        V, F, attributes = read(data, format)
        assert written(V, F, format, like=attributes) == data, name
        if extras(attributes).normals or format == "stl":
            continue
        X = np.floor(V) + 64.0  # whole numbers, which every type holds
        moved = written(X, F, format, like=attributes)
        X_read, F_read, again = read(moved, format)
        assert np.array_equal(X_read, X), name
        assert np.array_equal(F_read, F), name
        back = written(V, F, format, like=again)
        if FORMATS[f".{format}"].is_binary(data):
            assert back == data, name
        elif "pi" not in name and "digits" not in name:
            assert words_alike(back, data), name
        assert back.count(b"\n") == data.count(b"\n")


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(any_plys(), st.booleans())
def test_any_ply_keeps_everything_else(drawn, fractions):
    data, *_ = drawn
    V, F, attributes = read(data, "ply")
    assert written(V, F, "ply", like=attributes) == data
    X = V[:, [1, 2, 0]] + (0.5 if fractions else 1.0)
    moved = written(X, F, "ply", like=attributes)
    X_read, F_read, again = read(moved, "ply")
    assert np.array_equal(X_read, X)  # in double precision where the type was one of integers
    assert len(F_read) == len(F)  # polygons may be cut otherwise, now that they lie otherwise
    if not fractions:  # the types are what they were
        back = written(V, F, "ply", like=again)
        assert back == data or (b"ascii" in data and words_alike(back, data))


def test_whole_numbers_become_double_where_they_have_to():
    for order in "<", ">":
        head = mesh_files.header(mesh_files.ORDERS[order], coordinate="short")
        rows = [mesh_files.packed(order, "short short short", *map(int, p)) for p in mesh_files.V]
        data = head.encode() + b"".join(rows) + mesh_files.face_rows(order, mesh_files.F)
        V, F, attributes = read(data, "ply")
        out = written(V + 0.1, F, "ply", like=attributes)
        assert np.array_equal(read(out, "ply")[0], V + 0.1)
        assert out.count(b"property double") == 3
        assert out.endswith(mesh_files.face_rows(order, mesh_files.F))
        larger = written(V + 40000, F, "ply", like=attributes)
        assert np.array_equal(read(larger, "ply")[0], V + 40000)


def test_single_precision_stays_and_becomes_double_only_where_it_overflows():
    data = mesh_files.SOUND["big.ply"]
    V, F, attributes = read(data, "ply")
    out = written(V * 1.1, F, "ply", like=attributes)
    assert len(out) == len(data)
    assert np.array_equal(read(out, "ply")[0], (V * 1.1).astype(np.float32))
    assert np.array_equal(read(written(V * 1e39, F, "ply", like=attributes), "ply")[0], V * 1e39)


def test_an_stl_keeps_header_and_attribute_words_and_is_written_in_its_order():
    data = mesh_files.stl_binary(title=b"COLOR= a scanner", attribute=0x1234)
    V, F, attributes = read(data, "stl")
    assert len(V) == 5  # welded, and the vertex that no face uses is none
    assert written(V, F, "stl", like=attributes) == data
    X = V + [[0, 0, 0.5]] * (np.arange(5) == 2)[:, None]
    out = written(X, F, "stl", like=attributes)
    assert out[:84] == data[:84]
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    old, new = (np.frombuffer(d, record, offset=84) for d in (data, out))
    assert np.array_equal(new["attribute"], old["attribute"])
    assert np.array_equal(new["corners"], X[F])
    moved = np.any(F == 2, axis=1)
    np.testing.assert_allclose(new["normal"][moved], mesh.face_normals(X, F)[moved], atol=1e-7)
    assert np.array_equal(new["normal"][~moved], old["normal"][~moved])


def test_solids_of_a_text_keep_their_names():
    data = b"\n".join(
        mesh_files.stl(F=part, name=name).encode()
        for part, name in ((mesh_files.F[:2], "vertex 1 2 3"), (mesh_files.F[2:], "part#2 facet"))
    )
    V, F, attributes = read(data, "stl")
    assert len(F) == 6
    assert written(V, F, "stl", like=attributes) == data
    out = written(V * 2, F, "stl", like=attributes).split(b"\n")
    for line, before in zip(out, data.split(b"\n"), strict=True):
        if b"vertex " not in before[:12] and b"normal" not in before:
            assert line == before
    assert np.array_equal(read(b"\n".join(out), "stl")[0], V * 2)


def test_compressed_files_and_paths_as_source(tmp_path):
    V, F = mesh_files.V, mesh_files.F
    source, out = tmp_path / "a.obj.gz", tmp_path / "b.obj.gz"
    source.write_bytes(gzip.compress(mesh_files.SOUND["obj"] + b"# end"))
    io.write(out, V * 2, F, like=source)
    assert gzip.decompress(out.read_bytes()).endswith(b"# end")
    soup, faces = V[F].reshape(-1, 3), np.arange(18).reshape(6, 3)
    path = tmp_path / "a.stl"
    path.write_bytes(mesh_files.stl_binary(title=b"mine"))
    io.write(tmp_path / "b.stl", soup, faces, like=path)  # not welded, as it is
    assert (tmp_path / "b.stl").read_bytes() == path.read_bytes()


# ---- Normals


def ply_with_normals(V, F, N):
    """A PLY in text of float32 normals."""
    head = mesh_files.header(
        vertices=len(V),
        faces=len(F),
        coordinate="double",
        after_vertex="".join(f"property float n{axis}\n" for axis in "xyz"),
    )
    rows = mesh_files.text("%r " * 6 + "\n", np.hstack([V, N]).tolist())
    return (head + rows + mesh_files.polygons(F)).encode()


def normals_in(data, n):
    """The normals of n vertices in what `ply_with_normals` makes."""
    lines = data.split(b"end_header\n")[1].split(b"\n")[:n]
    return np.array([line.split()[3:6] for line in lines], float)


def test_normals_are_those_of_the_vertices():
    V, F = shapes.icosphere(2)
    _, _, attributes = read(ply_with_normals(V, F, V), "ply")
    X = V * [1, 2, 3]
    N = normals_in(written(X, F, "ply", like=attributes), len(V))
    np.testing.assert_allclose(N, mesh.vertex_normals(X, F), atol=1e-8)  # nine digits


def test_both_sides_of_a_seam_keep_one_normal_and_of_a_sharp_edge_two():
    # Two triangles along an edge, its ends there twice.
    V = np.array([[0.0, 0, 0], [0, 1, 0], [1, 0, 0], [0, 0, 0], [0, 1, 0], [-1, 0, 0]])
    F = np.array([[0, 2, 1], [3, 4, 5]])
    X = V + [0, 0, 1] * (np.abs(V[:, :1]) > 0)  # bent along the edge
    faces = mesh.face_normals(X, F)
    smooth = faces.sum(axis=0) / np.linalg.norm(faces.sum(axis=0))
    for N, expected in (
        (np.tile([0.0, 0, 1], (6, 1)), smooth),  # a seam of textures
        (np.repeat([[0.0, 0, 1], [0, 0.1, 1]], 3, axis=0), None),  # two sides of an edge
    ):
        attributes = read(ply_with_normals(V, F, N), "ply")[2]
        new = normals_in(written(X, F, "ply", like=attributes), 6)
        on_edge = [0, 1, 3, 4]
        wanted = np.repeat(faces, 3, axis=0)[on_edge] if expected is None else [expected] * 4
        np.testing.assert_allclose(new[on_edge], wanted, atol=1e-7)
        np.testing.assert_allclose(new[[2, 5]], faces, atol=1e-7)  # at one face only


def test_a_normal_of_a_flat_face_stays_that_of_the_face():
    V, F = shapes.box(segments=1)
    lines = mesh_files.text("v %r %r %r\n", V.tolist())
    lines += mesh_files.text("vn %r %r %r\n", mesh.face_normals(V, F).tolist())
    lines += "".join(f"f {a}//{k} {b}//{k} {c}//{k}\n" for k, (a, b, c) in enumerate(F + 1, 1))
    _, _, attributes = read(lines.encode(), "obj")
    X = V + np.random.default_rng(3).normal(0, 0.1, V.shape)
    out = written(X, F, "obj", like=attributes)
    N = np.array([line.split()[1:] for line in out.split(b"\n") if line[:2] == b"vn"], float)
    np.testing.assert_allclose(N, mesh.face_normals(X, F), atol=1e-8)


# ---- Other formats


@pytest.fixture(scope="module")
def skin():
    """A mesh with colours, texture coordinates with a seam, and normals; and its OBJ."""
    V, F = shapes.icosphere(1)
    color = np.arange(3 * len(V)).reshape(-1, 3) % 256
    uv = np.vstack([V[:, :2] / 4 + 0.5, [[0.75, 0.25]]])
    corner_uv = F.copy()
    corner_uv[0, 0] = len(V)  # here the first face differs from the others
    lines = mesh_files.text("v %r %r %r %r %r %r\n", np.hstack([V, color / 255]).tolist())
    lines += mesh_files.text("vt %r %r\n", uv.tolist()) + "vn 0 0 1\nusemtl skin\n"
    for face, at in zip(F + 1, corner_uv + 1, strict=True):
        lines += "f " + " ".join(f"{a}/{t}/1" for a, t in zip(face, at, strict=True)) + "\n"
    return V, F, color, uv[corner_uv], lines.encode()


@pytest.mark.parametrize("format", ["obj", "off", "ply", "glb", "gltf", "vtu", "vtk", "dae"])
def test_what_a_format_holds_is_carried(skin, format):
    V, F, color, uv, data = skin
    _, _, attributes = read(data, "obj")
    options = {"binary": False} if format == "ply" else {}
    if format == "obj":
        out = written(V, F, format, like=attributes)
    else:
        out, message = told(V, F, format, like=attributes, **options)
        assert f"a .{format} file cannot hold them: " in message
        assert message.endswith("materials")
    X, T, again = read(out, format)
    np.testing.assert_allclose(X[T], V[F], atol=1e-6)  # single precision, seven digits
    more = extras(again)
    if format != "dae":
        assert np.array_equal(more.colors[:, :3][T], color[F])
        assert more.normals
    if format not in ("vtk",):
        np.testing.assert_allclose(
            more.texture[more.texture_of].reshape(F.shape + (2,)), uv, atol=1e-6
        )
    # Vertices are doubled only where a format has one coordinate for each.
    assert len(X) == len(V) + (format in ("off", "glb", "gltf", "vtu", "vtk", "dae"))


@pytest.mark.parametrize("binary", [True, False])
def test_trimesh_finds_colours_in_a_ply(binary):
    V, F = mesh_files.V, mesh_files.F
    color = [[i, 2 * i, 255] for i in range(len(V))]
    rows = mesh_files.text("%r %r %r %d %d %d\n", np.hstack([V, color]).tolist())
    data = f"COFF\n{len(V)} {len(F)} 0\n{rows}{mesh_files.polygons(F)}".encode()
    out = written(V, F, "ply", like=read(data, "off")[2], binary=binary)
    other = trimesh.load_mesh(streams.BytesIO(out), file_type="ply", process=False)
    assert np.array_equal(other.vertices, V)
    assert other.visual.vertex_colors[:, :3].tolist() == color


def test_trimesh_finds_everything_in_a_glb(skin):
    V, F, color, uv, data = skin
    out, _ = told(V, F, "glb", like=read(data, "obj")[2])
    scene = trimesh.load_scene(streams.BytesIO(out), file_type="glb", process=False)
    (other,) = scene.geometry.values()
    np.testing.assert_allclose(other.visual.uv[other.faces], uv, atol=1e-7)
    colors = other.visual.vertex_attributes["color"][other.faces]
    assert np.array_equal(colors[..., :3], color[F])


def test_faces_keep_colours_and_corners():
    pattern = mesh_files.off(faces=mesh_files.POLYGONS).replace("\n4 0 3 2 1", "\n4 0 3 2 1 9 8 7")
    data = "".join(
        line + (" 1 2 3" if line[:2] == "3 " else "") + "\n" for line in pattern.split("\n")
    ).encode()
    V, F, attributes = read(data, "off")
    for binary in True, False:
        out = written(V, F, "ply", like=attributes, binary=binary)
        X, T, again = read(out, "ply")
        more = extras(again)
        assert np.array_equal(X, V)
        assert np.array_equal(T, F)
        assert more.counts.tolist() == [4, 3, 3, 3, 3]
        assert more.face_colors.tolist() == [[9, 8, 7]] + 4 * [[1, 2, 3]]
        back = extras(read(written(X, T, "off", like=again), "off")[2])
        assert back.face_colors.tolist() == more.face_colors.tolist()
    _, message = told(V, F, "obj", like=attributes)
    assert "a .obj file cannot hold them: colours of faces" in message
    _, message = told(V, F, "stl", like=attributes)
    assert message.endswith("cannot hold them: polygons, colours of faces")


def test_colours_of_an_stl_go_to_faces():
    for title, word in (b"", 1 << 15 | 31 << 10 | 8), (b"COLOR=....", 31 | 8 << 10):
        V, F, attributes = read(mesh_files.stl_binary(title=title, attribute=word), "stl")
        more = extras(read(written(V, F, "ply", like=attributes), "ply")[2])
        assert more.face_colors.tolist() == 6 * [[255, 0, 65]]


def test_a_mesh_of_other_faces_keeps_what_belongs_to_vertices(skin):
    V, F, color, _, data = skin
    attributes = read(data, "obj")[2]
    out, message = told(V, F[:-1], "obj", like=attributes)
    assert "the faces are others" in message
    assert "texture coordinates, materials" in message
    assert np.array_equal(extras(read(out, "obj")[2]).colors, color)
    out, message = told(V[:-1], F[np.all(F < len(V) - 1, axis=1)], "obj", like=attributes)
    assert f"the mesh has {len(V) - 1} vertices" in message
    assert extras(read(out, "obj")[2]).kinds() == []


def test_another_encoding_is_written_anew():
    V, F, attributes = read(mesh_files.SOUND["big.ply"], "ply")
    text = written(V, F, "ply", like=attributes, binary=False)
    assert b"format ascii" in text
    assert np.array_equal(read(text, "ply")[0], V)


# ---- Precision


def test_what_single_precision_loses_is_told():
    V, F = shapes.icosphere(3)
    data, message = told(V + UTM, F, "stl")
    corners = read(data, "stl", weld=False)[0]
    lost = mesh.degenerate_faces(corners, np.arange(len(corners)).reshape(-1, 3)).sum()
    assert lost > 20
    assert f"{lost} faces lose their area" in message
    assert "move the mesh to the origin" in message
    # In a unit of a thousandth, and what is a millionth as large: the same mesh.
    assert "fall together" in told((V + UTM) * 1000, F, "stl")[1]
    assert "fall together" in told(V + UTM, F, "glb")[1]


@pytest.mark.parametrize("format", ["obj", "off", "ply", "vtu", "3mf"])
def test_what_keeps_all_digits_is_silent(format):
    V, F = shapes.icosphere(3)
    data = written(V + UTM, F, format)  # warnings are errors here
    assert np.array_equal(read(data, format)[0], V + UTM)


def test_an_offset_that_does_no_harm_is_silent():
    V, F = shapes.icosphere(3)
    written(V + 100, F, "stl")
    written(V * 1e-20, F, "stl")
    written(V * 1e20, F, "stl")


def test_single_precision_of_the_source_is_told_too():
    V, F = shapes.icosphere(1)
    X = V * 64 + UTM.round()  # edges of about 35
    data = mesh_files.ply_binary(V=X, faces=F, coordinate="float")
    read_X, _, attributes = read(data, "ply")
    written(read_X, F, "ply", like=attributes)  # as it was
    centre = read_X.mean(axis=0)
    _, message = told((read_X - centre) / 100 + centre, F, "ply", like=attributes)
    assert "lose their area" in message


# ---- Streams


def test_streams_need_a_format_and_bytes():
    with pytest.raises(io.MeshFileError, match="the stream: name: a stream has no ending"):
        io.read(streams.BytesIO(b""))
    with pytest.raises(io.MeshFileError, match="the stream: opening: the stream gives text"):
        io.read(streams.StringIO("OFF"), format="off")
    with pytest.raises(io.MeshFileError, match=r"the format '\.xyz'.*give one of them"):
        io.read(streams.BytesIO(b""), format="xyz")
    V, F = mesh_files.V, mesh_files.F
    packed = written(V, F, "obj.gz")
    assert np.array_equal(read(packed, ".OBJ.GZ")[0], V)


def test_a_format_says_more_than_the_ending(tmp_path):
    path = tmp_path / "mesh.dat"
    io.write(path, mesh_files.V, mesh_files.F, format="off")
    assert np.array_equal(io.read(path, format="off")[1], mesh_files.F)
