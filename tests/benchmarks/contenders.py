"""What is measured: for each task, how each library does it.

A contender prepares what a user has at hand before the task (the library's own
mesh object, the known operator) and returns a function that does the task.
"""

from collections.abc import Callable
from typing import NamedTuple
from unittest import mock

import numpy as np
from scipy.sparse import csr_array, diags_array

STEPS = 20  # of the tasks "steps" and "flow"
LONG_STEP = 10  # of the implicit step, in squared mean edge lengths
TOLERANCE = 1e-8


class Known(NamedTuple):
    """What is known of the mesh before a step is measured."""

    V: np.ndarray
    F: np.ndarray
    A: csr_array
    """Averaging operator with equal weights."""
    system: csr_array
    """M + t L with cotangent weights."""
    rhs: np.ndarray
    """M V, around the centre."""
    start: np.ndarray
    """V around its centre."""


def known(V, F):
    """Build the operators that the steps need."""
    from meshfair import mesh, operators, weights

    A = operators.averaging(weights.combinatorial(F, len(V)))
    L = operators.laplacian(weights.cotangent(V, F))
    M = operators.mass(V, F)
    t = LONG_STEP * mesh.mean_edge_length(V, F) ** 2
    X = V - V.mean(axis=0)
    return Known(V, F, A, csr_array(M + t * L), M @ X, X)


# Cotangent weights.


def weights_known_edges(k):
    from meshfair import mesh, weights

    edges = mesh.Edges(k.F, len(k.V))
    return lambda: weights.cotangent(k.V, edges)


def weights_from_nothing(k):
    from meshfair import weights

    return lambda: weights.cotangent(k.V, k.F)


def without_loops(run):
    """The same without compiled loops, as for a small mesh: NumPy and SciPy alone."""

    def plain():
        from meshfair import _fast

        with mock.patch.object(_fast, "wanted", return_value=False):
            return run()

    return plain


def weights_plain(k):
    return without_loops(weights_from_nothing(k))


def weights_libigl(k):
    import igl

    return lambda: igl.cotmatrix(k.V, k.F)


def weights_gpytoolbox(k):
    import gpytoolbox

    return lambda: gpytoolbox.cotangent_laplacian(k.V, k.F)


def weights_potpourri3d(k):
    import potpourri3d

    return lambda: potpourri3d.cotan_laplacian(k.V, k.F)


# Libraries give W, L or -L: compare what L does to V.


def from_weights(k, W):
    return W.sum(axis=1)[:, None] * k.V - W @ k.V


def from_laplacian(k, L):
    return L @ k.V


def from_negative_laplacian(k, L):
    return -(L @ k.V)


# Averaging with equal weights: one step, or many in one call.


def steps_meshfair(k, steps):
    from meshfair import flow

    return lambda: flow.average(k.V, k.A, steps)


def steps_scipy(k, steps):
    def run():
        V = k.V
        for _ in range(steps):
            V = k.A @ V
        return V

    return run


def steps_trimesh(k, steps):
    import trimesh

    mesh = trimesh.Trimesh(k.V, k.F, process=False)
    operator = trimesh.smoothing.laplacian_calculation(mesh, equal_weight=True)

    def run():
        return trimesh.smoothing.filter_laplacian(
            mesh, lamb=1.0, iterations=steps, volume_constraint=False, laplacian_operator=operator
        ).vertices.copy()

    return run


def steps_open3d(k, steps):
    import open3d

    mesh = open3d.geometry.TriangleMesh(
        open3d.utility.Vector3dVector(k.V), open3d.utility.Vector3iVector(k.F.astype(np.int32))
    )
    mesh.compute_adjacency_list()
    return lambda: np.asarray(mesh.filter_smooth_simple(number_of_iterations=steps).vertices)


def steps_pyvista(k, steps):
    import pyvista

    mesh = pyvista.PolyData.from_regular_faces(k.V, k.F)
    return lambda: (
        mesh.smooth(
            n_iter=steps, relaxation_factor=1.0, feature_smoothing=False, convergence=0.0
        ).points
    )


def steps_pymeshlab(k, steps):
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(k.V, k.F.astype(np.int32)))

    def run():
        meshes.apply_coord_laplacian_smoothing(stepsmoothnum=steps, cotangentweight=False)
        return meshes.current_mesh().vertex_number()

    return run


# The implicit step (M + t L) X = M V: all of it, from the matrices to the new places.


def implicit_meshfair(k):
    from meshfair import solve

    return lambda: solve.spd(k.system, k.rhs, guess=k.start, tolerance=TOLERANCE)


def implicit_scipy(k):
    from scipy.sparse.linalg import cg

    def run():
        jacobi = diags_array(1 / k.system.diagonal())
        columns = zip(k.rhs.T, k.start.T, strict=True)
        return np.column_stack(
            [cg(k.system, b, x, rtol=TOLERANCE, M=jacobi)[0] for b, x in columns]
        )

    return run


def implicit_pyamg(k):
    import pyamg
    from scipy.sparse import csr_matrix

    A = csr_matrix(k.system)

    def run():
        levels = pyamg.smoothed_aggregation_solver(A)
        columns = zip(k.rhs.T, k.start.T, strict=True)
        return np.column_stack(
            [levels.solve(b, x0=x, tol=TOLERANCE, accel="cg") for b, x in columns]
        )

    return run


def implicit_pyamg_tuned(k):
    import pyamg
    from scipy.sparse import csr_matrix
    from scipy.sparse.linalg import cg

    A = csr_matrix(k.system)
    smoother = ("gauss_seidel", {"sweep": "symmetric"})

    def run():
        # The quickest of the settings that were tried: no improved candidates, every
        # connection strong, one symmetric sweep before and after, as a preconditioner.
        levels = pyamg.smoothed_aggregation_solver(
            A, symmetry="symmetric", strength=None, improve_candidates=None,
            presmoother=smoother, postsmoother=smoother,
        )  # fmt: skip
        cycle = levels.aspreconditioner()
        columns = zip(k.rhs.T, k.start.T, strict=True)
        return np.column_stack([cg(A, b, x, rtol=TOLERANCE, M=cycle)[0] for b, x in columns])

    return run


def implicit_cholespy(k):
    from cholespy import CholeskySolverD, MatrixType

    A = k.system.tocoo()
    i, j = (index.astype(np.int32) for index in A.coords)

    def run():
        X = np.zeros_like(k.rhs)
        CholeskySolverD(len(k.V), i, j, A.data, MatrixType.COO).solve(k.rhs, X)
        return X

    return run


# The original report's experiment on one mesh: three weights, twenty steps, the SNR at each.


def flow_meshfair(k):
    from meshfair import flow, mesh, noise, operators, weights

    V_noisy = noise.along_normals(k.V, k.F, 0.2, np.random.default_rng(0))

    def run():
        edges = mesh.Edges(k.F, len(k.V))
        curves = [
            flow.snr_curve(V_noisy, k.V, operators.averaging(W), 0.6, 0.6 * STEPS)
            for W in (
                weights.combinatorial(edges, len(k.V)),
                weights.distance(V_noisy, edges),
                weights.cotangent(V_noisy, edges),
            )
        ]
        return np.concatenate(curves)

    return run


def flow_plain(k):
    return without_loops(flow_meshfair(k))


def as_it_is(k, result):
    return np.asarray(result)


class Contender(NamedTuple):
    """One way to do one task."""

    task: str
    name: str
    library: str
    """What it imports; without it the contender is left out."""
    prepare: Callable
    """From what is `Known` to a function that does the task."""
    answer: Callable = as_it_is
    """From what is known and the result to an array that can be compared."""
    within: float | None = 1e-9
    """How far the answer may be from ours, relative; None where the algorithm is another one."""


def _averaging(task, steps):
    """The contenders for so many steps in one call."""

    def of(function):
        return lambda k: function(k, steps)

    return [
        Contender(task, "ours", "meshfair", of(steps_meshfair)),
        Contender(task, "SciPy product", "scipy", of(steps_scipy)),
        # These are not quite the same: in trimesh an open edge counts one way, in Open3D and
        # PyMeshLab a vertex is one of its neighbours, PyVista moves the vertices in turn.
        Contender(task, "trimesh", "trimesh", of(steps_trimesh), within=None),
        Contender(task, "Open3D", "open3d", of(steps_open3d), within=None),
        Contender(task, "PyVista", "pyvista", of(steps_pyvista), within=None),
        Contender(task, "PyMeshLab", "pymeshlab", of(steps_pymeshlab), within=None),
    ]


# The first of each task is ours, to which the others are compared.
CONTENDERS = [
    Contender("weights", "ours, edges known", "meshfair", weights_known_edges, from_weights),
    Contender("weights", "ours, from nothing", "meshfair", weights_from_nothing, from_weights),
    Contender("weights", "plain NumPy", "scipy", weights_plain, from_weights),
    Contender("weights", "libigl", "igl", weights_libigl, from_negative_laplacian),
    Contender("weights", "gpytoolbox", "gpytoolbox", weights_gpytoolbox, from_laplacian),
    Contender("weights", "potpourri3d", "potpourri3d", weights_potpourri3d, from_laplacian),
    *_averaging("step", 1),
    *_averaging("steps", STEPS),
    Contender("implicit", "ours", "meshfair", implicit_meshfair),
    Contender("implicit", "SciPy CG, diagonal", "scipy", implicit_scipy, within=1e-5),
    Contender("implicit", "PyAMG", "pyamg", implicit_pyamg, within=1e-5),
    Contender("implicit", "PyAMG, tuned", "pyamg", implicit_pyamg_tuned, within=1e-5),
    Contender("implicit", "cholespy", "cholespy", implicit_cholespy, within=1e-5),
    Contender("flow", "ours", "meshfair", flow_meshfair),
    Contender("flow", "plain NumPy, SciPy product", "scipy", flow_plain),
]
