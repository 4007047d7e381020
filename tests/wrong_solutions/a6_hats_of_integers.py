# task: hats
# points: 0
# hint: Only whole numbers
import numpy as np


def hats(x, nodes):
    H = np.zeros((len(x), len(nodes)), dtype=int)
    for a, one in enumerate(np.eye(len(nodes))):
        H[:, a] = np.interp(x, nodes, one)
    return H
