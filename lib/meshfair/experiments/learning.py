"""What a filter that learns carries over to a shape that it has not learned from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from meshfair.checks import needed_for
from meshfair.experiments.quality import noisy_pair
from meshfair.filters import kernel_table
from meshfair.metrics import normal_angle

if TYPE_CHECKING:
    import pandas as pd


def kernel_transfer(
    meshes: Sequence[str] = ("box", "torus", "knot"),
    size: float = 0.2,
    seed: int = 0,
    *,
    passes: int = 5,
) -> pd.DataFrame:
    """Kernels fitted to each of several meshes, tried on each of them with other noise.

    Parameters
    ----------
    meshes : sequence of str
        Names for `meshfair.experiments.load_mesh`.
    size : float
        Noise along the normals, in mean edge lengths.
    seed : int
        Of the noise to learn from; that to try on has the next one.
    passes : int
        See `meshfair.filters.kernel_table.cascade`.

    Returns
    -------
    pandas.DataFrame
        learned_from, tried_on, normal_angle (degrees); learned_from is "none" for the noisy mesh.
    """
    with needed_for("an experiment"):
        import pandas as pd

    tried = {name: noisy_pair(name, size, seed + 1) for name in meshes}
    rows = [("none", name, normal_angle(*tried[name])) for name in meshes]
    for learned_from in meshes:
        tables = list(kernel_table.cascade([noisy_pair(learned_from, size, seed)], passes))
        for name, (V_noisy, V, F) in tried.items():
            N = kernel_table.normals_by_tables(V_noisy, F, tables)[-1]
            found = kernel_table.fit_vertices(V_noisy, F, N)
            rows.append((learned_from, name, normal_angle(found, V, F)))
    return pd.DataFrame(rows, columns=["learned_from", "tried_on", "normal_angle"])
