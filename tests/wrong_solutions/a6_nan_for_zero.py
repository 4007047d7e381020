# task: filtered
# points: 1
# hint: 0 / 0 is nan
import numpy as np


def filtered(G, table):
    sums = np.einsum("mkx,k->mx", G, table)
    return sums / np.linalg.norm(sums, axis=1, keepdims=True)
