# task: mean_edge_length
# points: 1.5
# hint: Inner edges count twice
import numpy as np


def mean_edge_length(V, F):
    lengths = []
    for a, b, c in F:
        for i, j in ((a, b), (b, c), (c, a)):
            lengths.append(np.linalg.norm(V[i] - V[j]))
    return sum(lengths) / len(lengths)
