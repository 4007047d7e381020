# task: best_stopping
# points: 0
# hint: end of the flow
import numpy as np


def best_stopping(V_noisy, V_true, A, tau, steps):
    V = heat(V_noisy, A, tau, steps)
    noise = np.linalg.norm(V_true - V, axis=1).sum()
    return tau * steps, -20 * np.log10(noise / np.linalg.norm(V_true, axis=1).sum())
