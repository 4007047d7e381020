# task: contributions
# points: 0
# hint: square of the difference
import numpy as np
from scipy.sparse import csr_array


def contributions(N, i, j, share, distance, differences, distances):
    m = len(N)
    of_difference = hats(((N[i] - N[j]) ** 2).sum(axis=1), differences)
    of_distance = hats(distance, distances)
    columns = []
    for a in range(len(differences)):
        for b in range(len(distances)):
            w = share * of_difference[:, a] * of_distance[:, b]
            columns.append(csr_array((w, (i, j)), shape=(m, m)) @ N)
    G = np.stack(columns, axis=1)
    return G
