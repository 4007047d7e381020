"""The front: every filter by name; automatic parameters against those that the clean mesh picks."""

import numpy as np
import pytest

import meshfair
from meshes import pair
from meshfair import denoising, filters, metrics, noise, operators, shapes, solve, weights
from meshfair.denoising import registry

NAMES = [
    "averaging", "heat", "implicit", "regularised", "taubin", "bilateral", "sun",
    "bilateral-normal", "guided-normal", "l0", "feature-convinced", "learned",
]  # fmt: skip
QUICK = [name for name in NAMES if name != "l0"]


@pytest.fixture
def noisy_box():
    V, F = shapes.box(segments=10)
    return noise.along_normals(V, F, 0.2, np.random.default_rng(2)), V, F


def test_every_filter_has_its_name():
    assert set(denoising.methods()) >= set(NAMES)
    assert {name.replace("-", "_") for name in NAMES} == set(filters.__all__)


@pytest.mark.parametrize("method", NAMES)
def test_a_method_is_its_filter_with_what_is_recorded(method, noisy_box):
    V, clean, F = noisy_box
    result = meshfair.denoise(V, F, method, ground_truth=clean)
    states = list(getattr(filters, method.replace("-", "_"))(V, F, **result.parameters))
    np.testing.assert_array_equal(result.V, states[-1][1])
    assert set(result.parameters) == set(denoising.defaults(method))
    assert "fixed" in result.parameters
    assert result.finished
    assert result.seconds > 0
    history = result.history
    assert list(history.columns) == ["iteration", "normal_angle", "snr"]
    assert history["snr"].iloc[0] == metrics.snr(clean, V)
    assert history["snr"].iloc[-1] == metrics.snr(clean, result.V)
    assert history["normal_angle"].iloc[-1] == metrics.normal_angle(result.V, clean, F)
    assert result.ratio is None
    assert result.reason is None


@pytest.mark.parametrize("method", QUICK)
def test_automatic_parameters_give_the_same_mesh_again(method, noisy_box):
    V, clean, F = noisy_box
    auto = meshfair.denoise(V, F, method, parameters="auto", ground_truth=clean)
    again = meshfair.denoise(V, F, method, **auto.parameters)
    np.testing.assert_array_equal(auto.V, again.V)
    assert auto.history["snr"].iloc[-1] == metrics.snr(clean, auto.V)


@pytest.mark.parametrize("method", QUICK)
def test_automatic_parameters_are_nearly_those_that_the_clean_mesh_picks(method):
    V, F = shapes.torus(sections=80, sides=32)
    noisy = noise.along_normals(V, F, 0.2, np.random.default_rng(8))
    before = metrics.normal_angle(noisy, V, F)
    best = metrics.normal_angle(denoising.tune(noisy, F, method, V).V, V, F)
    auto = meshfair.denoise(noisy, F, method, parameters="auto")
    found = metrics.normal_angle(auto.V, V, F)
    assert best <= found
    # Of what the best of the same candidates gains, nine tenths without the clean mesh.
    assert before - found > 0.9 * (before - best)


def test_a_clean_mesh_is_left_nearly_alone():
    V, F = shapes.icosphere(4)
    auto = meshfair.denoise(V, F, "taubin", parameters="auto", sigma=0.0)
    np.testing.assert_array_equal(auto.V, V)
    assert auto.parameters["iterations"] == 0


def test_fixed_vertices_stay(noisy_box):
    V, _, F = noisy_box
    fixed = np.arange(0, len(V), 3)
    for method in NAMES:
        result = meshfair.denoise(V, F, method, fixed=fixed)
        np.testing.assert_array_equal(result.V[fixed], V[fixed])
        assert not np.allclose(result.V, V)
    auto = meshfair.denoise(V, F, "bilateral", parameters="auto", fixed=fixed)
    np.testing.assert_array_equal(auto.V[fixed], V[fixed])


def test_progress_and_cancelling(noisy_box):
    V, _, F = noisy_box
    seen = []
    meshfair.denoise(V, F, "taubin", iterations=4, callback=seen.append)
    assert seen == [0.25, 0.5, 0.75, 1.0]
    *_, second, _, _ = (X for _, X in filters.taubin(V, F, iterations=4))
    stopped = meshfair.denoise(V, F, "taubin", iterations=4, callback=lambda p: p < 0.5)
    assert not stopped.finished
    np.testing.assert_array_equal(stopped.V, second)
    seen.clear()
    meshfair.denoise(V, F, "implicit", parameters="auto", callback=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0
    early = meshfair.denoise(V, F, "implicit", parameters="auto", callback=lambda p: False)
    assert not early.finished
    assert early.ratio is None
    np.testing.assert_array_equal(early.V, V)


def test_a_given_parameter_is_kept(noisy_box):
    V, _, F = noisy_box
    auto = meshfair.denoise(
        V, F, "implicit", parameters="auto", weights="combinatorial", iterations=2
    )
    assert auto.parameters["weights"] == "combinatorial"
    assert auto.parameters["iterations"] == 2
    auto = meshfair.denoise(V, F, "bilateral", parameters="auto", iterations=3)
    assert auto.parameters["iterations"] <= 3  # the most that are made


def test_a_filter_of_ones_own(noisy_box, monkeypatch):
    V, clean, F = noisy_box
    monkeypatch.setattr(registry, "_METHODS", dict(registry._METHODS))

    @denoising.register(
        "halfway",
        candidates=[{"iterations": 6}],
        count="iterations",
    )
    def halfway(V, F, *, iterations=3):
        A = operators.averaging(weights.combinatorial(F, len(V)))
        for k in range(iterations):
            V = (V + A @ V) / 2
            yield (k + 1) / iterations, V

    assert "halfway" in denoising.methods()
    by_name = meshfair.denoise(V, F, "halfway", iterations=2)
    *_, (_, expected) = filters.heat(V, F, tau=0.5, time=1.0)
    np.testing.assert_allclose(by_name.V, expected, atol=1e-12)
    auto = meshfair.denoise(V, F, "halfway", parameters="auto", ground_truth=clean)
    assert 1 <= auto.parameters["iterations"] <= 6


@pytest.mark.parametrize(
    ("arguments", "wrong"),
    [
        ({"method": "laplace"}, "no method is called 'laplace'; there are auto, averaging, heat, "),
        ({"method": "sun", "sigma_normal": 1}, "sun has no parameter 'sigma_normal'; it has thr"),
        ({"parameters": "best"}, "parameters is 'best'; give one of default, auto"),
        ({"method": "taubin", "iterations": -1}, "iterations is -1"),
        ({"parameters": "auto", "sigma": -1.0}, "sigma"),
        ({"method": "feature-convinced", "sigma": np.nan}, "sigma is nan"),
        ({"method": "tauben"}, r"learned \(did you mean 'taubin'\?\)$"),
        ({"method": "atuo"}, r"there are auto, averaging, .* \(did you mean 'auto'\?\)$"),
        ({"method": ["sun"]}, r"no method is called \['sun'\]; there are auto, "),
        ({"strenght": 0.5}, r"name the method, too \(did you mean 'strength'\?\)$"),
        ({"method": "sun", "fixed": [[1, 2]]}, r"fixed has shape \(1, 2\); give a boolean mask or"),
        ({"method": "implicit", "step": 1e300}, r"No face is flat: step=1e\+300 is too large$"),
        ({"method": "sun", "treshold": 1}, r"strength \(did you mean 'threshold'\?\)$"),
        ({"method": "heat", "weights": "Cotan"}, r"cotangent \(did you mean 'cotangent'\?\)$"),
        ({"method": "taubin", "sigma": 0.2}, "taubin with default parameters does not use it"),
    ],
)
def test_wrong_arguments_are_named(noisy_box, arguments, wrong):
    V, _, F = noisy_box
    with pytest.raises((ValueError, solve.SolveError), match=wrong):
        meshfair.denoise(V, F, **arguments)


@pytest.mark.parametrize("nothing", ["scan.ply", None, shapes])
def test_what_is_no_mesh_is_named(nothing):
    with pytest.raises(
        TypeError, match=r"^V is a \w+, and F is missing; give positions V and faces"
    ):
        meshfair.denoise(nothing)


@pytest.mark.parametrize("callback", [3, "progress", [print]])
def test_a_callback_that_is_none_is_refused(noisy_box, callback):
    V, _, F = noisy_box
    with pytest.raises(TypeError, match=r"^callback is .*; give a function of one number, 0 to 1$"):
        meshfair.denoise(V, F, callback=callback)


def test_a_known_noise_size_is_used(noisy_box, monkeypatch):
    V, _, F = noisy_box
    known = meshfair.denoise(V, F, "feature-convinced", sigma=0.3)
    assert known.parameters["noise"] == 0.3
    assert known.parameters["iterations"] == 6  # the table of [LLL19] for 0.25 to 0.45
    np.testing.assert_array_equal(known.V, meshfair.denoise(V, F, "feature-convinced", noise=0.3).V)
    chosen = meshfair.denoise(V, F, "feature-convinced", sigma=0.3, noise=0.05)
    assert chosen.parameters["noise"] == 0.05  # what is given by name stands
    auto = meshfair.denoise(V, F, "feature-convinced", parameters="auto", sigma=0.3)
    assert auto.parameters["noise"] == 0.3

    monkeypatch.setattr(registry, "_METHODS", dict(registry._METHODS))

    @denoising.register("by noise", noise="size")
    def by_noise(V, F, *, size=None, fixed=None):
        yield 1.0, V * (1 - size)

    np.testing.assert_array_equal(meshfair.denoise(V, F, "by noise", sigma=0.25).V, V * 0.75)


@pytest.mark.parametrize("method", NAMES)
def test_a_part_of_the_way_with_any_method(method, noisy_box):
    V, clean, F = noisy_box
    whole = meshfair.denoise(V, F, method, fixed=[0, 5])
    part = meshfair.denoise(V, F, method, strength=0.25, fixed=[0, 5], ground_truth=clean)
    np.testing.assert_allclose(part.V, 0.75 * V + 0.25 * whole.V, atol=1e-12)
    np.testing.assert_array_equal(part.V[[0, 5]], V[[0, 5]])
    assert part.parameters == whole.parameters | {"strength": 0.25}
    assert part.history["snr"].iloc[-1] == metrics.snr(clean, part.V)
    assert len(part.history) == len(meshfair.denoise(V, F, method, ground_truth=clean).history)


def test_the_ends_of_the_way(noisy_box):
    V, _, F = noisy_box
    whole = meshfair.denoise(V, F, "taubin")
    np.testing.assert_array_equal(meshfair.denoise(V, F, "taubin", strength=0).V, V)
    np.testing.assert_array_equal(meshfair.denoise(V, F, "taubin", strength=1).V, whole.V)
    assert "strength" not in whole.parameters


def test_the_error_on_the_way_is_a_parabola(noisy_box):
    # With e the noise and r what was taken away, the squared error is |e|^2 - 2 s e'r + s^2 |r|^2.
    V, clean, F = noisy_box
    r, e = V - meshfair.denoise(V, F, "averaging").V, V - clean
    best = np.sum(e * r) / np.sum(r * r)
    assert 0.2 < best < 0.8  # averaging shrinks this box: all of the way is too far
    for s in (0.1, best, 0.9):
        left = np.sum((meshfair.denoise(V, F, "averaging", strength=s).V - clean) ** 2)
        expected = np.sum(e * e) - 2 * s * np.sum(e * r) + s**2 * np.sum(r * r)
        assert left == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("method", "parameters"), [("auto", "default"), ("taubin", "default"), ("taubin", "auto")]
)
def test_a_given_strength_holds_for_whatever_is_chosen(noisy_box, method, parameters):
    V, _, F = noisy_box
    result = meshfair.denoise(V, F, method, parameters=parameters, strength=0.5)
    assert result.parameters["strength"] == 0.5
    whole = meshfair.denoise(V, F, result.method, **result.parameters | {"strength": 1}).V
    np.testing.assert_allclose(result.V, (V + whole) / 2, atol=1e-12)


@pytest.mark.parametrize(
    ("method", "truth"), [("auto", False), ("averaging", True), ("learned", False)]
)
def test_a_given_strength_does_not_change_what_is_chosen(noisy_box, method, truth):
    V, clean, F = noisy_box
    options = {"parameters": "auto", "ground_truth": clean if truth else None}
    free = meshfair.denoise(V, F, method, **options)
    assert np.abs(free.V - V).max() > 0
    for strength in (0, "0.5", np.float32(1)):
        result = meshfair.denoise(V, F, method, strength=strength, **options)
        s = result.parameters["strength"]
        assert (type(s), s) == (float, float(strength))
        assert (result.method, result.parameters) == (
            free.method,
            free.parameters | {"strength": s},
        )
        np.testing.assert_allclose(result.V, V + s * (free.V - V), atol=1e-12)
        assert "beyond" not in result.reason
        if s == 0:
            assert (result.ratio, result.reason) == (1, "left as it is: the strength is 0")


@pytest.mark.parametrize("strength", [-0.1, 1.5, np.nan, "half", None])
def test_a_strength_beyond_the_way_is_refused(noisy_box, strength):
    V, _, F = noisy_box
    with pytest.raises(ValueError, match=r"^strength is .*; give a number of at least 0 and at"):
        meshfair.denoise(V, F, "taubin", strength=strength)


def test_a_filter_with_a_strength_of_its_own_is_refused():
    with pytest.raises(ValueError, match=r"^own has a parameter 'strength', which is the part"):

        @denoising.register("own")
        def own(V, F, *, strength=3):
            yield 1.0, V


def own_filter(name, **options):
    """A decorator that registers a filter whose results are those of averaging."""
    return denoising.register(name, candidates=[{"iterations": 6}], count="iterations", **options)


def test_a_filter_of_ones_own_may_move_vertices_in_place(noisy_box, monkeypatch):
    V, clean, F = noisy_box
    monkeypatch.setattr(registry, "_METHODS", dict(registry._METHODS))
    A = operators.averaging(weights.combinatorial(F, len(V)))
    before, faces = V.copy(), F.copy()

    @own_filter("in place")
    def in_place(V, F, *, iterations=3):
        F += 1  # its own copy
        for k in range(iterations):
            V[:] = A @ V
            yield (k + 1) / iterations, V

    @own_filter("listed")
    def listed(V, F, *, iterations=3):
        for k in range(iterations):
            V = A @ V
            yield (k + 1) / iterations, V.astype(np.float32).tolist()

    for name, tolerance in (("in place", 1e-14), ("listed", 1e-6)):
        by_name = meshfair.denoise(V, F, name, ground_truth=clean)
        np.testing.assert_allclose(by_name.V, A @ (A @ (A @ V)), atol=tolerance)
        assert (by_name.V.dtype, len(by_name.history)) == (np.float64, 4)
        half = meshfair.denoise(V, F, name, strength=0.5).V
        np.testing.assert_allclose(half, (V + by_name.V) / 2, atol=1e-14)
        best = denoising.tune(V, F, name, clean)
        again = meshfair.denoise(V, F, name, **best.parameters)
        np.testing.assert_array_equal(again.V, best.V)
    np.testing.assert_array_equal(V, before)
    np.testing.assert_array_equal(F, faces)


@pytest.mark.parametrize(
    ("result", "wrong"),
    [
        (lambda V: V, "own returned a ndarray; it has to yield progress, from 0 to 1, and posit"),
        (lambda V: iter([V]), "own yielded a ndarray; it has to yield progress"),
        (
            lambda V: iter([(1.0, V[:2])]),
            r"own yielded positions of shape \(2, 3\); \(\d+, 3\) was",
        ),
        (
            lambda V: iter([(1.0, V * np.nan)]),
            "own yielded .* for vertex 0; positions have to be f",
        ),
        (lambda V: iter([(1.0, "V")]), "own yielded positions that are no numbers; it has to"),
    ],
)
def test_what_a_filter_of_ones_own_yields_is_looked_at(noisy_box, monkeypatch, result, wrong):
    V, _, F = noisy_box
    monkeypatch.setattr(registry, "_METHODS", dict(registry._METHODS))
    denoising.register("own")(lambda V, F: result(V))
    with pytest.raises(ValueError, match=f"^{wrong}"):
        meshfair.denoise(V, F, "own")


@pytest.mark.parametrize(
    ("function", "options", "wrong"),
    [
        (lambda X, F: (), {}, "own: its first arguments are not V and F; a filter is written def"),
        (lambda V, F, *, k: (), {}, "own: its parameter k has no default; a filter is written"),
        (lambda V, F, **more: (), {}, r"own: \*\*more stands for any parameters; name each; a f"),
        (lambda V, F, *, k=1: (), {"candidates": []}, "own: candidates is empty; give a dict for"),
        (lambda V, F, *, k=1: (), {"candidates": [{"kk": 2}]}, "own has no parameter 'kk'; it has"),
        (lambda V, F, *, k=1: (), {"count": "K"}, r"own has no .* \(did you mean 'k'\?\)"),
        (lambda V, F: (), {"noise": "sigma"}, "own has no parameter 'sigma'; it has none"),
    ],
)
def test_a_filter_that_could_not_be_called_is_refused(function, options, wrong):
    with pytest.raises(ValueError, match=f"^{wrong}"):
        denoising.register("own", **options)(function)
    assert "own" not in denoising.methods()


@pytest.mark.parametrize("method", ["averaging", "heat", "sun", "auto"])
@pytest.mark.parametrize("no", [False, np.False_])
def test_a_cancelled_result_comes_again(noisy_box, method, no):
    V, _, F = noisy_box
    asked = []

    def twice(progress):
        asked.append(progress)
        return no if len(asked) == 2 else None

    result = meshfair.denoise(V, F, method, callback=twice)
    assert not result.finished
    assert len(asked) == 2  # and it is not asked again
    again = meshfair.denoise(V, F, result.method, **result.parameters)
    np.testing.assert_array_equal(again.V, result.V)


def far_vertex():
    """A sphere with one vertex 10,000 radii away."""
    V, F = shapes.icosphere(3)
    V = noise.along_normals(V, F, 0.2, np.random.default_rng(2))
    V[7] *= 10_000
    return V, F


def test_candidates_that_cannot_be_solved_are_left_out_and_told():
    V, F = far_vertex()
    with pytest.warns(meshfair.MeshWarning, match=r"^\d+ of 18 candidates were left out") as caught:
        result = meshfair.denoise(V, F, "regularised", parameters="auto")
    assert np.isfinite(result.V).all()
    assert "left a residual of" in str(caught[0].message)
    with pytest.raises(solve.SolveError, match=r"flattest face is \d+, with vertices \[.*\b7\b"):
        meshfair.denoise(V, F, "regularised", order=2, lam=8.0)


def test_where_no_candidate_can_be_solved_the_error_says_why(noisy_box, monkeypatch):
    V, _, F = noisy_box

    def unsolvable(*_, **__):
        raise solve.SolveError("the residual is what it is")

    monkeypatch.setattr(solve, "implicit_step", unsolvable)
    with pytest.raises(solve.SolveError, match="the residual is what it is"):
        meshfair.denoise(V, F, "implicit", parameters="auto")


@pytest.mark.parametrize(
    "method", [name for name in NAMES if name not in ("implicit", "regularised")]
)
def test_progress_comes_in_small_steps(noisy_box, method):
    V, _, F = noisy_box
    told = [0.0]
    meshfair.denoise(V, F, method, callback=told.append)
    assert told[-1] == 1
    largest = {"averaging": 0.5, "heat": 0.1, "bilateral": 0.2}.get(method, 0.1)  # 2, 10, 5 steps
    assert np.diff(told).max() <= largest + 1e-12
    assert np.diff(told).min() > 0


# A country's grid in metres and in millimetres, and a satellite's orbit; edges are of 0.3 units.
PLACES = [(448250.0, 5411940.0, 212.0), (4.4e8, 5.4e9, 2.1e5), (0.0, 0.0, 4.2e7)]


@pytest.mark.parametrize("place", PLACES, ids=str)
@pytest.mark.parametrize("method", NAMES)
def test_a_result_does_not_depend_on_the_place(method, place):
    V, F = shapes.icosphere(2)
    there = noise.along_normals(V, F, 0.2, np.random.default_rng(4)) + place
    here = there - place  # the same mesh: what rounding made of it there
    moved = meshfair.denoise(there, F, method).V - place
    # Each of up to 70 steps rounds positions to their last digit there, and its sums of a
    # few tens of them; a normal turns by that over the distance of a third of an edge.
    digit = np.spacing(np.max(np.abs(there)))
    np.testing.assert_allclose(moved, meshfair.denoise(here, F, method).V, atol=3000 * digit)


@pytest.mark.parametrize("method", NAMES)
def test_a_mesh_without_edges_is_told_or_left_as_it_is(method):
    V, F = np.ones((2, 3)), [[0, 0, 0], [1, 1, 1]]
    if method in ("implicit", "regularised", "l0"):  # whose strength is in mean edge lengths
        with pytest.raises(meshfair.MeshError, match="no edge at all"):
            meshfair.denoise(V, F, method)
    else:
        np.testing.assert_array_equal(meshfair.denoise(V, F, method).V, V)


def test_a_clean_mesh_of_another_size(noisy_box):
    V, clean, F = noisy_box
    with pytest.raises(meshfair.MeshError, match="ground_truth"):
        meshfair.denoise(V, F, ground_truth=clean[:-1])


# What is asked of the best method with automatic parameters, in degrees.
@pytest.mark.parametrize(
    ("name", "method", "at_most"),
    [("Fandisk0.3", "feature-convinced", 2.9), ("Bunny0.2", "bilateral-normal", 5.5)],
)
def test_automatic_parameters_on_public_pairs(mirror, name, method, at_most):
    V, clean, F = pair(mirror, name)
    auto = meshfair.denoise(V, F, method, parameters="auto")
    assert metrics.normal_angle(auto.V, clean, F) <= at_most
