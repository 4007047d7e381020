import numpy as np
import pytest
from scipy.sparse import csr_array

from meshfair import noise, operators, shapes, stability, weights
from test_operators import all_weights, generalised


@pytest.mark.parametrize("subdivisions", [1, 3])  # a dense and a sparse eigenvalue problem
def test_stable_step_is_two_over_the_largest_eigenvalue(subdivisions, rng):
    V, F = shapes.icosphere(subdivisions)
    V = noise.gaussian(V, F, 0.5, rng)
    for W in all_weights(V, F).values():
        bound = stability.stable_step(operators.averaging(W))
        # 1e-3 is the accuracy asked of the eigenvalue.
        assert bound == pytest.approx(2 / generalised(W).max(), rel=2e-3)


def test_stable_step_separates_decay_from_growth(rng):
    V, F = shapes.icosphere(2)
    V = noise.gaussian(V, F, 0.5, rng)
    A = operators.averaging(weights.cotangent(V, F))
    bound = stability.stable_step(A)
    x = rng.standard_normal(len(V))

    def size_after(tau, steps=3000):
        y = x.copy()
        for _ in range(steps):
            y = (1 - tau) * y + tau * (A @ y)
        return np.abs(y).max()

    assert size_after(0.99 * bound) <= np.abs(x).max() * 10
    assert size_after(1.01 * bound) > np.abs(x).max() * 1e6


def test_what_is_surely_stable_is_stable(rng):
    V, F = shapes.icosphere(3)
    for size in (0, 0.2, 0.5):
        V_noisy = noise.gaussian(V, F, size, rng)
        M = operators.mass(V_noisy, F)
        for W in all_weights(V_noisy, F).values():
            for A in (operators.averaging(W), operators.diffusion(W, M)):
                bound = stability.stable_step(A)
                assert not stability.surely_stable(A, 1.002 * bound)
                assert stability.surely_stable(A, 0.6 * bound)


def test_the_step_of_the_identity_and_of_any_unit():
    one = csr_array(np.eye(200))
    assert stability.stable_step(one) == np.inf
    assert stability.surely_stable(one, 1e300)
    V, F = shapes.icosphere(3)
    steps = []
    for s in (1, 1e-30):
        A = operators.diffusion(weights.cotangent(s * V, F), operators.mass(s * V, F))
        steps.append(stability.stable_step(A))
    assert steps[1] == pytest.approx(1e-60 * steps[0], rel=2e-3)


def test_the_step_of_a_rotation_is_that_of_its_eigenvalues():
    # I - A turns the plane by 60 degrees: mu = exp(+-i pi / 3), 2 Re(mu) / |mu|^2 = 1.
    c, s = 0.5, np.sqrt(3) / 2
    A = csr_array(np.eye(2) - [[c, -s], [s, c]])
    assert stability.stable_step(A) == pytest.approx(1, rel=1e-12)


def test_no_step_is_stable_where_a_mode_grows_by_itself():
    assert stability.stable_step(csr_array([[3.0, 0], [0, 1]])) == 0


def test_bounds_by_hand():
    # |I - A| has rows 0.5 + 0.5 and 1 + 1: Gershgorin's bound is 2, the spectral radius 1.5.
    A = csr_array([[0.5, 0.5], [1.0, 0.0]])
    assert stability.surely_stable(A, 1.0)
    # x = (1, 1), (3/2, 2), (5/2, 4), (9/2, 8), (17/2, 16) give 2, 7/4, 13/8, 25/16, 49/32.
    assert stability.surely_stable(A, 1.3)  # 2 / 1.3 = 1.538 is above the last
    assert not stability.surely_stable(A, 1.34)  # and 2 / 1.34 below the radius


@pytest.mark.parametrize("tau", [0, -1, np.nan])
def test_a_step_that_is_none(tau):
    with pytest.raises(ValueError, match="tau is"):
        stability.surely_stable(csr_array(np.eye(3)), tau)
