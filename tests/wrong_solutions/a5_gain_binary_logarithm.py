# task: gain
# points: 0
# hint: binary logarithm
import numpy as np


def gain(V, V_noisy, V_true, part):
    before = np.linalg.norm(V_noisy - V_true, axis=1)[part].sum()
    after = np.linalg.norm(V - V_true, axis=1)[part].sum()
    return 20 * np.log2(before / after)
