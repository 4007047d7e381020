"""Every filter on sharp and smooth meshes, with default, automatic and tuned parameters."""

import json

import numpy as np

from meshfair import denoising
from meshfair.checks import MeshError
from meshfair.experiments.cases import add_noise, load_mesh
from meshfair.experiments.seed import missile_vertices
from meshfair.experiments.sweep import sweep
from meshfair.mesh import mean_edge_length
from meshfair.metrics import compare

PARAMETERS = ("default", "auto", "tuned")
# Meshes of the public GuidedDenoising pairs: how much noise their noisy files have.
PAIRS = {"fandisk": 0.3, "bunny pair": 0.2}
_FILES = {
    "fandisk": ("fandisk-clean", "fandisk-noisy"),
    "bunny pair": ("bunny-clean", "bunny-noisy"),
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
    V_noisy, V_clean : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)

    Raises
    ------
    NotDownloadedError
        A mesh that ``make data`` has not fetched.
    """
    if mesh in _FILES:
        (V, F), (V_noisy, _) = (load_mesh(name) for name in _FILES[mesh])
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
    V_clean : ndarray of float64, shape (n, 3)
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
        Those of `meshfair.metrics.compare`; used, the parameters as JSON; seconds;
        on the jet missile_error, the mean distance of the missiles' vertices from
        their clean places, in mean edge lengths.
    """
    if method == "none":
        V_new, V, F = noisy_and_clean(mesh, size, seed)
        facts = {"used": "{}", "seconds": 0.0}
    else:
        result, V, F = denoised(mesh, method, parameters, size, seed)
        V_new = result.V
        used = {name: value for name, value in result.parameters.items() if name != "fixed"}
        facts = {"used": json.dumps(used), "seconds": result.seconds}
    if mesh == "jet":
        distance = np.linalg.norm(V_new - V, axis=1)[missile_vertices()]
        facts["missile_error"] = float(distance.mean() / mean_edge_length(V, F))
    return compare(V_new, F, V, F) | facts


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
        mesh, method, parameters, size, seed, and what `score` returns; method "none"
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
        common = {
            "experiment": score, "mesh": mesh, "size": PAIRS.get(mesh, size), "seed": seed,
        }  # fmt: skip
        for which, ways in ((["none"], ["default"]), (methods, PARAMETERS)):
            grid = common | {"method": which, "parameters": ways}
            parts.append(sweep(grid, path=path, progress=progress))
    table = pd.concat(parts, ignore_index=True)
    if "error" in table and table["error"].notna().any():
        failed = table[table["error"].notna()].iloc[0]
        raise MeshError(f"{failed['method']} failed on {failed['mesh']}: {failed['error']}")
    return table
