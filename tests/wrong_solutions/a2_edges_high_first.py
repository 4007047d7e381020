# task: edges
# points: 0
# hint: not all rows have i < j
import numpy as np


def edges(F):
    E = np.concatenate([F[:, [0, 1]], F[:, [1, 2]], F[:, [2, 0]]])
    return np.unique(np.sort(E, axis=1), axis=0)[:, ::-1]
