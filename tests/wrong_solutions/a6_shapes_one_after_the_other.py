# task: held_out
# points: 3
# hint: in blocks
from itertools import pairwise

import numpy as np


def held_out(G, N_true, shape, ridge):
    errors = []
    for first, last in pairwise(np.append(0, np.cumsum(np.bincount(shape)))):
        rest = np.r_[0:first, last : len(G)]
        N = filtered(G[first:last], fit(G[rest], N_true[rest], ridge))
        cosine = np.clip((N * N_true[first:last]).sum(axis=1), -1, 1)
        errors.append(np.degrees(np.arccos(cosine)).mean())
    return np.array(errors)
