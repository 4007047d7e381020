# task: hats
# points: 0
# hint: At a node itself
import numpy as np


def hats(x, nodes):
    x = np.clip(x, nodes[0], nodes[-1])
    H = np.zeros((len(x), len(nodes)))
    for a in range(len(nodes) - 1):
        inside = (nodes[a] < x) & (x < nodes[a + 1])
        t = (x[inside] - nodes[a]) / (nodes[a + 1] - nodes[a])
        H[inside, a], H[inside, a + 1] = 1 - t, t
    return H
