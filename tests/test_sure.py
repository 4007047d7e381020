"""Stein's estimate against the true error, which the tests know."""

import numpy as np
import pytest

from meshes import grid
from meshfair import MeshError, mesh, noise, operators, shapes, weights
from meshfair.mesh import Edges
from meshfair.sure import SURE, true_risk


def test_the_true_risk_by_hand():
    # A flat quadrangle, vertex 0 lifted: two triangles, five edges, of which three end there.
    # It is seen along the normals of the lifted mesh, the mean of (0, 0, 1) and the normals
    # of both faces by area; so lift it by so little that these are (0, 0, 1) to rounding.
    V, F = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), [[0, 1, 2], [0, 2, 3]]
    lifted = V + np.array([[0, 0, 1e-6], [0, 0, 0], [0, 0, 0], [0, 0, 0]])
    assert true_risk(lifted, V, F) == pytest.approx(3 / 5 * 1e-12, rel=1e-9)
    # What all vertices have in common, or what moves them along the plane, turns no normal.
    assert true_risk(V + [0, 0, 5.0], V, F) == pytest.approx(0, abs=1e-25)
    assert true_risk(V * 2, V, F) == pytest.approx(0, abs=1e-25)
    with pytest.raises(MeshError, match="V_true"):
        true_risk(V, V[:3], F)


def test_a_linear_filter_on_a_plane_by_hand():
    # V~ = V + s (W~ - I) V moves heights only, and the noisy mesh's normals hardly differ.
    V, F = grid(60)
    A = operators.averaging(weights.combinatorial(F, len(V)))
    sigma, rng = 1e-3, np.random.default_rng(0)
    length = mesh.mean_edge_length(V, F)
    noisy = V + np.array([0, 0, sigma * length]) * rng.standard_normal((len(V), 1))
    risk = SURE(noisy, F, np.random.default_rng(1), sigma=sigma)

    def filtered(X, s):
        return np.column_stack([V[:, :2], X[:, 2] + s * (A @ X[:, 2] - X[:, 2])])

    D = Edges(F).ends
    # Both sides are means over about 10,700 edges of squared or multiplied normal numbers,
    # each vertex in six of them: four standard errors are 4 sqrt(2 * 6 / 10,700) = 13 % of
    # the noise's own difference, 2 sigma^2.
    scale = 2 * (sigma * length) ** 2
    for s in (0.0, 0.3, 0.7, 1.0):
        found = risk(filtered(noisy, s), filtered(risk.V_perturbed, s))
        error = filtered(noisy, s)[:, 2]  # the clean heights are 0
        expected = np.mean((error[D[:, 0]] - error[D[:, 1]]) ** 2)
        assert found == pytest.approx(expected, abs=0.13 * scale)


def test_the_noisy_mesh_itself():
    V, F = shapes.icosphere(5)
    rng = np.random.default_rng(4)
    noisy = noise.along_normals(V, F, 0.1, rng)
    risk = SURE(noisy, F, rng, sigma=0.1)
    # The filter that does nothing follows all of the noise: 2 sigma^2 exactly, but for the
    # probe's own mean square along the edges (30,720 signs' products: 1 +- 4 sqrt(1/30,720)).
    length = mesh.mean_edge_length(noisy, F)
    found = risk(noisy, risk.V_perturbed)
    assert found == pytest.approx(2 * (0.1 * length) ** 2, rel=2 * 4 / np.sqrt(30720))


@pytest.mark.parametrize("weight", ["combinatorial", "cotangent"])
def test_it_finds_when_to_stop(weight):
    from meshfair import filters

    V, F = shapes.torus(sections=80, sides=32)
    noisy = noise.along_normals(V, F, 0.15, np.random.default_rng(3))
    risk = SURE(noisy, F, np.random.default_rng(0))
    runs = (filters.taubin(X, F, weights=weight, iterations=20) for X in (noisy, risk.V_perturbed))
    guess, true = [], []
    for (_, X), (_, Y) in zip(*runs, strict=True):
        guess.append(risk(X, Y))
        true.append(true_risk(X, V, F))
    assert true[np.argmin(guess)] < 1.1 * min(true)
    assert np.corrcoef(guess, true)[0, 1] > 0.99


def test_scale_motion_and_units():
    V, F = shapes.torus(sections=30, sides=12)
    noisy = noise.along_normals(V, F, 0.2, np.random.default_rng(3))
    risk = SURE(noisy, F, np.random.default_rng(0))
    larger = SURE(10 * noisy + 5, F, np.random.default_rng(0))
    np.testing.assert_allclose(larger.V_perturbed, 10 * risk.V_perturbed + 5, atol=1e-10)
    smooth, probed = 0.9 * noisy, 0.9 * risk.V_perturbed
    assert larger(10 * smooth + 5, 10 * probed + 5) == pytest.approx(100 * risk(smooth, probed))


def test_what_it_refuses():
    V, F = grid(3)
    with pytest.raises(TypeError, match="rng is 7"):
        SURE(V, F, 7)
    with pytest.raises(ValueError, match="sigma"):
        SURE(V, F, np.random.default_rng(0), sigma=-1)
    with pytest.raises(MeshError):
        SURE(V, F + 100, np.random.default_rng(0))
    with pytest.raises(MeshError, match="all edges have length 0"):
        SURE(np.zeros((3, 3)), np.array([[0, 1, 2]]), np.random.default_rng(0))
