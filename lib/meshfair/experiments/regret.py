"""How much worse than the best a choice is, on the grid of `meshfair.experiments.choices`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

CELL = ["mesh", "kind", "size", "seed"]
OWN, NOISY = "own choice", "noisy mesh"
"""The contenders that are no method: the front's choice, and to do nothing."""


def regrets(table: pd.DataFrame, error: str = "normal_angle") -> pd.DataFrame:
    """What each choice has cost: its error over the least that any tuned method reaches.

    Parameters
    ----------
    table : pandas.DataFrame
        From `meshfair.experiments.compare_choices`.
    error : str
        A column of it that is best when small.

    Returns
    -------
    pandas.DataFrame
        The rows that chose without the ground truth, with the columns contender (such as "taubin",
        "taubin, auto", "noisy mesh", or "own choice" for the front's), best (the least error
        among rows with tuned parameters), best_default (among methods' defaults), noisy (that
        of the noisy mesh) and regret (error / best).
    """
    table = table.reset_index(drop=True)
    front, noisy = table["method"] == "auto", table["method"] == "none"
    plain = (table["parameters"] == "default") & ~front & ~noisy
    groups = {
        "best": table["parameters"] == "tuned",
        "best_default": plain,
        "noisy": noisy,
    }
    rows = table[table["parameters"] != "tuned"].copy()
    names = rows["method"].where(rows["parameters"] == "default", rows["method"] + ", auto")
    names = names.mask(front[rows.index], OWN).mask(noisy[rows.index], NOISY)
    rows.insert(0, "contender", names)
    for name, which in groups.items():
        least = table[which].groupby(CELL)[error].min().rename(name)
        rows = rows.join(least, on=CELL)
    return rows.assign(regret=rows[error] / rows["best"])


def summary(regrets: pd.DataFrame, by: Sequence[str] = ()) -> pd.DataFrame:
    """Median and worst regret of each contender.

    Parameters
    ----------
    regrets : pandas.DataFrame
        From `regrets`.
    by : sequence of str
        Further columns to group by, such as kind and size.

    Returns
    -------
    pandas.DataFrame
        contender, the columns of ``by``, cells (how many), median and worst regret; the
        least median first.
    """
    groups = regrets.groupby([*by, "contender"], sort=False)["regret"]
    found = groups.agg(cells="size", median="median", worst="max").reset_index()
    return found.sort_values([*by, "median", "worst"], ignore_index=True)
