# task: hats
# points: 0
# hint: nearest node alone
import numpy as np


def hats(x, nodes):
    return np.eye(len(nodes))[np.abs(x[:, None] - nodes).argmin(axis=1)]
