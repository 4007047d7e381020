# task: hats
# points: 3
# hint: straight lines go on
import numpy as np


def hats(x, nodes):
    left = np.clip(np.searchsorted(nodes, x, "right") - 1, 0, len(nodes) - 2)
    t = (x - nodes[left]) / (nodes[left + 1] - nodes[left])
    H = np.zeros((len(x), len(nodes)))
    rows = np.arange(len(x))
    H[rows, left] = 1 - t
    H[rows, left + 1] = t
    return H
