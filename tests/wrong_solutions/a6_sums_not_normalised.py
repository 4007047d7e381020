# task: filtered
# points: 0
# hint: not made one long
import numpy as np


def filtered(G, table):
    sums = np.einsum("mkx,k->mx", G, table)
    return sums
