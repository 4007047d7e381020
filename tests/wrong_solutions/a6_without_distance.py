# task: contributions
# points: 0
# hint: distance does not count
import numpy as np
from scipy.sparse import csr_array


def contributions(N, i, j, share, distance, differences, distances):
    of_difference = hats(np.linalg.norm(N[i] - N[j], axis=1), differences)
    columns = []
    for hat in of_difference.T:
        one = csr_array((share * hat, (i, j)), shape=(len(N), len(N))) @ N
        columns += [one] * len(distances)
    return np.stack(columns, axis=1)
