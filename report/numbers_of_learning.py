"""The numbers of the section on filters that learn, from its experiment and from training."""

import re

import numpy as np
import pandas as pd

from meshfair.experiments import PAIRS
from meshfair.filters.learned import record, trained
from tables import QUALITY_NOISE

Tables = dict[str, pd.DataFrame]
Texts = dict[str, str]

CELL = ["shape", "noise", "size"]
LOSS = 0.1  # decibels below the noisy mesh from which on a cell counts as lost


def cells(table: pd.DataFrame) -> pd.DataFrame:
    """One row for each shape, noise and size of the validation.

    Parameters
    ----------
    table : pandas.DataFrame
        What `data_scripts/train` wrote to results/validation.csv.

    Returns
    -------
    pandas.DataFrame
        Indexed by shape, noise, size. ratio: the learned filter's angle over that of the
        best other default; kept: its angle over the noisy mesh's; gain: its SNR less the
        noisy mesh's, in dB.
    """
    angle = table.pivot(index=CELL, columns="method", values="normal_angle")
    snr = table.pivot(index=CELL, columns="method", values="snr")
    best = angle.drop(columns=["noisy", "learned"]).min(axis=1)
    return pd.DataFrame(
        {
            "ratio": angle["learned"] / best,
            "kept": angle["learned"] / angle["noisy"],
            "gain": snr["learned"] - snr["noisy"],
        }
    )


def numbers(data: Tables) -> Texts:
    """Format the numbers of the section, see `numbers_in_text.numbers`."""
    return _transfer(data) | _training(data) | _validation(data) | _elsewhere(data)


def _transfer(data: Tables) -> Texts:
    table = data["kernel_transfer"]
    angle = table.pivot(index="learned_from", columns="tried_on", values="normal_angle")
    shapes = angle.index.drop("none")
    square = angle.loc[shapes, shapes].to_numpy()
    own = np.eye(len(shapes), dtype=bool)
    return {
        "transfer-noise": f"{QUALITY_NOISE:g}",
        "transfer-box-own": f"{angle.loc['box', 'box']:.1f}",
        "transfer-box-torus": f"{angle.loc['torus', 'box']:.1f}",
        "transfer-own": f"{square[own].mean():.1f}",
        "transfer-other": f"{square[~own].mean():.1f}",
    }


def _training(data: Tables) -> Texts:
    curve, how, stages = data["training"], record(), trained()
    found: Texts = {
        "learned-stages": str(len(stages)),
        "learned-numbers": f"{sum(part.size for part in stages[0].values()):,}",
        "learned-shapes": f"{int(re.match(r'[0-9]+', how['data'])[0]):,}",  # type: ignore[index]
        "learned-mesh-share": how["loss"].partition("%")[0],
        "learned-largest": re.search(r"up to ([0-9.]+) edges", how["data"])[1],  # type: ignore[index]
    }
    for stage, rows in curve.groupby("stage"):
        marked = rows.dropna(subset=["sharp", "smooth"])
        found |= {
            f"learned-{stage}-steps": f"{rows['step'].max():,}",
            f"learned-{stage}-minutes": f"{rows['seconds'].max() / 60:.0f}",
            f"learned-{stage}-sharp": f"{marked['sharp'].iloc[-1]:.2f}",
            f"learned-{stage}-smooth": f"{marked['smooth'].iloc[-1]:.2f}",
        }
    return found


def _validation(data: Tables) -> Texts:
    found = cells(data["validation"])
    worst = found["ratio"].idxmax()
    texts: Texts = {
        "learned-cells": str(len(found)),
        "learned-validation-shapes": str(found.index.unique("shape").size),
        "learned-noises": str(found.index.unique("noise").size),
        "learned-sizes": str(found.index.unique("size").size),
        "learned-won": f"{100 * (found['ratio'] < 1).mean():.0f}",
        "learned-median": f"{100 * (1 - found['ratio'].median()):.0f}",
        "learned-worst": f"{found.loc[worst, 'ratio']:.1f}",
        "learned-worst-shape": worst[0],
        "learned-worst-noise": worst[1],
        "learned-rougher": str((found["kept"] > 1).sum()),
        "learned-lost": str((found["gain"] < -LOSS).sum()),
        "learned-lost-most": f"{-found['gain'].min():.1f}",
        "learned-lost-shape": found["gain"].idxmin()[0],
    }
    for level in ("noise", "shape"):
        for name, rows in found.groupby(level=level):
            texts[f"learned-{name}-won"] = f"{100 * (rows['ratio'] < 1).mean():.0f}"
            texts[f"learned-{name}-median"] = f"{rows['ratio'].median():.2f}"
            texts[f"learned-{name}-worst"] = f"{rows['ratio'].max():.2f}"
    return texts


def _elsewhere(data: Tables) -> Texts:
    """The jet's missiles and the public pairs, where they were measured."""
    table = data["quality"]
    table = table[table["parameters"] == "default"]
    angle = table.pivot(index="mesh", columns="method", values="normal_angle")
    jet = table[table["mesh"] == "jet"].set_index("method")["missile_error"]
    texts: Texts = {"learned-missiles": f"{jet['learned']:.3f}"}
    if PAIRS.keys() <= set(angle.index):
        others = angle.drop(columns=["none", "learned"])
        for mesh, key in (("fandisk", "fandisk"), ("bunny pair", "pair")):
            texts[f"learned-{key}"] = f"{angle.loc[mesh, 'learned']:.2f}"
            texts[f"learned-{key}-other"] = f"{others.loc[mesh].min():.2f}"
            texts[f"learned-{key}-method"] = others.loc[mesh].idxmin()
    return texts
