# task: filtered
# points: 0
# hint: norm of the whole array
import numpy as np


def filtered(G, table):
    sums = np.einsum("mkx,k->mx", G, table)
    return sums / np.linalg.norm(sums)
