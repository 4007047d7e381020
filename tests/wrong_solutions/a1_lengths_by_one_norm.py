# task: mean_edge_length
# points: 0
# hint: norm of the whole array of differences
import numpy as np


def mean_edge_length(V, F):
    E = np.concatenate([F[:, [0, 1]], F[:, [1, 2]], F[:, [2, 0]]])
    i, j = np.unique(np.sort(E, axis=1), axis=0).T
    return np.linalg.norm(V[i] - V[j]).mean()
