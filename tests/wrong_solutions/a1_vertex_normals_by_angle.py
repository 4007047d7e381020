# task: vertex_normals
# points: 1
# hint: weight by the angles
import numpy as np


def vertex_normals(V, F):
    N = np.zeros(V.shape)
    for a, b, c in F:
        for i, j, k in ((a, b, c), (b, c, a), (c, a, b)):
            u, v = V[j] - V[i], V[k] - V[i]
            n = np.cross(u, v)
            angle = np.arctan2(np.linalg.norm(n), u @ v)
            N[i] += angle * n / np.linalg.norm(n)
    return N / np.linalg.norm(N, axis=1, keepdims=True)
