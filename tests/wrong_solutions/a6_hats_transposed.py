# task: hats
# points: 0
# hint: that of the transpose
import numpy as np


def hats(x, nodes):
    return np.array([np.interp(x, nodes, one) for one in np.eye(len(nodes))])
