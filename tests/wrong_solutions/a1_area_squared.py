# task: vertex_normals
# points: 1
# hint: squares of the areas
import numpy as np


def vertex_normals(V, F):
    a, b, c = V[F[:, 0]], V[F[:, 1]], V[F[:, 2]]
    D = np.cross(b - a, c - a)
    N = np.zeros(V.shape)
    for k in range(3):
        np.add.at(N, F[:, k], D * np.linalg.norm(D, axis=1, keepdims=True))
    return N / np.linalg.norm(N, axis=1, keepdims=True)
