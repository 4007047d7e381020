import igl
import numpy as np
import pytest

from meshes import CLOSED
from meshfair import mesh, shapes


@pytest.mark.parametrize("build", CLOSED.values(), ids=CLOSED)
def test_closed_oriented_outward(build):
    V, F = build()
    assert mesh.is_closed(F)
    # Each directed edge once: all faces turn the same way.
    assert len(np.unique(mesh.half_edges(F), axis=0)) == 3 * len(F)
    assert mesh.volume(V, F) > 0
    assert not mesh.degenerate_faces(V, F).any()
    assert np.array_equal(np.unique(F), np.arange(len(V)))


@pytest.mark.parametrize(("name", "genus"), [("knot", 1), ("sphere", 0), ("torus", 1), ("box", 0)])
def test_euler_characteristic(name, genus):
    V, F = CLOSED[name]()
    assert len(V) - len(mesh.Edges(F)) + len(F) == 2 - 2 * genus


def test_knot_is_knotmesh(mirror):
    V, F = igl.read_triangle_mesh(str(mirror / "KnotMesh.ply"))
    ours, faces = shapes.knot()
    assert np.array_equal(faces, F)
    # 0.03 is the goal set for the closed form, on a bounding box of 181.
    assert np.linalg.norm(ours - V, axis=1).max() < 0.03


def test_knot_closes_for_other_numbers():
    V, F = shapes.knot(sections=200, sides=16)
    assert V.shape == (3200, 3)
    assert mesh.is_closed(F)


def test_icosphere_converges_to_the_sphere():
    errors = [4 * np.pi / 3 - mesh.volume(*shapes.icosphere(k)) for k in (2, 3, 4)]
    # Halving the edges divides the error of an inscribed surface by four.
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 4, rtol=0.03)


def test_torus_converges_to_pappus():
    exact = 2 * np.pi**2 * 1.0 * 0.4**2
    errors = [exact - mesh.volume(*shapes.torus(sections=k, sides=k)) for k in (40, 80)]
    np.testing.assert_allclose(errors[0] / errors[1], 4, rtol=0.01)


def test_box_is_exact():
    V, F = shapes.box((1, 2, 3), (2, 3, 4))
    assert mesh.volume(V, F) == pytest.approx(6, rel=1e-14)
    assert mesh.area(V, F) == pytest.approx(22, rel=1e-14)
    assert len(V) == 3 * 4 * 5 - 1 * 2 * 3
    assert len(F) == 4 * (2 * 3 + 3 * 4 + 4 * 2)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: shapes.knot(sections=2), "sections is 2"),
        (lambda: shapes.icosphere(-1), "subdivisions is -1"),
        (lambda: shapes.icosphere(10), "10 million"),
        (lambda: shapes.icosphere(1.5), "whole number"),
        (lambda: shapes.torus(minor=2.0), "minor is 2.0"),
        (lambda: shapes.torus(major=1, minor=1), "touch itself"),
        (lambda: shapes.box(size=0), "size is 0"),
        (lambda: shapes.box(segments=0), "segments is 0"),
    ],
)
def test_bad_numbers(call, message):
    with pytest.raises(ValueError, match=message):
        call()
