"""The front of all filters: `denoise` by name, or with the method and parameters that suit."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import (
    MeshWarning,
    check_choice,
    check_mesh,
    check_number,
    check_same_vertices,
    did_you_mean,
)
from meshfair.denoising.choice import ALL, WHOLE, Chooser
from meshfair.denoising.registry import (
    DEFAULT,
    STRENGTH,
    Parameters,
    defaults,
    distinct,
    find_method,
    methods,
    unknown,
    with_noise,
)
from meshfair.denoising.runs import Cancelled, Denoised, Run, warn_of_failed
from meshfair.filters.feature_convinced import noise_by_lengths
from meshfair.mesh.objects import arrays, is_object, moved, takes_meshes
from meshfair.solve import SolveError
from meshfair.sure import noise_by_differences

# The part of the progress that the choice is, where its result has to be made again.
CHOICE = 0.5

Function = TypeVar("Function", bound=Callable[..., Denoised])


def _gives_mesh(function: Function) -> Function:
    """Decorate a function of V and F that also takes a mesh object, and gives back its kind."""
    taking = takes_meshes(function)

    @wraps(function)
    def unpacked(V: Any, *args: Any, **kwargs: Any) -> Denoised:
        if is_object(kwargs.get("ground_truth")):
            kwargs["ground_truth"], _ = arrays(kwargs["ground_truth"])
        if is_object(V):
            result = taking(V, *args, **kwargs)
            return result._replace(mesh=moved(V, result.V))
        if not args and "F" not in kwargs:
            raise TypeError(
                f"V is a {type(V).__name__}, and F is missing; give positions V and faces F, which "
                "meshfair.io.read finds in a file, or a mesh of trimesh, pyvista, open3d or meshio"
            )
        return taking(V, *args, **kwargs)

    return cast(Function, unpacked)


@_gives_mesh
def denoise(
    V: ArrayLike,
    F: ArrayLike,
    method: str = DEFAULT,
    *,
    parameters: str = "default",
    sigma: float | None = None,
    ground_truth: ArrayLike | None = None,
    callback: Callable[[float], Any] | None = None,
    **chosen: Any,
) -> Denoised:
    """Denoise a mesh.

    Parameters
    ----------
    V : array_like, shape (n, 3)
        Noisy positions.
    F : array_like of integers, shape (m, 3)
        A mesh object of another library may stand for V and F, see `meshfair.mesh.arrays`.
    method : str
        One of `methods`; or "auto", which chooses one of them and its parameters.
    parameters : {"default", "auto"}
        Where a method's parameters come from that are not given by name. "auto" tries
        the defaults and each of the method's candidates, and takes the parameters, and the
        iteration to stop at, that promise to leave the least error, see
        `meshfair.denoising.forecast`; that may be the noisy mesh. A number of iterations
        that is given is then the most that are made.
    sigma : float, optional
        The noise's standard deviation, as a fraction of the mean edge length, if it is
        known: "auto" looks at it, and feature-convinced uses it (its ``noise``).
    ground_truth : array_like, shape (n, 3), optional
        The noise-free positions, for the history. Nothing else looks at them.
    callback : function, optional
        Called with the progress, a number up to 1, after each iteration.
        When it returns False (not None), the work ends there.
    **chosen
        The method's parameters by name. All have ``fixed``, vertices that keep their place,
        as a boolean mask (n,) or as indices; and ``strength``, the part, from 0 to 1, of the
        way from the noisy mesh to where the filter leads: the less, the more detail is kept,
        and noise. It is 1 where it is neither given nor chosen by "auto"; where it is given,
        "auto" chooses all else as without it.

    Returns
    -------
    Denoised
        V, method, parameters, history, ratio, reason, seconds, finished, mesh.

    Raises
    ------
    MeshError, ValueError, TypeError
        No mesh; no such method or parameter (the message lists those there
        are), or parameters without a method; a parameter outside its range; ``sigma``
        for a method that does not use it; a callback that is no function.
    SolveError
        A linear system of an implicit method that cannot be solved; with "auto", all of them.

    Warns
    -----
    MeshWarning
        Copies of vertices along seams, which are joined for the work; faces turned against
        their neighbours', where that matters; candidates of "auto" that cannot be solved.
    """
    V, F = check_mesh(V, F)
    if ground_truth is not None:
        V, ground_truth = check_same_vertices(V, ground_truth, ("V", "ground_truth"))
    auto = check_choice(parameters, "parameters", ("default", "auto")) == "auto"
    if sigma is not None:
        sigma = check_number(sigma, "sigma", 0)
    if method != DEFAULT and method not in methods():
        raise unknown(method, [DEFAULT, *methods()])
    names = ALL if method == DEFAULT else (method,)
    chosen = _checked(method, chosen, sigma, auto)
    turn = auto or any(find_method(name).normals for name in names)
    run = Run(V, F, ground_truth, callback, chosen, normals=turn)
    if auto or method == DEFAULT:
        return _chosen(run, names, sigma)
    given = defaults(method) | with_noise(method, run.chosen, sigma)
    filled = find_method(method).filled_in(run.V, run.F, given)
    return run.ended(method, run.states(find_method(method), filled, run.report))


def _checked(method: str, chosen: Parameters, sigma: float | None, auto: bool) -> Parameters:
    """The given parameters; refuse those that the method does not have."""
    if STRENGTH in chosen:
        chosen = chosen | {STRENGTH: check_number(chosen[STRENGTH], STRENGTH, 0, 1)}
    if method == DEFAULT:
        free = ["fixed", STRENGTH]
        if named := set(chosen) - set(free):
            raise ValueError(
                f'{min(named)} is given, but method="auto" chooses all parameters; name the '
                f"method, too{did_you_mean(min(named), free)}"
            )
        return chosen
    known = [*defaults(method), STRENGTH]
    for name in chosen:
        if name not in known:
            raise ValueError(
                f"{method} has no parameter {name!r}; it has {', '.join(known)}"
                f"{did_you_mean(name, known)}"
            )
    if sigma is not None and not auto and find_method(method).noise is None:
        raise ValueError(
            f"sigma is given, but {method} with default parameters does not use it; leave it out, "
            'or let parameters="auto" choose'
        )
    return chosen


def _chosen(run: Run, names: Sequence[str], sigma: float | None) -> Denoised:
    """What comes of the best choice among some methods."""
    if run.fixed and np.all(run.fixed["fixed"]):  # there is nothing to look at
        only = find_method(names[0])
        parameters = only.filled_in(run.V, run.F, defaults(names[0]) | run.chosen)
        states = run.states(only, parameters, run.report)
        return run.ended(names[0], states, 1.0, "left as it is: all of its vertices are fixed")
    # What was tried on the whole mesh is not done again, but for its history.
    share = 1.0 if len(run.F) <= WHOLE and run.ground_truth is None else CHOICE
    try:
        # Candidates warn of what they meet on patches, and most are not taken.
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", MeshWarning)
            chooser = Chooser(run.V, run.F, run.chosen, sigma, lambda p: run.report(share * p))
            choices = chooser.ranked(names)
    except Cancelled:
        nothing = defaults(names[0]) | run.fixed | {STRENGTH: 0.0}
        state = next(run.known(run.V.copy(), nothing))
        return run.ended(names[0], iter([state]))._replace(finished=False)
    for w in caught:
        if not issubclass(w.category, MeshWarning):
            warnings.warn_explicit(w.message, w.category, w.filename, w.lineno)
    warned = any(issubclass(w.category, MeshWarning) for w in caught)
    if len(names) == 1:
        warn_of_failed(chooser.failed, chooser.trials)
    for choice in choices:
        method = find_method(choice.method)
        parameters = method.filled_in(run.V, run.F, choice.parameters | run.fixed)
        if choice.stop is not None:
            parameters = method.stopped(parameters, choice.stop)
        states = run.states(method, parameters, lambda p: run.report(share + (1 - share) * p))
        if share == 1 and not warned:  # else it is done again, and says itself what it meets
            X = run.V.copy()
            X[chooser.vertices] = choice.X
            states = run.known(X, parameters)
        try:
            return run.ended(choice.method, states, choice.ratio, choice.reason)
        except SolveError as error:  # on the whole mesh; the next best may do
            chooser.failed.append((parameters, error))
    raise chooser.failed[0][1]


@_gives_mesh
def tune(
    V: ArrayLike,
    F: ArrayLike,
    method: str,
    ground_truth: ArrayLike,
    *,
    callback: Callable[[float], Any] | None = None,
    **chosen: Any,
) -> Denoised:
    """Denoise with the parameters that come closest to the ground truth, which has to be known.

    Among the candidates of "auto", and the iterations to stop at, this takes
    those with the smallest mean normal angle: what a method can do at best,
    and a way to find parameters for meshes like this one.

    Parameters
    ----------
    V, F, method, callback, **chosen
        As in `denoise`.
    ground_truth : array_like, shape (n, 3)
        The positions that decide.

    Returns
    -------
    Denoised

    Raises
    ------
    MeshError, ValueError, TypeError, SolveError
        As `denoise`.

    Warns
    -----
    MeshWarning
        As `denoise`.
    """
    V, F = check_mesh(V, F)
    V, ground_truth = check_same_vertices(V, ground_truth, ("V", "ground_truth"))
    chosen = _checked(method, chosen, None, auto=True)
    found = find_method(method)
    run = Run(V, F, ground_truth, callback, chosen, normals=found.normals)
    trials: list[Parameters] = []
    for candidate in (*found.candidates, *found.refinements):
        given = defaults(method) | candidate | run.chosen
        trials.append(found.filled_in(run.V, run.F, given))
    return run.ended(method, run.better_states(found, distinct(trials)))


@takes_meshes
def estimate_noise(V: ArrayLike, F: ArrayLike, by: str = "lengths") -> float:
    """The size of the noise on a mesh, estimated without the ground truth.

    By "lengths" of the edges, which noise makes longer, see
    `meshfair.filters.feature_convinced`'s `noise_by_lengths`; by third "differences",
    see `meshfair.sure.noise_by_differences`: closer on coarse meshes, and with strong noise.

    Parameters
    ----------
    V : array_like, shape (n, 3)
    F : array_like of integers, shape (m, 3)
    by : {"lengths", "differences"}

    Returns
    -------
    float
        As a fraction of the mean edge length, as in `along_normals`; but of the
        noisy mesh's, since the true one's is unknown. From about 0.4 on
        too small: normals are lost. On clean meshes with much detail
        too large, since detail looks like noise.

    Raises
    ------
    MeshError, ValueError
        No mesh; another word for ``by``.
    """
    V, F = check_mesh(V, F)
    return _ESTIMATES[check_choice(by, "by", _ESTIMATES)](V, F)


_ESTIMATES: dict[str, Callable[[ArrayLike, ArrayLike], float]] = {
    "lengths": noise_by_lengths,
    "differences": noise_by_differences,
}
