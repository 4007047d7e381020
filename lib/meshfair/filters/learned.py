"""A normal filter whose weights were learned from pairs of noisy and clean meshes.

It is the bilateral normal filter's idea, n_i <- sum_j w_ij n_j, with the kernel w replaced by
a small network, `meshfair.filters.face_network`. Stages follow each other as in [Wang16]_,
each trained on what the one before leaves; that a network finds the normals is the idea of
[ZLZ19]_, too. How it was trained: `data_scripts/train`.

References
----------
.. [Wang16] P.-S. Wang, Y. Liu, X. Tong, "Mesh denoising via cascaded normal regression",
   ACM Transactions on Graphics 35(6), 2016.
.. [ZLZ19] W. Zhao, X. Liu, Y. Zhao, X. Fan, D. Zhao, "NormalNet: learning-based normal
   filtering for mesh denoising", arXiv 1903.04015, 2019.
"""

from collections.abc import Iterator
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from meshfair.checks import Booleans, Floats, Integers, check_count, check_fixed, check_mesh
from meshfair.filters.face_network import (
    BANK,
    LAYERS,
    Rings,
    Weights,
    exchanged,
    first_features,
    normals,
)
from meshfair.filters.guided_normal import Patches
from meshfair.filters.neighbourhoods import face_rings
from meshfair.filters.normal_bank import COUNT, filtered_normals, surfaces
from meshfair.filters.normal_filtering import move_vertices
from meshfair.mesh import face_shapes, normalised
from meshfair.mesh.geometry import incidence
from meshfair.operators import averaging
from meshfair.weights import combinatorial

MOVES = 20
"""How often the vertices are moved in training, after each stage."""


def learned(
    V: ArrayLike,
    F: ArrayLike,
    *,
    stages: int = 2,
    vertex_iterations: int = 20,
    fixed: ArrayLike | None = None,
) -> Iterator[tuple[float, Floats]]:
    """Learned normal filtering in stages [Wang16]_, as an iterator: networks find the normals.

    Each stage filters the normals in 14 ways, see
    `meshfair.filters.normal_bank.filtered_normals`, finds one normal a face from these by
    a network whose weights come with the package, and moves the vertices to fit. Its
    defaults serve any mesh: noise of any size, flat sides, creases and details were all among
    the examples.

    Parameters
    ----------
    V, F, fixed
        As in `meshfair.filters.averaging`.
    stages : int
        How many stages to run: 1, or 2.
    vertex_iterations : int
        How often the vertices are moved in each stage; before the last at most 20 times, as
        in training. More bring the mesh closer to the normals that were found, which helps
        where these are good, as on flat and smooth surfaces under strong noise; elsewhere their
        errors add up over many edges, and places go astray.

    Yields
    ------
    progress, V
        As `meshfair.filters.averaging`.

    Raises
    ------
    MeshError, ValueError
        As `meshfair.filters.averaging`.
    """
    V, F = check_mesh(V, F)
    networks = trained()
    stages = check_count(stages, "stages", 1)
    if stages > len(networks):
        raise ValueError(f"stages is {stages}; give 1 or {len(networks)}")
    vertex_iterations = check_count(vertex_iterations, "vertex_iterations")
    fixed = check_fixed(fixed, len(V))
    B = incidence(F, len(V))
    A = averaging(combinatorial(F, len(V)))
    patches = Patches(face_rings(B))
    moves = [min(vertex_iterations, MOVES)] * (stages - 1) + [vertex_iterations]
    steps, step = stages * (COUNT + LAYERS) + sum(moves), 0
    of_input, wanted = np.zeros((len(F), 3)), np.zeros((len(F), 3))
    for stage, network in enumerate(networks[:stages]):
        G = np.empty((len(F), BANK, 3))
        smoothed = surfaces(V, F)
        for k, N in enumerate(filtered_normals(V, F, smoothed, patches)):
            G[:, k] = N
            step += 1
            yield step / steps, V
        G[:, COUNT], G[:, COUNT + 1] = of_input, wanted
        N, area, C = face_shapes(V, F)
        rings = Rings(patches.rings, C, face_shapes(smoothed[0], F)[2], area)
        h, v = first_features(network, G, rings)
        for layer in range(LAYERS):
            h, v = exchanged(network, layer, h, v, rings)
            step += 1
            yield step / steps, V
        if stage == 0:
            of_input = N
        wanted = normals(network, h, v, G)
        for _ in range(moves[stage]):
            V = move_and_unfold(V, F, B, A, wanted, fixed)
            step += 1
            yield step / steps, V


def move_and_unfold(
    V: Floats, F: Integers, B: csr_array, A: csr_array, N: Floats, fixed: Booleans
) -> Floats:
    """Move each vertex towards the planes of its faces, and unfold where these have turned over.

    A step of `meshfair.filters.normal_filtering.move_vertices` moves a vertex along normals,
    which does not undo noise that has pushed it over an edge of its ring. So the vertices of a
    face that looks away from the normal it should have also move along the surface,

        v_i <- v_i + (I - m_i m_i') (A v - v)_i / 2,

    towards the mean of their neighbours, with the mean normal m_i of their faces; those stay
    whose faces would not get nearer to their normals by that, as on thin plates.

    Parameters
    ----------
    V, F, B, N, fixed
        As in `meshfair.filters.normal_filtering.move_vertices`.
    A : csr_array, shape (n, n)
        The averaging operator.

    Returns
    -------
    ndarray of float64, shape (n, 3)
    """
    V = move_vertices(V, F, B, N, fixed)
    cosine = np.sum(face_shapes(V, F)[0] * N, axis=1)
    turned = cosine < 0
    if not turned.any():
        return V
    corner = np.zeros(len(V), dtype=bool)
    corner[F[turned]] = True
    shift, m = A @ V - V, normalised(B @ N)
    shift -= np.sum(shift * m, axis=1, keepdims=True) * m
    moved = V + 0.5 * (corner & ~fixed)[:, None] * shift
    nearer = B @ (np.sum(face_shapes(moved, F)[0] * N, axis=1) - cosine) > 0
    return np.where(nearer[:, None], moved, V)


@cache
def trained() -> list[Weights]:
    """The weights of each stage by name, from the file that comes with the package.

    Returns
    -------
    list of dict
        Of each stage, matrices and vectors (float64) by the names that they have in training.
    """
    with np.load(str(files("meshfair.filters") / "learned.npz")) as file:
        stages: dict[str, Weights] = {}
        for key in file.files:
            stage, _, name = key.partition("/")
            if name:
                stages.setdefault(stage, {})[name] = file[key].astype(float)
    return [stages[stage] for stage in sorted(stages)]


def record() -> dict[str, str]:
    """How the weights came about: commit, seed, data, time and torch's version.

    Returns
    -------
    dict
        All values as text.
    """
    with np.load(str(files("meshfair.filters") / "learned.npz")) as file:
        return dict(zip(*file["record"].tolist(), strict=True))
