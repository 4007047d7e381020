import numpy as np
import pytest

from meshfair import MeshError, flow, mesh, metrics, noise, operators, weights
from meshfair.checks import check_mesh, check_number, check_rng

V = np.eye(3)
F = np.array([[0, 1, 2]])


def test_lists_and_other_types_are_accepted():
    checked_V, checked_F = check_mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    assert checked_V.dtype == np.float64
    assert checked_F.dtype == np.int64
    V32, F8 = check_mesh(V.astype("f4"), F.astype("u1"))
    assert (V32.dtype, F8.dtype) == (np.float64, np.int64)


def test_a_good_array_is_not_copied():
    checked_V, checked_F = check_mesh(V, F)
    assert np.shares_memory(checked_V, V)
    assert np.shares_memory(checked_F, F)


BAD = [
    (V[:, :2], F, r"V has shape \(3, 2\)"),
    (V[0], F, r"V has shape \(3,\)"),
    ([[0, 0, 0], [1, 0]], F, "different lengths"),
    ([["a", "b", "c"]], F, "values of type"),
    (V.astype(complex), F, "values of type complex"),
    (np.where(np.eye(3) == 1, np.nan, 0), F, "vertex 0 has x = nan"),
    (np.array([[0, 0, 0], [0, 0, np.inf], [0, 1, 0]]), F, "vertex 1 has z = inf"),
    (np.array([[0, 0, 0], [0, 0, 1], [0, -1e200, 0]]), F, "vertex 2 has y = -1e"),
    (np.zeros((0, 3)), F, "no vertices"),
    (V, np.zeros((0, 3), int), "no faces"),
    (V, [], "no faces"),
    (V, [[0, 1, 3]], r"face 0 has vertex index 3, but there are 3 vertices \(0 to 2\)"),
    (V, [[0, 1, 2], [0, -1, 2]], "face 1 has vertex index -1"),
    (V, [[0, 1, 2, 0]], r"F has shape \(1, 4\)"),
    (V, [[0.0, 1.0, 2.0]], "values of type float64; give integers"),
]


@pytest.mark.parametrize(("bad_V", "bad_F", "message"), BAD)
def test_bad_meshes_are_named(bad_V, bad_F, message):
    with pytest.raises(MeshError, match=message):
        check_mesh(bad_V, bad_F)


RNG = np.random.default_rng(0)
# Every public function that takes a mesh goes through the gate.
DOORS = {
    "normals": lambda V, F: noise.along_normals(V, F, 0.1, RNG),
    "gaussian": lambda V, F: noise.gaussian(V, F, 0.1, RNG),
    "impulsive": lambda V, F: noise.impulsive(V, F, 0.1, 0.5, RNG),
    "distance": weights.distance,
    "cotangent": weights.cotangent,
    "mass": operators.mass,
    "face_normals": mesh.face_normals,
    "vertex_normals": mesh.vertex_normals,
    "volume": mesh.volume,
    "normal_angle": lambda V, F: metrics.normal_angle(V, V, F),
    "surface_distance": lambda V, F: metrics.surface_distance(V, V, F),
    "volume_change": lambda V, F: metrics.volume_change(V, V, F),
}


@pytest.mark.parametrize("door", DOORS.values(), ids=DOORS)
def test_every_door_has_the_gate(door):
    for bad_V, bad_F, _ in BAD:
        with pytest.raises(MeshError):
            door(bad_V, bad_F)


def test_numbers_and_generators():
    for bad in (np.nan, np.inf, -1, "x", None):
        with pytest.raises(ValueError, match="size is"):
            check_number(bad, "size", 0)
    with pytest.raises(TypeError, match="default_rng"):
        check_rng(np.random.RandomState(1))


def test_operators_of_another_mesh_are_refused():
    A = operators.averaging(weights.combinatorial(F, 3))
    with pytest.raises(MeshError, match="build it from the same mesh"):
        flow.average(np.zeros((4, 3)), A, 1)
