import igl
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from broken import bow_tie, hourglass, moebius_strip, wild_meshes
from meshes import CLOSED, RIGHT_TRIANGLE, fan, grid, rigid_motions, soups
from meshfair import MeshError, MeshWarning, intrinsic, io, mesh, shapes, weights
from meshfair.operators import averaging, laplacian
from meshfair.stability import stable_step


def noisy(make, rng, sigma=0.25):
    V, F = make()
    return V + sigma * mesh.mean_edge_length(V, F) * rng.standard_normal(V.shape), F


def test_an_obtuse_pair_by_hand():
    # Two triangles with angles of 127 degrees opposite their common edge (0, 1): a weight
    # of -0.75 (see test_weights). The flip joins the tips 2 and 3, at distance 1.
    V = np.array([[-1.0, 0, 0], [1, 0, 0], [0, 0.5, 0], [0, -0.5, 0]])
    F = np.array([[0, 1, 2], [1, 0, 3]])
    assert weights.cotangent(V, F)[0, 1] == pytest.approx(-0.75)
    W = intrinsic.cotangent(V, F).toarray()
    assert W[0, 1] == 0
    # Opposite (2, 3): 53.1 degrees on both sides, the tangent of half of it is 1/2.
    assert W[2, 3] == pytest.approx((1 - 0.25) / (2 * 0.5))
    # Opposite the boundary edges: 63.4 degrees, the tangent is 2.
    assert W[0, 2] == pytest.approx(1 / 4)


def test_a_right_triangle_is_sewn_front_to_back():
    V, F = RIGHT_TRIANGLE
    # Opposite the hypotenuse there are 90 degrees on both sheets: 180, which is allowed.
    np.testing.assert_allclose(
        intrinsic.cotangent(V, F).toarray(), [[0, 0.5, 0.5], [0.5, 0, 0], [0.5, 0, 0]], atol=1e-12
    )


def test_an_obtuse_triangle_alone():
    # Its sheets are flipped along the long side: the new edge runs from the apex c on
    # the front to the same vertex on the back, and so has no weight.
    V = np.array([[0.0, 0, 0], [4, 0, 0], [1, 1, 0]])
    assert weights.cotangent(V, [[0, 1, 2]])[0, 1] < 0
    W = intrinsic.cotangent(V, [[0, 1, 2]]).toarray()
    assert W[0, 1] == 0
    # That leaves two isosceles triangles with the base 2, each sewn up along its legs.
    # The legs from vertex 0 face the base angle 45 degrees twice, those from 1 the base
    # angle arctan 3; and there are two sheets.
    assert W[0, 2] == pytest.approx((1 + 1) / 2 / 2)
    assert W[1, 2] == pytest.approx((1 / 3 + 1 / 3) / 2 / 2)


def test_a_flat_obtuse_triangle_alone():
    # The same with height h: tangents of the base angles 1 / h and 3 / h.
    h = 1e-5
    W = intrinsic.cotangent(np.array([[0.0, 0, 0], [4, 0, 0], [1, h, 0]]), [[0, 1, 2]], mollify=0)
    np.testing.assert_allclose(W.toarray()[2], [h / 2, h / 6, 0], rtol=1e-4)
    assert W[0, 1] == 0


def test_needles_do_not_flip_for_ever():
    # Sewn-up sides turn into cones so thin that rounding hides that they are Delaunay.
    for height in (1.6e-8, 1e-8, 2e-9):
        V = np.array([[0.0, 0, 0], [4, 0, 0], [1e-4, height, 0]])
        assert np.isfinite(intrinsic.cotangent(V, [[0, 1, 2]], mollify=1e-12).data).all()


MESHES = {
    "knot": shapes.knot,
    "noisy sphere": lambda: noisy(lambda: shapes.icosphere(3), np.random.default_rng(1)),
    "long torus": lambda: (shapes.torus()[0] * [9, 1, 1], shapes.torus()[1]),
    "noisy box": lambda: noisy(lambda: shapes.box(segments=6), np.random.default_rng(2)),
}
OPEN = {
    "grid": lambda: noisy(grid, np.random.default_rng(3)),
    "stretched grid": lambda: (grid()[0] * [8, 1, 1], grid()[1]),
    "cut knot": lambda: (
        shapes.knot()[0][:1200],
        shapes.knot()[1][(shapes.knot()[1] < 1200).all(axis=1)],
    ),
    "triangle": lambda: (np.array([[0.0, 0, 0], [4, 0, 0], [1, 1, 0]]), np.array([[0, 1, 2]])),
}
NOT_MANIFOLD = {
    "book": lambda: fan(3),
    "five pages": lambda: fan(5),
    "bow tie": bow_tie,
    "hourglass": hourglass,
    "moebius strip": moebius_strip,
}


ALL = MESHES | OPEN | NOT_MANIFOLD


@pytest.mark.parametrize("mollify", [0, 1e-5])
@pytest.mark.parametrize("make", ALL.values(), ids=ALL)
def test_the_laplacian_is_robust_laplacians(make, mollify):
    robust_laplacian = pytest.importorskip(
        "robust_laplacian", reason="robust_laplacian is not installed"
    )
    V, F = make()
    theirs, _ = robust_laplacian.mesh_laplacian(V, F, mollify_factor=mollify)
    ours = laplacian(intrinsic.cotangent(V, F, mollify=mollify))
    # It leaves angle sums up to about 1e-6 above 180 degrees as they are.
    assert abs(ours - theirs).max() < 1e-5 * abs(theirs).max()


@pytest.mark.parametrize("make", MESHES.values(), ids=MESHES)
def test_the_laplacian_is_libigls_on_closed_meshes(make):
    V, F = make()
    C, _, _ = igl.intrinsic_delaunay_cotmatrix(V, F)
    ours = laplacian(intrinsic.cotangent(V, F))
    assert abs(ours + C).max() < 1e-9 * abs(C).max()


@given(soups())
@settings(deadline=None)
def test_weights_are_nonnegative_symmetric_and_every_step_is_stable(soup):
    V, F = soup
    W = intrinsic.cotangent(V, F)
    assert W.shape == (len(V), len(V))
    assert np.isfinite(W.data).all()
    assert (W.data > 0).all()
    assert abs(W - W.T).max() == 0
    assert np.all(W.diagonal() == 0)
    assert stable_step(averaging(W)) >= 1 - 1e-9


@given(wild_meshes())
@settings(max_examples=200, deadline=None)
def test_degenerate_meshes_have_finite_weights(wild):
    V, F = wild
    proper = [face for face in F.tolist() if len(set(face)) == 3]
    shrunk = all(np.all(V[face] == V[face[0]]) for face in proper)
    if shrunk:
        with pytest.raises(MeshError, match="no triangle at all"):
            intrinsic.cotangent(V, F)
        return
    W = intrinsic.cotangent(V, F)
    assert np.isfinite(W.data).all()
    assert (W.data > 0).all()


@pytest.mark.parametrize("make", (MESHES | OPEN).values(), ids=MESHES | OPEN)
def test_the_flipped_mesh_is_the_same_surface_and_delaunay(make):
    V, F = make()
    D = intrinsic.delaunay(V, F)
    # Twins are mutual, run opposite ways and are of one length.
    h = np.arange(len(D.tail))
    assert np.array_equal(D.twin[D.twin], h)
    tip = D.tail.reshape(-1, 3)[:, [1, 2, 0]].ravel()
    assert np.array_equal(D.tail[D.twin], tip)
    assert np.array_equal(D.length[D.twin], D.length)
    # The area, by Heron's formula, is that of the surface, once for each sheet.
    assert D.sheets == (1 if mesh.is_closed(F) else 2)
    a, b, c = D.length.reshape(-1, 3).T
    s = (a + b + c) / 2
    unit = np.linalg.norm(V[F] - np.roll(V[F], 1, axis=1), axis=2).mean()
    area = unit**2 * np.sqrt(s * (s - a) * (s - b) * (s - c)).sum()
    assert area == pytest.approx(D.sheets * mesh.area(V, F), rel=1e-9)
    # Opposite angles, by the law of cosines, sum to 180 degrees at most.
    cosines = [
        (q * q + r * r - p * p) / (2 * q * r) for p, q, r in ((a, b, c), (b, c, a), (c, a, b))
    ]
    angle = np.arccos(cosines).T.ravel()
    assert (angle + angle[D.twin]).max() < np.pi + 1e-6


def test_a_flat_mesh_has_the_weights_of_its_delaunay_triangulation(rng):
    from scipy.spatial import Delaunay

    # A grid whose inner vertices are moved: the extrinsic triangulation of its plane.
    V, F = grid(6, irregular=rng)
    inside = np.all((V[:, :2] > 0) & (V[:, :2] < 6), axis=1)
    T = Delaunay(V[:, :2]).simplices.astype(np.int64)
    area = mesh.face_areas(V, T)
    plane = weights.cotangent(V, T[area > 1e-9])
    W = intrinsic.cotangent(V, F)
    assert abs((W - plane)[inside][:, inside]).max() < 1e-9


def test_linear_functions_are_harmonic_inside_a_plane(rng):
    V, F = grid(9, irregular=rng)
    assert np.all(mesh.face_normals(V, F)[:, 2] == 1)
    assert weights.cotangent(V, F).data.min() < -0.01
    inside = np.setdiff1d(np.arange(len(V)), mesh.boundary_vertices(F))
    L = laplacian(intrinsic.cotangent(V, F))
    assert abs((L @ V)[inside]).max() < 1e-12


@given(rigid_motions(), st.sampled_from([1e-6, 1.0, 1e6]))
@settings(deadline=None, max_examples=30)
def test_rigid_motion_and_scale_do_not_matter(motion, scale):
    rotation, shift = motion
    V, F = noisy(lambda: shapes.torus(sections=9, sides=6), np.random.default_rng(5))
    X = scale * (V @ rotation.T + shift)
    one, other = intrinsic.cotangent(V, F), intrinsic.cotangent(X, F)
    assert abs(one - other).max() < 1e-8 * abs(one).max()


def test_what_needs_no_flip_is_left_alone():
    V, F = CLOSED["sphere"]()
    ordinary = weights.cotangent(V, F)
    assert ordinary.data.min() > 0
    assert abs(intrinsic.cotangent(V, F) - ordinary).max() < 1e-12


def test_duplicate_and_collapsed_faces_and_unused_vertices_do_not_count():
    V, F = shapes.icosphere(1)
    X = np.concatenate([V, [[9.0, 9, 9]]])
    T = np.concatenate([F, F[:4, ::-1], [[3, 3, 5]]])
    W = intrinsic.cotangent(X, T)
    assert W.shape == (len(X), len(X))
    assert abs(W[: len(V)][:, : len(V)] - intrinsic.cotangent(V, F)).max() < 1e-14


def test_degenerate_faces_need_mollification():
    V = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]])
    F = [[0, 2, 3], [0, 1, 2]]
    with pytest.raises(MeshError, match=r"vertices \[0, 1, 2\] is degenerate"):
        intrinsic.cotangent(V, F, mollify=0)
    assert np.isfinite(intrinsic.cotangent(V, F).data).all()


@pytest.mark.parametrize("mollify", [-1e-9, 2, np.nan, "much"])
def test_a_wrong_mollification_is_refused(mollify):
    with pytest.raises(ValueError, match="mollify"):
        intrinsic.cotangent(*shapes.icosphere(0), mollify=mollify)


def test_flips_that_do_not_end_are_reported(monkeypatch):
    monkeypatch.setattr(intrinsic, "MOST_FLIPS", 0)
    with pytest.warns(MeshWarning, match="did not end"):
        W = intrinsic.cotangent(*shapes.knot())
    assert (W.data > 0).all()  # what is negative is then left out


@pytest.mark.parametrize("file", ["f16.ply", "stanford-bunny.obj"])
def test_real_meshes(mirror, file):
    robust_laplacian = pytest.importorskip(
        "robust_laplacian", reason="robust_laplacian is not installed"
    )
    V, F = io.read(mirror / file)
    W = intrinsic.cotangent(V, F)
    assert (weights.cotangent(V, F).data < -1e-10).any()
    assert (W.data > 0).all()
    # It needs vertices with faces, and counts duplicate faces as often as they are stored.
    V, F, *_ = mesh.repair(V, F, duplicates=True, unreferenced=True)
    theirs, _ = robust_laplacian.mesh_laplacian(V, F, mollify_factor=1e-6)
    ours = laplacian(intrinsic.cotangent(V, F))
    assert abs(ours - theirs).max() < 1e-5 * abs(theirs).max()
