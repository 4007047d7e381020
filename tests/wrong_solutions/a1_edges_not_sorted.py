# task: mean_edge_length
# points: 1.5
# hint: Inner edges count twice
import numpy as np


def mean_edge_length(V, F):
    E = np.unique(np.concatenate([F[:, [0, 1]], F[:, [1, 2]], F[:, [2, 0]]]), axis=0)
    return np.linalg.norm(V[E[:, 0]] - V[E[:, 1]], axis=1).mean()
