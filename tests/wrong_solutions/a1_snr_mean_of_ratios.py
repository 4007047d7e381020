# task: snr
# points: 1
# hint: average the ratios
import numpy as np


def snr(V, V_noisy):
    ratios = np.linalg.norm(V - V_noisy, axis=1) / np.linalg.norm(V, axis=1)
    return -20 * np.log10(ratios.mean())
