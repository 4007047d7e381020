"""What the original report could not do, or doubted: large and reduced meshes, the SNR itself."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from meshfair import flow, metrics, spectrum
from meshfair.checks import needed_for
from meshfair.experiments.meshes import load_mesh, load_noisy_mesh
from meshfair.experiments.original import TAU, TIME, curves
from meshfair.mesh import Edges, cluster, repair, unique_faces
from meshfair.noise import along_normals
from meshfair.operators import averaging
from meshfair.weights import BY_NAME, cotangent

if TYPE_CHECKING:
    import pandas as pd


def full_resolution(
    mesh: str, seed: int = 0, size: float = 0.2, iterations: int = 20
) -> pd.DataFrame:
    """SNR over iterated averaging on a mesh that the original report called far too large.

    Parameters
    ----------
    mesh : str
        "bunny" where it is downloaded, "large sphere" else.
    seed : int
        Of the noise.
    size : float
        Noise along the normals, as a fraction of the mean edge length.
    iterations : int
        How many there are.

    Returns
    -------
    pandas.DataFrame
        weights, time (the iteration), snr.
    """
    return curves(mesh, "normals", seed, size=size, tau=1.0, time=iterations)


def reduction(
    mesh: str = "fine knot",
    seed: int = 0,
    cells: Sequence[float] = (2.0, 3.0, 4.0),
    size: float = 0.2,
) -> pd.DataFrame:
    """What reducing a mesh does to its cotangent weights, and what a repair mends.

    The mesh is reduced by vertex clustering, noise is added along the normals,
    and the heat flow with cotangent weights is stopped at its best. Four times:
    with duplicate faces counted twice (as libigl's ``cotmatrix`` does), with our
    weights on the same faces, with the duplicate faces dropped, and with the
    surface split where it is not manifold besides.

    Parameters
    ----------
    mesh : str
        A name for `meshfair.experiments.load_mesh`.
    seed : int
        Of the noise.
    cells : sequence of float
        Sizes of the grid's cells, in mean edge lengths.
    size : float
        Noise, as a fraction of the reduced mesh's mean edge length.

    Returns
    -------
    pandas.DataFrame
        cell and treatment; vertices, faces, duplicates (faces), nonmanifold
        and boundary (edges); weight_error, the sum of the weights' differences to
        those of the repaired faces over the sum of these; noisy_snr, snr, time.
    """
    with needed_for("an experiment"):
        import pandas as pd

    from meshfair import reference  # loads libigl

    V, F = load_mesh(mesh)
    rows = []
    for cell in cells:
        V_small, F_small = cluster(V, F, cell)
        # (The two faces of a duplicate are often turned against each other: no normal between.)
        noisy = along_normals(V_small, unique_faces(F_small), size, np.random.default_rng(seed))
        dropped = repair(noisy, F_small, duplicates=True)
        split = repair(noisy, F_small, duplicates=True, split=True)
        right = cotangent(dropped.V, dropped.F)
        for treatment, W, repaired in (
            ("duplicate faces counted twice", reference.cotangent(noisy, F_small), None),
            ("duplicate faces counted once", cotangent(noisy, F_small), None),
            ("duplicate faces dropped", cotangent(dropped.V, dropped.F), dropped),
            ("dropped and split", cotangent(split.V, split.F), split),
        ):
            X, T = (noisy, F_small) if repaired is None else (repaired.V, repaired.F)
            target = V_small if repaired is None else V_small[repaired.vertex_map]
            faces_of_edge = Edges(T, len(X)).faces_of_edge
            best = flow.best_stopping(X, target, averaging(W), tau=TAU, time=TIME)
            same_vertices = W.shape == right.shape
            rows.append(
                {
                    "cell": cell,
                    "treatment": treatment,
                    "vertices": len(X),
                    "faces": len(T),
                    "duplicates": len(T) - len(unique_faces(T)),
                    "nonmanifold": (faces_of_edge > 2).sum(),
                    "boundary": (faces_of_edge == 1).sum(),
                    "weight_error": abs(W - right).sum() / abs(right).sum()
                    if same_vertices
                    else np.nan,
                    "noisy_snr": metrics.snr(target, X),
                    "snr": best.snr,
                    "time": best.time,
                }
            )
    return pd.DataFrame(rows)


def origin_shift(
    mesh: str = "knot",
    seed: int = 0,
    decibels: float = 22.71,
    shifts: Sequence[float] = (0.0, 0.5, 1.0, 2.0, 4.0),
) -> pd.DataFrame:
    """The SNR of one noisy mesh, with the origin put in different places.

    Parameters
    ----------
    mesh : str
        A name for `meshfair.experiments.load_mesh`.
    seed : int
        Of the noise, along the normals.
    decibels : float
        SNR with the mesh where its file has it.
    shifts : sequence of float
        Distances from the centre of the mesh to the origin, in diagonals of
        its bounding box.

    Returns
    -------
    pandas.DataFrame
        where ("as stored", or the shift), snr: the same noise every time.
    """
    with needed_for("an experiment"):
        import pandas as pd

    V_noisy, V, _ = load_noisy_mesh(mesh, "normals", seed, decibels=decibels)
    diagonal = np.linalg.norm(np.ptp(V, axis=0))
    rows = [{"where": "as stored", "snr": metrics.snr(V, V_noisy)}]
    for shift in shifts:
        move = -V.mean(axis=0) + [shift * diagonal, 0, 0]
        rows.append({"where": f"{shift:g}", "snr": metrics.snr(V + move, V_noisy + move)})
    return pd.DataFrame(rows)


def agreement(
    cases: Iterable[tuple[str, float]], *, tau: float = TAU, time: float = TIME, seed: int = 0
) -> pd.DataFrame:
    """When each metric would stop the flow, and what that costs the others.

    Parameters
    ----------
    cases : sequence of (mesh, size)
        Mesh names and the size of the noise along the normals.
    tau, time, seed
        As in `meshfair.experiments.curves`.

    Returns
    -------
    pandas.DataFrame
        mesh, weights; snr_time, angle_time, distance_time: the time at which SNR, mean
        normal angle and vertex distance are best; angle at the first two and
        noisy, volume_change at the angle's.
    """
    with needed_for("an experiment"):
        import pandas as pd

    rows = []
    for mesh, size in cases:
        table = curves(mesh, "normals", seed, size=size, tau=tau, time=time, angles=True)
        for name, flowed in table.groupby("weights", sort=False):
            by_snr = flowed.loc[flowed["snr"].idxmax()]
            by_angle = flowed.loc[flowed["normal_angle"].idxmin()]
            by_distance = flowed.loc[flowed["vertex_distance"].idxmin()]
            rows.append(
                {
                    "mesh": mesh,
                    "weights": name,
                    "snr_time": by_snr["time"],
                    "angle_time": by_angle["time"],
                    "distance_time": by_distance["time"],
                    "noisy_angle": flowed["normal_angle"].iloc[0],
                    "angle_at_snr_time": by_snr["normal_angle"],
                    "angle_at_angle_time": by_angle["normal_angle"],
                    "volume_at_snr_time": by_snr["volume_change"],
                    "volume_at_angle_time": by_angle["volume_change"],
                }
            )
    return pd.DataFrame(rows)


def eigenvalue_table(
    mesh: str,
    noise: str,
    seed: int,
    *,
    size: float | None = None,
    decibels: float | None = None,
) -> pd.DataFrame:
    """Eigenvalues of I - W~ on a noisy mesh: what a heat step does to each frequency.

    A step multiplies the part of the mesh along an eigenvector by
    1 - tau mu: near 1 for small mu (the shape), smaller for large mu (the
    noise), and beyond -1 where mu > 2 / tau (the flow blows up).

    Parameters
    ----------
    mesh, noise, seed, size, decibels
        As in `meshfair.experiments.curves`.

    Returns
    -------
    pandas.DataFrame
        weights, index, mu: all eigenvalues, ascending.

    Raises
    ------
    MeshError
        A mesh that is too large for a dense matrix, see `meshfair.spectrum.eigenvalues`.
    """
    with needed_for("an experiment"):
        import pandas as pd

    V_noisy, _, F = load_noisy_mesh(mesh, noise, seed, size=size, decibels=decibels)
    parts = []
    for name, build in BY_NAME.items():
        mu = 1 - spectrum.eigenvalues(build(V_noisy, F))
        parts.append(pd.DataFrame({"weights": name, "index": range(len(mu)), "mu": mu}))
    return pd.concat(parts, ignore_index=True)
