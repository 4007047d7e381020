# task: hats
# points: 0
# hint: the same width
import numpy as np


def hats(x, nodes):
    width = nodes[1] - nodes[0]
    return np.maximum(0, 1 - np.abs(np.clip(x, nodes[0], nodes[-1])[:, None] - nodes) / width)
