"""numba is optional: without it the same comes out, more slowly."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from meshfair import (
    _fast,
    denoise,
    denoising,
    flow,
    intrinsic,
    mesh,
    metrics,
    noise,
    operators,
    shapes,
    solve,
    stability,
    weights,
)

HERE = Path(__file__).parent

CODE = """
import sys
sys.modules["numba"] = sys.modules["llvmlite"] = None  # to import them raises ImportError
import numpy as np, test_without_numba
np.savez(sys.argv[1], **test_without_numba.core())
"""


def core():
    """What the core computes, by name: on a mesh that is large enough for the compiled loops."""
    V_true, F = shapes.torus(sections=220, sides=100)
    assert len(V_true) > _fast.ROWS
    V = noise.along_normals(V_true, F, 0.2, np.random.default_rng(7))
    edges = mesh.Edges(F, len(V))
    W = weights.cotangent(V, edges)
    A, L, M = operators.averaging(W), operators.laplacian(W), operators.mass(V, F)
    found = {
        "edges": edges.ends,
        "combinatorial": weights.combinatorial(F, len(V)).data,
        "distance": weights.distance(V, F).data,
        "cotangent": W.data,
        "intrinsic": intrinsic.cotangent(V, F).data,
        "averaging": A.data,
        "mass": M.data,
        "stable step": stability.stable_step(A),
        "average": flow.average(V, A, 5),
        "snr curve": flow.snr_curve(V, V_true, A, 0.5, 2.0),
        "implicit step": solve.implicit_step(V, L, M, 1e-3, method="iterative"),
        "reordered": mesh.reorder(V, F)[0],
        "taubin": denoise(V, F, "taubin", iterations=4).V,
        "bilateral normals": denoise(V, F, "bilateral-normal", normal_iterations=2).V,
    }
    V_true, F = shapes.icosphere(3)
    V = noise.along_normals(V_true, F, 0.2, np.random.default_rng(7))
    for method in denoising.methods():
        result = denoise(V, F, method)
        assert result.finished
        found[f"small, {method}"] = result.V
    found["snr"] = metrics.snr(V_true, V)
    return found


@pytest.fixture(scope="module")
def without(tmp_path_factory):
    """The same from a process in which numba cannot be imported."""
    file = tmp_path_factory.mktemp("without") / "found.npz"
    command = [sys.executable, "-W", "error", "-c", CODE, str(file)]
    done = subprocess.run(command, cwd=HERE, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with np.load(file) as arrays:
        return dict(arrays)


def test_without_numba_the_same_comes_out(without):
    pytest.importorskip("numba", reason="nothing to compare with")
    found = core()
    assert "numba" in sys.modules
    assert without.keys() == found.keys()
    for name, expected in found.items():
        assert np.isfinite(without[name]).all(), name
        # Sums in another order, amplified by slivers; the solver ends within 1e-8 of the solution.
        scale = np.abs(expected).max()
        np.testing.assert_allclose(without[name], expected, rtol=0, atol=1e-6 * scale, err_msg=name)
