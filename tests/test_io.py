"""Reading and writing files: what is sound comes back exactly, all else is refused by name."""

import gzip
import logging
import os
import re
import subprocess
import sys
import time
import warnings
from itertools import pairwise
from pathlib import Path

import igl
import numpy as np
import pytest
from hypothesis import HealthCheck, given, seed, settings
from hypothesis import strategies as st

import mesh_files
from meshfair import io, shapes
from meshfair.checks import LARGEST_COORDINATE, MeshError, MeshWarning
from meshfair.io import ply_header, ply_rows, text
from meshfair.io.welding import same_rows

EXACT = [".obj", ".off", ".ply", ".obj.gz", ".off.gz", ".ply.gz"]
ALL = [*EXACT, ".stl", ".stl.gz"]
BOTH = [*((ending, True) for ending in ALL), (".ply", False), (".stl", False)]
# After the name of the file: where in it the error is.
PLACE = r"(:| has no) (opening|name|header|line \d|byte \d|faces|face \d|vertex \d|vertices)"


def read(path, **options):
    """Read without the warnings on what was cut into triangles, or not merged."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        return io.read(path, **options)


def same(a, b):
    """Whether two arrays are equal bit by bit (0.0 and -0.0 differ)."""
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()


@pytest.fixture
def folder(tmp_path):
    yield tmp_path
    assert not list(tmp_path.rglob(".meshfair*")), "a temporary file is left"


# ---- Malformed files


@pytest.fixture(scope="module")
def refused(tmp_path_factory):
    """What reading each malformed file ended in."""
    folder = tmp_path_factory.mktemp("malformed")
    files = mesh_files.malformed()
    for name, data in files.items():
        (folder / name).write_bytes(data)
    return dict(zip(files, mesh_files.read_apart(folder / name for name in files), strict=True))


def test_malformed_files_are_many(refused):
    assert len(refused) > 600
    for ending in "obj", "off", "ply", "stl", "gz":
        assert sum(name.endswith(ending) for name in refused) >= 50


def test_malformed_files_give_a_mesh_error(refused):
    wrong = {name: end for name, end in refused.items() if end["outcome"] != "MeshError"}
    assert not wrong


def test_malformed_files_are_refused_with_name_and_place_in_one_line(refused):
    for name, end in refused.items():
        assert re.search(re.escape(name) + PLACE, end["message"]), end
        assert end["message"].isprintable() or "\ufffd" in end["message"]
        assert len(end["message"]) < 600


def test_malformed_files_take_little_time_and_memory(refused):
    assert max(end["seconds"] for end in refused.values()) < mesh_files.SECONDS
    assert max(end["megabytes"] for end in refused.values()) < mesh_files.MEGABYTES


def test_the_message_has_all_four_parts(tmp_path):
    path = tmp_path / "bunny.ply"
    path.write_bytes(mesh_files.changed(mesh_files.SOUND["ply"], "3 1 2 4", "3 1 98 4"))
    with pytest.raises(io.MeshFileError) as error:
        io.read(path)
    assert str(error.value) == (
        f"{path}: face 3: vertex index 98, but the file has 6 vertices (0 to 5); "
        "the file may be cut or damaged, download or export it again"
    )


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("html.obj", "HTML"),
        ("lfs.ply", "git-LFS pointer"),
        ("zip.obj", "zip archive"),
        ("gzip.stl", "gzip-compressed"),
        ("bzip2.off", "bzip2"),
        ("xz.ply", "xz"),
        ("utf16.off", "UTF-16"),
        ("zeros.obj", "binary data"),
        ("random.ply", "binary data"),
        ("named_like_another.ply", "looks like OBJ"),
        ("named_like_another.obj", "looks like PLY"),
        ("empty.stl", "empty"),
        ("gzip_not.obj.gz", "looks like OBJ"),
        ("bomb.ply.gz", "it has grown to"),
        (
            "index_just_too_large.obj",
            "line 10: vertex index 7, but the file has 6 vertices (1 to 6)",
        ),
        ("index_negative_too_far.obj", "line 10: vertex index -7, but the file has 6 vertices"),
        ("length_char_-3_row_0_little.ply", "row 0 of element 'face' has a list of -3"),
        ("index_word.obj", "line 10: found 'one', but an integer was expected"),
        ("coordinate_word.off", "line 5: found 'two', but a number was expected"),
        ("coordinate_nan.ply", "vertex 2 has y = nan"),
        ("row_short.ply", "line 12: 2 values in a row of element 'vertex'"),
        ("header_two_billion_faces.little.ply", "2147483648 rows of element 'face'"),
        ("announced_four_billion.stl", "4294967295 triangles announced"),
        ("counts_more_faces.off", "6 vertices and 7 faces announced, but 12 lines follow"),
    ],
)
def test_messages_say_what_was_found(refused, name, words):
    assert words in refused[name]["message"]


def test_places_of_lines_are_those_of_an_editor(tmp_path):
    path = tmp_path / "mesh.obj"
    path.write_bytes(b"\xef\xbb\xbf# one\r\n\r\nv 0 0 \\\r\n0\r\n# five\r\rv 1 0 x # seven\n")
    with pytest.raises(MeshError, match="line 7: found 'x'"):
        io.read(path)


def test_places_are_right_where_lines_are_broken_elsewhere(tmp_path):
    path = tmp_path / "mesh.off"
    path.write_text("4OFF\n3 1 0\n0 0 0\n1\n1 0 0 1 # five\n0 1\n0 2\n3 0 1 2\n")
    with pytest.raises(MeshError, match=r"line 6: 2\.0 as fourth coordinate"):
        io.read(path)


def test_what_is_no_regular_file_is_refused(tmp_path):
    (tmp_path / "folder.obj").mkdir()
    os.mkfifo(tmp_path / "pipe.ply")
    (tmp_path / "device.stl").symlink_to("/dev/zero")
    (tmp_path / "nowhere.off").symlink_to("nothing")
    (tmp_path / "loop.off").symlink_to("loop.off")
    names = ["folder.obj", "pipe.ply", "device.stl", "nowhere.off", "loop.off", "missing.obj"]
    (tmp_path / "memory.ply").symlink_to("/proc/self/mem")
    names += [
        "memory.ply",
        ".",
        "folder.obj/inside.obj",
        "x" * 300 + ".obj",
        "nu\0l.obj",
        "device.stl/x.obj",
    ]
    for name, end in zip(names, mesh_files.read_apart(tmp_path / n for n in names), strict=True):
        assert end["outcome"] == "MeshError", (name, end)
        assert re.search("opening|the ending ''|reading failed", end["message"])
        assert end["seconds"] < 1


# ---- Odd files


@pytest.fixture(scope="module")
def odd():
    return mesh_files.odd()


def test_odd_files_are_read_exactly(odd, tmp_path):
    assert len(odd) > 300
    for name, (data, V, F) in odd.items():
        path = tmp_path / name
        path.write_bytes(data)
        read_V, read_F = read(path, weld=False)
        assert same(read_V, np.asarray(V, np.float64)), name
        assert same(read_F, np.asarray(F, np.int64)), name
        assert read_V.flags.writeable
        assert read_F.flags.writeable
        assert read_V.flags.c_contiguous


def test_a_path_may_be_a_word_or_an_object(tmp_path, monkeypatch):
    (tmp_path / "a.obj").write_bytes(mesh_files.SOUND["obj"])
    monkeypatch.chdir(tmp_path)
    for path in "a.obj", Path("a.obj"), tmp_path / "a.obj", str(tmp_path / "a.obj"):
        assert same(io.read(path)[1], mesh_files.F)


def test_cutting_polygons_is_reported(tmp_path):
    path = tmp_path / "quads.obj"
    path.write_text(mesh_files.obj(faces=mesh_files.POLYGONS))
    message = r"quads\.obj: 1 of 5 faces .* more than three corners \(up to 4\); .* 6 triangles"
    with pytest.warns(MeshWarning, match=message) as record:
        io.read(path)
    assert record[0].filename == __file__  # the warning points at the caller


def test_stl_is_merged_unless_the_soup_is_asked_for(tmp_path, caplog):
    path = tmp_path / "pyramid.stl"
    path.write_bytes(mesh_files.SOUND["binary.stl"])
    with caplog.at_level(logging.INFO, "meshfair.io"):
        V, F = io.read(path)
    assert "merged 18 vertices into 5" in caplog.text
    # In the order of the file: the corners of the first face come first.
    assert same(V[:3], mesh_files.V[[0, 3, 2]])
    assert same(V[F], mesh_files.V[mesh_files.F])
    V, F = io.read(path, weld=False)
    assert V.shape == (18, 3)
    assert same(F, np.arange(18).reshape(6, 3))


def test_welding_is_exact_and_leaves_other_formats_alone(tmp_path):
    V = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-0.0, 0, 0], [1, 1e-45, 0], [0, 1, 0]])
    F = np.array([[0, 1, 2], [3, 4, 5]])
    io.write(tmp_path / "a.stl", V, F)
    assert same(io.read(tmp_path / "a.stl")[1], np.array([[0, 1, 2], [0, 3, 2]]))
    io.write(tmp_path / "a.obj", V, F)
    assert same(io.read(tmp_path / "a.obj")[0], V)


@given(st.lists(st.tuples(*3 * [st.sampled_from([0.0, -0.0, 1.0, 5e-324])]), min_size=1))
def test_rows_are_the_same_where_python_says_so(rows):
    first, kind = same_rows(np.array(rows))
    assert first.tolist() == [rows.index(row) for row in dict.fromkeys(rows)]
    assert kind.tolist() == [list(dict.fromkeys(rows)).index(row) for row in rows]


# ---- The fast code against the slow and obvious


def slow_obj(data):
    """What an OBJ says, read with a loop: the specification of `meshfair.io.obj`."""
    number = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?|[-+]?(nan|inf|infinity)", re.I)
    integer = re.compile(r"[-+]?\d+")
    data = data.decode("latin-1").removeprefix("\u00ef\u00bb\u00bf")
    data = re.sub(r"(?<!\S)#[^\n]*", "", data.replace("\r\n", "\n").replace("\r", "\n"))
    V, polygons = [], []
    for line in data.replace("\\\n", " ").split("\n"):
        words = re.findall(r"[^ \t\n\v\f\r]+", line)
        if not words:
            continue
        keyword, *values = words
        if keyword == "v":
            if len(values) not in (3, 4, 6, 7, 8) or not all(map(number.fullmatch, values)):
                raise ValueError(line)
            V.append([float(value) for value in values[:3]])
        elif keyword == "f":
            if len(values) < 3:
                raise ValueError(line)
            parts = [value.split("/") for value in values]
            for vertex, *rest in parts:
                if len(rest) > 2 or not integer.fullmatch(vertex):
                    raise ValueError(line)
                if not vertex[-1].isdigit() or any(r and not integer.fullmatch(r) for r in rest):
                    raise ValueError(line)
            indices = [int(vertex) for vertex, *_ in parts]
            polygons.append([i - 1 if i > 0 else len(V) + i if i else -1 for i in indices])
        elif keyword not in ("vn", "vt", "g", "o", "s"):
            raise ValueError(line)
    if not V or not np.isfinite(V).all() or np.abs(V).max() > LARGEST_COORDINATE or not polygons:
        raise ValueError("no mesh")
    if any(not 0 <= i < len(V) for face in polygons for i in face):
        raise ValueError("index")
    return np.array(V), np.array([[p[0], a, b] for p in polygons for a, b in pairwise(p[1:])])


OBJ_WORDS = st.sampled_from(
    ["v", "f", "vn", "g", "1", "2", "3", "-1", "0", "4", "1/1", "2//3", "3/1/2", "1/", "2/x", "nan"]
    + ["0.5", ".5", "5.", "-1e-3", "1.5.5", "1-2", "1_0", "inf", "1e999", "+2", "x", "#", "\\", "/"]
)
OBJ_BLANKS = st.sampled_from(
    [" "] * 12 + ["\n"] * 2 + ["\t", "  ", "\r\n", "\r", " \\\n", "\f", ""]
)
OBJ_LINES = st.sampled_from(
    [
        "v 0 0 0\n",
        "v 1 0 0\n",
        "v 0 1 .5 1\n",
        "f 1 2 3\n",
        "f -1 -2 -3 # x\n",
        "f 1/1 2/2 3/3 1/1\n",
    ]
)


@settings(max_examples=400, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.lists(OBJ_LINES, max_size=6),
    st.lists(st.tuples(OBJ_WORDS, OBJ_BLANKS).map("".join), max_size=12),
    st.lists(OBJ_LINES, max_size=6),
)
def test_obj_is_read_as_the_loop_reads_it(tmp_path_factory, before, middle, after):
    path = tmp_path_factory.getbasetemp() / "random.obj"
    data = "".join([*before, *middle, "\n", *after]).encode()
    path.write_bytes(data)
    try:
        expected = slow_obj(data)
    except ValueError:
        with pytest.raises(MeshError):
            read(path)
    else:
        V, F = read(path)
        assert same(V, expected[0])
        assert same(F, expected[1])


@settings(max_examples=300, deadline=None)
@given(st.text(alphabet=" \t\n\r\f\v#ab1.\\", max_size=60))
def test_lines_and_words_are_those_of_python(data):
    data = data.encode()
    normalised = text.normalised_text(data, comments=True)
    assert [data[a : a + n] for a, n in zip(*text.words_of(normalised), strict=True)] == (
        normalised.split()
    )
    lines = text.Lines(normalised)
    by_python = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    by_python = re.sub(rb"(?<!\S)#[^\n]*", b"", by_python)
    expected = [
        (i, line.split()) for i, line in enumerate(by_python.split(b"\n"), 1) if line.split()
    ]
    assert lines.split() == [words for _, words in expected]
    assert lines.words.tolist() == [len(words) for _, words in expected]
    assert [lines.place(k) for k in range(len(lines))] == [f"line {i}" for i, _ in expected]
    every_second = lines[::2]
    assert every_second.split() == [words for _, words in expected[::2]]
    assert lines.first_words(4).tolist() == [words[0][:4] for _, words in expected]


@given(st.lists(st.floats(), min_size=1), st.sampled_from([repr, "%.17g".__mod__]))
def test_numbers_are_those_of_python(values, write):
    data = " ".join(map(write, values)).encode()
    numbers = text.parse_numbers(data, np.float64, len(values))
    np.testing.assert_array_equal(numbers, [float(word) for word in data.split()])


@st.composite
def any_plys(draw):
    """A PLY of any elements and properties in any order and encoding, and the mesh in it."""
    types = st.sampled_from(sorted(mesh_files.CODES))
    integer_types = types.filter(lambda name: name not in ("float", "double"))
    extras = st.lists(st.tuples(types, st.one_of(st.none(), integer_types)), max_size=2)
    small = st.integers(0, 3)
    V = draw(st.lists(st.tuples(small, small, small), min_size=4, max_size=6))
    faces = draw(st.lists(st.lists(small, min_size=3, max_size=5), min_size=1, max_size=4))
    if draw(st.booleans()):
        faces = [face[:3] for face in faces]
    coordinate, index, length = draw(types), draw(types), draw(integer_types)
    columns = {
        "vertex": [(axis, coordinate, None, [row[k] for row in V]) for k, axis in enumerate("xyz")],
        "face": [(draw(st.sampled_from(["vertex_index", "vertex_indices"])), index, length, faces)],
        "extra": [],
        "more": [],
    }
    rows = {"vertex": len(V), "face": len(faces), "extra": draw(small), "more": draw(small)}
    for element, properties in columns.items():
        for k, (dtype, length) in enumerate(draw(extras)):
            value = small if length is None else st.lists(small, max_size=3)
            count = rows[element]
            values = draw(st.lists(value, min_size=count, max_size=count))
            properties.append((f"p{k}", dtype, length, values))
        columns[element] = draw(st.permutations(properties))
    order = draw(st.sampled_from(["", "<", ">"]))
    head = f"ply\nformat {mesh_files.ORDERS.get(order, 'ascii')} 1.0\n"
    body = b""
    for element in draw(st.permutations(sorted(columns))):
        head += f"element {element} {rows[element]}\n"
        for name, dtype, length, _ in columns[element]:
            head += f"property {f'list {length} ' if length else ''}{dtype} {name}\n"
        for row in range(rows[element]):
            for _, dtype, length, values in columns[element]:
                numbers = values[row] if length else [values[row]]
                if order:
                    body += mesh_files.packed(order, length, len(numbers)) if length else b""
                    body += mesh_files.packed(order, f"{dtype} " * len(numbers), *numbers)
                else:
                    words = [len(numbers)] * bool(length) + numbers
                    body += (" ".join(map(str, words)) + " ").encode()
            body += b"" if order else b"\n"
    F = [[face[0], *pair] for face in faces for pair in pairwise(face[1:])]
    sizes = [len(face) - 2 for face in faces]
    return head.encode() + b"end_header\n" + body, np.array(V, float), np.array(F), sizes


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(any_plys())
def test_any_ply_is_read(tmp_path_factory, drawn):
    data, V, F, sizes = drawn
    path = tmp_path_factory.getbasetemp() / "random.ply"
    path.write_bytes(data)
    read_V, read_F = read(path)
    assert same(read_V, V)
    assert len(read_F) == len(F)
    # A fan, or where that folds (see test_io_polygons) other triangles of the same corners.
    at = np.cumsum(sizes)[:-1]
    for triangles, fan in zip(np.split(read_F, at), np.split(F, at), strict=True):
        assert same(triangles, fan) or set(triangles.ravel()) <= set(fan.ravel())


def test_numbers_are_as_many_as_words():
    assert text.parse_numbers(b"1 2\n", np.float64, 2).tolist() == [1, 2]
    for words in b"1 2 3", b"1", b"1 2x", b"1 2_0", b"1 2.5.5", b"1 x", b" ":
        assert text.parse_numbers(words, np.float64, 2) is None


@given(st.data(), st.sampled_from(["little", "big"]))
def test_binary_rows_are_the_same_at_once_and_one_by_one(data, order):
    types = st.sampled_from(sorted(ply_header.TYPES)).map(ply_header.TYPES.get)
    length_types = st.sampled_from([None, "int8", "uint8", "uint16", "int32"])
    drawn = data.draw(st.lists(st.tuples(types, length_types), min_size=1, max_size=4))
    properties = [
        ply_rows.Property(str(k), dtype, length and np.dtype(length))
        for k, (dtype, length) in enumerate(drawn)
    ]
    rows = data.draw(st.integers(0, 6))
    lengths = data.draw(st.sampled_from([[2], [0], [1, 1, 1, 1, 2], [0, 1, 2, 3]]))
    content = b""
    for row in range(rows):
        for p in properties:
            n = 1 if p.length is None else lengths[row % len(lengths)]
            if p.length is not None:
                content += n.to_bytes(p.length.itemsize, order)
            content += bytes(range(row, row + n * p.dtype.itemsize))
    element = ply_rows.Element("any", rows, properties)
    table, end = ply_rows._binary_table(b"head" + content, 4, element, order)
    slow, slow_end = ply_rows._rows_one_by_one(b"head" + content, 4, element, order, rows)
    assert end == slow_end == 4 + len(content)
    for p in properties:
        for column in ("values", "lengths", "starts"):
            assert same(getattr(table[p.name], column), getattr(slow[p.name], column))


# ---- Other readers and real files


@pytest.mark.parametrize(("ending", "binary"), [b for b in BOTH if not b[0].endswith(".gz")])
def test_libigl_reads_what_is_written(folder, ending, binary):
    V, F = shapes.icosphere(2)
    V = V.astype(np.float32).astype(np.float64)
    io.write(folder / f"a{ending}", V, F, binary=binary)
    other_V, other_F = igl.read_triangle_mesh(str(folder / f"a{ending}"))
    np.testing.assert_array_equal(other_V[other_F], V[F])
    if ending != ".stl":
        np.testing.assert_array_equal(other_V, V)


@pytest.mark.parametrize("ending", [".obj", ".off", ".ply", ".stl"])
def test_what_libigl_writes_is_read(tmp_path, ending):
    path = tmp_path / f"a{ending}"
    V, F = shapes.icosphere(2)
    igl.write_triangle_mesh(str(path), V, F)
    read_V, read_F = read(path)
    np.testing.assert_allclose(read_V[read_F], V[F], atol=1e-6)


def test_real_meshes_are_read(mirror):
    counts = {
        "KnotMesh.ply": (1440, 2880),
        "f16.ply": (2537, 4428),
        "stanford-bunny.obj": (35947, 69451),
        "GuidedDenoising-Fandisk0.3-Original.obj": (6475, 12946),
        "GuidedDenoising-Fandisk0.3-Noisy.obj": (6475, 12946),
        "GuidedDenoising-Bunny0.2-Noisy.obj": (34834, 69451),
    }
    for name, (n, m) in counts.items():
        V, F = io.read(mirror / name)
        assert (len(V), len(F)) == (n, m)
        if name != "f16.ply":  # libigl refuses it for its comment
            other_V, other_F = igl.read_triangle_mesh(str(mirror / name))
            np.testing.assert_array_equal(V, other_V)
            np.testing.assert_array_equal(F, other_F)


def test_real_meshes_come_back(mirror, folder):
    for path in [*mirror.glob("*.ply"), *mirror.glob("*Noisy.obj")]:
        V, F = io.read(path)
        for ending in EXACT[:3]:
            io.write(folder / f"again{ending}", V, F)
            read_V, read_F = io.read(folder / f"again{ending}")
            assert same(read_V, V)
            assert same(read_F, F)


# ---- Writing


@st.composite
def any_meshes(draw, width=64):
    """Any numbers as coordinates, any vertices as corners."""
    limit = LARGEST_COORDINATE if width == 64 else 3e38
    number = (
        st.floats(-limit, limit, width=width)
        if width == 64
        else st.floats(width=32, allow_nan=False, allow_infinity=False)
    )
    V = draw(st.lists(st.tuples(number, number, number), min_size=1, max_size=8))
    corner = st.integers(0, len(V) - 1)
    F = draw(st.lists(st.tuples(corner, corner, corner), min_size=1, max_size=8))
    return np.array(V), np.array(F)


@pytest.mark.parametrize("binary", [True, False])
@pytest.mark.parametrize("ending", EXACT)
@settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(mesh=any_meshes())
def test_written_meshes_come_back_bit_by_bit(folder, ending, binary, mesh):
    V, F = mesh
    io.write(folder / f"a{ending}", V, F, binary=binary)
    read_V, read_F = io.read(folder / f"a{ending}")
    assert same(read_V, V)
    assert same(read_F, F)


@pytest.mark.parametrize("binary", [True, False])
@settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(mesh=any_meshes(width=32))
def test_written_stl_comes_back_as_triangles(folder, binary, mesh):
    V, F = mesh
    io.write(folder / "a.stl", V, F, binary=binary)
    read_V, read_F = read(folder / "a.stl", weld=False)
    assert same(read_V, V[F].reshape(-1, 3))
    assert same(read_F, np.arange(3 * len(F)).reshape(-1, 3))


def test_stl_rounds_to_float32_and_refuses_what_does_not_fit(folder):
    V, F = np.array([[0.1, 0, 0], [1, 0, 0], [0, 1 / 3, 0]]), np.array([[0, 1, 2]])
    io.write(folder / "a.stl", V, F)
    assert same(read(folder / "a.stl", weld=False)[0], V.astype(np.float32).astype(np.float64))
    for binary in True, False:
        with pytest.raises(MeshError, match=r"a\.stl: vertex 1: position .* up to 3\.4e38"):
            io.write(folder / "a.stl", V * [1e39, 1, 1], F, binary=binary)


def test_normals_in_stl_are_those_of_the_triangles(folder):
    V, F = shapes.icosphere(1)
    io.write(folder / "a.stl", V, F)
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    records = np.frombuffer((folder / "a.stl").read_bytes(), record, offset=84)
    centres = V[F].mean(axis=1)
    centres /= np.linalg.norm(centres, axis=1, keepdims=True)
    assert np.all(np.sum(records["normal"] * centres, axis=1) > 0.99)


@pytest.mark.parametrize("ending", ALL)
def test_no_mesh_is_not_written(folder, ending):
    V, F = shapes.icosphere(0)
    path = folder / f"a{ending}"
    for bad_V, bad_F in (V * np.nan, F), (V, F + 1), (V, F[:0]), (V[:, :2], F), (V, F * 1.0):
        with pytest.raises(MeshError):
            io.write(path, bad_V, bad_F)
    assert not path.exists()


def test_unknown_endings_are_not_written(folder):
    for name in "a.xyz", "a", "a.obj.zip", "a.gz", ".obj":
        with pytest.raises(MeshError, match=r"ending .*\.obj, \.off, \.ply, \.stl"):
            io.write(folder / name, *shapes.icosphere(0))
    assert not list(folder.iterdir())


def test_compressed_files_hold_the_same_bytes_and_no_time(folder):
    mesh = shapes.icosphere(1)
    for ending in EXACT[:3]:
        io.write(folder / f"a{ending}", *mesh)
        io.write(folder / f"b{ending}.gz", *mesh)
        assert (
            gzip.decompress((folder / f"b{ending}.gz").read_bytes())
            == (folder / f"a{ending}").read_bytes()
        )
        first = (folder / f"b{ending}.gz").read_bytes()
        io.write(folder / f"c{ending}.gz", *mesh)
        assert (folder / f"c{ending}.gz").read_bytes() == first


def test_a_new_file_has_usual_permissions_and_an_old_one_keeps_its_own(folder):
    path = folder / "a.obj"
    old = os.umask(0o027)
    try:
        io.write(path, *shapes.icosphere(0))
    finally:
        os.umask(old)
    assert path.stat().st_mode & 0o777 == 0o640
    path.chmod(0o604)
    io.write(path, *shapes.icosphere(1))
    assert path.stat().st_mode & 0o777 == 0o604


def test_a_link_keeps_pointing_to_its_file(folder):
    (folder / "deep").mkdir()
    (folder / "link.obj").symlink_to("deep/file.obj")
    for subdivisions in 0, 1:  # the file is new, then there
        io.write(folder / "link.obj", *shapes.icosphere(subdivisions))
        assert (folder / "link.obj").is_symlink()
        assert same(io.read(folder / "deep" / "file.obj")[1], shapes.icosphere(subdivisions)[1])


def test_what_cannot_be_written_is_named(folder):
    (folder / "folder.obj").mkdir()
    os.mkfifo(folder / "pipe.obj")
    (folder / "file").write_text("")
    for name in "folder.obj", "pipe.obj", "missing/a.obj", "file/a.obj", "x" * 300 + ".obj":
        with pytest.raises(io.MeshFileError, match=r"\.obj: writing: "):
            io.write(folder / name, *shapes.icosphere(0))
    assert (folder / "folder.obj").is_dir()
    assert (folder / "pipe.obj").is_fifo()


def test_a_write_that_is_interrupted_leaves_the_old_file(folder, monkeypatch):
    path = folder / "a.obj"
    io.write(path, *shapes.icosphere(0))
    before = path.read_bytes()
    for name, error in (
        ("fsync", OSError(28, "No space left on device")),
        ("fsync", KeyboardInterrupt()),
    ):

        def fail(*_, error=error):
            raise error

        monkeypatch.setattr(os, name, fail)
        with pytest.raises((MeshError, KeyboardInterrupt)) as raised:
            io.write(path, *shapes.icosphere(1))
        if isinstance(error, OSError):
            assert "No space left on device" in str(raised.value)
        assert path.read_bytes() == before


IN_CHILDREN = """
import os, resource, signal, sys, time
import numpy as np
from meshfair import io, shapes

path, kind = sys.argv[1], sys.argv[2]
old, new = shapes.icosphere(4), shapes.icosphere(5)
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)

def write_in_child(prepare):
    child = os.fork()
    if not child:
        prepare()
        try:
            io.write(path, *new)
        except io.MeshFileError as error:
            os._exit(2)
        os._exit(0)
    return child

def whole():
    V, F = io.read(path)
    which = {len(mesh[0]): (name, mesh) for name, mesh in (("old", old), ("new", new))}
    name, mesh = which[len(V)]
    assert np.array_equal(V, mesh[0]) and np.array_equal(F, mesh[1])
    return name

def kill_at(event):
    count = 0
    def hook(frame, *_):
        nonlocal count
        if count or frame.f_code.co_name == "replace_file":
            count += 1
        if count == event:
            os.kill(os.getpid(), signal.SIGKILL)
    sys.setprofile(hook)

if kind == "full":
    io.write(path, *old)
    for size in 0, 1, 1000, 100000:
        limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
        assert os.waitpid(write_in_child(limit), 0)[1] == 2 << 8
        print(whole())
if kind == "events":  # killed at each call, and at each return, of a function that writes
    old, new = shapes.icosphere(0), shapes.icosphere(1)
    for event in range(1, 1000):
        io.write(path, *old)
        status = os.waitpid(write_in_child(lambda: kill_at(event)), 0)[1]
        print(whole())
        if status == 0:
            break
if kind == "times":  # killed at any time in between
    start = time.perf_counter()
    io.write(path, *new)
    needed = time.perf_counter() - start
    for part in np.linspace(0, 1.2, 25):
        io.write(path, *old)
        child = write_in_child(lambda: None)
        time.sleep(part * needed)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        print(whole())
"""


def in_children(path, kind):
    """What the file was after each of many failures: "old" or "new", always whole."""
    answer = subprocess.run(
        [sys.executable, "-c", IN_CHILDREN, str(path), kind],
        capture_output=True,
        text=True,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
    )
    assert answer.returncode == 0, answer.stderr
    return answer.stdout.split()


def test_a_full_disk_leaves_the_old_file_and_nothing_else(folder):
    assert in_children(folder / "a.ply", "full") == ["old"] * 4


@pytest.mark.slow
def test_a_kill_leaves_the_old_file_or_the_new_one(tmp_path):
    ends = in_children(tmp_path / "a.ply", "events")
    assert len(ends) >= 50
    assert (ends[0], ends[-1]) == ("old", "new")
    assert ends == sorted(ends, reverse=True)  # never back to the old one
    ends = in_children(tmp_path / "b.ply", "times")
    assert ends.count("old") >= 3


# ---- Mutants and random bytes


def mutant(data, rng):
    """A file with one to four errors of the kinds that disks, networks and editors make."""
    data = bytearray(data)
    for _ in range(rng.integers(1, 5)):
        at = int(rng.integers(0, len(data) + 1))
        size = int(rng.choice([1, 1, 2, 5, 30]))
        kind = rng.integers(0, 9)
        if kind == 0:
            data[at : at + size] = rng.bytes(size)
        elif kind == 1:
            del data[at : at + size]
        elif kind == 2:
            data[at:at] = data[at : at + size]
        elif kind == 3:
            data[at:at] = rng.bytes(size)
        elif kind == 4:
            del data[at:]
        elif kind == 5 and at < len(data):
            data[at] ^= 1 << int(rng.integers(8))
        elif kind == 6:
            words = [b"-1", b"99", b"4294967295", b"nan", b"1e999", b" ", b"\n", b"\0", b"0", b"/"]
            data[at : at + size] = words[rng.integers(len(words))]
        elif kind == 7:
            lines = bytes(data).split(b"\n")
            i, j = rng.integers(0, len(lines), 2)
            lines[i], lines[j] = lines[j], lines[i]
            data = bytearray(b"\n".join(lines))
        elif kind == 8:
            # Within numbers: the file stays one, and its counts or indices are others.
            digits = [k for k, code in enumerate(data) if 48 <= code <= 57]
            if digits:
                data[digits[rng.integers(len(digits))]] = int(rng.integers(48, 58))
        if not data:
            data = bytearray(b"v")
    return bytes(data)


def check_mutants(folder, meshes, number, rng):
    """Read mutants of some meshes, in every format and encoding, each in a process of its own."""
    sources = []
    for k, (V, F) in enumerate(meshes):
        for ending, binary in BOTH:
            io.write(folder / f"{k}{ending}", V, F, binary=binary)
            sources.append((ending, (folder / f"{k}{ending}").read_bytes()))
    paths = []
    for k in range(number):
        ending, data = sources[k % len(sources)]
        if ending.endswith(".gz") and k % 2:  # or nearly all fail at the checksum
            data = gzip.compress(mutant(gzip.decompress(data), rng))
        else:
            data = mutant(data, rng)
        paths.append(folder / f"mutant_{k}{ending}")
        paths[-1].write_bytes(data)
    ends = mesh_files.read_apart(paths)
    for path, end in zip(paths, ends, strict=True):
        assert end["outcome"] in ("mesh", "MeshError"), (path, end)
        assert path.name in end["message"] or end["outcome"] == "mesh"
        assert end["seconds"] < mesh_files.SECONDS
        assert end["megabytes"] < mesh_files.MEGABYTES
    outcomes = [end["outcome"] for end in ends]
    assert 0.02 * number < outcomes.count("mesh") < 0.7 * number


def test_mutants_of_shapes_give_a_mesh_or_an_error(tmp_path, rng):
    meshes = [shapes.icosphere(1), shapes.box(segments=(1, 2, 1)), (mesh_files.V, mesh_files.F)]
    check_mutants(tmp_path, meshes, 500, rng)


def test_mutants_of_real_meshes_give_a_mesh_or_an_error(tmp_path, rng, mirror):
    meshes = []
    for name in "KnotMesh.ply", "f16.ply", "stanford-bunny.obj":
        V, F = io.read(mirror / name)
        used, corners = np.unique(F[:60], return_inverse=True)
        meshes.append((V[used], corners.reshape(-1, 3)))
    check_mutants(tmp_path, meshes, 200, rng)


PIECES = st.one_of(
    st.binary(max_size=20),
    st.sampled_from(
        [b"\n", b" ", b"\r", b"\0", b"#", b"\\\n", b"-1", b"1e999", b"nan", b"99", b"/"]
    ),
)


def fuzz(folder, examples):
    """Read files of random bytes, and sound ones with random bytes in some places."""

    @settings(max_examples=examples, deadline=None, database=None)
    @given(
        st.sampled_from(sorted(mesh_files.SOUND)),
        st.one_of(
            st.binary(max_size=300),
            st.lists(st.tuples(st.floats(0, 1), st.integers(0, 8), PIECES), max_size=5),
        ),
        st.booleans(),
    )
    def read_any(kind, changes, compressed):
        data = changes
        if isinstance(changes, list):
            data = mesh_files.SOUND[kind]
            for part, removed, piece in changes:
                at = int(part * len(data))
                data = data[:at] + piece + data[at + removed :]
        path = folder / (f"fuzz.{kind}.gz" if compressed else f"fuzz.{kind}")
        path.write_bytes(gzip.compress(data, 0) if compressed else data)
        try:
            V, F, attributes = read(path, attributes=True)
        except MeshError as error:
            named = path.name in str(error)
            assert named
        else:
            assert np.isfinite(V).all()
            assert len(F)
            assert F.min() >= 0
            assert F.max() < len(V)
            mesh_files.check_attributes(V, F, attributes)

    return read_any


def test_random_bytes_give_a_mesh_or_an_error(tmp_path):
    """Two seconds; as many as MESHFAIR_FUZZ_SECONDS says, with other bytes each time."""
    seconds = float(os.environ.get("MESHFAIR_FUZZ_SECONDS", 2))
    start, round_ = time.monotonic(), 0
    first = 0 if seconds <= 2 else time.time_ns()
    while time.monotonic() - start < seconds:
        seed(first + round_)(fuzz(tmp_path, examples=100))()
        round_ += 1
