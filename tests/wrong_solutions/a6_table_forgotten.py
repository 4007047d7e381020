# task: filtered
# points: 0
# hint: without the table
import numpy as np


def filtered(G, table):
    sums = G.sum(axis=1)
    return sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-300)
