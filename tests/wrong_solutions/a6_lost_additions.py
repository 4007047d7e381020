# task: contributions
# points: 0
# hint: assign where you have to add
import numpy as np


def contributions(N, i, j, share, distance, differences, distances):
    of_difference = hats(np.linalg.norm(N[i] - N[j], axis=1), differences)
    of_distance = hats(distance, distances)
    G = np.zeros((len(N), len(differences) * len(distances), 3))
    for a in range(len(differences)):
        for b in range(len(distances)):
            w = share * of_difference[:, a] * of_distance[:, b]
            G[i, a * len(distances) + b] += w[:, None] * N[j]
    return G
