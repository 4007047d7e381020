# task: vertex_normals
# points: 1
# hint: weight each by the area
import numpy as np


def vertex_normals(V, F):
    a, b, c = V[F[:, 0]], V[F[:, 1]], V[F[:, 2]]
    n = np.cross(b - a, c - a)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    N = np.zeros(V.shape)
    for corner in range(3):
        np.add.at(N, F[:, corner], n)
    return N / np.linalg.norm(N, axis=1, keepdims=True)
