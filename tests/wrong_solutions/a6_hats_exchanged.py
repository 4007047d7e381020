# task: hats
# points: 0
# hint: parts are exchanged
import numpy as np


def hats(x, nodes):
    left = np.clip(np.searchsorted(nodes, x, "right") - 1, 0, len(nodes) - 2)
    t = np.clip((x - nodes[left]) / (nodes[left + 1] - nodes[left]), 0, 1)
    H = np.zeros((len(x), len(nodes)))
    rows = np.arange(len(x))
    H[rows, left] = t
    H[rows, left + 1] = 1 - t
    return H
