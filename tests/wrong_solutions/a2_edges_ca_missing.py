# task: edges
# points: 0
# hint: The edges ca of the triangles are missing
import numpy as np


def edges(F):
    return np.unique(np.sort(np.concatenate([F[:, :2], F[:, 1:]]), axis=1), axis=0)
