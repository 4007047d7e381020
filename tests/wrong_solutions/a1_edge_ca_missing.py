# task: mean_edge_length
# points: 0
# hint: ca is missing
import numpy as np


def mean_edge_length(V, F):
    E = np.unique(np.sort(np.concatenate([F[:, [0, 1]], F[:, [1, 2]]]), axis=1), axis=0)
    return np.linalg.norm(V[E[:, 0]] - V[E[:, 1]], axis=1).mean()
