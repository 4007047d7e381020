"""Every filter on sharp and smooth meshes, with default, automatic and tuned parameters."""

import json
from typing import NamedTuple

import numpy as np

from meshfair import denoising, flow
from meshfair.checks import MeshError
from meshfair.experiments.cases import WEIGHTS, add_noise, load_mesh, operator
from meshfair.experiments.original import TAU, TIME, missile_vertices
from meshfair.experiments.sweep import sweep
from meshfair.mesh import mean_edge_length
from meshfair.metrics import compare

PARAMETERS = ("default", "auto", "tuned")


class Pair(NamedTuple):
    """A mesh that is published both clean and noisy."""

    clean: str
    """Its name in `meshfair.datasets.SOURCES`."""
    noisy: str
    """As before."""
    size: float
    """The noise of the noisy one, in mean edge lengths."""


PAIRS = {
    "fandisk": Pair("fandisk-clean", "fandisk-noisy", 0.3),
    "bunny pair": Pair("bunny-clean", "bunny-noisy", 0.2),
}


def noisy_and_clean(mesh, size, seed):
    """A noisy mesh and its clean one.

    Parameters
    ----------
    mesh : str
        A name for `meshfair.experiments.load_mesh`, or one of `PAIRS`, of which the
        noisy file is the public one.
    size : float
        Noise along the normals, as a fraction of the mean edge length; unused for a pair.
    seed : int
        As before.

    Returns
    -------
    V_noisy, V_true : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)

    Raises
    ------
    NotDownloadedError
        A mesh that ``make data`` has not fetched.
    """
    if mesh in PAIRS:
        (V, F), (V_noisy, _) = load_mesh(PAIRS[mesh].clean), load_mesh(PAIRS[mesh].noisy)
        return V_noisy, V, F
    V, F = load_mesh(mesh)
    return add_noise(V, F, "normals", seed, size=size), V, F


def denoised(mesh, method, parameters, size, seed):
    """One method on one noisy mesh.

    Parameters
    ----------
    mesh, size, seed
        As in `noisy_and_clean`.
    method : str
        One of `meshfair.denoising.methods`.
    parameters : {"default", "auto", "tuned"}
        Tuned ones are those that come closest to the clean mesh on another draw of
        the noise, with seed + 1; here they only prove themselves.

    Returns
    -------
    result : meshfair.denoising.Denoised
    V_true : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)
    """
    V_noisy, V, F = noisy_and_clean(mesh, size, seed)
    if parameters == "tuned":
        other = add_noise(V, F, "normals", seed + 1, size=size)
        chosen = denoising.tune(other, F, method, V).parameters
        return denoising.denoise(V_noisy, F, method, **chosen), V, F
    return denoising.denoise(V_noisy, F, method, parameters=parameters), V, F


def score(mesh, method, parameters, size, seed):
    """Every metric of one method on one noisy mesh; "none" leaves the mesh noisy.

    Parameters
    ----------
    mesh, method, parameters, size, seed
        As in `denoised`.

    Returns
    -------
    dict
        What `measured` returns, and used, the parameters as JSON, and seconds.
    """
    if method == "none":
        V_noisy, V, F = noisy_and_clean(mesh, size, seed)
        return measured(mesh, V_noisy, V, F) | {"used": "{}", "seconds": 0.0}
    result, V, F = denoised(mesh, method, parameters, size, seed)
    used = {name: value for name, value in result.parameters.items() if name != "fixed"}
    facts = {"used": json.dumps(used), "seconds": result.seconds}
    return measured(mesh, result.V, V, F) | facts


def measured(mesh, V_new, V, F):
    """Every metric; on the jet, how far its missiles are off, too.

    Parameters
    ----------
    mesh : str
    V_new, V : ndarray of float64, shape (n, 3)
        Denoised and clean.
    F : ndarray of int64, shape (m, 3)

    Returns
    -------
    dict
        Those of `meshfair.metrics.compare`, and on the jet `missile_error`.
    """
    metrics = compare(V_new, F, V, F)
    if mesh == "jet":
        metrics["missile_error"] = missile_error(V_new, V, F)
    return metrics


def missile_error(V_new, V, F):
    """How far the jet's missiles are off.

    Parameters
    ----------
    V_new, V : ndarray of float64, shape (n, 3)
        Denoised and clean.
    F : ndarray of int64, shape (m, 3)

    Returns
    -------
    float
        Mean distance of the missiles' vertices from their clean places, in mean edge lengths.
    """
    distance = np.linalg.norm(V_new - V, axis=1)[missile_vertices()]
    return float(distance.mean() / mean_edge_length(V, F))


def averaging_for_missiles(size=0.2, seed=0, *, tau=TAU, time=TIME):
    """The seed's three heat flows on the jet, each stopped when its missiles are best.

    Parameters
    ----------
    size, seed
        As in `quality`, with the same noise.
    tau, time : float
        Step and longest time.

    Returns
    -------
    pandas.DataFrame
        weights, time, and what `measured` returns.
    """
    import pandas as pd

    V_noisy, V, F = noisy_and_clean("jet", size, seed)
    rows = []
    for name in WEIGHTS:
        states = flow.heat(V_noisy, operator(V_noisy, F, name), tau, time)
        best, X = min(states, key=lambda state: missile_error(state[1], V, F))
        rows.append({"weights": name, "time": best} | measured("jet", X, V, F))
    return pd.DataFrame(rows)


def quality(meshes, size=0.2, seed=0, *, methods=None, path=None, progress=False):
    """Every method on several meshes, with each way to choose parameters.

    Parameters
    ----------
    meshes : sequence of str
        As in `noisy_and_clean`.
    size : float
        Noise of the meshes that are not pairs.
    seed : int
    methods : sequence of str, optional
        All, if not given.
    path, progress
        As in `meshfair.experiments.sweep`.

    Returns
    -------
    pandas.DataFrame
        mesh, size, seed, method, parameters, and what `score` returns; method "none"
        with parameters "default" is the noisy mesh.

    Raises
    ------
    MeshError
        A method failed; the message says which and why.
    """
    import pandas as pd

    methods = denoising.methods() if methods is None else list(methods)
    parts = []
    for mesh in meshes:
        noise = PAIRS[mesh].size if mesh in PAIRS else size
        common = {"experiment": score, "mesh": mesh, "size": noise, "seed": seed}
        for which, ways in ((["none"], ["default"]), (methods, PARAMETERS)):
            grid = common | {"method": which, "parameters": ways}
            parts.append(sweep(grid, path=path, progress=progress))
    table = pd.concat(parts, ignore_index=True)
    if "error" in table and table["error"].notna().any():
        failed = table[table["error"].notna()].iloc[0]
        raise MeshError(f"{failed['method']} failed on {failed['mesh']}: {failed['error']}")
    return table
