# task: gain
# points: 0
# hint: gain on the whole mesh
import numpy as np


def gain(V, V_noisy, V_true, part):
    before = np.linalg.norm(V_noisy - V_true, axis=1)
    after = np.linalg.norm(V - V_true, axis=1)
    return 20 * np.log10(before.sum() / after.sum())
