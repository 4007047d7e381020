# task: snr
# points: 1
# hint: squared the norms
import numpy as np


def snr(V, V_noisy):
    return -10 * np.log10(((V - V_noisy) ** 2).sum() / (V**2).sum())
