"""The transfer functions of the filters that are compared with one made by hand."""

import numpy as np

from meshfair import spectrum
from meshfair.checks import Floats
from meshfair.plotting import OTHER_COLORS

STEPS = 30  # of each of the other filters, at most
TAU, LAM, MU, LENGTH = 0.2, 0.5, -0.53, 0.5  # heat step; Taubin's two; implicit step
HAND = "by hand"
RIVALS = {
    "heat": f"heat steps of τ = {TAU:g}",
    "taubin": "Taubin steps",
    "implicit": f"implicit steps of τ = {LENGTH:g}",
}
COLORS = dict(zip((HAND, *RIVALS), OTHER_COLORS, strict=False))


def transfer(rival: str, eigenvalues: Floats, steps: int) -> Floats:
    """The transfer function of some steps of one of `RIVALS`."""
    factor = spectrum.transfer_function
    if rival == "heat":
        return factor(eigenvalues, TAU, steps)
    if rival == "taubin":
        return factor(eigenvalues, LAM, steps) * factor(eigenvalues, MU, steps)
    return 1 / factor(eigenvalues, -LENGTH, steps)


def by_hand(eigenvalues: Floats, count: int, width: float) -> Floats:
    """A transfer function that is 1 for the first eigenmodes and 0 for the others.

    Parameters
    ----------
    eigenvalues : ndarray of float64, shape (n,)
        The largest first.
    count : int
        How many are kept.
    width : float
        Half the part of the axis of eigenvalues on which it falls; 0 for a sharp edge.

    Returns
    -------
    ndarray of float64, shape (n,)
    """
    if width == 0 or not 0 < count < len(eigenvalues):
        return (np.arange(len(eigenvalues)) < count).astype(float)
    edge = (eigenvalues[count - 1] + eigenvalues[count]) / 2
    part = np.clip((eigenvalues - edge) / width, -1, 1)
    return (1 + np.sin(np.pi / 2 * part)) / 2
