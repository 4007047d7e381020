# task: filtered
# points: 0
# hint: sum of the table
import numpy as np


def filtered(G, table):
    sums = np.einsum("mkx,k->mx", G, table)
    return sums / table.sum()
