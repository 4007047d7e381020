# task: combinatorial_weights
# points: 0
# hint: Build it sparse
import numpy as np


def combinatorial_weights(F, n):
    W = np.zeros((n, n))
    for a, b, c in F:
        for i, j in ((a, b), (b, c), (c, a)):
            W[i, j] = W[j, i] = 1
    return W
