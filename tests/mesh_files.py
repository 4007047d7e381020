"""A corpus of mesh files, sound, odd and malformed, made here byte by byte; and a safe reader.

The corpus does not use `meshfair.io.write`, so that an error of the writer and
one of the reader cannot hide each other. Run as a program, the module reads
files, in processes with limits on time and memory; see
`read_apart`.
"""

import bz2
import functools
import gzip
import io
import json
import lzma
import os
import resource
import signal
import struct
import subprocess
import sys
import time
import warnings
import zipfile
import zlib

import numpy as np

# A pyramid over a square, with one vertex that no face uses. All coordinates
# are exact in float32 and short as text.
V = np.array(
    [
        [0.0, 0.0, 0.0],
        [2.0, 0.0, 0.125],
        [2.0, 2.5, 0.0],
        [0.0, 2.0, -0.5],
        [1.0, 1.0, 3.0],
        [1.0078125, -7.0, 0.25],
    ]
)
WHOLE = np.trunc(2 * V) + 0.0  # no negative zero
SQUARE = [0, 3, 2, 1]
SIDES = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
POLYGONS = [SQUARE, *SIDES]
F = np.array([[0, 3, 2], [0, 2, 1], *SIDES])
N, M = len(V), len(F)

SECONDS, MEGABYTES = 5, 200  # what a file may take, however bad it is


def text(pattern, rows):
    return "".join(pattern % tuple(row) for row in rows)


def obj(V=V, faces=F, vertex="v %r %r %r\n", corner="%d"):
    lines = ["f " + " ".join(corner.replace("%d", str(i + 1)) for i in face) for face in faces]
    return text(vertex, np.asarray(V).tolist()) + "\n".join(lines) + "\n"


def polygons(faces):
    return "".join(f"{len(face)} {' '.join(map(str, face))}\n" for face in faces)


def off(V=V, faces=F, keyword="OFF\n", counts=None):
    counts = counts or f"{len(V)} {len(faces)} 0"
    return f"{keyword}{counts}\n" + text("%r %r %r\n", np.asarray(V).tolist()) + polygons(faces)


def header(
    encoding="ascii",
    vertices=N,
    faces=M,
    lists="uchar int vertex_indices",
    coordinate="float",
    before_vertex="",
    after_vertex="",
    before_face="",
    after_face="",
    face="face",
):
    """A PLY header; the four additions are whole lines."""
    return (
        f"ply\nformat {encoding} 1.0\n{before_vertex}element vertex {vertices}\n"
        + "".join(f"property {coordinate} {axis}\n" for axis in "xyz")
        + f"{after_vertex}element {face} {faces}\n{before_face}property list {lists}\n{after_face}"
        + "end_header\n"
    )


def ply(V=V, faces=F, **changes):
    changes = {"vertices": len(V), "faces": len(faces)} | changes
    return header(**changes) + text("%r %r %r\n", np.asarray(V).tolist()) + polygons(faces)


CODES = dict(
    zip(
        ["char", "uchar", "short", "ushort", "int", "uint", "float", "double", "int64", "uint64"],
        "bBhHiIfdqQ",
        strict=True,
    )
)
ORDERS = {"<": "binary_little_endian", ">": "binary_big_endian"}


def packed(order, types, *values):
    return struct.pack(order + "".join(CODES[name] for name in types.split()), *values)


def ply_binary(order="<", V=V, faces=F, length="uchar", index="int", coordinate="float", **changes):
    changes = {"vertices": len(V), "faces": len(faces)} | changes
    lists = f"{length} {index} vertex_indices"
    head = header(ORDERS[order], coordinate=coordinate, lists=lists, **changes)
    body = b"".join(packed(order, f"{coordinate} " * 3, *row) for row in np.asarray(V).tolist())
    return head.encode() + body + face_rows(order, faces, length, index)


def face_rows(order, faces, length="uchar", index="int"):
    return b"".join(
        packed(order, length, len(face)) + packed(order, f"{index} " * len(face), *map(int, face))
        for face in faces
    )


FACET = "facet normal %s\n  outer loop\n%s  endloop\nendfacet\n"


def stl(V=V, F=F, normal="0 0 1", name="pyramid"):
    corners = [text("    vertex %r %r %r\n", V[face].tolist()) for face in F]
    return f"solid {name}\n" + "".join(FACET % (normal, c) for c in corners) + f"endsolid {name}\n"


def stl_binary(V=V, F=F, title=b"pyramid", announced=None, attribute=0, normal=(0, 0, 1)):
    records = b"".join(
        struct.pack("<12fH", *normal, *V[face].ravel().tolist(), attribute) for face in F
    )
    count = len(F) if announced is None else announced
    return title.ljust(80, b"\0") + struct.pack("<I", count) + records


def zipped(data):
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("mesh.obj", data)
    return archive.getvalue()


RANDOM = np.random.default_rng(6).integers(0, 256, 5000, np.uint8).tobytes()
HTML = b"\n<!DOCTYPE html>\n<html><body><h1>404 Not Found</h1></body></html>\n"
LFS = b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a21\nsize 12345\n"

SOUND = {
    "obj": obj().encode(),
    "off": off().encode(),
    "ply": ply().encode(),
    "little.ply": ply_binary("<"),
    "big.ply": ply_binary(">"),
    "stl": stl().encode(),
    "binary.stl": stl_binary(),
}


def changed(data, old, new):
    """The data with the first ``old`` replaced, which has to be there."""
    old, new = (s if isinstance(s, bytes) else s.encode() for s in (old, new))
    assert old in data, old
    return data.replace(old, new, 1)


def malformed():
    """Files that have to be refused: a dict from name to bytes."""
    files = {}
    for kind, data in SOUND.items():
        ending = kind.split(".")[-1]
        for name, content in {
            "empty": b"",
            "blanks": b" \t\n\n",
            "many_blanks": b" \t\n" * 300_000,
            "one_long_line": b"x" * 1_000_000,
            "html": HTML,
            "lfs": LFS,
            "json": b'{"vertices": [[0, 0, 0]]}\n',
            "gzip": gzip.compress(data),
            "bzip2": bz2.compress(data),
            "xz": lzma.compress(data),
            "zip": zipped(data),
            "random": RANDOM,
            "zeros": bytes(3000),
            "prose": b"This is not a mesh.\nIt was never one.\n",
            "utf16": data.decode("latin-1").encode("utf-16"),
            "named_like_another": SOUND["obj" if ending != "obj" else "ply"],
        }.items():
            files[f"{name}.{ending}"] = content
        for part in 0.15, 0.5, 0.8, 0.97:
            files[f"cut_{part}.{kind}"] = data[: int(part * len(data))]
        files[f"cut_by_the_last_line.{kind}"] = data.rstrip()[
            : -len(data.rstrip().split(b"\n")[-1])
        ]
        files[f"longer.{kind}"] = data + data[len(data) // 2 :]
        files[f"twice.{kind}"] = data + data
        files[f"trailing_words.{kind}"] = data + b"and so on\n"
        files[f"with_zeros_behind.{kind}"] = data + bytes(1000)
    # An OBJ has no end, so some of these are whole.
    for name in "cut_0.8", "cut_by_the_last_line", "longer", "twice":
        del files[f"{name}.obj"]
    files["twice.stl"] = files.pop("longer.stl")  # two solids are a file
    del files["cut_by_the_last_line.binary.stl"]  # one line only

    text_coordinates = {
        "nan": "nan",
        "inf": "-inf",
        "overflow": "1e999",
        "huge": "1e300",
        "word": "two",
        "underscore": "2_5",
        "hexadecimal": "0x10",
        "comma": "2,5",
        "two_points": "2.5.5",
        "glued": "2.5-3",
        "fortran": "2.5d0",
        "unit": "2.5mm",
        "nul": "2.\0005",
        "nothing": "",
        "one_more": "2.5 2.5",
        "nbsp": "2.5\u00a07",
    }
    for kind in "obj", "off", "ply", "stl":
        for name, value in text_coordinates.items():
            files[f"coordinate_{name}.{kind}"] = changed(SOUND[kind], "2.5", value)
    del files["coordinate_one_more.obj"]  # x y z w

    # How C prints on Windows what is no number; and what is a comment only after a blank.
    for kind in "obj", "off", "ply", "stl":
        for name in "QNAN", "IND", "INF", "SNAN", "foo":
            for sign in "", "-":
                word = f"{sign}1.#{name}"
                files[f"coordinate_{word}.{kind}"] = changed(SOUND[kind], "2.5", word)
        files[f"coordinate_glued_comment.{kind}"] = changed(SOUND[kind], "2.5 ", "2.5# ")
    for kind in "obj", "off":
        files[f"index_glued_comment.{kind}"] = SOUND[kind].replace(b"2 3 5", b"2 3 5#1")
        files[f"comments_glued.{kind}"] = b"#1\n".join(SOUND[kind].split(b"\n"))
    files["index_glued_comment.off"] = changed(SOUND["off"], "3 1 2 4", "3 1 2 4#1")
    for kind in "ply", "stl":
        files[f"comment_lines.{kind}"] = SOUND[kind].replace(b"2.5", b"2.5 # half\n")
        files[f"comment_first.{kind}"] = b"# 1\n" + SOUND[kind]
        files[f"comment_last.{kind}"] = SOUND[kind] + b"# 1\n"

    indices = {
        "too_large": "98",
        "just_too_large": str(N),
        "huge": "99999999999999999999999999",
        "negative": "-1",
        "very_negative": "-99999999999999999999999999",
        "fraction": "1.5",
        "word": "one",
        "nan": "nan",
        "inf": "inf",
        "underscore": "0_1",
        "hexadecimal": "0x1",
        "plus": "+",
        "minus": "- 1",
    }
    for kind in "off", "ply":
        for name, value in indices.items():
            files[f"index_{name}.{kind}"] = changed(SOUND[kind], "3 1 2 4", f"3 1 {value} 4")
        for name, row in {
            "length_too_large": "4 1 2 4",
            "length_too_small": "2 1 2 4",
            "length_negative": "-3 1 2 4",
            "length_minus_one": "-1 1 2 4",
            "length_huge": "99999999999999999999 1 2 4",
            "length_fraction": "3.5 1 2 4",
            "two_corners": "2 1 2",
            "one_corner": "1 2",
            "no_corner": "0",
            "two_more": "3 1 2 4 5 5",
            "four_more": "3 1 2 4 5 5 5 5 5",
        }.items():
            files[f"face_{name}.{kind}"] = changed(SOUND[kind], "3 1 2 4", row)
        files[f"last_index_plus.{kind}"] = SOUND[kind].rstrip()[:-1] + b"+"
    files["last_index_plus.obj"] = SOUND["obj"].rstrip()[:-1] + b"+"
    del files["face_length_too_small.off"]  # an edge with a colour: refused for its two corners
    files["face_length_too_small.off"] = changed(SOUND["off"], "3 1 2 4", "2 1 2 4")
    for name, value in indices.items():
        if name not in ("just_too_large", "negative"):
            files[f"index_{name}.obj"] = changed(SOUND["obj"], "f 2 3 5", f"f 2 {value} 5")
    for name, row in {
        "just_too_large": f"f 2 {N + 1} 5",
        "zero": "f 2 0 5",
        "negative_too_far": f"f 2 -{N + 1} 5",
        "two_corners": "f 2 3",
        "one_corner": "f 2",
        "no_corner": "f",
        "letter_in_texture": "f 2/a/1 3/a/1 5/a/1",
        "letter_in_normal": "f 2//a 3//1 5//1",
        "four_parts": "f 2/1/1/1 3/1/1/1 5/1/1/1",
        "no_vertex": "f /1/1 3/1/1 5/1/1",
        "fraction_with_texture": "f 2.5/1 3/1 5/1",
        "backslash_at_blank": "f 2 3 \\ 5",
        "comma": "f 2,3,5",
    }.items():
        files[f"index_{name}.obj"] = changed(SOUND["obj"], "f 2 3 5", row)
    for name, row in {
        "two_values": "v 1 2",
        "no_values": "v",
        "five_values": "v 1 2 3 4 5",
        "nine_values": "v 1 2 3 4 5 6 7 8 9",
        "word_as_colour": "v 1 2 3 red green blue",
        "keyword_glued": "v1 2 3",
        "unknown_keyword": "vertex 1 2 3",
        "upper_case_keyword": "V 1 2 3",
        "number_as_keyword": "1 2 3",
        "rubbish": "\x01\x02\x7f",
        "long_line": "x" * 100000,
    }.items():
        files[f"line_{name}.obj"] = changed(SOUND["obj"], "f 2 3 5", row + "\nf 2 3 5")
    files["no_faces.obj"] = obj(faces=[]).encode()
    files["no_vertices.obj"] = obj(V=[]).encode()
    files["only_comments.obj"] = b"# nothing\n# here\n"
    files["only_names.obj"] = b"mtllib a.mtl\no thing\n"
    files["negative_before_vertices.obj"] = b"f -1 -2 -3\n" + obj(faces=[]).encode()
    files["lost_vertex.obj"] = changed(SOUND["obj"], "v 1.0078125 -7.0 0.25\n", "")
    files["lost_vertex.obj"] = changed(files["lost_vertex.obj"], "f 1 2 5", "f 1 2 6")

    for name, counts in {
        "more_vertices": f"{N + 1} {M} 0",
        "fewer_vertices": f"{N - 1} {M} 0",
        "more_faces": f"{N} {M + 1} 0",
        "fewer_faces": f"{N} {M - 1} 0",
        "one_moved": f"{N + 1} {M - 1} 0",
        "one_moved_back": f"{N - 1} {M + 1} 0",
        "two_billion_faces": f"{N} {2**31} 0",
        "endless_vertices": f"{10**30} {M} 0",
        "many_digits": "9" * 5000 + " 5 0",
        "negative": f"{N} -{M} 0",
        "fraction": f"{N}.5 {M} 0",
        "word": f"{N} faces 0",
        "two_only": f"{N} {M}",
        "none": "",
        "four": f"{N} {M} 0 0",
        "zero_faces": f"{N} 0 0",
        "zero": "0 0 0",
    }.items():
        files[f"counts_{name}.off"] = off(counts=counts or "\n").encode()
    for keyword in "OF\n", "PFF\n", "nOFF\n3\n", "OFF BINARY\n", "OFFX\n", "COFF\n", "NOFF\n":
        files[f"keyword_{keyword.split()[0]}_{len(keyword)}.off"] = off(keyword=keyword).encode()
    files["no_faces.off"] = off(faces=[]).encode()
    files["no_vertices.off"] = off(V=np.zeros((0, 3))).encode()
    files["four_coordinates.off"] = off(keyword="4OFF\n").encode()
    files["fourth_coordinate_not_one.off"] = (
        f"4OFF\n{N} {M} 0\n" + text("%r %r %r 2\n", V.tolist()) + polygons(F)
    ).encode()

    bad_headers = {
        "no_end": ("end_header\n", ""),
        "no_format": ("format ascii 1.0\n", ""),
        "two_formats": ("format ascii 1.0\n", "format ascii 1.0\nformat ascii 1.0\n"),
        "unknown_format": ("format ascii", "format binary_middle_endian"),
        "version": ("ascii 1.0", "ascii 2.0"),
        "no_version": ("ascii 1.0", "ascii"),
        "unknown_type": ("property float y", "property real y"),
        "unknown_length_type": ("list uchar", "list byte"),
        "length_is_float": ("list uchar", "list float"),
        "no_z": ("property float z\n", ""),
        "x_twice": ("property float y", "property float x"),
        "z_is_a_list": ("property float z", "property list uchar float z"),
        "no_list": ("property list uchar int vertex_indices\n", ""),
        "list_of_another_name": ("vertex_indices", "corners"),
        "indices_are_no_list": ("list uchar int", "int"),
        "no_vertex_element": ("element vertex", "element point"),
        "no_face_element": ("element face", "element polygon"),
        "vertex_element_twice": ("element face", "element vertex"),
        "negative_count": (f"face {M}", f"face -{M}"),
        "fraction_as_count": (f"face {M}", f"face {M}.0"),
        "word_as_count": (f"face {M}", "face many"),
        "no_count": (f"face {M}", "face"),
        "superscript_as_count": (f"face {M}", "face \u00b2"),
        "property_first": (f"element vertex {N}\nproperty", "property"),
        "unknown_line": ("end_header", "elements 2\nend_header"),
        "more_vertices": (f"vertex {N}", f"vertex {N + 1}"),
        "fewer_vertices": (f"vertex {N}", f"vertex {N - 1}"),
        "more_faces": (f"face {M}", f"face {M + 1}"),
        "fewer_faces": (f"face {M}", f"face {M - 1}"),
        "no_faces": (f"face {M}", "face 0"),
        "no_vertices": (f"vertex {N}", "vertex 0"),
        "two_billion_faces": (f"face {M}", f"face {2**31}"),
        "two_billion_vertices": (f"vertex {N}", f"vertex {2**31}"),
        "endless_faces": (f"face {M}", f"face {10**18}"),
        "endless_vertices": (f"vertex {N}", f"vertex {10**30}"),
        "many_digits": (f"face {M}", "face " + "9" * 5000),
        "endless_others": ("element face", f"element extra {2**40}\nproperty char c\nelement face"),
        "endless_lists": (
            "element face",
            f"element extra {2**40}\nproperty list uchar int c\nelement face",
        ),
        "other_byte_order": ("little", "big"),
        "text_instead_of_binary": ("binary_little_endian", "ascii"),
        "binary_instead_of_text": ("ascii", "binary_little_endian"),
        "wrong_first_line": ("ply\n", "plx\n"),
        "upper_case_first_line": ("ply\n", "PLY\n"),
        "words_in_first_line": ("ply\n", "ply file\n"),
        "strips": (
            f"element face {M}\nproperty list uchar int vertex_indices",
            "element tristrips 1\nproperty list int int strip",
        ),
    }
    for kind in "ply", "little.ply", "big.ply":
        for name, (old, new) in bad_headers.items():
            # Each encoding has its own name in the file, and little is not big.
            encoding = {"ply": "ascii"}.get(kind, f"binary_{kind.split('.')[0]}_endian")
            old, new = (s.replace("format ascii", f"format {encoding}") for s in (old, new))
            old, new = (s.replace("ascii 1.0", f"{encoding} 1.0") for s in (old, new))
            new = new.replace("ascii 2.0", f"{encoding} 2.0")
            if old.encode() in SOUND[kind]:
                files[f"header_{name}.{kind}"] = changed(SOUND[kind], old, new)
    files["points.ply"] = (header().split("element face")[0] + "end_header\n").encode()
    files["points.ply"] += text("%r %r %r\n", V.tolist()).encode()
    files["many_comments.ply"] = header().split("end_header")[0].encode() + b"comment\n" * 50_000
    many = "".join(f"property uchar p{k}\n" for k in range(20_000))
    for encoding in "ascii", *ORDERS.values():
        files[f"many_properties_{encoding}.ply"] = header(encoding, after_vertex=many).encode()
        files[f"many_elements_{encoding}.ply"] = (
            header(encoding).split("end_header")[0]
            + "".join(f"element e{k} {2**40}\nproperty int i\n" for k in range(20_000))
            + "end_header\n"
        ).encode()
    files["escape_in_name.ply"] = changed(
        SOUND["ply"], "element face", "element \33[31m 5\nproperty int \33\nelement face"
    )
    files["braces_in_name.ply"] = changed(
        SOUND["ply"], "element face", "element {x} 5\nproperty int {0}\nelement face"
    )
    braces = changed(files["braces_in_name.ply"], "{x} 5", "{x} 1")
    files["braces_in_row.ply"] = changed(braces, "3 0 3 2", "1 2 3\n3 0 3 2")
    files["nul_in_name.ply"] = changed(
        SOUND["big.ply"], "element face", "element \0 5\nproperty int \0\nelement face"
    )
    strip = ply_binary(faces=[[0, 1, 1]], index="float", face="tristrips")
    files["strip_fraction_float.ply"] = strip[:-4] + packed("<", "float", 1.5)
    for name, strips in {
        "two": "2 0 1",
        "of_breaks": "4 -1 -1 -1 -1",
        "too_large": f"3 0 1 {N}",
        "negative": "4 0 1 2 -2",
        "fraction": "3 0 1 1.5",
    }.items():
        head = header(face="tristrips", faces=1).encode()
        files[f"strip_{name}.ply"] = head + text("%r %r %r\n", V.tolist()).encode()
        files[f"strip_{name}.ply"] += strips.encode() + b"\n"
    files["only_ply.ply"] = b"ply\n"
    files["only_header.ply"] = header().encode()
    files["row_short.ply"] = changed(SOUND["ply"], "2.0 2.5 0.0\n", "2.0 2.5\n")
    files["row_long.ply"] = changed(SOUND["ply"], "2.0 2.5 0.0\n", "2.0 2.5 0.0 7\n")
    files["row_moved.ply"] = changed(files["row_short.ply"], "3 1 2 4\n", "3 1 2 4 5\n")
    files["fractions_as_integers.ply"] = ply(coordinate="int").encode()

    for order, word in ("<", "little"), (">", "big"):
        for value in "nan", "-inf", "1e300":
            bad = V.copy()
            bad[2, 1] = float(value)
            files[f"coordinate_{value}_{word}.ply"] = ply_binary(order, V=bad, coordinate="double")
            if value != "1e300":
                files[f"short_coordinate_{value}_{word}.ply"] = ply_binary(order, V=bad)
        signalling = packed(order, "uint", 0x7F800001)
        files[f"coordinate_signalling_{word}.ply"] = changed(
            ply_binary(order), packed(order, "float", 2.5), signalling
        )
        for value in N, 98, -1, -(2**31), 2**31 - 1:
            bad = F.copy()
            bad[3, 1] = value
            files[f"index_{value}_{word}.ply"] = ply_binary(order, faces=bad)
        bad = [[0, 1, 2**64 - 1], *F[1:].tolist()]
        files[f"index_uint64_{word}.ply"] = ply_binary(order, faces=bad, index="uint64")
        for index in "float", "double":
            for value in 1.5, float("nan"), float("inf"), 1e30:
                body = packed(order, "uchar", 3) + packed(order, f"{index} " * 3, 0, 1, value)
                lists = f"uchar {index} vertex_indices"
                data = header(ORDERS[order], faces=1, lists=lists).encode()
                data += b"".join(packed(order, "float float float", *row) for row in V.tolist())
                files[f"index_{value}_{index}_{word}.ply"] = data + body
        for length, value in (
            ("char", -3),
            ("int", -1),
            ("int", 2**31 - 1),
            ("uint", 2**32 - 1),
            ("int64", -(2**63)),
            ("int64", 2**62),
            ("uint64", 2**64 - 1),
            ("uchar", 200),
            ("uchar", 2),
            ("uchar", 0),
        ):
            for row in 0, 3:
                data = ply_binary(order, length=length)
                size = struct.calcsize(CODES[length])
                at = len(data) - (M - row) * (size + 12)
                data = data[:at] + packed(order, length, value) + data[at + size :]
                files[f"length_{length}_{value}_row_{row}_{word}.ply"] = data
        for faces, name in ([SQUARE, [1, 2], *SIDES], "edge"), ([[3], *POLYGONS], "point"):
            files[f"face_is_{name}_{word}.ply"] = ply_binary(order, faces=faces)
        files[f"edges_only_{word}.ply"] = ply_binary(order, faces=[[0, 1], [1, 2], [2, 3]])
        mixed = ply_binary(order, faces=POLYGONS)
        files[f"mixed_cut_{word}.ply"] = mixed[:-3]
        files[f"mixed_longer_{word}.ply"] = mixed + b"\1\2\3"
        files[f"mixed_more_{word}.ply"] = changed(mixed, "face 5", "face 6")
        files[f"bytes_as_line_ends_{word}.ply"] = changed(
            ply_binary(order), packed(order, "float", 2.5), b"\r\n"
        )

    one_triangle = stl(F=F[:1])
    for name, (old, new) in {
        "no_endsolid": ("endsolid pyramid\n", ""),
        "no_endfacet": ("endfacet", ""),
        "no_endloop": ("endloop", ""),
        "no_outer_loop": ("outer loop", ""),
        "no_normal": ("normal 0 0 1", ""),
        "two_vertices": ("    vertex 0.0 2.0 -0.5\n", ""),
        "four_vertices": ("    vertex 0.0 2.0 -0.5\n", "    vertex 0.0 2.0 -0.5\n" * 2),
        "no_solid": ("solid pyramid\n", ""),
        "words_between": ("facet", "next\nfacet"),
        "keyword_misspelt": ("vertex", "vertx"),
        "facets_joined": ("endfacet", "endfacetfacet"),
        "no_facets": (one_triangle.split("\n", 1)[1].split("endsolid")[0], ""),
        "infinite": ("0.0 2.0", "0.0 inf"),
        "not_a_number": ("0.0 2.0", "0.0 nan"),
    }.items():
        files[f"facet_{name}.stl"] = changed(one_triangle.encode(), old, new)
    for name, announced in {
        "one_more": M + 1,
        "one_less": M - 1,
        "none": 0,
        "four_billion": 2**32 - 1,
        "two_billion": 2**31,
    }.items():
        files[f"announced_{name}.stl"] = stl_binary(announced=announced)
        files[f"announced_{name}_solid.stl"] = stl_binary(announced=announced, title=b"solid x")
    files["announced_all_blanks.stl"] = b" " * 80 + b"\xff" * 4
    files["announced_none_whole.stl"] = stl_binary(F=F[:0])
    files["header_only.stl"] = b"short header"
    for value in np.nan, np.inf, -np.inf:
        bad = V.copy()
        bad[2, 1] = value
        files[f"coordinate_{value}_binary.stl"] = stl_binary(V=bad)
    files["coordinate_signalling.stl"] = changed(
        stl_binary(), struct.pack("<f", 2.5), struct.pack("<I", 0x7F800001)
    )

    for kind, data in SOUND.items():
        compressed = gzip.compress(data, mtime=0)
        files[f"gzip_cut.{kind}.gz"] = compressed[: len(compressed) // 2]
        files[f"gzip_without_checksum.{kind}.gz"] = compressed[:-8]
        files[f"gzip_wrong_checksum.{kind}.gz"] = compressed[:-8] + b"12345678"
        files[f"gzip_damaged.{kind}.gz"] = (
            compressed[:40] + bytes([compressed[40] ^ 255]) + compressed[41:]
        )
        files[f"gzip_rubbish_behind.{kind}.gz"] = compressed + b"rubbish"
        files[f"gzip_not.{kind}.gz"] = data
        files[f"gzip_empty.{kind}.gz"] = b""
        files[f"gzip_of_nothing.{kind}.gz"] = gzip.compress(b"")
        files[f"gzip_twice.{kind}.gz"] = gzip.compress(compressed)
        files[f"gzip_of_html.{kind}.gz"] = gzip.compress(HTML)
    files["zip.obj.gz"] = zipped(SOUND["obj"])
    for ending in "obj", "off", "ply", "stl":
        files[f"bomb.{ending}.gz"] = bomb()
        files[f"unknown_ending.{ending}x"] = SOUND[ending]
        files[f"no_ending_{ending}"] = SOUND[ending]
        files[f"other_ending.{ending}.txt"] = SOUND[ending]
        files[f"gzip_in_the_middle.gz.{ending}"] = gzip.compress(SOUND[ending])
    files["only_gzip.gz"] = gzip.compress(SOUND["obj"])
    return files


@functools.cache
def bomb(megabytes=100):
    """About a kilobyte for each megabyte that comes out."""
    packer = zlib.compressobj(wbits=31)
    blanks = b" " * (1 << 20)
    return b"".join(packer.compress(blanks) for _ in range(megabytes)) + packer.flush()


TRIANGLES = V, F
# What every reader should make of POLYGONS: fans from the first corner.
FANS = V, np.array([[0, 3, 2], [0, 2, 1], *SIDES])


def soup(V=V, F=F):
    """What an STL file holds: three vertices for each triangle."""
    return V[F].reshape(-1, 3), np.arange(3 * len(F)).reshape(-1, 3)


def odd():
    """Sound but odd files: a dict from name to bytes, vertices and faces."""
    files = {}

    def add(name, data, mesh=TRIANGLES):
        data = data if isinstance(data, bytes) else data.encode()
        files[name] = (data, *(soup(*mesh) if ".stl" in name.lower() else mesh))

    for kind, data in SOUND.items():
        add(f"sound.{kind}", data)
        add(f"UPPER.{kind.upper()}", data)
        add(f"sp ace.{kind}", data)
        add(f"n\u00e4me \u2603.{kind}", data)
        add(f"two.dots.{kind}", data)
        add(f"packed.{kind}.gz", gzip.compress(data))
        add(f"Packed.{kind}.GZ", gzip.compress(data, 1))
        half = len(data) // 2
        add(f"two_members.{kind}.gz", gzip.compress(data[:half]) + gzip.compress(data[half:]))
    for kind in "obj", "off", "ply", "stl":
        data = SOUND[kind]
        add(f"bom.{kind}", b"\xef\xbb\xbf" + data)
        add(f"crlf.{kind}", data.replace(b"\n", b"\r\n"))
        add(f"lone_cr.{kind}", data.replace(b"\n", b"\r"))
        add(f"bom_crlf.{kind}", b"\xef\xbb\xbf" + data.replace(b"\n", b"\r\n"))
        for k in range(3):
            lines = data.split(b"\n")
            mixed = [line + [b"\n", b"\r\n", b"\r"][(i + k) % 3] for i, line in enumerate(lines)]
            add(f"mixed_ends_{k}.{kind}", b"".join(mixed))
        add(f"no_last_end.{kind}", data.rstrip())
        add(f"many_last_ends.{kind}", data + b"\n \n\t\n\n")
        add(f"trailing_blanks.{kind}", data.replace(b"\n", b" \t \n"))
        add(f"tabs.{kind}", data.replace(b" ", b"\t"))
        add(f"many_blanks.{kind}", data.replace(b" ", b"   \t "))
        add(f"blank_lines.{kind}", data.replace(b"\n", b"\n\n \n"))
        add(f"indented.{kind}", data.replace(b"\n", b"\n   "))
        add(f"exponents.{kind}", data.replace(b"2.5 ", b"+25.E-1 ").replace(b"-7.0", b"-.7e+01"))
        add(f"leading_zeros.{kind}", data.replace(b" 2.5 ", b" 0002.5000 "))
    for kind in "obj", "off":
        data = SOUND[kind]
        lines = data.split(b"\n")
        add(f"comment_lines.{kind}", b"# v 9 9 9\n" + b"\n# 3 0 1 2\n".join(lines))
        add(f"comments_behind.{kind}", b" # f 1 2 3\n".join(lines))
        add(f"comment_latin.{kind}", b"# M\xfcller, \xd1\n" + data)
        add(f"comment_ends_with_backslash.{kind}", b"\n".join(b"# C:\\\n" + x for x in lines))
        add(f"long_comment.{kind}", b"# " + b"x" * 100000 + b"\n" + data)
    vertices, faces = obj(faces=[]).rstrip("\n") + "\n", obj(V=[])
    add("faces_first.obj", faces + vertices)
    for name, corner in {
        "texture": "%d/1",
        "texture_and_normal": "%d/2/3",
        "normal": "%d//3",
        "empty_texture": "%d/",
        "empty_both": "%d//",
        "negative_texture": "%d/-1/-2",
    }.items():
        add(f"corners_{name}.obj", obj(corner=corner).replace("f", "vt 0 0\nvn 0 0 1\nf", 1))
    mixed = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1 2/1 3//1\nf 1/1/1 3/1/1 2/1/1\n"
    three = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    add("corners_mixed.obj", mixed, (three, np.array([[0, 1, 2], [0, 2, 1]])))
    negative = "".join(f"f {' '.join(str(i - N) for i in face)}\n" for face in F)
    add("negative.obj", vertices + negative)
    add(
        "negative_with_normals.obj",
        vertices + negative.replace(" -", " -").replace("-2", "-2/-1/-1"),
    )
    patches = "".join(text("v %r %r %r\n", V[face].tolist()) + "f -3 -2 -1\n" for face in F)
    add("negative_in_patches.obj", patches, soup())
    add(
        "negative_and_positive.obj",
        vertices + "f 1 -3 3\nf -6 3 -5\n" + "".join(faces.splitlines(True)[2:]),
    )
    add("fourth_coordinate.obj", obj(vertex="v %r %r %r 1.0\n"))
    add("fourth_coordinate_of_some.obj", changed(SOUND["obj"], "2.5 0.0", "2.5 0.0 1"))
    add("colours.obj", obj(vertex="v %r %r %r 0.5 0.25 1\n"))
    add("colours_as_integers.obj", obj(vertex="v %r %r %r 255 0 17\n"))
    add("colours_with_alpha.obj", obj(vertex="v %r %r %r 0.5 0.25 1 0.5\n"))
    add("continued.obj", SOUND["obj"].replace(b" ", b" \\\n "))
    add("continued_crlf.obj", SOUND["obj"].replace(b" ", b" \\\r\n "))
    add("continued_last.obj", SOUND["obj"].rstrip() + b" \\\n")
    rest = "g a b\no pyramid\ns off\nusemtl red#1\nmtllib a.mtl\nvn 0 0 1\nvt 0 0\nvp 1\n"
    rest += "l 1 2\np 1\nt crease 1/1/0 0 1 2\nvw 0 0 1\n"
    add("other_statements.obj", rest + vertices + rest + faces + rest)
    add("between_every_line.obj", "".join(line + rest for line in obj().splitlines(True)))
    add("surface.obj", "cstype bezier\ndeg 3 3\ncurv2 1 2\nparm u 0 1\nend\n" + obj())
    add("quads.obj", obj(faces=POLYGONS), FANS)
    add("quads_with_textures.obj", obj(faces=POLYGONS, corner="%d/1/1") + "vt 0 0\n", FANS)
    ring = np.array([[np.cos(t), np.sin(t), 0.5] for t in range(40)])
    disc = ring, np.array([[0, k, k + 1] for k in range(1, 39)])
    add("polygon.obj", obj(ring, [list(range(40))]), disc)
    add("degenerate.obj", obj(faces=[[0, 0, 1], [1, 1, 1], *F]), (V, [[0, 0, 1], [1, 1, 1], *F]))
    add("duplicates.obj", obj(faces=[*F, *F]), (V, [*F, *F]))
    add("one_triangle.obj", obj(three, [[0, 1, 2]]), (three, [[0, 1, 2]]))
    add("far_away.obj", obj(V * 1e30), (V * 1e30, F))
    tiny = V * 5e-324
    add("denormal.obj", obj(tiny), (tiny, F))
    precise = V + np.pi * 1e-3
    add("seventeen_digits.obj", obj(precise), (precise, F))
    add("minus_zero.obj", obj(V * -1.0), (V * -1.0, F))

    plain = text("%r %r %r\n", V.tolist())
    add("no_keyword.off", off(keyword=""))
    add("one_line_header.off", off(keyword="OFF "))
    add("no_blank_after_keyword.off", off(keyword="OFF"))
    add("lower_case.off", off(keyword="off\n"))
    add("everything_in_one_line.off", off().replace("\n", " "))
    add("everything_in_one_line_glued.off", off(keyword="OFF").replace("\n", " "))
    add("every_word_a_line.off", off().replace(" ", "\n\n"))
    add("header_in_lines.off", off(counts=f"{N}\n# faces:\n{M}\n\n0"))
    add("edges_counted.off", off(counts=f"{N} {M} 11"))
    add("wrong_edges.off", off(counts=f"{N} {M} 99"))
    for name, columns in {
        "COFF": " 0.5 0.25 1 1",
        "C_OFF_RGB": " 255 0 17",
        "NOFF": " 0 0 1",
        "CNOFF": " 0 0 1 255 0 17 255",
        "STOFF": " 0.5 0.5",
        "STCNOFF": " 0 0 1 1 1 0 1 0.5 0.5",
        "NCSTOFF": " 1 1 0 1 0 0 1 0.5 0.5",
        "4OFF": " 1",
        "OFF_colours": " 255 0 17 255",
    }.items():
        keyword = name.split("_colours")[0].replace("_OFF_RGB", "OFF") + "\n"
        rows = text(f"%r %r %r{columns}\n", V.tolist())
        add(f"{name}.off", f"{keyword}{N} {M} 0\n{rows}{polygons(F)}")
    for name, colour in {
        "index": " 7",
        "rgb": " 255 0 17",
        "rgba": " 255 0 17 255",
        "fractions": " 0.5 0.25 1.0",
        "exponents": " 5e-1 1 1e-05",
    }.items():
        rows = polygons(F).replace("\n", colour + "\n")
        add(f"face_colours_{name}.off", f"OFF\n{N} {M} 0\n{plain}{rows}")
    some = polygons(F).replace("\n", " 1 0 0\n", 2)
    add("face_colours_of_some.off", f"OFF\n{N} {M} 0\n{plain}{some}")
    add("quads.off", off(faces=POLYGONS), FANS)
    add("polygon.off", off(ring, [list(range(40))]), disc)
    add("integers.off", off(WHOLE.astype(int)), (WHOLE, F))

    f16 = "comment ply file downloaded from somewhere\nformat ascii 1.0"
    add("comment_before_format.ply", changed(SOUND["ply"], "format ascii 1.0", f16))
    add(
        "format_last.ply",
        "ply\n" + ply().split("1.0\n")[1].replace("end_", "format ascii 1.0\nend_"),
    )
    comments = SOUND["ply"].replace(b"\n", b"\ncomment a # end_header 3 0 1 2\nobj_info b\n", 8)
    add("comments_in_header.ply", comments)
    add("comments_between_rows.ply", SOUND["ply"].replace(b"\n", b"\ncomment 1 2 3\n"))
    add("vertex_index.ply", ply(lists="uchar int vertex_index"))
    add("sized_types.ply", ply(lists="uint8 int32 vertex_indices", coordinate="float32"))
    add(
        "integer_coordinates.ply",
        ply(WHOLE.astype(int), coordinate="int"),
        (WHOLE, F),
    )
    add("doubles.ply", ply(V + np.pi, coordinate="double"), (V + np.pi, F))
    add(
        "fractions_as_indices.ply",
        ply(lists="uchar float vertex_indices").replace("3 1 2 4", "3 1.0 2 4"),
    )
    add("quads.ply", ply(faces=POLYGONS), FANS)
    add("polygon.ply", ply(ring, [list(range(40))], coordinate="double"), disc)
    colours = "property uchar red\nproperty uchar green\nproperty float quality\n"
    rows = text("%r %r %r 255 0 nan\n", V.tolist())
    add("extra_after.ply", header(after_vertex=colours) + rows + polygons(F))
    scattered = header().replace("property float y", "property uchar red\nproperty float y")
    scattered = scattered.replace("element vertex", "comment\nelement vertex")
    add("extra_between.ply", scattered + text("%r 17 %r %r\n", V.tolist()) + polygons(F))
    swapped = (
        header()
        .replace("float x", "float w")
        .replace("float z", "float x")
        .replace("float w", "float z")
    )
    add("z_y_x.ply", swapped + text("%r %r %r\n", V[:, ::-1].tolist()) + polygons(F))
    lists = "property list uchar float weights\n"
    listed = "".join(
        f"{x!r} {y!r} {z!r} {i} {'0.5 ' * i}\n" for i, (x, y, z) in enumerate(V.tolist())
    )
    add("list_in_vertex.ply", header(after_vertex=lists) + listed + polygons(F))
    several = header(
        before_face="property float area\nproperty list uchar float texcoord\n",
        after_face="property int group\n",
    )
    rows = "".join(
        f"0.5 {2 * k} {'0.25 ' * 2 * k} 3 {a} {b} {c} -7\n" for k, (a, b, c) in enumerate(F)
    )
    add("extra_around_faces.ply", several + plain + rows)
    front = "element camera 1\nproperty float view\nproperty list int int path\n"
    front += "element none 0\nproperty int a\n"
    back = "element edge 2\nproperty int vertex1\nproperty int vertex2\nelement empty 3\n"
    more = header(before_vertex=front).replace("end_header", back + "end_header")
    add("extra_elements.ply", more + "0.5 2 7 7\n" + plain + polygons(F) + "0 1\n1 2\n")
    first = header().split("element face")
    turned = first[0].split("element vertex")
    face_part = "element face" + first[1].replace("end_header\n", "")
    faces_first = turned[0] + face_part + "element vertex" + turned[1] + "end_header\n"
    add("faces_first.ply", faces_first + polygons(F) + plain)

    for kind in "off", "ply":
        # A line may end anywhere, as long as the words are those announced.
        head, rows = SOUND[kind].split(b"0\n" if kind == "off" else b"end_header\n", 1)
        head += b"0\n" if kind == "off" else b"end_header\n"
        add(f"rows_in_one_line.{kind}", head + rows.replace(b"\n", b" "))
        add(f"rows_joined.{kind}", head + rows.replace(b"\n3", b" 3", 2))
        add(f"rows_of_one_word.{kind}", head + rows.replace(b" ", b"\n"))
        add(f"rows_broken.{kind}", head + rows.replace(b"3 1", b"3 \n1").replace(b"2.5", b"\n2.5"))
        mixed = (off if kind == "off" else ply)(faces=POLYGONS)
        add(f"rows_broken_quads.{kind}", mixed.replace("4 0 3", "4\n0 3"), FANS)
    split = "0.5 2\n7 7 " + plain + polygons(F).replace(" ", "\n") + "0 1 1 2\n"
    add("rows_broken_of_extra_elements.ply", more + split)

    strips = "8 0 1 2 3 -1 3 4 5\n5 -1 -1 0 1 2\n3 2 0 0\n"
    winding = (V, np.array([[0, 1, 2], [1, 3, 2], [3, 4, 5], [0, 1, 2], [2, 0, 0]]))
    head = header(face="tristrips", faces=3)
    add("strips.ply", head + plain + strips, winding)
    for index in "uchar", "double":
        strip = ply_binary(faces=[[0, 1, 2, 3]], index=index, face="tristrips")
        add(f"strip_of_{index}.ply", strip, (V, winding[1][:2]))
    head = header("binary_big_endian", face="tristrips", faces=3, lists="int int vertex_indices")
    body = b"".join(packed(">", "float float float", *row) for row in V.tolist())
    numbers = strips.split()
    body += packed(">", "int " * len(numbers), *map(int, numbers))
    add("strips_big.ply", head.encode() + body, winding)

    for order, word in ("<", "little"), (">", "big"):
        encoding = ORDERS[order]
        points = b"".join(packed(order, "float float float", *row) for row in V.tolist())
        bits = ply_binary(order)
        end = bits.index(b"end_header\n") + len(b"end_header\n")
        head, body = bits[:end], bits[end:]
        add(f"crlf_header_{word}.ply", head.replace(b"\n", b"\r\n") + body)
        add(f"lone_cr_header_{word}.ply", head.replace(b"\n", b"\r") + body)
        add(f"bom_{word}.ply", b"\xef\xbb\xbf" + bits)
        add(f"line_end_behind_{word}.ply", bits + b"\n")
        add(
            f"blanks_in_header_{word}.ply",
            head.replace(b"\n", b" \n\n")
            .replace(b" ", b"  ")
            .replace(b"end_header  \n\n", b"end_header \n")
            + body,
        )
        # The first byte of the rows looks like the second half of a line end.
        feed = V.copy()
        feed[0, 0] = struct.unpack(order + "f", bytes([10, 13, 10, 13]))[0]
        bits_feed = ply_binary(order, V=feed)
        for name, line_end in ("lf", b"\n"), ("crlf", b"\r\n"), ("lone_cr", b"\r"):
            data = head.replace(b"\n", line_end) + bits_feed[end:]
            add(f"line_feed_first_{name}_{word}.ply", data, (feed, F))
        end_in_comment = head.replace(b"element vertex", b"comment end_header\nelement vertex")
        add(f"end_header_in_comment_{word}.ply", end_in_comment + body)
        for length in "char", "uchar", "short", "ushort", "int", "uint", "int64", "uint64":
            add(f"length_{length}_{word}.ply", ply_binary(order, length=length))
            add(
                f"mixed_length_{length}_{word}.ply",
                ply_binary(order, faces=POLYGONS, length=length),
                FANS,
            )
        for index in CODES:
            add(f"index_{index}_{word}.ply", ply_binary(order, index=index))
        add(f"double_{word}.ply", ply_binary(order, V + np.pi, coordinate="double"), (V + np.pi, F))
        for coordinate in "char", "short", "int", "int64":
            data = ply_binary(order, WHOLE.astype(int), coordinate="float")
            data = header(encoding, coordinate=coordinate).encode() + b"".join(
                packed(order, f"{coordinate} " * 3, *map(int, row)) for row in WHOLE
            )
            add(f"coordinate_{coordinate}_{word}.ply", data + face_rows(order, F), (WHOLE, F))
        add(f"quads_{word}.ply", ply_binary(order, faces=POLYGONS), FANS)
        squares = [SQUARE, SQUARE[::-1]]
        both = np.array([[0, 3, 2], [0, 2, 1], [1, 2, 3], [1, 3, 0]])
        add(f"quads_only_{word}.ply", ply_binary(order, faces=squares), (V, both))
        add(
            f"polygon_{word}.ply",
            ply_binary(order, ring.astype("f4"), [list(range(40))]),
            (ring.astype("f4"), disc[1]),
        )
        types = "char uchar short ushort int uint double"
        extra = "".join(f"property {name} extra_{name}\n" for name in types.split())
        values = packed(order, types, -1, 2, -3, 4, -5, 6, float("nan"))
        data = header(encoding, after_vertex=extra).encode() + b"".join(
            points[12 * i : 12 * i + 12] + values for i in range(N)
        )
        add(f"extra_after_{word}.ply", data + face_rows(order, F))
        data = header(encoding, after_vertex="property list short double weights\n").encode()
        data += b"".join(
            points[12 * i : 12 * i + 12] + packed(order, "short" + " double" * i, i, *[0.5] * i)
            for i in range(N)
        )
        add(f"list_in_vertex_{word}.ply", data + face_rows(order, F))
        around = (
            header(
                encoding,
                before_face="property uchar flags\nproperty list uchar float texcoord\n",
                after_face="property double area\n",
            ).encode()
            + points
        )
        for name, sizes in ("even", [6] * M), ("uneven", range(M)):
            rows = b"".join(
                packed(order, "uchar uchar" + " float" * k, 9, k, *[0.5] * k)
                + face_rows(order, [face])
                + packed(order, "double", 0.5)
                for k, face in zip(sizes, F, strict=True)
            )
            add(f"extra_around_faces_{name}_{word}.ply", around + rows)
        more = header(encoding, before_vertex=front).replace("end_header", back + "end_header")
        data = more.encode() + packed(order, "float int int int", 0.5, 2, 7, 7) + points
        add(
            f"extra_elements_{word}.ply",
            data + face_rows(order, F) + packed(order, "int int int int", 0, 1, 1, 2),
        )
        data = faces_first.replace("ascii", encoding).encode() + face_rows(order, F) + points
        add(f"faces_first_{word}.ply", data)
        add(f"vertex_index_{word}.ply", bits.replace(b"vertex_indices", b"vertex_index"))

    add("solid_in_header.stl", stl_binary(title=b"solid pyramid"))
    add("solid_facet_in_header.stl", stl_binary(title=b"solid a\nfacet normal 0 0 1\n"))
    add("blanks_in_header.stl", stl_binary(title=b"solid " + b" " * 74))
    add("html_in_header.stl", stl_binary(title=b"<made by a program>"))
    add("ply_in_header.stl", stl_binary(title=b"ply\nformat ascii 1.0\n"))
    add("attributes.stl", stl_binary(attribute=0x7FFF))
    add("nan_normals_binary.stl", stl_binary(normal=(np.nan, np.inf, -np.inf)))
    add("one_facet.stl", stl_binary(F=F[:1]), (V, F[:1]))
    add("nan_normals.stl", stl(normal="nan nan -nan(ind)"))
    add("no_name.stl", stl(name=""))
    add("long_name.stl", stl(name="facet normal 0 0 1 outer loop " + "x" * 1000))
    add("accents_in_name.stl", stl(name="M\u00fcller"))
    add("latin_name.stl", stl(name="M\u00fcller").encode("latin-1"))
    add("no_name_at_end.stl", stl().replace("endsolid pyramid", "endsolid"))
    add("two_words_at_end.stl", stl().replace("endsolid", "end solid"))
    add("upper_case.stl", stl().upper())
    add("mixed_case.stl", stl().title())
    add("two_solids.stl", stl(F=F[:2]) + stl(F=F[2:], name="rest"))
    add("empty_solid_too.stl", stl(F=F[:0]) + stl())
    add("one_line.stl", stl().replace("\n", " ").replace("pyramid ", "pyramid\n", 1))
    add(
        "every_word_a_line.stl", stl().replace(" ", "\n").replace("solid\npyramid", "solid pyramid")
    )
    add("negative_zero.stl", stl(V=V * -1.0), (V * -1.0, F))
    return files


BATCH = 25  # files that one process reads: to start it takes as long as to read a hundred


def read_apart(paths):
    """Read files with `meshfair.io.read`, in processes that may crash, hang or fill the memory.

    Returns
    -------
    list of dict
        For each path ``outcome``: "mesh", "MeshError", or what went wrong;
        the ``message``, the ``seconds`` it took, and the most ``megabytes`` that
        its process has used until then.
    """
    answer = subprocess.run(
        [sys.executable, __file__],
        input=json.dumps([str(path) for path in paths]),
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
    )
    return json.loads(answer.stdout)


def _read_all():
    """Read the files named on standard input; the outcomes go to standard output."""
    from meshfair import io as mesh_io

    warnings.simplefilter("ignore")
    for format in "obj", "off", "ply", "stl":  # what is loaded here, every child has
        V, F, attributes = mesh_io.read(io.BytesIO(SOUND[format]), attributes=True, format=format)
        check_attributes(V, F, attributes)
    paths, ends = json.load(sys.stdin), []
    while len(ends) < len(paths):
        ends += _read_in_child(paths[len(ends) : len(ends) + BATCH])
    json.dump(ends, sys.stdout)


def _read_in_child(paths):
    """What became of each file, up to the first that ended the process."""
    answer, question = os.pipe()
    child = os.fork()
    if not child:
        os.close(answer)
        _limit()
        with open(question, "w", buffering=1) as file:  # line by line
            for path in paths:
                print(json.dumps(_read(path)), file=file)
        os._exit(0)
    os.close(question)
    signal.signal(signal.SIGALRM, lambda *_: os.kill(child, signal.SIGKILL))
    signal.alarm(4 * SECONDS)  # for a child that waits and uses no time of the processor
    with open(answer) as file:
        ends = [json.loads(line) for line in file]
    _, status = os.waitpid(child, 0)
    signal.alarm(0)
    if len(ends) < len(paths):
        ends.append({"outcome": f"crash or hang, status {status}"})
    return ends


def _limit():
    with open("/proc/self/status") as file:
        used = next(int(line.split()[1]) << 10 for line in file if line.startswith("VmSize"))
    resource.setrlimit(resource.RLIMIT_AS, (used + (2 * MEGABYTES << 20),) * 2)
    resource.setrlimit(resource.RLIMIT_CPU, (2 * SECONDS, 2 * SECONDS))


def check_attributes(V, F, attributes):
    """Written like the file it came from, a mesh makes the same file, and a moved one its own."""
    from meshfair import io as mesh_io

    for X in V, np.clip(V + 0.125, -1e75, 1e75):
        again = io.BytesIO()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # on precision, and polygons
            try:
                mesh_io.write(again, X, F, like=attributes, format=attributes.format)
            except mesh_io.MeshFileError:
                assert np.abs(X).max() > 3e38, "all that fits into single precision is written"
                continue
            if X is V:
                assert again.getvalue() == attributes.data
            again.seek(0)
            read_X, read_F = mesh_io.read(again, format=attributes.format, weld=False)
        near = {"rtol": 1e-6, "atol": 1e-37}
        if attributes.vertex is not None:
            assert np.allclose(read_X[read_F], X[F], **near)
            continue
        assert np.allclose(read_X, X, **near)
        # Polygons may be cut otherwise where their corners have moved.
        assert len(read_F) == len(F) if attributes.corner is not None else np.array_equal(read_F, F)


def _read(path):
    from meshfair import io
    from meshfair.checks import MeshError

    start, message = time.perf_counter(), ""
    try:
        V, F, attributes = io.read(path, attributes=True)
        check_attributes(V, F, attributes)
        sound = (
            V.dtype == np.float64
            and F.dtype == np.int64
            and V.shape[1:] == F.shape[1:] == (3,)
            and len(F)
            and np.isfinite(V).all()
            and F.min() >= 0
            and F.max() < len(V)
        )
        outcome = "mesh" if sound else "an unsound mesh"
    except MeshError as error:
        outcome, message = "MeshError", str(error)
    except BaseException as error:
        outcome, message = type(error).__name__, str(error)
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    seconds = time.perf_counter() - start
    return {"outcome": outcome, "message": message, "seconds": seconds, "megabytes": used}


if __name__ == "__main__":
    _read_all()
