# task: edges
# points: 2
# hint: boundary edges are missing
import numpy as np


def edges(F):
    E = np.sort(np.concatenate([F[:, [0, 1]], F[:, [1, 2]], F[:, [2, 0]]]), axis=1)
    E, count = np.unique(E, axis=0, return_counts=True)
    return E[count == 2]
