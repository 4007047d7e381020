"""Meshes coloured by their distance from another one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from meshfair.checks import Floats, Integers, check_mesh
from meshfair.metrics import distances
from meshfair.viewer.side_by_side import SideBySide

ENOUGH = 20_000  # faces, so that what lies between the vertices of a coarse mesh has colours
FINEST = 64  # parts of an edge, at most
SHARE = 99.5  # percent of the points, whose distances have colours of their own

Mesh = tuple[ArrayLike, ArrayLike]


def by_distance(
    meshes: Sequence[Mesh],
    references: Sequence[Mesh | None],
    *,
    titles: Sequence[str],
    label: str = "distance",
) -> SideBySide:
    """Meshes side by side, each coloured by its distance from another one.

    Faces of coarse meshes are divided, so that a distance between their vertices shows, too.

    Parameters
    ----------
    meshes : sequence of (V, F)
    references : sequence of (V, F) or None
        What each mesh's distance is from; None for one that has a single colour.
    titles : sequence of str
        What stands above each mesh.
    label : str
        What stands at the colour bar. The distances are in the units of the meshes.

    Returns
    -------
    SideBySide
        The colours end at the distance that five in a thousand points exceed.

    Raises
    ------
    MeshError
        One of them is no mesh.
    """
    shown: list[tuple[Floats, Integers, Floats | None]] = []
    for (V, F), reference in zip(meshes, references, strict=True):
        V, F = check_mesh(V, F)
        if reference is None:
            shown.append((V, F, None))
            continue
        V, F = divided(V, F)
        shown.append((V, F, distances(V, *reference)))
    values = [x for _, _, x in shown]
    given: list[Floats] = [x for x in values if x is not None]
    ends = None
    if given:
        together = np.concatenate(given)
        ends = (0.0, float(np.percentile(together, SHARE) or together.max()))
    return SideBySide(
        [V for V, _, _ in shown],
        [F for _, F, _ in shown],
        titles=list(titles),
        values=values,
        label=label if given else "",
        limits=ends,
    )


def divided(V: Floats, F: Integers) -> tuple[Floats, Integers]:
    """The same surface with its faces divided into k * k parts each, where it has few.

    Parameters
    ----------
    V : ndarray of float64, shape (n, 3)
    F : ndarray of int64, shape (m, 3)

    Returns
    -------
    V : ndarray of float64, shape (n', 3)
        Each face's own vertices, where faces were divided.
    F : ndarray of int64, shape (m k k, 3)
    """
    k = min(int(np.ceil(np.sqrt(ENOUGH / len(F)))), FINEST)
    if k == 1:
        return V, F
    # Points (i, j) of the triangle's lattice, numbered row by row, and its small triangles.
    rows = [[(i, j) for j in range(k + 1 - i)] for i in range(k + 1)]
    number = {point: n for n, point in enumerate(point for row in rows for point in row)}
    parts = []
    for i, j in number:
        if i + j < k:
            parts.append((number[i, j], number[i + 1, j], number[i, j + 1]))
        if i + j < k - 1:
            parts.append((number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]))
    lattice = np.array(list(number)) / k
    weights = np.column_stack([1 - lattice.sum(axis=1), lattice])
    X = np.einsum("pc,fcx->fpx", weights, V[F])
    first = len(weights) * np.arange(len(F))
    return X.reshape(-1, 3), (first[:, None, None] + np.array(parts)).reshape(-1, 3)
