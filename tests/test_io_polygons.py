"""Polygons become triangles of their area, whatever their shape."""

import io as streams
import sys
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mesh_files
from meshfair import io, mesh
from meshfair.checks import MeshWarning

L = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]]
# With corners on straight sides, which faces beside it may have.
LONG_L = [[0, 0], [1, 0], [2, 0], [2, 1], [1.5, 1], [1, 1], [1, 2], [0, 2], [0, 1]]
COMB = [[0, 0], [7, 0], [7, 3], [6, 3], [6, 1], [5, 1], [4, 1], [4, 3], [3, 3], [3, 1], [1, 1]]
COMB += [[1, 3], [0, 3]]


def shoelace(P):
    x, y = np.asarray(P, float).T
    return (x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def triangles(P, matrix=((1, 0), (0, 1), (0, 0)), offset=(0, 0, 0), format="obj", shift=0):
    """V and F of a file with one polygon, which begins with another corner; and the warning."""
    V = np.asarray(P, float) @ np.asarray(matrix, float).T + offset
    face = np.roll(np.arange(len(P)), shift).tolist()
    options = {"coordinate": "double"} if format == "ply" else {}
    data = getattr(mesh_files, format)(V, [face], **options)
    with warnings.catch_warnings(record=True) as record:
        warnings.simplefilter("always")
        V, F = io.read(streams.BytesIO(data.encode()), format=format)
    return V, F, str(record[0].message)


def boundary(F):
    """The edges of triangles that have no other side, each with its direction."""
    edges = {(int(f[k - 1]), int(f[k])) for f in F for k in range(3)}
    return {(a, b) for a, b in edges if (b, a) not in edges}


@pytest.mark.parametrize("format", ["obj", "off", "ply"])
@pytest.mark.parametrize("P", [L, LONG_L, COMB], ids=["L", "long L", "comb"])
def test_the_area_is_that_of_the_polygon(P, format):
    turned = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0][:, :2]
    for matrix, offset in (
        (((1, 0), (0, 1), (0, 0)), (0, 0, 0)),
        (turned, (0, 0, 0)),
        (1000 * turned, (448250, 5411940, 212)),
        (1e-6 * turned, (0, 0, 0)),
    ):
        scale = np.linalg.norm(np.asarray(matrix)[:, 0])
        for shift in range(len(P)):
            V, F, message = triangles(P, matrix, offset, format, shift)
            area = shoelace(P) * scale**2
            # The coordinates have been rounded: at 5e6, by 1e-9, which is 1e-12 of the size.
            np.testing.assert_allclose(mesh.area(V, F), area, rtol=1e-9)
            assert len(F) == len(P) - 2
            assert boundary(F) == {(k, (k + 1) % len(P)) for k in range(len(P))}
            assert "folded" not in message


def test_convex_polygons_are_fans():
    ring = [[np.cos(t), np.sin(t)] for t in np.linspace(0, 6, 9)]
    assert triangles(ring)[1].tolist() == [[0, k, k + 1] for k in range(1, 8)]


@given(
    st.lists(st.floats(0.2, 3), min_size=4, max_size=12),
    st.integers(0, 3),
)
def test_stars_have_their_area(radii, shift):
    angles = np.linspace(0, 2 * np.pi, len(radii), endpoint=False)
    P = np.column_stack([np.cos(angles), np.sin(angles)]) * np.array(radii)[:, None]
    V, F, _ = triangles(P, shift=shift)
    np.testing.assert_allclose(mesh.area(V, F), shoelace(P), rtol=1e-8)  # 1e-9 are let pass


def test_polygons_that_cross_themselves_are_told():
    bow = [[0, 0], [3, 1], [3, 0], [0, 1.5]]
    _, F, message = triangles(bow)
    assert len(F) == 2
    assert "some are folded in 1 polygons that cross themselves" in message


def test_without_the_library_a_fan_is_made_and_told(monkeypatch):
    monkeypatch.setitem(sys.modules, "mapbox_earcut", None)
    V, F, message = triangles(L, shift=1)
    assert mesh.area(V, F) > 3
    assert 'to cut these well, run: pip install "meshfair[formats]"' in message
    assert "folded" not in triangles([[0, 0], [1, 0], [1, 1], [0, 1]])[2]


def test_the_polygon_is_written_again():
    data = mesh_files.obj(np.column_stack([L, np.zeros(6)]), [[1, 2, 3, 4, 5, 0]]).encode()
    with pytest.warns(MeshWarning):
        V, F, attributes = io.read(streams.BytesIO(data), attributes=True, format="obj")
    out = streams.BytesIO()
    io.write(out, V * 2, F, like=attributes, format="obj")
    assert out.getvalue().endswith(b"f 2 3 4 5 6 1\n")
