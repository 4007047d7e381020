# task: edges
# points: 0
# hint: (i, j) and as (j, i)
# also: not all rows have i < j
import numpy as np


def edges(F):
    return np.unique(np.concatenate([F[:, [0, 1]], F[:, [1, 2]], F[:, [2, 0]]]), axis=0)
