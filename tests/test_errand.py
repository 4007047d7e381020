"""A person's own scan through `meshfair denoise`: better, and otherwise as it was.

Files are put together and taken apart here, byte by byte, and not by `meshfair.io`.
"""

import json
import struct
from typing import NamedTuple

import numpy as np
import pytest

from meshfair import cli, denoising, mesh, metrics, noise, shapes

GRID = np.array([448250.0, 5411940.0, 212.0])  # metres, in a country's grid


class Scan(NamedTuple):
    """A ground truth with creases, the same with noise, and denoised as a plain mesh."""

    F: np.ndarray
    truth: np.ndarray
    noisy: np.ndarray
    denoised: np.ndarray


@pytest.fixture(scope="module")
def scan():
    V, F = shapes.box((2, 1.5, 1), segments=8)
    noisy = noise.along_normals(V, F, 0.2, np.random.default_rng(4))
    noisy = noisy.astype(np.float32).astype(float)  # what an STL can hold
    return Scan(F, V, noisy, denoising.denoise(noisy, F).V)


@pytest.fixture
def errand(tmp_path, capsys):
    """Bytes into a file, the command, and what is then in the other file and on the screen."""

    def run(name, content, *words):
        (tmp_path / name).write_bytes(content)
        out = tmp_path / f"better-{name}"
        code = cli.main(["denoise", str(tmp_path / name), str(out), *words])
        said = capsys.readouterr().err
        assert code == 0, said
        assert (tmp_path / name).read_bytes() == content
        return out.read_bytes(), said

    return run


def check_as_plain(scan, V, copies, rounding):
    """The vertices, copies of the plain mesh's, are where denoising the plain mesh put these."""
    assert np.abs(V - scan.denoised[copies]).max() < rounding
    joined = np.empty_like(scan.noisy)
    joined[copies] = V
    before, plain, found = (
        (metrics.normal_angle(X, scan.truth, scan.F), np.linalg.norm(X - scan.truth))
        for X in (scan.noisy, scan.denoised, joined)
    )
    assert found == pytest.approx(plain, rel=1e-4)  # angles of faces of 0.2 by `rounding`
    assert found[0] < before[0] / 2


# Sums run in another order where vertices come in another order, which changes last digits; those
# are 1e-16 here, and a few dozen averages over a dozen faces leave them below this.
ORDER = 1e-12
SINGLE = 2**-24  # half of the last digit of a float32 between 1 and 2


def test_stl(scan, errand):
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("colour", "<u2")])
    triangles = np.zeros(len(scan.F), record)
    triangles["corners"] = scan.noisy[scan.F]
    triangles["normal"] = mesh.face_normals(scan.noisy, scan.F)
    triangles["colour"] = np.arange(len(scan.F)) % 2**15 + 2**15
    head = b"scanner 7, run 12".ljust(80) + len(scan.F).to_bytes(4, "little")
    content, said = errand("scan.stl", head + triangles.tobytes())
    assert said == ""
    assert content[:84] == head
    found = np.frombuffer(content, record, offset=84)
    assert np.array_equal(found["colour"], triangles["colour"])
    check_as_plain(scan, found["corners"].reshape(-1, 3), scan.F.ravel(), ORDER + SINGLE)
    # From float32 corners normals are off by their rounding over the width of a face, 0.1.
    plain = mesh.face_normals(scan.denoised, scan.F)
    assert np.abs(found["normal"] - plain).max() < 20 * SINGLE


VERTEX = [("x", "<f8"), ("y", "<f8"), ("z", "<f8"), ("confidence", "<f4"), ("rgb", "u1", 3)]
FACE = [("corners", "u1"), ("indices", "<u4", 3), ("part", "<i2")]


def ply(V, F, rng):
    """A photogrammetry program's PLY: confidences, colours, parts; its head, and its tables."""
    head = (
        "ply\nformat binary_little_endian 1.0\ncomment a program's, with 17 photographs\n"
        f"element vertex {len(V)}\nproperty double x\nproperty double y\nproperty double z\n"
        "property float confidence\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
        f"element face {len(F)}\nproperty list uchar uint vertex_indices\nproperty short part\n"
        "end_header\n"
    ).encode()
    vertices, faces = np.zeros(len(V), VERTEX), np.zeros(len(F), FACE)
    vertices["x"], vertices["y"], vertices["z"] = V.T
    vertices["confidence"] = rng.random(len(V))
    vertices["rgb"] = rng.integers(0, 256, (len(V), 3))
    faces["corners"], faces["indices"], faces["part"] = 3, F, rng.integers(0, 9, len(F))
    return head, vertices, faces


def denoised_ply(V, F, rng, errand):
    """The positions after the command has run, and what it said; all else has stayed."""
    head, vertices, faces = ply(V, F, rng)
    content, said = errand("scan.ply", head + vertices.tobytes() + faces.tobytes())
    table = np.frombuffer(content, VERTEX, offset=len(head), count=len(V)).copy()
    found = np.column_stack([table[axis] for axis in "xyz"])
    for axis in "xyz":
        table[axis] = vertices[axis]
    restored = content[: len(head)] + table.tobytes() + content[len(head) + table.nbytes :]
    assert restored == head + vertices.tobytes() + faces.tobytes()
    return found, said


def test_a_soup_in_ply(scan, errand, rng):
    copies = scan.F.ravel()
    soup = np.arange(scan.F.size).reshape(-1, 3)
    V, said = denoised_ply(scan.noisy[copies], soup, rng, errand)
    assert said.startswith("meshfair denoise: warning: ")
    assert "copies" in said
    assert said.count("\n") == 1
    check_as_plain(scan, V, copies, ORDER)


def test_a_coloured_ply_in_grid_coordinates(scan, errand, rng):
    V, said = denoised_ply(scan.noisy + GRID, scan.F, rng, errand)
    assert said == ""
    # The last digit of a float64 near 5,411,940 is 9e-10, of which the noise and each move of a
    # vertex are rounded to a half; a face's normal turns by as much over its width of 0.1.
    check_as_plain(scan, V - GRID, np.arange(len(V)), 1e-7)


def test_a_seamed_and_textured_obj(scan, errand, rng):
    right = scan.truth[scan.F].mean(axis=1)[:, 0] > 0.5  # of the seam
    on_seam = np.intersect1d(scan.F[right], scan.F[~right])
    copies = np.concatenate([np.arange(len(scan.noisy)), on_seam])
    F = scan.F.copy()
    F[right] = np.where(
        np.isin(F[right], on_seam), len(scan.noisy) + np.searchsorted(on_seam, F[right]), F[right]
    )
    N = mesh.vertex_normals(scan.noisy, scan.F)[copies]
    lines = ["# exported", "mtllib scan.mtl", "o scan"]
    lines += ["v " + " ".join(map(repr, x)) for x in scan.noisy[copies].tolist()]
    lines += [f"vt {u:.6f} {v:.6f}" for u, v in rng.random((F.size, 2))]
    lines += ["vn " + " ".join(map(repr, x)) for x in N.tolist()]
    for k, face in enumerate((F + 1).tolist()):
        if k == 0 or right[k] != right[k - 1]:
            lines += [f"g {'right' if right[k] else 'left'}", "usemtl skin", "s 1"]
        lines.append("f " + " ".join(f"{i}/{3 * k + c + 1}/{i}" for c, i in enumerate(face)))
    lines += ["l 1 2 3", "# the end"]
    content, said = errand("scan.obj", "\r\n".join([*lines, ""]).encode())
    assert "copies" in said
    assert said.count("\n") == 1
    found = content.decode().split("\r\n")
    assert len(found) == len(lines) + 1
    changed = {"v ": [], "vn": []}
    for old, new in zip(lines, found, strict=False):
        if old[:2] in changed:
            changed[old[:2]].append([float(word) for word in new.split()[1:]])
        else:
            assert new == old
    check_as_plain(scan, np.array(changed["v "]), copies, ORDER)
    N = mesh.vertex_normals(scan.denoised, scan.F)[copies]
    assert np.abs(np.array(changed["vn"]) - N).max() < 1e-9  # written with nine digits


KINDS = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def glb(tables, scene):
    """A GLB of tables (number of the kind, width, values) that ``scene`` tells the use of."""
    accessors, views, data = [], [], b""
    for kind, width, values in tables:
        values = np.asarray(values, KINDS[kind])
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": values.nbytes})
        accessors.append(
            {"bufferView": len(views) - 1, "componentType": kind, "count": len(values)}
            | {"type": width, "normalized": kind == 5121}
            | (
                {"min": values.min(0).tolist(), "max": values.max(0).tolist()}
                if kind == 5126
                else {}
            )
        )
        data += values.tobytes() + bytes(-values.nbytes % 4)
    whole = scene | {"accessors": accessors, "bufferViews": views}
    text = json.dumps(whole | {"buffers": [{"byteLength": len(data)}]}).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    chunks += struct.pack("<II", len(data), 0x004E4942) + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def unpacked(content):
    """The description in a GLB, and what its only mesh holds: tables by their names."""
    size = struct.unpack_from("<I", content, 12)[0]
    scene = json.loads(content[20 : 20 + size])
    data = content[28 + size :]
    (primitive,) = scene["meshes"][0]["primitives"]
    tables = {}
    for name, k in (primitive["attributes"] | {"faces": primitive["indices"]}).items():
        accessor = scene["accessors"][k]
        view = scene["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        width = WIDTHS[accessor["type"]]
        values = np.frombuffer(
            data, KINDS[accessor["componentType"]], accessor["count"] * width, start
        )
        tables[name] = values.reshape(-1, width)
    return scene, tables


def test_a_glb(scan, errand, rng):
    pytest.importorskip("trimesh")
    n = len(scan.noisy)
    content = glb(
        [
            (5126, "VEC3", scan.noisy),
            (5126, "VEC3", mesh.vertex_normals(scan.noisy, scan.F)),
            (5126, "VEC2", rng.random((n, 2))),
            (5121, "VEC4", rng.integers(0, 256, (n, 4))),
            (5125, "SCALAR", scan.F.reshape(-1, 1)),
        ],
        {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "name": "statue"}],
            "meshes": [
                {
                    "name": "statue",
                    "primitives": [
                        {
                            "attributes": {
                                "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "COLOR_0": 3
                            },
                            "indices": 4,
                            "material": 0,
                        }
                    ],
                }
            ],
            "materials": [
                {"name": "skin", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 1, 1]}}
            ],
        },
    )  # fmt: skip
    found, said = errand("scan.glb", content)
    assert said == ""
    (_, old), (after, new) = unpacked(content), unpacked(found)
    check_as_plain(scan, new["POSITION"], np.arange(n), ORDER + SINGLE)
    N = mesh.vertex_normals(scan.denoised, scan.F)
    assert np.abs(new["NORMAL"] - N).max() < 20 * SINGLE
    assert set(new) == set(old)
    for name in ("COLOR_0", "faces"):
        assert np.array_equal(new[name], old[name])
    # trimesh has 1 - v for v, there and back in single precision.
    assert np.abs(new["TEXCOORD_0"] - old["TEXCOORD_0"]).max() <= SINGLE
    (skin,) = after["materials"]
    assert skin["name"] == "skin"
    color = skin["pbrMetallicRoughness"]["baseColorFactor"]
    assert color == pytest.approx([0.5, 0.25, 1, 1], abs=0.5 / 255)  # trimesh keeps it in bytes
    assert [node["name"] for node in after["nodes"] if "mesh" in node] == ["statue"]
