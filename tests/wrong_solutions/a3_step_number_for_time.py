# task: best_stopping
# points: 3
# hint: number of steps
import numpy as np


def best_stopping(V_noisy, V_true, A, tau, steps):
    V, curve = V_noisy, []
    for _ in range(steps + 1):
        noise = np.linalg.norm(V_true - V, axis=1).sum()
        curve.append(-20 * np.log10(noise / np.linalg.norm(V_true, axis=1).sum()))
        V = (1 - tau) * V + tau * (A @ V)
    return np.argmax(curve), np.max(curve)
