# task: snr
# points: 1
# hint: absolute values of the coordinates
import numpy as np


def snr(V, V_noisy):
    return -20 * np.log10(np.abs(V - V_noisy).sum() / np.abs(V).sum())
