"""Input validation: in `meshfair.checks`, and in every public function that takes a mesh."""

import inspect
import re
from types import ModuleType

import numpy as np
import pytest
from scipy.sparse import coo_array, csr_array, eye_array

import meshfair
from meshfair import MeshError, denoise, filters, flow, noise, operators, shapes, viewer, weights
from meshfair.checks import (
    check_choice,
    check_count,
    check_direction,
    check_fixed,
    check_mesh,
    check_number,
    check_operator,
    check_range,
    check_rng,
    check_square,
    check_values,
)

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


# ---- Every public function that takes a mesh checks it


def public_functions():
    """Each public function, or class that is no result, whose parameters include V and F."""
    found = {}
    for name in meshfair.__all__:
        module = getattr(meshfair, name)
        if not isinstance(module, ModuleType) or name == "checks":
            continue
        for key in getattr(module, "__all__", vars(module)):
            function = getattr(module, key)
            if (
                key.startswith("_")
                or not callable(function)
                or not getattr(function, "__module__", "").startswith(f"meshfair.{name}")
                or (isinstance(function, type) and issubclass(function, (tuple, Exception)))
            ):
                continue
            if {"V", "F"} <= set(inspect.signature(function).parameters):
                found[f"{name}.{key}"] = function
    return found


FUNCTIONS = public_functions()
# These take arrays that were checked already, and are called in every iteration of a filter,
# on the results of an experiment, or by `io.read`.
TRUSTING = {"mesh.face_shapes", "experiments.part_errors", "io.Attributes"}
# Widgets: they hand the mesh to a View, which checks it.
WIDGETS = {name for name in FUNCTIONS if name.startswith("explorers.")}
CHECKING = {name: FUNCTIONS[name] for name in FUNCTIONS if name not in TRUSTING | WIDGETS}

# What other parameters get, by their names, where they have no default: so a function with a
# new one fails until it has a value here. `noise.add` needs a size, though it has a default.
VALUES = {
    "camera": viewer.Camera((9.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "cell": 1.5,
    "fraction": 0.5,
    "method": "heat",
    "model": "gaussian",
    "parameters": "default",
    "sigma": 0.1,
}
OTHER_POSITIONS = {"V_true", "V_noisy", "ground_truth", "X"}


def call(name, V, F, good, folder):
    """Call a public function with a mesh, which a good one is compared with."""
    function = CHECKING[name]
    given = {"V": V, "F": F}
    for key, parameter in inspect.signature(function).parameters.items():
        is_given = key in given or parameter.kind is parameter.VAR_KEYWORD
        if is_given or parameter.default is not parameter.empty:
            continue
        if key in OTHER_POSITIONS:
            given[key] = good[0]
        elif key == "F_true":
            given[key] = good[1]
        elif key == "rng":
            given[key] = np.random.default_rng(0)
        elif key == "path":
            given[key] = folder / "mesh.ply"
        else:
            given[key] = VALUES[key]
    if name == "noise.add":
        given["size"] = 0.1
    result = function(**given)
    return next(result) if inspect.isgenerator(result) else result


@pytest.mark.parametrize("name", CHECKING)
def test_every_public_function_refuses_what_is_no_mesh(name, tmp_path):
    for bad_V, bad_F, _ in BAD:
        with pytest.raises(MeshError):
            call(name, bad_V, bad_F, (V, F), tmp_path)


@pytest.mark.parametrize("name", [name for name in CHECKING if not name.startswith("viewer.")])
def test_it_is_the_mesh_that_is_refused(name, tmp_path):
    """With a good mesh the same call works (those that show something have tests of their own)."""
    good = shapes.icosphere(1)
    call(name, *good, good, tmp_path)
    call(name, *(array.tolist() for array in good), good, tmp_path)  # lists are meshes, too


def test_the_functions_are_found():
    assert len(CHECKING) > 40
    assert {name.split(".")[0] for name in CHECKING} >= {
        "mesh", "io", "noise", "metrics", "weights", "intrinsic", "operators", "reference",
        "filters", "sure", "denoising", "viewer",
    }  # fmt: skip
    assert set(FUNCTIONS) >= TRUSTING  # no name in it is out of date


# ---- Numbers, choices and generators


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, -1, "x", None, [1, 2], 1j])
def test_bad_numbers_are_refused(bad):
    with pytest.raises(ValueError, match=r"^size is .*; give a number of at least 0$"):
        check_number(bad, "size", 0)


def test_bounds_of_numbers():
    assert check_number(np.float32(0.5), "size", 0, 1) == 0.5
    assert isinstance(check_number(1, "size", 0, 1), float)
    assert (check_number(0, "size", 0, 1), check_number(1, "size", 0, 1)) == (0, 1)
    assert check_number("1e-300", "size", 0, open_low=True) == 1e-300
    with pytest.raises(ValueError, match=r"^size is 0; give a number above 0 and at most 1$"):
        check_number(0, "size", 0, 1, open_low=True)
    with pytest.raises(ValueError, match=r"and at most 1$"):
        check_number(1.0001, "size", 0, 1)


@pytest.mark.parametrize("bad", [1, -3, 2.0, np.float64(3), "3", None, True, [3]])
def test_bad_counts_are_refused(bad):
    with pytest.raises(ValueError, match=r"^sides is .*; give a whole number of at least 2$"):
        check_count(bad, "sides", 2)


def test_counts_of_any_integer_type():
    for good in (2, np.int8(2), np.uint64(2)):
        assert check_count(good, "sides", 2) == 2
        assert type(check_count(good, "sides", 2)) is int
    assert check_count(0, "iterations") == 0
    with pytest.raises(ValueError, match="at least 0"):
        check_count(-1, "iterations")


def test_choices():
    choices = {"keep": 1, "clamp": 2}
    assert check_choice("clamp", "negative", choices) == "clamp"
    assert check_choice(None, "orient", (None, "outward")) is None
    for bad in ("drop", "", "KEEP", None, 0, ["keep"]):
        hint = re.escape(" (did you mean 'keep'?)") if bad == "KEEP" else ""
        with pytest.raises(ValueError, match=rf"^negative is .*; give one of keep, clamp{hint}$"):
            check_choice(bad, "negative", choices)


def test_generators():
    rng = np.random.default_rng(1)
    assert check_rng(rng) is rng
    for bad in (np.random.RandomState(1), 1, None, np.random):
        with pytest.raises(TypeError, match=r"default_rng"):
            check_rng(bad)


# ---- Fixed vertices


@pytest.mark.parametrize(
    ("fixed", "mask"),
    [
        (None, [0, 0, 0, 0]),
        ([], [0, 0, 0, 0]),
        ([2, 0, 2], [1, 0, 1, 0]),
        (np.array([3], dtype=np.uint8), [0, 0, 0, 1]),
        ([True, False, False, True], [1, 0, 0, 1]),
        (np.zeros(4, bool), [0, 0, 0, 0]),
        (range(4), [1, 1, 1, 1]),
    ],
)
def test_fixed_vertices_as_a_mask_or_as_indices(fixed, mask):
    checked = check_fixed(fixed, 4)
    assert checked.dtype == bool
    assert checked.tolist() == [bool(x) for x in mask]


def test_a_mask_is_copied():
    mask = np.ones(3, bool)
    check_fixed(mask, 3)[0] = False
    assert mask.all()


@pytest.mark.parametrize(
    ("fixed", "message"),
    [
        ([4], r"vertex index 4, but there are 4 vertices \(0 to 3\)"),
        ([1, -1], "vertex index -1"),
        ([0.0, 1.0], "of type float64"),
        (["a"], "of type <U1"),
        ([[0, 1]], "boolean mask or vertex indices"),
        (2, "boolean mask or vertex indices"),
        ([True, False], r"shape \(2,\); a mask needs \(4,\)"),
        (np.ones((4, 1), bool), r"shape \(4, 1\)"),
        (True, r"shape \(\)"),
    ],
)
def test_bad_fixed_vertices_are_named(fixed, message):
    with pytest.raises(MeshError, match=message):
        check_fixed(fixed, 4)


# ---- Matrices


def with_entry(value, column=1):
    """A sound matrix of 3 x 3 but for one entry."""
    A = csr_array(eye_array(3) + coo_array(([1.0], ([0], [1])), shape=(3, 3)))
    A.data[1] = value
    A.indices[1] = column
    return A


def test_a_good_matrix_is_not_copied():
    A = with_entry(2.0)
    assert check_square(A) is A
    assert check_operator(A, 3) is A


@pytest.mark.parametrize(
    "make", [np.eye, lambda n: eye_array(n, format="coo"), lambda n: np.eye(n, dtype=int)]
)
def test_other_matrices_become_rows_of_float64(make):
    A = check_square(make(3))
    assert isinstance(A, csr_array)
    assert A.dtype == np.float64
    np.testing.assert_array_equal(A.toarray(), np.eye(3))


@pytest.mark.parametrize(
    ("A", "message"),
    [
        (with_entry(np.nan), "W holds NaN or infinite entries"),
        (with_entry(np.inf), "W holds NaN or infinite entries"),
        (with_entry(-np.inf), "W holds NaN or infinite entries"),
        (with_entry(1.0, column=3), "W has an entry in a column that it does not have"),
        (with_entry(1.0, column=-1), "W has an entry in a column that it does not have"),
        (np.ones((3, 4)), r"W has shape \(3, 4\); give a square sparse matrix"),
        (np.ones(3), r"W has shape \(3,\)"),
        (7, r"W has shape \(\)"),
    ],
)
def test_bad_matrices_are_named(A, message):
    with pytest.raises(MeshError, match=message):
        check_square(A, "W")
    with pytest.raises(MeshError):
        check_operator(A, 3)


def test_large_entries_are_finite_though_their_sum_is_not():
    A = csr_array(np.array([[1e308, 1e308], [1e308, 1.0]]))
    assert check_square(A) is A


def test_operators_of_another_mesh_are_refused():
    A = operators.averaging(weights.combinatorial(F, 3))
    for entries in (True, False):
        with pytest.raises(MeshError, match=r"shape \(3, 3\), but V has 4 .*from the same mesh"):
            check_operator(A, 4, entries=entries)
    with pytest.raises(MeshError, match="build it from the same mesh"):
        flow.average(np.zeros((4, 3)), A, 1)


def test_a_step_that_looks_at_all_entries_spares_their_check():
    assert check_operator(with_entry(np.nan), 3, entries=False).nnz == 4


def test_values_are_one_number_for_each_vertex_or_face():
    for good, n, m in (([1, 2, 3], 3, 1), ([4], 3, 1)):
        checked = check_values(good, n, m)
        assert checked.dtype == np.float64
        assert checked.tolist() == good
    array = np.zeros(3)
    assert not np.shares_memory(check_values(array, 3, 1), array)
    for bad, message in (
        ([1, 2], r"shape \(2,\); give one number for each of the 3 vertices or of the 1 faces"),
        (np.zeros((3, 1)), "shape"),
        ([0, np.nan, 1], "number 1 is nan"),
        (["1", "2", "3"], "values of type"),
        ([1j, 0, 0], "values of type complex128"),
        ([0, [1, 2], 3], "different lengths"),
    ):
        with pytest.raises(MeshError, match=f"values.*{message}"):
            check_values(bad, 3, 1)


def test_ranges_and_directions():
    assert check_range(np.array([1, 2]), "limits") == (1.0, 2.0)
    assert check_range((1, 1), "limits") == (1.0, 1.0)
    for bad in ((2, 1), (0, np.nan), (0, np.inf), (1,), (1, 2, 3), 1, None, "ab"):
        with pytest.raises(ValueError, match=r"limits is .*; give two numbers"):
            check_range(bad, "limits")
    np.testing.assert_allclose(check_direction([0, 3, 4], "up"), [0, 0.6, 0.8])
    for bad in ((0, 0, 0), (1, 2), (1, np.nan, 0), (np.inf, 0, 0), "up", None, [[1, 0, 0]]):
        with pytest.raises(ValueError, match=r"up is .*; give three numbers"):
            check_direction(bad, "up")


def test_warnings_name_the_line_that_called_the_package():
    V, F = shapes.icosphere(1)
    soup = V[F].reshape(-1, 3), np.arange(F.size).reshape(-1, 3)
    rng = np.random.default_rng(1)
    A = operators.averaging(weights.combinatorial(F, len(V)))
    calls = (
        lambda: noise.along_normals(*soup, 0.1, rng),
        lambda: noise.add(*soup, "normals", rng, size=0.1),
        lambda: denoise(*soup),
        lambda: list(filters.sun(*soup)),
        lambda: weights.cotangent(V, [[0, 1, 1], *F]),
        lambda: list(flow.heat(V, A, 1.5, 3)),
        lambda: list(filters.heat(V, F, tau=1.5, time=3)),
    )
    for call in calls:
        with pytest.warns() as caught:
            call()
        assert {warning.filename for warning in caught} == {__file__}
