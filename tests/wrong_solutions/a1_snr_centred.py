# task: snr
# points: 1
# hint: moved it to the origin
import numpy as np


def snr(V, V_noisy):
    signal = np.linalg.norm(V - V.mean(axis=0), axis=1).sum()
    return -20 * np.log10(np.linalg.norm(V - V_noisy, axis=1).sum() / signal)
