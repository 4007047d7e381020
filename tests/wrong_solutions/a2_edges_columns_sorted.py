# task: edges
# points: 0
# hint: tears the edges apart
import numpy as np


def edges(F):
    E = np.concatenate([F[:, [0, 1]], F[:, [1, 2]], F[:, [2, 0]]])
    return np.unique(np.sort(E, axis=0), axis=0)
