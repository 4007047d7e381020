# task: hats
# points: 0
# hint: whole interval
import numpy as np


def hats(x, nodes):
    left = np.clip(np.searchsorted(nodes, x, "right") - 1, 0, len(nodes) - 2)
    return np.eye(len(nodes))[left]
