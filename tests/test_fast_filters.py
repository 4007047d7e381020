"""The filters' compiled loops equal their formulas in NumPy, on every kind of mesh."""

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from broken import moebius_strip, wild_meshes
from fast import both
from meshes import fan, grid, soups
from meshfair import MeshError, MeshWarning, filters, intrinsic, mesh, noise, shapes, weights
from meshfair.filters import creases, neighbourhoods, normal_filtering
from meshfair.filters.bilateral import move_along_normals, shortest_edges
from meshfair.filters.guided_normal import Patches, guidance
from meshfair.mesh.geometry import incidence

# Sums over some tens of neighbours of terms of size 1: a few hundred roundings of 1e-16.
ROUNDING = 1e-13
# A filter repeats them up to seventy times, and a normal may be the mean of some that cancel
# all but a hundredth.
MANY_ROUNDINGS = 1e-10


def noisy(make, sigma=0.2):
    V, F = make()
    return noise.gaussian(V, F, sigma, np.random.default_rng(1)), F


def ragged():
    """A noisy torus with duplicate, collapsed and zero-area faces, and isolated vertices."""
    V, F = noisy(lambda: shapes.torus(sections=12, sides=8))
    n = len(V)
    V = np.concatenate([V, V[:2], [[9.0, 9, 9]]])  # two copies, and one far away
    odd = [F[3], F[3], F[10], [4, 4, 5], [7, 7, 7], [0, n, 1], [1, n, n + 1]]
    return V, np.concatenate([F, odd])


MESHES = {
    "torus": lambda: noisy(lambda: shapes.torus(sections=20, sides=10)),
    "box": lambda: noisy(lambda: shapes.box(segments=5), 0.1),
    "very noisy box": lambda: noisy(lambda: shapes.box(segments=5), 0.5),
    "grid": lambda: noisy(lambda: grid(8)),
    "fan": lambda: noisy(lambda: fan(5)),
    "moebius strip": lambda: noisy(moebius_strip, 0.1),
    "ragged": ragged,
}


@pytest.fixture(params=MESHES.values(), ids=MESHES)
def odd_mesh(request):
    return request.param()


def same(results, tolerance=ROUNDING):
    plain, fast = results
    assert type(plain) is type(fast)
    assert np.isfinite(plain).all()
    np.testing.assert_allclose(fast, plain, rtol=0, atol=tolerance * (1 + np.abs(plain).max()))


def around(V, F):
    """What the loops over faces are given: incidence, rings, normals, areas, centroids."""
    B = incidence(F, len(V))
    return B, neighbourhoods.face_rings(B), *mesh.face_shapes(V, F)


def ways_to_fix(V):
    """No vertex fixed, and every third."""
    return np.zeros(len(V), dtype=bool), np.arange(len(V)) % 3 == 0


def check_neighbourhoods(V, F):
    lengths = weights.distance(V, F)
    _, R, _, _, C = around(V, F)
    for P, graph in ((V, lengths), (C, R)):
        for radius in (0.0, 0.3, 1.0, 100.0):
            radii = np.full(len(P), radius) * np.linspace(1, 2, len(P))
            plain, fast = both(lambda g=graph, P=P, r=radii: neighbourhoods.within(P, g, r))
            assert plain.dtype == fast.dtype == bool
            assert (plain != fast).nnz == 0


def check_heights(V, F):
    lengths = weights.distance(V, F)
    sigma = shortest_edges(lengths)
    near = neighbourhoods.within(V, lengths, 2 * sigma)
    N = mesh.vertex_normals(V, F)
    for fixed in ways_to_fix(V):
        same(both(lambda h=fixed: move_along_normals(V, N, near, sigma, h)))


def check_means(V, F):
    B, R, N, area, C = around(V, F)
    G = np.roll(N, 1, axis=0)
    for T in (-1.0, 0.0, 0.6, 1.0):
        same(both(lambda t=T: normal_filtering.sun_normals(R, N, t)))
    for sigma in (0.0, 0.2, 3.0):
        plain, fast = both(lambda s=sigma: normal_filtering.spatial_weights(R, C, area, s))
        np.testing.assert_array_equal(plain.indices, fast.indices)
        np.testing.assert_array_equal(plain.indptr, fast.indptr)
        same((plain.data, fast.data))
        for guides in (N, G):
            same(both(lambda g=guides, S=plain: normal_filtering.joint_bilateral(S, N, g, 0.5)))
    same(both(lambda: normal_filtering.joint_bilateral(plain, N, G, 1e-200)))
    for fixed in ways_to_fix(V):
        same(both(lambda h=fixed: normal_filtering.move_vertices(V, F, B, N, h)))


def check_guidance(V, F):
    _, R, N, area, C = around(V, F)
    patches = Patches(R)
    same(both(lambda: guidance(patches, N, area)))
    H = mesh.interior_edges(F)
    for cosine in (-1.0, 0.5, 0.99):
        for gap, shortest in ((0, 1), (2, 2), (5, 4)):
            plain, fast = both(
                lambda c=cosine, g=gap, s=shortest: creases.crease_edges(V, H, c, gap=g, shortest=s)
            )
            assert plain.dtype == fast.dtype == bool
            np.testing.assert_array_equal(plain, fast)
        same(both(lambda e=~plain: creases.crease_guidance(H.faces[e], N, area, C)))


CHECKS = [check_neighbourhoods, check_heights, check_means, check_guidance]


@pytest.mark.parametrize("check", CHECKS)
def test_each_loop_on_odd_meshes(check, odd_mesh):
    check(*odd_mesh)


# Without duplicates: where a face and its flipped duplicate cancel, rounding is all that is left.
@pytest.mark.parametrize("check", CHECKS)
@given(soup=soups())
def test_each_loop_on_soups(check, soup):
    V, F = soup
    check(V, mesh.unique_faces(F))


ALL = {name: getattr(filters, name) for name in filters.__all__}
OF_LOOPS = ("bilateral", "bilateral_normal", "feature_convinced", "guided_normal", "sun")


@pytest.mark.parametrize("name", OF_LOOPS)
@pytest.mark.filterwarnings("ignore::meshfair.MeshWarning")
def test_whole_filters(name, odd_mesh):
    V, F = odd_mesh

    def run():
        return np.array([X for _, X in ALL[name](V, F)])

    same(both(run), MANY_ROUNDINGS)


def same_triangulations(results):
    plain, fast = results
    np.testing.assert_array_equal(plain.tail, fast.tail)
    np.testing.assert_array_equal(plain.twin, fast.twin)
    assert plain.tail.dtype == plain.twin.dtype == np.int64
    # Each length is computed from those of the edge that was there before: some tens of flips.
    np.testing.assert_allclose(plain.length, fast.length, rtol=1e-11)
    assert plain.sheets == fast.sheets


def test_flips(odd_mesh):
    same_triangulations(both(lambda: intrinsic.delaunay(*odd_mesh)))


@given(soups())
def test_flips_of_soups(soup):
    same_triangulations(both(lambda: intrinsic.delaunay(*soup)))


@given(wild_meshes())
def test_weights_of_degenerate_meshes(wild):
    # Angle sums of 180 degrees are common here, and rounding may flip such an edge or not: the
    # weights are the same, since that edge has none. Triangles so thin that only the mollification
    # by 1e-6 gives them a height have cotangents of 1e3, known to about 1e-10 of that.
    try:
        plain, fast = both(lambda: intrinsic.cotangent(*wild))
    except MeshError:
        return
    assert abs(plain - fast).max() <= 1e-7 * abs(plain).max()


def test_flips_that_do_not_end(monkeypatch):
    monkeypatch.setattr(intrinsic, "MOST_FLIPS", 0)
    with pytest.warns(MeshWarning, match="did not end"):
        same_triangulations(both(lambda: intrinsic.delaunay(*shapes.knot())))


@given(st.integers(0, 2**32 - 1))
def test_lines_through_many_equal_choices(seed):
    # On a noise-free box all creases are bent alike: the first in order is taken, in both forms.
    V, F = shapes.box(segments=(2, 3, 4))
    to = np.random.default_rng(seed).permutation(len(V))
    X = np.empty_like(V)
    X[to] = V
    H = mesh.interior_edges(to[F])
    plain, fast = both(lambda: creases.crease_edges(X, H, 0.5, gap=3, shortest=2))
    np.testing.assert_array_equal(plain, fast)
    assert plain.sum() == 4 * (2 + 3 + 4)


def test_the_number_of_cores_changes_no_digit(monkeypatch):
    from meshfair._fast import kernels

    # More rows than a block of the loops has.
    V, F = noisy(lambda: shapes.torus(sections=100, sides=50))
    monkeypatch.setattr("meshfair._fast.wanted", lambda *_: True)

    def run():
        return [X for name in OF_LOOPS for _, X in ALL[name](V, F)][-1]

    expected = run()
    monkeypatch.setattr(kernels, "threads", lambda: 3)
    np.testing.assert_array_equal(run(), expected)


def test_small_meshes_load_no_numba():
    done = subprocess.run(
        [
            sys.executable,
            "-c",
            "import sys\n"
            "from meshfair import filters, intrinsic, shapes\n"
            "V, F = shapes.knot(30, 5)\n"
            "for name in filters.__all__:\n"
            "    for _ in getattr(filters, name)(V, F):\n"
            "        pass\n"
            "intrinsic.cotangent(V, F)\n"
            "assert 'numba' not in sys.modules\n",
        ],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
