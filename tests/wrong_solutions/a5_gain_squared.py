# task: gain
# points: 0
# hint: squared the norms
import numpy as np


def gain(V, V_noisy, V_true, part):
    before = np.linalg.norm(V_noisy - V_true, axis=1)[part]
    after = np.linalg.norm(V - V_true, axis=1)[part]
    return 10 * np.log10((before**2).sum() / (after**2).sum())
