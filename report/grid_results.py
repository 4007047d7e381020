"""What the report says of the grid of choices: its tables, its figure and its numbers.

All come from what `make grid` has left in report/results.
"""

from pathlib import Path

import numpy as np
import pandas as pd

from meshfair import plotting
from meshfair.experiments import regrets, summary
from meshfair.experiments.choices import KINDS, SIZES
from meshfair.experiments.draws import STOPPED
from meshfair.experiments.regret import NOISY, OWN
from meshfair.plotting import OTHER_COLORS, shades

Tables = dict[str, pd.DataFrame]

RESULTS = Path(__file__).resolve().parent / "results"
SHOWN = (OWN, "learned", "feature-convinced")
TICKS = (1, 2, 5, 10, 20, 50, 100)  # of regret
NEAR = 1.05  # of the best default's error: near enough
HARM = 1.01  # of the noisy mesh's angle: worse than to do nothing


def regret(**_: object) -> pd.DataFrame:
    """Median and worst regret of every contender: on the whole grid, and for each kind and size.

    One that has not run in every cell is left out.
    """
    found = regrets(pd.read_csv(RESULTS / "choices.csv"))
    found = found[found["contender"] != NOISY]
    whole = summary(found).set_index("contender")
    whole = whole.loc[whole["cells"] == whole["cells"].max(), ["median", "worst"]]
    for column, values in (("kind", KINDS), ("size", SIZES)):
        part = summary(found, [column])
        part = part.pivot(index="contender", columns=column, values="median")
        whole = whole.join(part[list(values)])
    return whole.rename(columns=str).reset_index()


def regret_figure(folder: Path, data: Tables) -> None:
    """Regret over the cells, from the least on, and the own choice's by kind and size."""
    found = regrets(data["choices"])
    with plotting.figure(folder / "regret.svg", (6.3, 3.2), columns=2, sharey=True) as panels:
        left, right = panels
        for name, colour in zip(SHOWN, OTHER_COLORS, strict=False):
            values = np.sort(found.loc[found["contender"] == name, "regret"])
            share = 100 * (np.arange(len(values)) + 0.5) / len(values)
            left.semilogy(share, values, color=colour, label=name, lw=2.2 if name == OWN else 1.3)
        left.axhline(1, color="0.3", lw=0.8, ls="--")
        left.set(xlabel="cells, in per cent", ylabel="regret")
        left.legend(ncols=2, loc="lower center", bbox_to_anchor=(0.5, 1))
        own = found[found["contender"] == OWN]
        for k, (size, colour) in enumerate(zip(SIZES, shades(len(SIZES)), strict=True)):
            rows = own[own["size"] == size].groupby("kind")["regret"]
            x = np.arange(len(KINDS)) + 0.17 * (k - 1.5)
            low, middle, high = (rows.quantile(q).reindex(list(KINDS)) for q in (0, 0.5, 1))
            right.vlines(x, low, high, color=colour, lw=1)
            right.plot(x, middle, "o", ms=4.5, color=colour, label=f"{size:g}")
        right.axhline(1, color="0.3", lw=0.8, ls="--")
        ticks = [tick for tick in TICKS if tick <= left.get_ylim()[1]]
        left.set_yticks(ticks, labels=map(str, ticks))
        left.minorticks_off()
        right.set(xticks=range(len(KINDS)))
        right.set_xticklabels(list(KINDS), rotation=25, ha="right", rotation_mode="anchor")
        right.legend(title="noise size", ncols=4, loc="lower center", bbox_to_anchor=(0.5, 1))


def numbers(data: Tables) -> dict[str, str]:
    """The numbers of the section's text.

    Parameters
    ----------
    data : dict of str to pandas.DataFrame
        The tables of `make grid`: choices, missile_draws, knot_draws, pairs.

    Returns
    -------
    dict of str to str
    """
    return _grid(data["choices"]) | _draws(data) | _pairs(data["pairs"])


def _grid(table: pd.DataFrame) -> dict[str, str]:
    found = regrets(table)
    whole = summary(found).set_index("contender")
    single = whole.drop(index=[OWN, NOISY])
    single = single[single["cells"] == single["cells"].max()]
    own = found[found["contender"] == OWN]
    worst = own.loc[own["regret"].idxmax()]
    ratio = own["normal_angle"] / own["best_default"]
    harm = own["normal_angle"] / own["noisy"]
    noisy = table[table["method"] == "none"].set_index(["mesh", "kind", "size"])
    lost = noisy["snr"] - own.set_index(["mesh", "kind", "size"])["snr"]
    cells = ["mesh", "kind", "size", "method"]
    ways = table[~table["method"].isin(["none", "auto"])].pivot(
        index=cells, columns="parameters", values="normal_angle"
    )
    whole_way = (table["strength"] == 1) & (table["chosen"] == "learned")
    longer, decibels = _beside_default(table, table[whole_way & (table["method"] == "auto")])
    in_part = (table["strength"] < 1) & (table["method"] == "learned")
    part_rows = table[in_part & (table["parameters"] == "auto")]
    part, part_decibels = _beside_default(table, part_rows)
    of_noisy = part_rows.set_index(noisy.index.names)["normal_angle"] / noisy["normal_angle"]
    automatic = (ways["auto"] / ways["default"]).dropna()
    tuned = table[table["parameters"] == "tuned"]
    best = tuned.loc[tuned.groupby(["mesh", "kind", "size"])["normal_angle"].idxmin(), "method"]
    return {
        "grid-cells": f"{len(own)}",
        "grid-shapes": str(table.loc[table["kind"].isin(KINDS), "mesh"].nunique()),
        "grid-kinds": str(len(KINDS)),
        "grid-sizes": str(len(SIZES)),
        "grid-smallest": f"{min(SIZES):g}",
        "grid-largest": f"{max(SIZES):g}",
        "grid-methods": str(len(ways.index.unique("method"))),
        "grid-winners": str(best.nunique()),
        "grid-winner": best.value_counts().index[0],
        "grid-winner-cells": str(best.value_counts().iloc[0]),
        "own-median": f"{whole.loc[OWN, 'median']:.2f}",
        "own-worst": f"{whole.loc[OWN, 'worst']:.1f}",
        "own-worst-mesh": worst["mesh"],
        "own-worst-kind": worst["kind"],
        "own-worst-size": f"{worst['size']:g}",
        "single-best": single.index[0],
        "single-median": f"{single['median'].iloc[0]:.2f}",
        "single-worst": f"{single['worst'].iloc[0]:.1f}",
        "own-default-median": f"{ratio.median():.3f}",
        "own-default-mean": f"{np.exp(np.log(ratio).mean()):.2f}",
        "own-default-below": f"{100 * (ratio < 1).mean():.0f}",
        "own-default-near": f"{100 * (ratio <= NEAR).mean():.0f}",
        "own-default-worst": f"{ratio.max():.1f}",
        "auto-ratio": f"{np.exp(np.log(automatic).mean()):.2f}",
        "auto-worse": f"{100 * (automatic > NEAR).mean():.1f}",
        "auto-worst": f"{automatic.max():.1f}",
        "auto-worst-mesh": automatic.idxmax()[0],
        "own-harm": str((harm > HARM).sum()),
        "own-harm-worst": f"{100 * (harm.max() - 1):.1f}",
        "own-lost-worst": f"{lost.max():.2f}",
        "longer-cells": str(len(longer)),
        "longer-ratio": f"{np.exp(np.log(longer).mean()):.2f}",
        "longer-worst": f"{longer.max():.2f}",
        "longer-gain": f"{decibels.mean():.1f}",
        "part-cells": str((own["strength"] < 1).sum() or "none"),
        "part-auto-cells": str(len(part)),
        "part-auto-mesh": ", ".join(f"the {mesh}" for mesh in part.index.unique("mesh")),
        "part-auto-ratio": f"{np.exp(np.log(part).mean()):.2f}",
        "part-auto-worst": f"{part.max():.2f}",
        "part-auto-gain": f"{part_decibels.mean():.1f}",
        "part-auto-noisy-low": f"{of_noisy.min():.2f}",
        "part-auto-noisy-high": f"{of_noisy.max():.2f}",
    }


def _beside_default(table: pd.DataFrame, rows: pd.DataFrame) -> tuple[pd.Series, pd.Series]:
    """Of rows of the learned filter that differ from its default: ratio of angles, gain in SNR."""
    cells = ["mesh", "kind", "size"]
    plain = table[(table["method"] == "learned") & (table["parameters"] == "default")]
    default, rows = plain.set_index(cells), rows.set_index(cells)
    ratio = rows["normal_angle"] / default["normal_angle"].loc[rows.index]
    gain = rows["snr"] - default["snr"].loc[rows.index]
    return ratio[ratio != 1], gain[ratio != 1]


def _draws(data: Tables) -> dict[str, str]:
    rows = data["missile_draws"]
    errors = rows.pivot(index="seed", columns=["method", "parameters"], values="missiles")
    stopped, own = errors[STOPPED, "default"], errors["auto", "default"]
    ratio = own / stopped
    knot = data["knot_draws"].pivot(index=["size", "seed"], columns="method", values="snr")
    gain = (knot["auto"] - knot["none"]).groupby("size")
    found = {
        "missile-draws": str(len(errors)),
        "missiles-stopped": _spread(stopped),
        "missiles-own": _spread(own),
        "missiles-learned": _spread(errors["learned", "default"]),
        "missiles-ratio": _spread(ratio),
        "missiles-ratio-worst": f"{ratio.max():.2f}",
    }
    for size, values in gain:
        found[f"knot-gain-{size:g}"] = f"{values.mean():.1f}"
        found[f"knot-gain-{size:g}-least"] = f"{values.min():.1f}"
    return found


def _spread(values: pd.Series) -> str:
    return f"{values.mean():.3f} ± {values.std():.3f}"


def _pairs(table: pd.DataFrame) -> dict[str, str]:
    angle = table.pivot(index=["source", "pair"], columns="method", values="normal_angle")
    classical = angle.drop(columns=["none", "auto", "learned"]).min(axis=1)
    ratio = angle["learned"] / classical
    own = angle["auto"] / angle.drop(columns=["none", "auto"]).min(axis=1)
    return {
        "pairs-count": str(len(angle)),
        "pairs-better": str((ratio < 1).sum()),
        "pairs-ratio": f"{ratio.median():.2f}",
        "pairs-own": f"{own.median():.2f}",
    }
