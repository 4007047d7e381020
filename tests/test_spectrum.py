"""The spectrum: known eigenvalues, bounds, and one step against the flow itself."""

import numpy as np
import pytest
from scipy.sparse import csr_array

from meshfair import MeshError, flow, noise, operators, shapes, spectrum, stability, weights

TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


def test_tetrahedron_by_hand():
    # Each vertex is joined to the three others: W~ = (1 1' - I) / 3.
    W = weights.combinatorial(TETRAHEDRON, 4)
    np.testing.assert_allclose(spectrum.eigenvalues(W), [1, -1 / 3, -1 / 3, -1 / 3])


@pytest.mark.parametrize("build", [weights.distance, weights.cotangent])
def test_eigenmodes_are_eigenvectors_orthonormal_in_the_inner_product_of_d(build, rng):
    V, F = shapes.knot(30, 5)
    W = build(noise.along_normals(V, F, 0.3, rng), F)
    A, D = operators.averaging(W), np.diag(operators.degrees(W))
    lam, Phi = spectrum.eigenmodes(W)
    np.testing.assert_allclose(A @ Phi, Phi * lam, atol=1e-10)
    np.testing.assert_allclose(Phi.T @ D @ Phi, np.eye(len(V)), atol=1e-10)
    np.testing.assert_allclose(spectrum.eigenvalues(W), lam, atol=1e-10)
    assert lam[0] == pytest.approx(1)


def test_eigenvalues_stay_in_their_bounds(rng):
    V, F = shapes.box((1.0, 1.0, 0.1), (4, 3, 2))
    for _ in range(20):
        noisy = noise.gaussian(V, F, 1.0, rng)
        assert spectrum.eigenvalues(weights.distance(noisy, F)).min() >= -1
        assert spectrum.eigenvalues(weights.cotangent(noisy, F)).min() > -2


def test_stable_step_is_two_over_the_largest_mu(rng):
    V, F = shapes.knot(40, 6)
    W = weights.cotangent(noise.along_normals(V, F, 0.5, rng), F)
    bound = 2 / (1 - spectrum.eigenvalues(W).min())
    assert stability.stable_step(operators.averaging(W)) == pytest.approx(bound, rel=2e-3)


def test_the_transfer_function_is_what_the_flow_does_to_an_eigenmode(rng):
    V, F = shapes.torus(sections=12, sides=6)
    W = weights.cotangent(V, F)
    lam, Phi = spectrum.eigenmodes(W)
    A = operators.averaging(W)
    *_, (_, after) = flow.heat(V, A, 0.4, 1.2)
    left = spectrum.transfer_function(lam, 0.4, iterations=3)
    np.testing.assert_allclose(
        spectrum.coefficients(after, W, Phi),
        np.abs(left) * spectrum.coefficients(V, W, Phi),
        atol=1e-9,
    )


def test_coefficients_have_the_whole_mesh():
    V, F = shapes.torus(sections=12, sides=6)
    W = weights.combinatorial(F, len(V))
    squares = spectrum.coefficients(V, W, spectrum.eigenmodes(W)[1]) ** 2
    assert squares.sum() == pytest.approx((operators.degrees(W)[:, None] * V**2).sum())


def test_no_spectrum_of_large_meshes_or_lonely_vertices(monkeypatch):
    W = csr_array(([1.0, 1.0], ([0, 1], [1, 0])), shape=(3, 3))
    with pytest.raises(MeshError, match="vertex 2 has weights that sum to 0"):
        spectrum.eigenvalues(W)
    monkeypatch.setattr(spectrum, "LARGEST", 2)
    with pytest.raises(MeshError, match=r"3 vertices.*take a coarser mesh, of at most 2"):
        spectrum.eigenmodes(W)


def test_a_transfer_function_by_hand():
    # A factor of 1 - tau + tau lambda in each step.
    found = spectrum.transfer_function([1, 0.5, 0, -1], 0.4)
    np.testing.assert_allclose(found, [1, 0.8, 0.6, 0.2])
    found = spectrum.transfer_function([1, 0.5, 0, -1], 0.4, iterations=2)
    np.testing.assert_allclose(found, [1, 0.64, 0.36, 0.04])
    np.testing.assert_allclose(spectrum.transfer_function([0.5], -1, iterations=0), [1])
    with pytest.raises(ValueError, match="tau is inf"):
        spectrum.transfer_function([1], np.inf)
    with pytest.raises(ValueError, match="iterations is -1"):
        spectrum.transfer_function([1], 0.5, iterations=-1)
