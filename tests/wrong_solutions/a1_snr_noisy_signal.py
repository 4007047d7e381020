# task: snr
# points: 0
# hint: noisy mesh is in the denominator
import numpy as np


def snr(V, V_noisy):
    noise = np.linalg.norm(V - V_noisy, axis=1).sum()
    return -20 * np.log10(noise / np.linalg.norm(V_noisy, axis=1).sum())
