# task: best_stopping
# points: 0
# hint: where the SNR is lowest
import numpy as np


def best_stopping(V_noisy, V_true, A, tau, steps):
    def snr(V):
        noise = np.linalg.norm(V_true - V, axis=1).sum()
        return 20 * np.log10(noise / np.linalg.norm(V_true, axis=1).sum())

    V, curve = V_noisy, [snr(V_noisy)]
    for _ in range(steps):
        V = heat(V, A, tau, 1)
        curve.append(snr(V))
    best = int(np.argmax(curve))
    return best * tau, curve[best]
