# task: snr
# points: 0
# hint: np.log10
import numpy as np


def snr(V, V_noisy):
    noise = np.linalg.norm(V - V_noisy, axis=1).sum()
    return -20 * np.log(noise / np.linalg.norm(V, axis=1).sum())
